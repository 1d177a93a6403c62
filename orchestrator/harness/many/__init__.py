"""Many runs of one scene: which points, what is kept of them, who computes them, where it lies, and what follows from it."""

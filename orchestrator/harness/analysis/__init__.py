"""What is computed from recorded signals and from sets of runs."""

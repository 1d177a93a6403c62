"""What the paper on the rules of the wrist announces, claim by claim."""

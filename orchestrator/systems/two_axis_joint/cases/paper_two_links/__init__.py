"""What the paper of the body on a two-axis joint and of two links announces, claim by claim."""

"""What the paper of the pipe robots announces, claim by claim."""

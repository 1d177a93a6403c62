"""What the paper of the wind pump announces, claim by claim."""

"""The paper of Frączak (2013), claim by claim: a drive with friction wheels, its control, and what a surgeon asks of it."""

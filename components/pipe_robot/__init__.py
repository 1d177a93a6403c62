"""Pipe robots that move by vibration: bodies braced in the pipe, the pipe along the way, a coupling for towing."""

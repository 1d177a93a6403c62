"""Two-axis joint: a body in a gimbal with its controller, a chain of two links whole and in parts."""

"""From the start of a run to its end: the clock, the loop in its forms, events, faults, and who watches."""

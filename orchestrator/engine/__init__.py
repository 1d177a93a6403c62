"""The orchestrator proper: checked graph, master algorithms, stepping; knows no system, no file format, no page."""

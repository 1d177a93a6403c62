"""cosimo: physical components as FMI co-simulation FMUs, an orchestrator that couples them, and a harness that judges them."""

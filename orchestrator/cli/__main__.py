"""`python -m cosimo.orchestrator.cli`."""

from . import main

main()

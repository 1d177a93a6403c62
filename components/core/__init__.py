"""The parts of every component: declared variables, effects, kernels, integrators."""

"""What every component is made of: declared variables, effects, kernels, integrators."""

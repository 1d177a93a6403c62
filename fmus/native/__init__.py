"""FMUs that need no Python: a component's own kernels, compiled ahead of time, and a runtime in C.

`machine_code` makes object files of a component's kernels, `kept_code` keeps them on disk. `instance` lays out the variables in
the block of memory. `variables` and `description` write what an importing tool reads. `build` links and packs.
"""

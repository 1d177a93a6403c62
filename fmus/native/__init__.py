"""FMUs that need no Python: a component's own kernels, compiled ahead of time, and a runtime in C.

`hooks` translates what a component's `_step` and `_outputs` do into functions over one block of memory, `block` lays the block
out, `machine_code` makes object files of them, `image` computes the initial state at build, `tables` and `description` write
what the runtime and an importing tool read, and `build` links and packs.
"""

"""Public names of cosimo that components use, by the module that has them: `from cosimo import ...` in a component of one's own."""

from __future__ import annotations

_NAMES = {
    "components.core.component": ("Component", "Effect", "Preset"),
    "components.core.contract": ("KernelComponent", "Kernels", "Refusal"),
    "components.core.stateless": ("StatelessComponent", "stateless_kernels"),
    "components.core.errors": ("BadInput", "StepFailed"),
    "components.core.kernels": ("DONE", "OWN", "bind", "hold_inputs", "kernel", "kernel_tuple"),
    "components.core.events": ("EventComponent", "event_kernels"),
    "components.core.integrators": ("OdeComponent", "ode_kernels"),
    "components.core.sampled": ("SampledComponent", "sampled_kernels"),
    "components.core.high_order": ("SmoothComponent", "smooth_kernels"),
    "components.core.variables": ("choice", "count", "flag", "input_", "integer", "output", "parameter"),
}
PLACE = {name: place for place, names in _NAMES.items() for name in names}

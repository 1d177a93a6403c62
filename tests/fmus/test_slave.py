"""The slave in Python: which values a call gives does not depend on the calls before it."""

import numpy as np
import pytest
from cosimo.components.rotor.beam import BeamRotor
from cosimo.fmus.slave import KEPT, WIDE, ComponentSlave


class Rotor(ComponentSlave):
    component_class = BeamRotor


pytestmark = pytest.mark.interpreted


@pytest.fixture
def slave():
    made = Rotor(instance_name="rotor", resources="")
    on = [f"effects.{name}" for name in ("gravity", "disks", "unbalance", "bearing_a", "bearing_b")]
    made.set_boolean([made._references[n] for n in on], [True] * len(on))
    made.exit_initialization_mode()
    return made


def test_wide_reads_in_turns_are_narrow_reads(slave):
    outputs = np.array([slave._references[n] for n in slave.component.outputs])
    order = np.random.default_rng(3)
    lists = [order.choice(outputs, WIDE + 2).tolist() for _ in range(KEPT + 3)]  # more than are remembered
    for k in range(3):
        assert slave.do_step(k * 1e-3, 1e-3)
        for references in (*lists[:2], *lists):
            assert slave.get_real(references) == [slave.get_real([v])[0] for v in references]
    assert len({slave.get_real(references)[0] for references in lists}) > 1


@pytest.mark.parametrize("derivative", ["{}", "der({})", "der({},2)"])
def test_wide_writes_in_turns_are_narrow_writes(slave, derivative):
    inputs = {port: [slave._references[derivative.format(n)] for n in slave.component.inputs if n.startswith(port)]
              for port in ("bearing_a", "bearing_b")}  # fmt: skip
    for k in (1.0, 2.0):
        for port, factor in (("bearing_a", k), ("bearing_b", -k)):
            references = inputs[port]
            assert len(references) > WIDE
            slave.set_real(references, [factor * i for i in range(len(references))])
        for port, factor in (("bearing_a", k), ("bearing_b", -k)):
            assert [slave._real_reads[v][0][slave._real_reads[v][1]] for v in inputs[port]] == [
                factor * i for i in range(len(inputs[port]))
            ]

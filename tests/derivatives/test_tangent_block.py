"""A block with tangents goes on from any instant to the bit, however many steps are asked for at once."""

from __future__ import annotations

from contextlib import ExitStack

import numpy as np
import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.tests.derivatives.test_coupled_step import on_spring

if COMPILED:
    from cosimo.orchestrator.derivatives.tangent_block import CHUNK, TangentBlock

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
STEPS = 2 * CHUNK + 3


def test_steps_of_several_calls_are_those_one_by_one():
    with ExitStack() as stack:
        block = TangentBlock(on_spring(**{"master.extrapolation": 2}), stack)
        block.start(block.places(["mass.mass", "spring.damping"]))
        block.advance(5)
        instant, seeds = block.save(), block.tangents.copy()
        rows = [(values.copy(), tangents.copy()) for values, tangents in block.rows(STEPS)]
        assert [len(values) for values, _ in rows] == [CHUNK, CHUNK, 3]
        end, values, tangents = block.save(), *map(np.concatenate, zip(*rows, strict=True))
        assert np.abs(tangents[-1, :, :2]).max() > 0.0
        block.restore(instant)
        block.tangents[:] = seeds
        for k in range(STEPS):
            block.advance(1)
            np.testing.assert_array_equal((block.cells[block.table], *block.tangents[block.table].T), (values[k], *tangents[k].T))
        np.testing.assert_array_equal(block.cells[: block.layout.at], end.cells[: block.layout.at])  # of all units
        assert block.time == end.time == block.scene.start_time + (5 + STEPS) * block.h


def test_another_length_of_step_begins_where_the_block_stands():
    with ExitStack() as stack:
        block = TangentBlock(on_spring(), stack)
        block.start()
        block.advance(3)
        instant, h = block.save(), block.h
        block.pace(0.5 * h)
        block.advance(2)
        assert (block.time, block.taken) == (4.0 * h, 2)
        block.restore(instant)
        assert (block.time, block.taken, block.h) == (3.0 * h, 3, h)


def test_directions_beyond_the_width_all_begin_where_the_block_stands():
    with ExitStack() as stack:
        block = TangentBlock(on_spring(), stack, width=2)
        block.start()
        block.fill()
        begun, cells = block.save(), np.array([*block.samples(0), block.outputs["mass.base_x"]])
        for some in block.batches(cells, np.eye(cells.size), first=1):
            assert some == slice(1, 2)
            assert block.time == begun.time
            np.testing.assert_array_equal(block.cells, begun.cells)
            block.advance(4)

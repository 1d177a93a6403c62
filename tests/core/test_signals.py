"""Tables over time as components: values between rows, jumps, ends, and a search that goes on where it was."""

from itertools import pairwise

import numpy as np
import pytest
from cosimo import BadInput, StepFailed
from cosimo.components.core.signals import row_of, signals_class
from scipy.interpolate import PchipInterpolator


def table(times, *columns, **parameters):
    """An instance of a table with columns y1, y2 ..., not initialized."""
    names = [f"y{k + 1}" for k in range(len(columns))]
    rows = np.ascontiguousarray(np.column_stack([times, *columns]).astype(float))
    return signals_class(names, ["1"] * len(names), rows, "table.csv")((), parameters)


def at(signals, times):
    """The values of the first column at some times, behind jumps."""
    values = []
    for t in times:
        signals.t = float(t)
        signals.refresh()
        values.append(signals["y1"])
    return np.array(values)


def jumps(signals, begin, end):
    """Times of jumps of an instance."""
    return signals.jump_times(signals.parameters, begin, end)


RANDOM = np.random.default_rng(5)
TIMES = np.cumsum(RANDOM.uniform(0.1, 1.0, 400))
VALUES = RANDOM.normal(size=400)
BETWEEN = np.linspace(TIMES[0], TIMES[-1], 3001)


@pytest.mark.parametrize(
    ("interpolation", "exact"),
    [
        ("linear", lambda t: np.interp(t, TIMES, VALUES)),
        ("hold", lambda t: VALUES[np.searchsorted(TIMES, t, "right") - 1]),
        ("pchip", PchipInterpolator(TIMES, VALUES)),
    ],
)
def test_values_between_rows_are_those_of_numpy_and_scipy(interpolation, exact):
    signals = table(TIMES, VALUES, interpolation=interpolation)
    signals.initialize(TIMES[0])
    np.testing.assert_allclose(at(signals, BETWEEN), exact(BETWEEN), rtol=0.0, atol=1e-13)


def test_a_cubic_is_cut_at_a_jump():
    signals = table([0, 1, 2, 2, 3, 5], [0, 1, 2, 5, 4, 7], interpolation="pchip")
    signals.initialize(0.0)
    left, right = PchipInterpolator([0, 1, 2], [0, 1, 2]), PchipInterpolator([2, 3, 5], [5, 4, 7])
    np.testing.assert_allclose(at(signals, [0.3, 1.7]), left([0.3, 1.7]), atol=1e-14)
    np.testing.assert_allclose(at(signals, [2.0, 2.4, 4.9]), right([2.0, 2.4, 4.9]), atol=1e-14)


@pytest.mark.parametrize("interpolation", ["linear", "pchip"])
def test_a_step_ends_before_a_jump_and_an_update_is_behind_it(interpolation):
    signals = table([0, 1, 1, 2], [0, 1, 5, 6], interpolation=interpolation)
    signals.initialize(0.0)
    signals.step(0.0, 1.0)
    assert signals["y1"] == 1.0
    signals.refresh()
    assert signals["y1"] == 5.0
    signals.step(1.0, 0.5)
    assert signals["y1"] == pytest.approx(5.5)


def test_held_rows_jump_with_the_step():
    signals = table([0, 1, 2], [3, 4, 5], interpolation="hold")
    signals.initialize(0.0)
    signals.step(0.0, 1.0)
    assert signals["y1"] == 4.0


def test_two_rows_at_the_start_are_the_value_before_and_behind():
    signals = table([0, 0, 1], [7, 1, 2], outside="hold")
    signals.initialize(-1.0)
    assert signals["y1"] == 7.0
    signals.step(-1.0, 1.0)
    assert signals["y1"] == 7.0
    signals.refresh()
    assert signals["y1"] == 1.0


def test_one_row_is_a_constant_where_it_is_held_and_no_period():
    signals = table([1.0], [3.0], outside="hold")
    signals.initialize(0.0)
    assert at(signals, [0.0, 1.0, 9.0]).tolist() == [3.0, 3.0, 3.0]
    with pytest.raises(BadInput, match="one row"):
        table([1.0], [3.0], outside="repeat").initialize(1.0)


def test_a_constant_column_has_its_number_in_every_bit():
    signals = table(TIMES, np.full(400, 0.1))
    signals.initialize(TIMES[0])
    assert set(at(signals, BETWEEN)) == {0.1}


def test_start_shifts_the_table_both_ways():
    for start in (-3.0, 4.0):
        signals = table(TIMES, VALUES, start=start)
        signals.initialize(TIMES[5] + start)
        np.testing.assert_allclose(at(signals, TIMES[5:50] + start), VALUES[5:50], atol=1e-12)


def test_a_table_that_does_not_cover_the_start_says_what_it_covers():
    with pytest.raises(BadInput, match=r"table\.csv from 0 s on"):
        table([0, 1], [0, 1]).initialize(-0.1)
    with pytest.raises(BadInput, match=r"table\.csv up to 3 s"):
        table([0, 1], [0, 1], start=2.0).initialize(3.1)


def test_a_table_that_ends_within_a_run_fails_with_its_range():
    signals = table([0, 1], [0, 1])
    signals.initialize(0.5)
    signals.step(0.5, 0.5)
    with pytest.raises(StepFailed, match=r"table\.csv covers 0 to 1 s"):
        signals.step(1.0, 0.1)


def test_a_repeated_table_has_its_period_before_and_behind():
    signals = table([0, 1, 3], [0, 1, 0], outside="repeat")
    signals.initialize(0.0)
    np.testing.assert_allclose(at(signals, [-2.5, 0.5, 3.5, 300.5]), [0.5, 0.5, 0.5, 0.5], atol=1e-12)
    assert at(signals, [3.0, 6.0, -3.0]).tolist() == [0.0, 0.0, 0.0]


def test_the_end_of_a_repeated_table_is_a_jump_where_its_values_differ():
    signals = table([0, 0.7], [0, 7], outside="repeat")
    signals.initialize(0.0)
    assert jumps(signals, 0.0, 3.0) == [0.7, 1.4, 2.1, 2.8]
    signals.step(0.0, 0.7)
    assert signals["y1"] == 7.0
    signals.refresh()
    assert signals["y1"] == 0.0
    assert jumps(table([0, 0.5, 0.7], [0, 7, 0], outside="repeat"), 0.0, 3.0) == []


def test_times_of_jumps_are_decimals():
    """Of binary sums ticks of a clock would be as short as a last digit."""
    signals = table([0.1, 0.2, 0.2, 0.3], [0, 0, 1, 1], start=0.1, outside="hold")
    assert jumps(signals, 0.0, 1.0) == [0.3]
    assert jumps(table([0, 0.1, 0.2], [0, 0, 1], interpolation="hold", start=0.1), 0.0, 1.0) == [0.3]


def test_the_search_reads_few_rows_however_long_the_table_is():
    """Counted in rows, for steps that go on by one row and by a thousand."""

    class Counted:
        """A column of times that counts what is read of it."""

        def __init__(self, times):
            self.times, self.shape, self.reads = times, (len(times), 1), 0

        def __getitem__(self, place):
            self.reads += 1
            return self.times[place[0]]

    search, reads = getattr(row_of, "py_func", row_of), {}
    for n in (10**3, 10**6):
        rows, near = Counted(range(n)), 0
        for t in range(500):
            near = search(rows, float(t), near)
            assert near == t
        reads[n] = rows.reads
    assert reads[10**3] == reads[10**6] <= 4 * 500
    rows, near = Counted(range(10**6)), 0
    for t in range(0, 10**6, 1000):
        near = search(rows, float(t), near)
    assert near == 999_000
    assert rows.reads < 25 * 1000


def test_a_search_finds_the_same_row_from_everywhere():
    rows = np.array([[0.0], [1.0], [1.0], [2.0], [5.0]])
    for t, row in ((-1.0, -1), (0.0, 0), (0.5, 0), (1.0, 2), (1.5, 2), (2.0, 3), (4.9, 3), (5.0, 4), (9.0, 4)):
        assert {int(row_of(rows, t, near)) for near in range(-2, 8)} == {row}


def test_a_state_is_exact_and_knows_its_row():
    signals = table(TIMES, VALUES, interpolation="pchip")
    signals.initialize(TIMES[0])
    ends = np.linspace(TIMES[0], TIMES[-1], 60)
    for a, b in pairwise(ends[:30]):
        signals.step(a, b - a)
    state = signals.save()
    first = [(signals.step(a, b - a), signals["y1"])[1] for a, b in pairwise(ends[29:])]
    signals.restore(state)
    assert signals.x[0] == np.searchsorted(TIMES, ends[29], "right") - 1
    assert [(signals.step(a, b - a), signals["y1"])[1] for a, b in pairwise(ends[29:])] == first


def test_machine_code_is_shared_by_all_tables():
    one, other = table(TIMES, VALUES), table([0, 1], [0, 1], [2, 3])
    assert type(one) is not type(other)
    assert type(one.block.s) is type(other.block.s)
    assert type(one).Values is type(other).Values


def test_a_table_is_held_once_beside_its_class():
    signals = table(TIMES, VALUES)
    assert signals.block is not None
    assert signals.block._initial.size < 50 < signals.block.memory.size

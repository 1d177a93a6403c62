"""Consistent initial values, as kernels over the records of a master: groups of simulators that feed one another, each behind those
that feed it.

A group of one simulator has its inputs and is initialized once. In a larger one the simulators are initialized one after the other
until their outputs stop changing. Where these sweeps do not converge, a quasi-Newton method continues from their best result: it
takes the outputs that a sweep starts with as unknowns, and learns from all its earlier answers (Anderson's method with full memory;
for a linear group of n unknowns n + 2 of its steps are enough but for rounding, up to a gain of a sweep of about 1e6). A group that
has not converged then has kinks, such as contacts that open: answers from before are of another piece, so the oldest are forgotten,
and where a step of the method does not bring the group closer, a few go the share of a sweep with which contacts contract.
"""

from __future__ import annotations

import numpy as np

from ....components.core.kernels import kernel
from ...units.call_names import FAILED, IN_MEMORY, NOTED
from ...units.calls import call_entry, store
from .kernels import _given, _read, _show
from .records import ABOUT_ZERO, BEYOND, CONVERGED, NOT_CONVERGED, SECANTS, STALLED

SWEEPS = 30
RUNAWAY = 1e12  # times the nominal value: no answer of a model any more, even where a nominal value was left at 1
RETURNED = 1e-7  # change of a miss relative to the change of an answer; below it a circle gives back what it gets
NEW = 1e-10  # share of an answer that earlier ones do not foretell; less of it is rounding
KINKED = 1e-8  # residual that is more than rounding: after the steps that a linear group needs, the group is not linear
RELAXED = 8  # such steps in a row at most; of 600 made-up pairs of wires under a head 1 does not settle in all, with 5 of them 8
LONGEST = 4 * SECANTS  # steps of a group with kinks, which remembers few of them
BEST, BEFORE, RIGHT, WEIGHTS, LENGTHS, SHARES, ANSWERS = range(7)  # rows of the workspace, and behind the last one:
MISSES, COLUMNS, TRIANGLE, ROWS = (ANSWERS + k * SECANTS for k in range(1, 5))


@kernel
def _initialize(unit, m, t):
    """Initialize one simulator with its present inputs and read its outputs; returns the status."""
    links, own = m.links, m.units[unit.slow] if unit.input_mode == NOTED else unit
    for k in range(unit.links):
        link = links[unit.first_link + k]
        link.looked = _given(link, m.signals)
        if own.input_mode == IN_MEMORY:
            store(links[own.first_link + k].at, link.looked)
    status = FAILED * call_entry(unit.initialize, t, 0.0, own.argument)
    if status == 0 and own.input_mode == IN_MEMORY:
        status = _read(own, m.outputs_at, m.signals)
        if unit.input_mode == NOTED:
            _show(unit, m.units, links, m.pasts, m.signals)
    return status


@kernel
def _sweep(group, m, t):
    """Initialize the simulators of a group one after the other; returns whether all have succeeded."""
    for place in range(group.first, group.last):
        status = _initialize(m.units[m.initial_order[place]], m, t)
        if status != 0:
            m.request[0].unit, m.request[0].status = m.initial_order[place], status
            return False
    return True


@kernel
def _copy_outputs(group, m, row):
    """Copy the outputs of a group into a row of `answers`."""
    for j in range(group.answers):
        m.space[row, j] = m.signals[m.answers[group.first_answer + j].cell]


@kernel
def _bounded(group, m):
    """Whether all outputs of a group are numbers and none has run away."""
    for j in range(group.answers):
        answer = m.answers[group.first_answer + j]
        if not abs(m.signals[answer.cell]) < RUNAWAY / ABOUT_ZERO * answer.least:
            return False
    return True


@kernel
def _residual(group, m, row):
    """Largest relative change of the outputs of a group against a row of `answers`; infinite where an output has run away."""
    if not _bounded(group, m):
        return np.inf
    largest = 0.0
    for j in range(group.answers):
        answer = m.answers[group.first_answer + j]
        v, before = m.signals[answer.cell], m.space[row, j]
        change = abs(v - before) / max(max(abs(v), abs(before)), answer.least)
        if change > largest:
            largest, group.worst = change, answer.cell
    return largest


@kernel
def _within(residual, last):
    """Whether a group has converged: its outputs stand, or change by no more than rounding and no longer less and less."""
    return residual <= CONVERGED or 0.5 * last <= residual <= STALLED


@kernel
def _solve_group(group, m, t):
    """Initialize a group until its outputs stand; returns whether they do."""
    smallest, last = np.inf, np.inf
    if group.last - group.first == 1:
        group.sweeps = 1
        return _sweep(group, m, t) and _bounded(group, m)
    _copy_outputs(group, m, BEST)
    for sweep in range(1, SWEEPS + 1):
        _copy_outputs(group, m, BEFORE)
        if not _sweep(group, m, t):
            return False
        group.sweeps = sweep
        group.residual = residual = _residual(group, m, BEFORE)
        if _within(residual, last):
            return True
        if residual == np.inf:
            break
        miss = 0.0
        for j in range(group.answers):
            answer = m.answers[group.first_answer + j]
            miss = max(miss, abs(m.signals[answer.cell] - m.space[BEFORE, j]) / answer.least)
        if miss < smallest:
            smallest = miss
            for j in range(group.answers):
                m.space[BEST, j] = m.space[BEFORE, j]
        last = residual
    return _solve_by_secants(group, m, t)


@kernel
def _solve_by_secants(group, m, t):
    """Continue from the best sweep by Anderson's method; returns whether the outputs stand."""
    unknowns, kept, last = _unknowns(group, m), 0, np.inf
    lowest, share, relaxed = np.inf, 1.0, 0
    for k in range(LONGEST):
        if kept == SECANTS or not _sweep_from_best(group, m, t):
            return False
        group.secants = k + 1
        group.residual = residual = _residual(group, m, BEST)
        if _within(residual, last):
            return True
        last = residual
        _copy_outputs(group, m, ANSWERS + kept)
        if not _store_misses(group, m, kept):
            return False
        size = _size_of_miss(group, m, kept)
        if kept > 0:
            share = min(share, _contraction(group, m, kept))
        kinked = k > unknowns + 1 and residual > KINKED
        if kinked and kept > unknowns:
            kept = _forget_oldest(group, m, kept)
        if kinked and size >= lowest and relaxed < RELAXED:
            _go_a_share(group, m, kept, share)
            relaxed += 1
        else:
            lowest, relaxed = size, 0
            _foretell(group, m, kept)
            _go_to_foretold(group, m, kept)
        kept += 1
    return False


@kernel
def _unknowns(group, m):
    """How many outputs of a group its sweeps depend on."""
    unknowns = 0
    for j in range(group.answers):
        unknowns += 1 if m.answers[group.first_answer + j].unknown != 0 else 0
    return unknowns


@kernel
def _sweep_from_best(group, m, t):
    """A sweep that starts with the row `BEST`; returns whether all units could be initialized."""
    for j in range(group.answers):
        m.signals[m.answers[group.first_answer + j].cell] = m.space[BEST, j]
    return _sweep(group, m, t)


@kernel
def _store_misses(group, m, k):
    """By how much the k-th answers miss what their sweep started with; returns whether all answers are finite."""
    answers, misses = m.space[ANSWERS + k], m.space[MISSES + k]
    for j in range(group.answers):
        unknown = m.answers[group.first_answer + j].unknown != 0
        misses[j] = answers[j] - m.space[BEST, j] if unknown else 0.0
        if not np.isfinite(answers[j]):
            return False
    return True


@kernel
def _size_of_miss(group, m, k):
    """Sum of squares of the k-th misses, relative to the least values."""
    size = 0.0
    for j in range(group.answers):
        size += (m.space[MISSES + k, j] / m.answers[group.first_answer + j].least) ** 2
    return size


@kernel
def _contraction(group, m, k):
    """Share of a sweep with which contacts contract, from the k-th answers and those before; notes a circle that gives back what
    it gets."""
    space, returned, moved, turned, way = m.space, 0.0, 0.0, 0.0, 0.0
    for j in range(group.answers):
        answer = m.answers[group.first_answer + j]
        if answer.unknown == 0:
            continue
        change = space[MISSES + k, j] - space[MISSES + k - 1, j]
        move = space[ANSWERS + k, j] - space[ANSWERS + k - 1, j]
        returned, moved = max(returned, abs(change)), max(moved, abs(move))
        turned += (change / answer.least) ** 2
        way += ((move - change) / answer.least) ** 2
    if returned < RETURNED * moved:
        group.parallel = 1
    return np.sqrt(way / turned) if turned > 0.0 else np.inf


@kernel
def _forget_oldest(group, m, k):
    """Move answers and misses one row up; returns the row of the newest."""
    for i in range(k):
        for j in range(group.answers):
            m.space[ANSWERS + i, j] = m.space[ANSWERS + i + 1, j]
            m.space[MISSES + i, j] = m.space[MISSES + i + 1, j]
    return k - 1


@kernel
def _go_a_share(group, m, k, share):
    """Go a share of the way to the k-th answers."""
    for j in range(group.answers):
        m.space[BEST, j] += share * m.space[MISSES + k, j]


@kernel
def _go_to_foretold(group, m, k):
    """Go to the answers weighted as `_foretell` says."""
    for j in range(group.answers):
        newest = m.space[ANSWERS + k, j]
        value = newest
        for i in range(k):
            value += (m.space[ANSWERS + i, j] - newest) * m.space[WEIGHTS, i]
        m.space[BEST, j] = value


@kernel
def _foretell(group, m, k):
    """Weights of the answers 0 ... k - 1 against the k-th, so that the weighted sum of the misses vanishes as far as possible.

    The shortest solution of least squares, by orthogonalization with the longest rest first.
    """
    space, order, n = m.space, m.pivots, group.answers
    right, weights, lengths, shares = space[RIGHT], space[WEIGHTS], space[LENGTHS], space[SHARES]
    for j in range(n):
        size = max(abs(space[ANSWERS + k, j]), m.answers[group.first_answer + j].least)
        right[j] = -space[MISSES + k, j] / size
        for i in range(k):
            space[COLUMNS + i, j] = (space[MISSES + i, j] - space[MISSES + k, j]) / size
    for i in range(k):
        column = space[COLUMNS + i]
        lengths[i], order[i], weights[i] = max(_length(column, n), 1e-300), i, 0.0
        for j in range(n):
            column[j] /= lengths[i]
    rank = 0
    while rank < k:
        longest, pivot = NEW, -1
        for i in range(rank, k):
            length = _length(space[COLUMNS + order[i]], n)
            if length > longest:
                longest, pivot = length, i
        if pivot < 0:
            break
        order[rank], order[pivot] = order[pivot], order[rank]
        axis, triangle = space[COLUMNS + order[rank]], space[TRIANGLE + rank]
        triangle[order[rank]] = longest
        for j in range(n):
            axis[j] /= longest
        for i in range(rank + 1, k):
            column = space[COLUMNS + order[i]]
            triangle[order[i]] = _project(axis, column, n)
            triangle[order[i]] += _project(axis, column, n)  # what rounding has left
        rank += 1
    for i in range(rank):
        shares[i] = _project(space[COLUMNS + order[i]], right, n)
    for i in range(rank):  # of the solutions the shortest: rows are made orthogonal, too
        row = space[TRIANGLE + i]
        for j in range(i):
            row[order[j]] = 0.0
        for j in range(i):
            shares[i] -= (_project(space[TRIANGLE + j], row, k) + _project(space[TRIANGLE + j], row, k)) * shares[j]
        length = _length(row, k)
        shares[i] /= length
        for j in range(k):
            row[j] /= length
            weights[j] += shares[i] * row[j]
    for i in range(k):
        weights[i] /= lengths[i]


@kernel
def _length(v, n):
    """Euclidean length of the first n elements."""
    total = 0.0
    for j in range(n):
        total += v[j] * v[j]
    return np.sqrt(total)


@kernel
def _project(axis, v, n):
    """Take the part along an axis of length 1 out of v; returns how much that was."""
    share = 0.0
    for j in range(n):
        share += axis[j] * v[j]
    for j in range(n):
        v[j] -= share * axis[j]
    return share


@kernel
def initialize_groups(t, h, m):
    """Initialize all groups; see `records.REQUEST` for what is answered where one does not succeed."""
    request = m.request[0]
    request.unit, request.status, request.row = -1, 0, 0
    for k in range(m.groups.size):
        request.row = k
        group = m.groups[k]
        group.sweeps, group.secants, group.residual, group.worst, group.parallel = 0, 0, 0.0, 0, 0
        if not _solve_group(group, m, t):
            if request.unit < 0:
                request.unit = BEYOND if group.last - group.first == 1 else NOT_CONVERGED
            return 0
    return 0

"""Loads of gusts on the nodes of the mesh, by sample in time and by station along the line: kernels."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..core.kernels import kernel, kernel_tuple
from .wires import contacts_at

BEYOND = 32  # nodes that are kept ready on either side of those that move
UNREADY = -1e9  # number of a sample that is never asked for
SAMPLE, FIRST, LAST, LOADS = 0, 1, 2, 3  # of the state: number of the sample, nodes with loads, the loads of two samples


INTERVAL, DISTANCE, FIELDS = 0, 1, 2  # of `Buffeting.grid`


@kernel_tuple
class Buffeting(NamedTuple):
    """Waves of the wind's fields and their loads on the mesh: the vertical field, then the one across the line if it lifts."""

    grid: np.ndarray  # (3,) s between samples, m between stations, straight in between; number of fields
    random: np.ndarray  # (5, n) what is random: place of each frequency within its band, wave numbers and phases of both fields
    omega: np.ndarray  # (n,) 1/s
    amplitude: np.ndarray  # (2, n) m/s
    wave: np.ndarray  # (2, n) 1/m
    phase: np.ndarray  # (2, n)
    turn: np.ndarray  # (2, 2, n) cosine and sine of a wave from station to station
    at_station: np.ndarray  # (2, 2, n) workspace: amplitude times cosine and sine
    push: np.ndarray  # (2, N) N.s/m, force on a node over the wind's speed; that of the vertical field also damps


@kernel
def load_nodes(t, first, last, mesh, gusts, out):
    """Force of the gusts at time t on the nodes first to last, N, into out (N,)."""
    W = mesh.bending_gradient.size
    for j in range(W * first, W * last + W):
        out[j] = 0.0
    for r in range(int(gusts.grid[FIELDS])):
        distance = gusts.grid[DISTANCE]
        station = int(mesh.position[first] / distance)
        left = 0.0
        for i in range(gusts.omega.size):
            angle = gusts.omega[i] * t + gusts.wave[r, i] * station * distance + gusts.phase[r, i]
            gusts.at_station[r, 0, i] = gusts.amplitude[r, i] * math.cos(angle)
            gusts.at_station[r, 1, i] = gusts.amplitude[r, i] * math.sin(angle)
            left += gusts.at_station[r, 0, i]
        right = next_station(r, gusts)
        for node in range(first, last + 1):
            while mesh.position[node] >= (station + 1) * distance:
                station += 1
                left = right
                right = next_station(r, gusts)
            share = mesh.position[node] / distance - station
            speed = left + share * (right - left)
            for j in range(W * node, W * node + W):
                out[j] += gusts.push[r, j] * speed


@kernel
def next_station(r, gusts):
    """Turns all waves of field r on to the next station; its speed there, m/s."""
    now, turn = gusts.at_station, gusts.turn
    n = gusts.omega.size
    for i in range(n):
        c, s = now[r, 0, i], now[r, 1, i]
        now[r, 0, i] = c * turn[r, 0, i] - s * turn[r, 1, i]
        now[r, 1, i] = s * turn[r, 0, i] + c * turn[r, 1, i]
    one, two, three, four = 0.0, 0.0, 0.0, 0.0  # four sums side by side: one alone waits for each addition
    for i in range(0, n - 3, 4):
        one += now[r, 0, i]
        two += now[r, 0, i + 1]
        three += now[r, 0, i + 2]
        four += now[r, 0, i + 3]
    for i in range(n - n % 4, n):
        one += now[r, 0, i]
    return one + two + three + four


@kernel
def follow_gusts(t, lo, hi, state, mesh, gusts):
    """Loads of the samples around the time t, ready on the nodes lo to hi; gives the share of the second one, 0 to 1.

    state: number of the first sample, first and last node with loads, loads of both samples (N,) each.
    """
    N, nodes = mesh.mass.size, mesh.position.size
    interval = gusts.grid[INTERVAL]
    sample = math.floor(t / interval)
    before, after = state[LOADS : LOADS + N], state[LOADS + N : LOADS + 2 * N]
    ready = state[FIRST] <= lo and hi <= state[LAST]
    if sample == state[SAMPLE] + 1.0 and ready:
        for j in range(N):
            before[j] = after[j]
        load_nodes((sample + 1.0) * interval, int(state[FIRST]), int(state[LAST]), mesh, gusts, after)
    elif sample != state[SAMPLE] or not ready:
        state[FIRST], state[LAST] = max(lo - BEYOND, 0), min(hi + BEYOND, nodes - 1)
        load_nodes(sample * interval, int(state[FIRST]), int(state[LAST]), mesh, gusts, before)
        load_nodes((sample + 1.0) * interval, int(state[FIRST]), int(state[LAST]), mesh, gusts, after)
    state[SAMPLE] = sample
    return t / interval - sample


@kernel
def gust_state(points, mesh):
    """Where in the catenary's state that of `follow_gusts` begins: behind that of the contact points."""
    return contacts_at(mesh.mass.size) + 2 * points.shape[0]


@kernel
def add_gusts(share, before, after, force):
    """Add the gusts' loads to the nodal forces, (k,) each, N."""
    for j in range(force.size):
        force[j] += before[j] + share * (after[j] - before[j])


@kernel
def accelerate_by_gusts(share, before, after, over_mass, a):
    """Add the gusts' loads over the masses to the accelerations, (k,) each."""
    for j in range(a.size):
        a[j] += over_mass[j] * (before[j] + share * (after[j] - before[j]))


@kernel
def load_at(t, position, i, state, mesh, gusts):
    """Lift per length of the gusts on the first contact wire at a position of element i, N/m."""
    N, W = mesh.mass.size, mesh.bending_gradient.size
    share = t / gusts.grid[INTERVAL] - state[SAMPLE]
    s = (position - mesh.position[i]) / mesh.length[i]
    total = 0.0
    for node, weight in ((i, 1.0 - s), (i + 1, s)):
        before, after = state[LOADS + W * node], state[LOADS + N + W * node]
        total += weight * (before + share * (after - before)) * 2.0 / (mesh.length[max(node - 1, 0)] + mesh.length[node])
    return total

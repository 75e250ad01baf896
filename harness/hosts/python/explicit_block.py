"""Explicit dynamics of a block on a rough base with the VUMAT of libasperity, in place of an explicit host.

An elastic block of hexahedra is pressed on a rigid base by its top, and its ends are then moved along the
base, by central differences.  The joint has a point at every node of the base.  Units: mm, N, MPa, t, s.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass

import numpy as np
from asperity import Interface, library
from numpy.typing import NDArray
from scipy import sparse

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

LENGTH, DEPTH, HEIGHT = 200.0, 100.0, 50.0
YOUNG, POISSON, DENSITY = 6000.0, 0.15, 2.0e-9
DIRECTION = 20.0
"""Of the slip, degrees from x."""

STABLE = 0.5
"""Time increment over the time of a wave through an element."""

DAMPING = 0.2
"""Damping proportional to the stiffness of the block, as a part of the time increment."""

PRELOAD_TIME, SLIP_TIME = 2.0e-3, 10.0e-3
BLOCK = 136
"""Most points of a call (Abaqus)."""

ROWS = 60
"""Rows of the result; each is a mean over the increments since the row before."""


@dataclass(frozen=True)
class Result:
    """Slip, force along it and rise of the top (ROWS,)."""

    slip: Floats
    force: Floats
    rise: Floats


class Points:
    """Points of the joint in a block of at most BLOCK, as Abaqus/Explicit passes them to a VUMAT."""

    def __init__(self, interface: Interface, n: int) -> None:
        """Create n virgin points."""
        self._vumat = ctypes.CDLL(str(library())).vumat_
        self._n = n
        props = interface.props()
        counts = [n, 1, 2, interface.nstatv, 0, len(props), 0]
        self._counts = [ctypes.c_int(value) for value in counts]
        self._times = [ctypes.c_double() for _ in range(3)]
        self.increment = np.zeros((3, n))  # of Fortran (n, 3): N, 23 and 13, half of the slips
        self.stress = [np.zeros((3, n)) for _ in range(2)]
        self._state = [np.zeros((interface.nstatv, n)) for _ in range(2)]
        self._energies = [[np.zeros(n) for _ in range(2)] for _ in range(2)]
        self._density, self._unset = np.full(n, DENSITY), np.zeros((9, n))
        self._props = props.copy()
        self._calls = [self._arguments(old, 1 - old) for old in (0, 1)]
        self._old = 0

    def _arguments(self, old: int, new: int) -> list[object]:
        """Arguments in the order of the interface, with the length of the name at the end."""
        name = ctypes.create_string_buffer(b"JOINT".ljust(80), 80)
        unset = _address(self._unset)
        of_old = [_address(x) for x in (self.stress[old], self._state[old], *self._energies[old])]
        of_new = [_address(x) for x in (self.stress[new], self._state[new], *self._energies[new])]
        return [
            *map(ctypes.byref, self._counts), *map(ctypes.byref, self._times), name, unset, unset,
            _address(self._props), _address(self._density), _address(self.increment), unset, unset, unset,
            unset, unset, *of_old, unset, unset, unset, unset, *of_new, ctypes.c_size_t(80),
        ]  # fmt: skip

    def advance(self, step: Floats, when: float, dt: float) -> Floats:
        """Tractions (N, Tx, Ty), (3, n), after an increment of the separation (3, n) in the same order."""
        self.increment[0] = step[0]
        self.increment[1] = 0.5 * step[2]
        self.increment[2] = 0.5 * step[1]
        for value, given in zip(self._times, (when, when, dt), strict=True):
            value.value = given
        self._vumat(*self._calls[self._old])
        self._old = 1 - self._old
        return self.stress[self._old][[0, 2, 1]]


def _address(array: Floats) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)


def run(law: Interface, pressure: float, slip: float, nx: int = 24, ny: int = 12, nz: int = 3) -> Result:
    """Press the block, then move its ends by `slip`; raises RuntimeError if the law rejects a call."""
    grid, stiffness, mass, dt = _model(nx, ny, nz)
    base, top = grid[:, :, 0].ravel(), grid[:, :, -1].ravel()
    ends = grid[[0, -1]].ravel()
    shares = np.outer(_trapezoid(nx), _trapezoid(ny)).ravel() * LENGTH * DEPTH
    area, load = shares, np.zeros(3 * grid.size)
    load[3 * top + 2] = -pressure * shares
    angle = np.radians(DIRECTION)
    along = np.array([np.cos(angle), np.sin(angle)])
    parts = [slice(i, min(i + BLOCK, len(base))) for i in range(0, len(base), BLOCK)]
    points = [Points(law, part.stop - part.start) for part in parts]
    of_points = np.stack([3 * base + 2, 3 * base, 3 * base + 1])  # N, Tx, Ty
    u, velocity = np.zeros(3 * grid.size), np.zeros(3 * grid.size)
    preload, increments = round(PRELOAD_TIME / dt), round(SLIP_TIME / dt)
    before = np.zeros((3, len(base)))
    traction = np.zeros((3, len(base)))
    force, rise = np.zeros(increments), np.zeros(increments)
    pressed = 0.0
    for k in range(preload + increments):
        share = _smooth((k + 1) / (0.5 * preload))
        speed = slip / SLIP_TIME * (k >= preload)
        separation = u[of_points]
        for part, block in zip(parts, points, strict=True):
            traction[:, part] = block.advance(separation[:, part] - before[:, part], (k + 1) * dt, dt)
        before = separation
        internal = stiffness @ (u + DAMPING * dt * velocity)
        internal[of_points] += area * traction
        velocity += dt / mass * (share * load - internal)
        # the ends move along the slip, and have all the time to accelerate in the first twentieth of it
        speed *= _smooth((k - preload + 1) / (0.05 * increments))
        velocity[3 * ends], velocity[3 * ends + 1] = speed * along
        u = u + dt * velocity
        if k == preload - 1:
            pressed = u[3 * top + 2].mean()
        if k >= preload:
            i = k - preload
            force[i] = area @ (along @ traction[1:])
            rise[i] = u[3 * top + 2].mean() - pressed
    if not np.isfinite(force).all():
        raise RuntimeError("the law rejected a call: see the messages above")
    rows = np.array_split(np.arange(increments), ROWS)
    mean = [[values[i].mean() for i in rows] for values in (force, rise)]
    slips = slip * np.array([(i.mean() + 1) / increments for i in rows])
    return Result(slips, *map(np.array, mean))


def _smooth(t: float) -> float:
    """Smooth step from 0 to 1."""
    t = min(max(t, 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


def _trapezoid(n: int) -> Floats:
    """Weights of n + 1 points."""
    weights = np.full(n + 1, 1.0 / n)
    weights[[0, -1]] *= 0.5
    return weights


def _model(nx: int, ny: int, nz: int) -> tuple[Integers, sparse.csr_array, Floats, float]:
    """Nodes (nx + 1, ny + 1, nz + 1), stiffness, lumped masses, time increment of a block."""
    grid = np.arange((nx + 1) * (ny + 1) * (nz + 1)).reshape(nx + 1, ny + 1, nz + 1)
    sizes = np.array([LENGTH / nx, DEPTH / ny, HEIGHT / nz])
    corners = [(a, b, c) for a in (0, 1) for b in (0, 1) for c in (0, 1)]
    cells = np.stack([grid[a : nx + a, b : ny + b, c : nz + c].ravel() for a, b, c in corners], axis=-1)
    unknowns = (3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), -1)
    element = _element(sizes, np.array(corners))
    rows, columns = np.repeat(unknowns, 24, axis=1).ravel(), np.tile(unknowns, (1, 24)).ravel()
    values = np.tile(element.ravel(), len(cells))
    stiffness = sparse.coo_array((values, (rows, columns)), shape=(3 * grid.size,) * 2).tocsr()
    weights = np.einsum("i,j,k->ijk", *(_trapezoid(n) for n in (nx, ny, nz))).ravel()
    mass = np.repeat(DENSITY * LENGTH * DEPTH * HEIGHT * weights, 3)
    wave = np.sqrt(YOUNG * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON)) / DENSITY)
    return grid, stiffness, mass, float(STABLE * sizes.min() / wave)


def _element(sizes: Floats, corners: Integers) -> Floats:
    """Stiffness (24, 24) of a linear hexahedron with 2 x 2 x 2 points."""
    lame = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
    shear = YOUNG / (2 * (1 + POISSON))
    signs = 2.0 * corners - 1.0
    total = np.zeros((24, 24))
    for point in signs / np.sqrt(3.0):
        factors = 0.5 * (1.0 + signs * point)
        others = [np.prod(np.delete(factors, i, axis=1), axis=1) for i in range(3)]
        slopes = signs / sizes * np.stack(others, axis=1)
        strain = np.zeros((6, 24))
        for row, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))):
            strain[row, i::3] += slopes[:, j]
            if i != j:
                strain[row, j::3] += slopes[:, i]
        elastic = np.diag([2.0 * shear] * 3 + [shear] * 3)
        elastic[:3, :3] += lame
        total += strain.T @ elastic @ strain * np.prod(sizes) / 8.0
    return total

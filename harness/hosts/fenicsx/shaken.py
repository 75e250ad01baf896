"""Shaken joints on FEniCSx, a line each: names and numbers; m, MN, s.

- growth: of vibrations of an elastic block that slides on rock, largest real part of the eigenvalues, 1/s.
- slip: of the block after a pulse .9 g of the base for .5 s, whose ends are smoothed over 20 ms, by `Shake`.
- sharp: the same with a sudden pulse; alpha2: by TSALPHA2 of PETSc, whose parameters are Bossak's.
- wall: five blocks, and one on two edges, that rock on a rigid base; largest energy over that at the start.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from asperity import Interface, Material, Pattern
from asperity.fenicsx import COMM, Conditions, Model, Shake, State, Terms, solve, total
from asperity.fenicsx.response import respond
from asperity.fenicsx.tangent import Equations
from asperity.mesh import split
from petsc4py import PETSc

from harness.hosts.fenicsx.words import words_of
from harness.hosts.structured import grid

G, DENSITY = 9.81, 0.0024
PULSE, LENGTH, RAMP, END = 0.9, 0.5, 0.02, 1.15
"""Acceleration over g, its duration, that of its ends, and the end of the run."""


def bed(kn: float, mu: float, c: float = 0.0) -> Interface:
    """Flat joint without bond."""
    return Interface(Material.from_joint(kn=kn, ks=0.4 * kn, mu=mu, c=c), Pattern.regular(0, 0.0))


def block(cells: int = 6, E: float = 2e4, kn: float = 2e4, mu: float = 0.5, c: float = 0.0) -> Model:
    """Block of 6 x 3 m on a rock of the same size."""
    x, rows = np.linspace(0.0, 6.0, cells + 1), np.repeat([0, 1], cells // 2)
    return Model(split(grid(x, x, block=rows)), {"joint": bed(kn, mu, c)}, E, 0.2, plane="strain")


def growth(beta: float = 0.0, mu: float = 0.5, c: float = 0.0, **constants: float) -> float:
    """Largest real part of an eigenvalue that oscillates, of the block that slides; one rank."""
    m = block(mu=mu, **constants)
    kn = m.laws[0].material.kc * m.laws[0].material.K
    K, B = m.K.copy().convert("dense").getDenseArray(), np.zeros((len(m.area), 2, 2 * m.n))
    for matrix, (a, b), axes in zip(B, m.pairs, m.axes, strict=True):
        matrix[:, 2 * a : 2 * a + 2], matrix[:, 2 * b : 2 * b + 2] = -axes[:2], axes[:2]
    J = np.einsum("pkd,kl,ple,p->de", B, [[1.0, 0.0], [-mu, 0.0]], B, m.area, optimize=True)
    free = np.flatnonzero(np.repeat(m.x[:, 1] > 1e-9, 2))
    M = np.abs(m.body([DENSITY] * 2))[free][:, None]
    A, C = (K + kn * J)[np.ix_(free, free)], (beta * K + c * J)[np.ix_(free, free)]
    eigenvalues = np.linalg.eigvals(np.block([[0.0 * A, np.eye(len(A))], [-A / M, -C / M]]))
    return float(eigenvalues[np.abs(eigenvalues.imag) > 1.0].real.max())


def base(ramp: float) -> Callable[[float], list[float]]:
    """Acceleration of the base, which pushes the block to +x."""

    def rise(t: float) -> float:
        return 0.5 - 0.5 * np.cos(np.pi * np.clip(t / ramp, 0.0, 1.0)) if ramp else float(t > 0.0)

    return lambda t: [-PULSE * G * (rise(t) - rise(t - LENGTH)), 0.0]


TERMS = Terms(dt=1e6, tolerance=1e-8)
"""Of a state at rest."""


def at_rest(m: Model, fixed: np.ndarray) -> tuple[State, Conditions]:
    """State of a model that carries its weight, and what holds and loads it."""
    conditions = Conditions(fixed, load=m.body([0.0, -DENSITY * G]))
    return solve(m, State.virgin(m), conditions, TERMS).taken(), conditions


def slip(dt: float, ramp: float, beta: float, cells: int = 6, c: float = 0.0) -> tuple[float, Shake]:
    """Mean slip at the end."""
    m = block(cells, c=c)
    rest = at_rest(m, m.dofs(m.x[:, 1] < 1e-9, 0, 1))
    shake = Shake(m, *rest, np.abs(m.body([DENSITY] * 2)), dt, ground=base(ramp), beta=beta)
    return total(shake.run(END).s[:, 1] @ m.area) / total(m.area.sum()), shake


def alpha2(dt: float, ramp: float) -> float:
    """Mean slip at the end by TSALPHA2, undamped; the state of the joints is accepted after each step."""
    m = block()
    state, conditions = at_rest(m, m.dofs(m.x[:, 1] < 1e-9, 0, 1))
    mass, ground, fixed = np.abs(m.body([DENSITY] * 2)), base(ramp), np.unique(conditions.fixed)
    down, dry = conditions.load, np.zeros(len(m.pairs))
    equations = Equations(m, fixed, "")
    x, v = m.K.createVecs()
    x.array[:] = state.u
    ts = PETSc.TS().create(COMM)
    ts.setType(PETSc.TS.Type.ALPHA2)

    def law(u):
        return respond(m, state, m.separations(u.array_r), dt, dry)

    def residual(ts, t, u, v, a, f):
        forces = m.stiff(u.array_r) + m.pulled(law(u).t)
        f.array[:] = mass * (a.array_r + np.tile(ground(t), m.n)) + forces - down
        f.array[fixed] = m.scale * u.array_r[fixed]

    def jacobian(ts, t, u, v, a, shift_v, shift_a, A, P):
        equations.assemble(law(u).D, shift_a * mass, 0.0, 0.0, False)

    def accept(ts):
        nonlocal state
        u = ts.getSolution()
        state = replace(state, s=m.separations(u.array_r), joints=law(u).joints)

    ts.setI2Function(residual, x.duplicate())
    ts.setI2Jacobian(jacobian, equations.A)
    ts.setSolution2(x, v)
    ts.setTimeStep(dt)
    ts.setMaxTime(END)
    ts.setExactFinalTime(PETSc.TS.ExactFinalTime.STEPOVER)
    ts.setPostStep(accept)
    bossak = {"alpha_m": 4 / 3, "alpha_f": 1, "gamma": 5 / 6, "beta": 4 / 9}
    words = " ".join(f"-ts_alpha_{name} {value!r}" for name, value in bossak.items())
    PETSc.Options().insertString(f"{words} -ts_adapt_type none")
    ts.setFromOptions()
    ts.getSNES().setTolerances(rtol=1e-8)
    ts.solve(x)
    return float(state.s[:, 1] @ m.area / m.area.sum())


def wall(
    blocks: int, edges: bool, dt: float = 5e-4, end: float = 0.55, turn: float = 0.1
) -> tuple[Shake, float]:
    """A wall of the half sizes .1 and .5 m that begins to turn about a corner; edges: contact there alone."""
    b, h, kn, cells = 0.1, 0.5, 2e5, 1 if edges else 8
    rows = np.append(0, 1 + np.arange(10) * blocks // 10)
    mesh = grid(np.linspace(-b, b, cells + 1), np.append(-0.2, np.linspace(0.0, 2.0 * h, 11)), block=rows)
    law = bed(kn, 0.7, 2.0 * np.sqrt(kn * DENSITY * 2.0 * h))
    m = Model(split(mesh), {"joint": law}, 2e6 if edges else 2e4, 0.2, plane="strain")
    rock = (m.x[:, 1] < -0.1) | (m.solid("block_0")[::2] > 0.0)
    state, conditions = at_rest(m, m.dofs(rock, 0, 1))
    v = turn * np.column_stack([m.x[:, 1], b - m.x[:, 0]]).ravel() * m.solid(*m.names[1:])
    shake = Shake(m, replace(state, v=v), conditions, np.abs(m.body([DENSITY] * 2)), dt)
    first, start, most = shake.ledger.kinetic, shake.ledger.balance, 1.0
    while shake.at < end:
        if shake.advance(end):
            most = max(most, 1.0 + (shake.ledger.balance - start) / first)
    return shake, most


def climb(d: int, theta: float, dt: float = 5e-4, xi: float = 1.0, end: float = 0.4) -> tuple[float, Shake]:
    """Way of a stiff slab, on rough joints with one plane, after a pulse 1.5 g for .1 s; in d dimensions.

    In space the plane faces a direction of 30 degrees in the joint, along which the base moves.
    """
    mass, kn, mu, a = 0.0072, 2e5, 0.5, np.radians(30.0) if d == 3 else 0.0
    plane = Pattern.planes([[np.cos(np.radians(theta)), -np.sin(np.radians(theta)), 0.0]], [1.0])
    law = Interface(Material.from_joint(kn, 0.4 * kn, mu, c=2.0 * xi * np.sqrt(kn * mass)), plane)
    side, up, density = np.linspace(0.0, 2.0, 4), [-0.2, 0.0, 0.2], mass / 0.2
    ways = np.array([np.cos(a), np.sin(a), 0.0] if d == 3 else [1.0, 0.0])
    jointed = split(grid(*[side] * (d - 1), up, block=np.arange(2)), direction=ways)
    m = Model(jointed, {"joint": law}, 2e6, 0.2, plane="strain")
    down = np.r_[np.zeros(d - 1), -density * G]
    conditions = Conditions(np.flatnonzero(m.solid("block_0")), load=m.body(down))
    start = solve(m, State.virgin(m), conditions, TERMS).taken()
    mass_of_nodes = np.abs(m.body([density] * d))
    ground = lambda t: -1.5 * G * ways * (t < 0.1 - 1e-9)  # noqa: E731
    shake = Shake(m, start, conditions, mass_of_nodes, dt, ground=ground)
    way = np.linalg.norm(shake.run(end).s - start.s, axis=1)
    return total(way @ m.area) / total(m.area.sum()), shake


def main() -> None:
    """Print the numbers of the words, or of all."""
    words = words_of(__doc__)
    warnings.simplefilter("ignore")

    def show(name: str, *numbers: float) -> None:
        if COMM.rank == 0:
            print(f"{name}:", *(f"{number:.6g}" for number in numbers), flush=True)

    if not words or "growth" in words:
        for name, kind in {
            "growth": {}, "growth beta": {"beta": 1e-5}, "growth fine": {"cells": 12}, "growth c": {"c": 5.0},
            "growth stiff": {"E": 2e6}, "growth frictionless": {"mu": 0.0},
        }.items():  # fmt: skip
            show(name, growth(**kind))
    for name, kind in {
        "slip": (1e-3, RAMP, 1e-5), "slip half": (5e-4, RAMP, 1e-5), "slip fine": (1e-3, RAMP, 1e-5, 12),
        "sharp": (1e-3, 0.0, 1e-5), "alone": (1e-3, RAMP, 0.0), "coarse": (2e-3, RAMP, 0.0),
    }.items():  # fmt: skip
        if not words or name.split()[0] in words:
            slipped, shake = slip(*kind)
            show(name, slipped, shake.gained, shake.cuts, shake.taken)
    if not words or "alpha2" in words:
        show("alpha2", alpha2(2e-3, RAMP))
    for d in (2, 3):
        for theta in (0.0, 10.0, 20.0):
            if not words or "climb" in words or f"climb{d}" in words:
                slipped, shake = climb(d, theta)
                show(f"climb{d} {theta:g}", slipped, shake.gained, shake.cuts, shake.taken)
    for name, kind in {"wall": (5, False), "edges": (1, True)}.items():
        if not words or name in words:
            shake, most = wall(*kind)
            show(name, most, shake.gained, shake.at, shake.cuts, shake.taken)


if __name__ == "__main__":
    main()

"""A rough joint between two arms whose ends are turned: double cantilever beam, plane strain; mm, N, MPa.

Prints a line for each mix of the turns: ratio of the moments, share of mode II, J by the beams, the energy
that the joint spends per advance of the crack, and its part of friction.
"""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
from asperity import Interface, Material, Pattern, contract
from asperity.fenicsx import COMM, Conditions, Follow, Model, State, total
from asperity.mesh import split

from harness.hosts.structured import grid

ARM, LENGTH, CRACK, E, NU, GC = 2.0, 60.0, 8.0, 3e4, 0.2, 0.15
"""Height of an arm, length, length of the crack at the start; constants of arms and bond."""

TURNS = (-1.0, -0.5, 0.0, 0.3, 0.5, 0.8, 1.0)
"""Turn of the lower arm over that of the upper one: -1 opens the crack, 1 shears it."""


def joint(mu: float) -> Interface:
    """Rough joint with a bond."""
    material = Material(sigma0=3.0, Gc=GC, eta=0.9, mu=mu, kc=100.0, height=0.5)
    return Interface(material, Pattern.regular(2, 45.0))


def peel(ratio: float, mu: float) -> tuple[float, ...]:
    """Numbers of a run until three quarters of the length are broken."""
    x, y = np.linspace(0.0, LENGTH, 121), np.linspace(-ARM, ARM, 17)
    law = joint(mu)
    m = Model(split(grid(x, y, block=y[:-1] >= 0.0)), {"joint": law}, E, NU, plane="strain")
    # the crack at the start
    first = contract.N_POINT_STATEV
    planes = slice(first, first + contract.N_PLANE_STATEV * law.n_planes, contract.N_PLANE_STATEV)
    start = State.virgin(m)
    damaged = start.joints[0].copy()
    damaged[m.places[:, 0] < CRACK, planes] = 1.0
    nodes, _ = m.group("left")
    upper = m.solid("block_1").reshape(-1, 2)[nodes, 0] > 0.0
    lever = m.x[nodes, 1] - np.where(upper, 0.5, -0.5) * ARM
    turned = np.zeros((m.n, 2))
    turned[nodes, 0] = np.where(upper, 1.0, ratio) * lever
    fixed, start = (
        np.r_[m.dofs(nodes, 0), m.dofs(m.group("right")[0], 0, 1)],
        replace(start, joints=(damaged,)),
    )
    follow = Follow(m, start, lambda t: Conditions(fixed, t * turned.ravel()[fixed]), 2e-4, 1e-3)
    stiff, kinds = E / (1.0 - NU**2), [contract.statev_index(name) for name in ("rupture", "friction")]
    rows = []
    for report in follow.to(0.3):
        force, joint_state = report.reaction.reshape(-1, 2)[nodes, 0], follow.state.joints[0]
        moment, axial = (
            [total((force * arm)[side].sum()) for side in (upper, ~upper)]
            for arm in (lever, 1.0 + 0.0 * lever)
        )
        # energy of the beams before the crack less that of the beam behind it, per area
        behind = moment[0] + moment[1] + 0.5 * ARM * (axial[0] - axial[1]), axial[0] + axial[1]
        J = sum(6.0 * M**2 / ARM**3 for M in moment) + sum(0.5 * F**2 / ARM for F in axial)
        J = (J - 0.75 * behind[0] ** 2 / ARM**3 - 0.25 * behind[1] ** 2 / ARM) / stiff
        opening = 3.0 * (moment[0] - moment[1]) ** 2 / (stiff * ARM**3)
        area, spent = total(joint_state[:, 0] @ m.area), m.area @ joint_state[:, kinds]
        rows.append((moment[1] / moment[0], 1.0 - opening / J, J, area, *map(total, spent)))
        if area > 0.75 * LENGTH:
            break
    table = np.array(rows)
    # the second half of the way of the crack
    k = int(np.searchsorted(table[:, 3], 0.5 * (table[0, 3] + table[-1, 3])))
    rupture, friction = (table[-1, 4:] - table[k, 4:]) / (table[-1, 3] - table[k, 3])
    return *table[k:, :3].mean(axis=0), rupture + friction, friction


def main() -> None:
    """Run all mixes with friction and without."""
    warnings.simplefilter("ignore")
    for mu in (0.8, 0.0):
        for ratio in TURNS:
            numbers = peel(ratio, mu)
            if COMM.rank == 0:
                print(f"mu {mu:g} turn {ratio:g}:", *(f"{number:.5g}" for number in numbers), flush=True)


if __name__ == "__main__":
    main()

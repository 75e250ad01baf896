"""Slender walls whose toe crushes on FEniCSx, a line each: share of the strength, force found and expected.

A wall of 1000 x 2500 x 102 mm stands on a dry joint with a compressive strength fc, carries N and is pushed
at its top until nothing carries more.  With a toe that yields at fc on the length N/(fc t) the force is
N (L - N/(fc t))/(2 H).  Where the shear of the toe takes part, its pressure is fc/sqrt(1 + Css (V/N)^2).
"""

from __future__ import annotations

import argparse
import math
import warnings
from contextlib import suppress
from pathlib import Path

import numpy as np
from asperity import Interface, Material, Pattern
from asperity.contract import Floats
from asperity.fenicsx import COMM, Branch, Conditions, Follow, Model, Output, State, Stopped, Terms, solve
from asperity.mesh import split
from asperity.options import add_options
from asperity.tools.style import COLOURS, TWO, new_figure, printed, save

from harness.hosts.structured import grid

LENGTH, HEIGHT, THICKNESS = 1000.0, 2500.0, 102.0
FC, KN, E = 6.2, 50.0, 1e5
"""Of calcium-silicate masonry; the wall is stiff beside its joint, as the closed form has it."""

SHARES = 0.1, 0.2, 0.3
"""Of the vertical force over fc L t."""


def expected(share: float, Css: float = 0.0, height: float = HEIGHT) -> float:
    """Largest horizontal force over the vertical one, by a toe that yields."""
    ratio = 0.0
    for _ in range(100):
        ratio = LENGTH / (2.0 * height) * (1.0 - share * math.sqrt(1.0 + Css * ratio**2))
    return ratio


class Toe:
    """A wall under its vertical force."""

    def __init__(
        self, share: float, Gfc: float, Css: float = 0.0, cells: int = 50, height: float = HEIGHT
    ) -> None:
        """Build the wall and press it; height: of the force above the joint."""
        material = Material.from_joint(kn=KN, ks=0.4 * KN, mu=1.3, fc=FC, Gfc=Gfc, Css=Css)
        y = np.r_[-100.0, np.linspace(0.0, height, 26)]
        whole = grid(np.linspace(0.0, LENGTH, cells + 1), y, block=y[:-1] >= 0.0) if COMM.rank == 0 else None
        law = Interface(material, Pattern.regular(0, 0.0))
        mesh = split(whole) if whole else None
        self.model = m = Model(mesh, {"joint": law}, {"block_0": 1e3 * E, "block_1": E}, 0.2, THICKNESS)
        self.N = share * FC * LENGTH * THICKNESS
        self.fixed = m.dofs(m.x[:, 1] < -99.9, 0, 1)
        nodes, area = m.group("top")
        down, push = np.zeros((m.n, 2)), np.zeros((m.n, 2))
        down[nodes, 1], push[nodes, 0] = -self.N * area, self.N * area
        self.down, self.push = (force.ravel() / (LENGTH * THICKNESS) for force in (down, push))
        state = State.virgin(m)
        for part in (0.25, 0.5, 0.75, 1.0):
            state = solve(m, state, Conditions(self.fixed, load=part * self.down)).taken()
        self.state = state

    def pushed(self, ratio: float) -> Conditions:
        """Vertical force, and the horizontal one over it."""
        return Conditions(self.fixed, load=self.down + ratio * self.push)

    def limit(self, always: bool = False) -> Follow:
        """Path up to the largest force."""
        step = 0.02
        follow = Follow(self.model, self.state, self.pushed, step, 2 * step, 1e-5, Terms(), always=always)
        follow.run_to_limit(1.0)
        return follow

    def rotation(self, state: State) -> float:
        """Rotation of the wall to its toe, by its top."""
        u, top = state.u.reshape(-1, 2), self.model.group("top")[0]
        here = np.column_stack([self.model.x[top, 0], u[top, 1]])
        return -float(np.polyfit(*np.concatenate(COMM.allgather(here)).T, 1)[0])

    def beyond(self, follow: Follow, share: float, most: float = 0.05) -> tuple[Branch, Floats]:
        """Go on until the force has fallen to a share; rows of the rotation and of the force over N."""
        branch, rows = follow.beyond(most), []
        for _ in branch.to(lambda state: state.at < share * follow.at):
            rows.append([self.rotation(branch.state), branch.at])
        return branch, np.array(rows)


def draw(path: Path) -> None:
    """Force over the rotation of the second wall, and pressure of its toe at the peak and at the end."""
    share = SHARES[1]
    with printed():
        figure, (forces, pressures) = new_figure(TWO, 2.9, ncols=2)
        for colour, Gfc in zip(COLOURS, (1500.0, 30.0, 15.0), strict=False):
            toe = Toe(share, Gfc)
            follow = Follow(toe.model, toe.state, toe.pushed, 0.005, 0.01, 1e-5)
            rows, label = [], f"Gfc = {Gfc:g} N/mm"
            with suppress(Stopped):
                for _ in follow.to(1.0):
                    rows.append([toe.rotation(follow.state), follow.at])
            branch, beyond = toe.beyond(follow, 0.93, most=2.0) if Gfc < 1e3 else (follow, np.zeros((0, 2)))
            turned = np.array([*rows, *beyond.tolist()])
            forces.plot(1e3 * turned[:, 0], turned[:, 1], color=colour, label=label)
            for state, line in ((follow.state, "-"), (branch.state, "--")):
                order = np.argsort(toe.model.places[:, 0])
                x, p = toe.model.places[order, 0], -state.t[order, 0]
                pressures.plot(x, p, line, color=colour, label=label if line == "-" else None)
        forces.axhline(expected(share), color="black", linewidth=0.6, linestyle=":", label="toe that yields")
        forces.set(
            xlabel="rotation [mrad]", ylabel="horizontal force over N [-]", xlim=(0, 12), ylim=(0, 0.18)
        )
        pressures.set(
            xlabel="place along the joint [mm]", ylabel="pressure [MPa]", xlim=(600, 1000), ylim=(0, 7)
        )
        for panel in (forces, pressures):
            panel.legend()
            panel.grid(alpha=0.3)
        save(figure, path)


def main() -> None:
    """Run all."""
    warnings.simplefilter("ignore")
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add_options(
        parser,
        ("--Gfc ENERGY", "of crushing, N/mm", 1500.0),
        ("--Css CSS", "part of the shear in the strength", 0.0),
        ("--pvd FILE", "fields of the second wall beyond its peak for ParaView", Path),
        ("-o --output FILE", "picture of the second wall", Path),
    )
    o = parser.parse_args()
    for share in SHARES:
        toe = Toe(share, o.Gfc, o.Css)
        follow = toe.limit()
        if COMM.rank == 0:
            print(f"{share:g}: {follow.at:.5f} {expected(share, o.Css):.5f}", flush=True)
        if o.pvd and share == SHARES[1]:
            branch, _ = toe.beyond(follow, 0.9)
            Output(toe.model, o.pvd).write(branch.state, ledger=branch.ledger)
    if o.output:
        draw(o.output)


if __name__ == "__main__":
    main()

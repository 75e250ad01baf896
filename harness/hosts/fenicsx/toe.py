"""Slender walls whose toe crushes on FEniCSx, a line each: name and numbers; mm, N, MPa.

A wall of 102 mm stands on a dry joint with a compressive strength fc, carries N and is pushed at its top.

- limit LENGTH HEIGHT SHARE Css Gfc: largest horizontal force over N, where the force is the load; the share
  is that of N in fc L t.
- moved METHOD: the same of the middle wall where the displacement of the top is prescribed, the force at the
  end, largest error of forces, steps, iterations.
- force Gfc, pressure Gfc STATE: points of the picture, rotation and force, place and pressure.
"""

from __future__ import annotations

import warnings

import numpy as np
from asperity import Interface, Material, Pattern
from asperity.contract import Floats
from asperity.fenicsx import COMM, Branch, Conditions, Follow, Model, State, Terms, solve, total
from asperity.mesh import split

from harness.hosts.fenicsx.toe_constants import CSS, MU, SOFTENING, YIELDING
from harness.hosts.fenicsx.words import words_of
from harness.hosts.structured import grid

LENGTH, HEIGHT, THICKNESS = 1000.0, 2500.0, 102.0
FC, KN, E = 6.2, 50.0, 1e5
"""Of calcium-silicate masonry; the wall is stiff beside its joint, as closed forms have it."""

SHARES = 0.1, 0.2, 0.3
"""Of the vertical force over fc L t."""

SIZES = (1000.0, 2500.0), (500.0, 1250.0), (2000.0, 5000.0), (1000.0, 4000.0)
"""Lengths of walls, and heights at which they are pushed."""

END = 20.0
"""Displacement of the top, mm, up to which walls are moved."""

METHODS = {
    "Newton": {},
    "passes": {"always": True},
    **{
        f"IMPL-EX {force}": {"passes": 1, "always": True, "errors": (2.5 * force, force)}
        for force in (0.02, 0.01, 0.005)
    },
}
"""Settings of paths: by Newton's method with passes where it fails, and IMPL-EX with its error of forces."""


class Toe:
    """A wall under its vertical force."""

    def __init__(
        self,
        share: float,
        Gfc: float,
        Css: float = 0.0,
        length: float = LENGTH,
        height: float = HEIGHT,
        cells: int = 50,
    ) -> None:
        """Build the wall and press it; height: of the force above the joint."""
        material = Material.from_joint(kn=KN, ks=0.4 * KN, mu=MU, fc=FC, Gfc=Gfc, Css=Css)
        y = np.r_[-0.1 * length, np.linspace(0.0, height, 26)]
        unsplit = (
            grid(np.linspace(0.0, length, cells + 1), y, block=y[:-1] >= 0.0) if COMM.rank == 0 else None
        )
        law = Interface(material, Pattern.regular(0, 0.0))
        mesh = split(unsplit) if unsplit else None
        self.model = m = Model(mesh, {"joint": law}, {"block_0": 1e3 * E, "block_1": E}, 0.2, THICKNESS)
        self.N, self.height = share * FC * length * THICKNESS, height
        self.base = m.dofs(m.x[:, 1] < -0.099 * length, 0, 1)
        top, area = m.group("top")
        self.top = m.dofs(np.isin(np.arange(m.n), top), 0)
        down, push = np.zeros((m.n, 2)), np.zeros((m.n, 2))
        down[top, 1], push[top, 0] = -self.N * area, self.N * area
        self.down, self.push = (force.ravel() / (length * THICKNESS) for force in (down, push))
        state = State.virgin(m)
        for part in (0.25, 0.5, 0.75, 1.0):
            state = solve(m, state, Conditions(self.base, load=part * self.down)).taken()
        self.state = state

    def pushed(self, ratio: float) -> Conditions:
        """Vertical force, and the horizontal one over it."""
        return Conditions(self.base, load=self.down + ratio * self.push)

    def moved(self, way: float) -> Conditions:
        """Vertical force, and the displacement of the top."""
        fixed = np.r_[self.base, self.top]
        return Conditions(fixed, self.state.u[fixed] + way * np.isin(fixed, self.top), self.down)

    def limit(self, always: bool = False) -> Follow:
        """Path of forces up to the largest one."""
        step = 0.02
        follow = Follow(self.model, self.state, self.pushed, step, 2 * step, 1e-5, Terms(), always=always)
        follow.run_to_limit(1.0)
        return follow

    def along(self, method: str, end: float = END) -> tuple[Floats, Follow, State]:
        """Rows of a path of displacements to an end: rotation, force over N, error of forces.

        With the path and the state of the largest force.
        """
        follow = Follow(self.model, self.state, self.moved, 0.25, 0.5, 1e-4, **METHODS[method])
        rows, peak, largest = [], follow.state, 0.0
        for report in follow.to(end):
            force = -total(report.reaction[self.base][::2].sum()) / self.N
            rows.append([self.rotation(follow.state), force, report.errors[1]])
            if force > largest:
                peak, largest = follow.state, force
        return np.array(rows), follow, peak

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


def say(name: str, *numbers: float) -> None:
    """Print a line."""
    if COMM.rank == 0:
        print(f"{name}:", *(f"{number:.6g}" for number in numbers), flush=True)


def limits(sizes: tuple[tuple[float, float], ...], kinds: tuple[tuple[float, float], ...]) -> None:
    """Print the largest forces of walls; kinds: Css and Gfc."""
    for length, height in sizes:
        for share in SHARES:
            for Css, Gfc in kinds:
                found = Toe(share, Gfc, Css, length, height).limit().at
                say(f"limit {length:g} {height:g} {share:g} {Css:g} {Gfc:g}", found)


def methods() -> None:
    """Print what the middle wall carries when its top is moved, by each method."""
    toe = Toe(SHARES[1], SOFTENING[0], CSS)
    for method in METHODS:
        rows, follow, _ = toe.along(method)
        say(f"moved {method}", rows[:, 1].max(), rows[-1, 1], rows[:, 2].max(), follow.count, follow.taken)


def picture() -> None:
    """Print force over rotation of the middle wall, and pressures of its toe at the peak and at the end."""
    for Gfc in (YIELDING, *SOFTENING):
        toe = Toe(SHARES[1], Gfc)
        rows, follow, peak = toe.along("Newton", 1.5 * END)
        for rotation, force, _ in rows:
            say(f"force {Gfc:g}", rotation, force)
        for name, state in (("peak", peak), ("end", follow.state)):
            for x, p in sorted(zip(toe.model.places[:, 0], -state.t[:, 0], strict=True)):
                say(f"pressure {Gfc:g} {name}", x, p)


def main() -> None:
    """Print the numbers of the words, or of all."""
    warnings.simplefilter("ignore")
    words = words_of(__doc__, "yields, limits, moved, picture") or ["limits", "moved", "picture"]
    if "yields" in words:
        limits(SIZES[:1], ((0.0, YIELDING), (CSS, YIELDING)))
    if "limits" in words:
        limits(SIZES, ((0.0, YIELDING), (CSS, YIELDING), *((CSS, Gfc) for Gfc in SOFTENING)))
    if "moved" in words:
        methods()
    if "picture" in words:
        picture()


if __name__ == "__main__":
    main()

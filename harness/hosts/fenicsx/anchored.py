"""A ribbed bar that is pulled out of its cover, as solids: a quarter by symmetry; mm, N, MPa.

Prints the stiffness of the cover, or rows of displacement of the loaded end, force, mean pressure on the bar
and largest opening of the crack of the cover, then rows of place along the bar and bond stress at the largest
force.
"""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace

import meshio
import numpy as np
from asperity import Interface, Material, Pattern
from asperity.contract import Floats
from asperity.fenicsx import COMM, Conditions, Follow, Model, State, largest, solve, total
from asperity.mesh import split

from harness.hosts.fenicsx.anchored_constants import (
    COVER,
    DIAMETER,
    E_CONCRETE,
    E_STEEL,
    EMBEDDED,
    NU,
    SOFT_BOND,
    TENSION,
)
from harness.hosts.structured import grid_cells

FRACTURE, STIFF = 0.1, 4500.0
"""Fracture energy and stiffness of the crack along which the cover may split, whose strength is TENSION."""

JACKET, SOFT = 0.5, 1.0
"""Thickness and modulus of the shell through which a constant pressure acts, instead of the cover."""

OFF = 1e-3
"""Force over the largest one below which the cover is off."""

CASES = "ring", "linear", "friction", "pressure", "cover", "split"
RIBBED = "pressure", "cover", "split"


@dataclass(frozen=True)
class Grid:
    """Numbers of cells: over an eighth of the circumference, layers of bar and cover, along the bar."""

    around: int = 3
    bar: int = 2
    cover: int = 6
    along: int = 24


def section(g: Grid, outer: float) -> tuple[Floats, np.ndarray, np.ndarray]:
    """Points (n, 2), cells (c, 4) and blocks of a quarter: bar 1, cover below and above 45 degrees 2, 3.

    A square core with layers around; the polygon of the bar has the circumference of the circle.
    """
    n, k = g.around, 2 * g.around
    angle = 0.25 * np.pi / n
    circle = np.linspace(0.0, 0.5 * np.pi, k + 1)
    ray = np.column_stack([np.cos(circle), np.sin(circle)]) * 0.5 * angle / np.sin(0.5 * angle)
    core = 0.22 * DIAMETER * np.linspace(0.0, 1.0, n + 1)
    square = np.stack(np.meshgrid(core, core, indexing="ij"), axis=-1)
    # from (1, 0) by the corner to (0, 1)
    edge = np.concatenate([square[-1, :], square[-2::-1, -1]])
    rings = [edge + t * (0.5 * DIAMETER * ray - edge) for t in np.linspace(0.0, 1.0, g.bar + 1)[1:]]
    radii = np.geomspace(DIAMETER, outer, g.cover + 1)[1:]
    rings += [0.5 * radius * ray for radius in radii]
    number = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    layers = [np.concatenate([number[-1, :], number[-2::-1, -1]])]
    layers += [(n + 1) ** 2 + i * (k + 1) + np.arange(k + 1) for i in range(len(rings))]
    table = np.array(layers)
    around = grid_cells((len(rings), k))
    cells = np.concatenate([grid_cells((n, n)), table.ravel()[around]])
    layer, place = np.divmod(np.arange(len(around)), k)
    block = np.where(layer < g.bar, 1, np.where(place < n, 2, 3))
    return np.concatenate([square.reshape(-1, 2), *rings]), cells, np.r_[np.ones(n * n, int), block]


def mesh_of(g: Grid, outer: float, cracked: bool) -> meshio.Mesh:
    """Solids of bar and cover."""
    flat, quads, block = section(g, outer)
    z = np.linspace(0.0, EMBEDDED, g.along + 1)
    points = np.column_stack([np.tile(flat, (len(z), 1)), np.repeat(z, len(flat))])
    first = len(flat) * np.arange(g.along)[:, None, None]
    cells = np.concatenate([quads + first, quads + first + len(flat)], axis=2).reshape(-1, 8)
    tags = block if cracked else np.minimum(block, 2)
    names = {"bar": 1, "cover": 2} | ({"other": 3} if cracked else {})
    return meshio.Mesh(
        points,
        [("hexahedron", cells)],
        cell_data={"gmsh:physical": [np.tile(tags, g.along)]},
        field_data={name: np.array([tag, 3]) for name, tag in names.items()},
    )


def flat(kn: float, mu: float = 0.0, **bond: float) -> Interface:
    """Joint without planes: a bond, or contact and friction alone."""
    return Interface(Material.from_joint(kn=kn, ks=0.4 * kn, mu=mu, **bond), Pattern.regular(0, 0.0))


def linear(k: float) -> Interface:
    """Bond of a stiffness that does not break."""
    strength, eta = 1e3 * k, 0.9
    return Interface(
        Material(strength, strength**2 / (2.0 * k * (1.0 - eta)), eta, 0.0), Pattern.regular(0, 0.0)
    )


def ribs(constants: dict[str, float]) -> Interface:
    """Ribs of two flanks with a bond."""
    values = dict(constants)
    pattern = Pattern.regular(2, values.pop("theta"))
    return Interface(Material(eta=0.9, kc=100.0, **values), pattern)


def splitting() -> Interface:
    """Crack of the cover."""
    eta = 1.0 - TENSION**2 / (2.0 * STIFF * FRACTURE)
    return Interface(Material(TENSION, FRACTURE, eta, 0.7, kc=10.0), Pattern.regular(0, 0.0))


class Pull:
    """A bar whose loaded end is moved, restrained as its case says.

    Without pressure the cover is held along the bar by a plate at the loaded end, or everywhere if it is
    rigid.  A constant pressure acts through a soft jacket, which is held everywhere.
    """

    def __init__(
        self, law: Interface, grid: Grid, pressure: float = 0.0, cracked: bool = False, rigid: bool = False
    ) -> None:
        """Set up the model, and press the bar."""
        rules = {"ribs": ("bar", "*")} | ({"crack": ("cover", "other")} if cracked else {})
        laws = {"ribs": law} | ({"crack": splitting()} if cracked else {})
        self.outer = DIAMETER + 2.0 * JACKET if pressure else COVER
        jointed = None
        if COMM.rank == 0:
            mesh = mesh_of(replace(grid, cover=1) if pressure else grid, self.outer, cracked)
            jointed = split(mesh, rules, direction=(0.0, 0.0, -1.0))
        covers = ["cover", "other"] if cracked else ["cover"]
        young = {"bar": E_STEEL} | dict.fromkeys(covers, SOFT if pressure else E_CONCRETE)
        self.model = m = Model(jointed, laws, young, NU)
        bar, cover = (m.solid(*blocks)[::3] > 0.0 for blocks in (["bar"], covers))
        end = m.x[:, 2] > EMBEDDED * (1.0 - 1e-9)
        loaded, held = m.dofs(bar & end, 2), m.dofs(cover & (end | rigid | (pressure > 0.0)), 2)
        mirror = [m.dofs(m.x[:, k] < 1e-9 * DIAMETER, k) for k in (0, 1)]
        self.fixed, self.loaded = np.concatenate([*mirror, held, loaded]), loaded
        self.moved = np.isin(self.fixed, loaded)
        self.load, start = self._squeezed(pressure, 2 * grid.around, grid.along), State.virgin(m)
        if pressure:
            start = solve(m, start, Conditions(self.fixed, load=self.load)).taken()
        self.follow = Follow(
            m, start, lambda u: Conditions(self.fixed, u * self.moved, self.load), 2e-3, 2e-2
        )
        self.z = np.linspace(0.0, EMBEDDED, grid.along + 1)

    def _squeezed(self, pressure: float, around: int, along: int) -> Floats:
        """Forces on the outside of the jacket that give a pressure on a bar which does not move."""
        m, load = self.model, np.zeros((self.model.n, 3))
        if pressure:
            inner, size = DIAMETER**2, self.outer**2
            outer_pressure = pressure * (size + (1.0 - 2.0 * NU) * inner) / (2.0 * (1.0 - NU) * size)
            r = np.hypot(m.x[:, 0], m.x[:, 1])
            at = np.flatnonzero(r > 0.5 * (DIAMETER + JACKET))
            x = m.x[at]
            share = 0.25 * np.pi * self.outer * EMBEDDED / (around * along) * np.ones(len(at))
            share *= np.cos(0.25 * np.pi / around)  # of a polygon
            share[np.minimum(x[:, 0], x[:, 1]) < 1e-9] *= 0.5
            share[(x[:, 2] < 1e-9) | (x[:, 2] > EMBEDDED * (1.0 - 1e-9))] *= 0.5
            load[at, :2] = -outer_pressure * (share / r[at])[:, None] * x[:, :2]
        return load.ravel()

    def row(self) -> Floats:
        """Displacement, force on the whole bar, mean pressure on it, largest opening of the crack."""
        m, ribs, state = self.model, self.model.parts[0], self.follow.state
        force = 4.0 * total(self.follow.report.reaction[self.loaded].sum())
        mean = -total(m.area[ribs] @ state.t[ribs, 0]) / total(m.area[ribs].sum())
        opening = largest(np.maximum(state.s[m.parts[-1], 0], 0.0)) if len(m.parts) > 1 else 0.0
        return np.array([self.follow.at, force, mean, opening])

    def bond(self) -> Floats:
        """Bond stress over the places along the bar."""
        m, ribs = self.model, self.model.parts[0]
        level = np.rint(m.places[ribs, 2] / self.z[1]).astype(int)
        area = m.area[ribs]
        sums = [
            np.bincount(level, area * value, len(self.z))
            for value in (self.follow.state.t[ribs, 1], np.ones(len(area)))
        ]
        force, size = COMM.allreduce(np.array(sums))
        return np.asarray(force / size)

    def pull(self, end: float) -> tuple[Floats, Floats]:
        """Move the loaded end; rows, and bond stresses along the bar at the largest force.

        A bar whose cover is off is not followed.
        """
        rows, along = [np.zeros(4)], 0.0 * self.z
        for _ in self.follow.to(end):
            rows.append(self.row())
            if rows[-1][1] >= max(row[1] for row in rows[:-1]):
                along = self.bond()
            if rows[-1][1] < OFF * max(row[1] for row in rows):
                break
        return np.array(rows), along


def pull_of(case: str, constants: dict[str, float], pressure: float, grid: Grid) -> Pull:
    """Bar of a case with ribs of some constants."""
    if case == "linear":
        return Pull(linear(SOFT_BOND), grid, rigid=True)
    if case == "friction":
        return Pull(flat(2e3, 0.4), grid, pressure)
    law = ribs(constants)
    return Pull(law, grid, pressure if case == "pressure" else 0.0, case == "split")


def ring(grid: Grid) -> float:
    """Pressure in the cover over its radial displacement at the bar."""
    run = Pull(linear(1e-3), grid)
    m = run.model
    conditions = Conditions(run.fixed, load=run.load, pressures={"ribs": 1.0})
    state = solve(m, State.virgin(m), conditions).taken()
    inside = m.solid("cover")[::3] * (np.hypot(m.x[:, 0], m.x[:, 1]) < 0.505 * DIAMETER) > 0.0
    out = np.einsum("nd,nd->n", state.u.reshape(-1, 3)[inside, :2], m.x[inside, :2])
    out = out / np.hypot(m.x[inside, 0], m.x[inside, 1])
    return total(np.ones(len(out)).sum()) / total(out.sum())


def constants_of(words: Sequence[str]) -> dict[str, float]:
    """Constants of the ribs; ValueError with the word that is none."""
    constants = {}
    for word in words:
        name, sign, text = word.partition("=")
        try:
            constants[name] = float(text)
        except ValueError:
            sign = ""
        if not (name and sign):
            raise ValueError(f"{word}: expected NAME=NUMBER")
    if constants and (missing := [name for name in ("sigma0", "Gc", "mu", "theta") if name not in constants]):
        raise ValueError(f"no {missing[0]}: expected the constants sigma0, Gc, mu, theta of the ribs")
    return constants


def main() -> None:
    """Run a case and print its rows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("case", choices=CASES)
    parser.add_argument("constants", nargs="*", help="of the ribs, such as mu=0.5")
    parser.add_argument("--pressure", type=float, default=10.3)
    parser.add_argument("--end", type=float, default=3.0, help="displacement of the loaded end")
    parser.add_argument("--grid", type=int, nargs=4, default=astuple(Grid()), help="cells, see Grid")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    for name, value in (("pressure", options.pressure), ("end", options.end)):
        if not 0.0 < value < np.inf:
            parser.error(f"--{name} {value:g}: expected above 0")
    if min(options.grid) < 1:
        parser.error(f"--grid {' '.join(map(str, options.grid))}: expected at least 1")
    grid = Grid(*options.grid)
    try:
        constants = constants_of(options.constants)
        if not constants and options.case in RIBBED:
            raise ValueError("expected the constants sigma0, Gc, mu, theta of the ribs")
        run = None if options.case == "ring" else pull_of(options.case, constants, options.pressure, grid)
    except (TypeError, ValueError) as error:
        parser.error(str(error))
    if run is None:
        stiffness = ring(grid)
        if COMM.rank == 0:
            print(f"ring: {stiffness:.6g}")
        return
    rows, along = run.pull(options.end)
    if COMM.rank == 0:
        for row in rows:
            print("row:", *(f"{value:.6g}" for value in row))
        for pair in zip(run.z, along, strict=True):
            print("bond:", *(f"{value:.6g}" for value in pair))


if __name__ == "__main__":
    main()

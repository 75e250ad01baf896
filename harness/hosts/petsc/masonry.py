"""Masonry walls of half-bricks: constants, laws of the joints, mesh.  mm, N, MPa."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from asperity.contract import Floats
from asperity.interface import Interface
from asperity.material import Material
from asperity.pattern import Pattern

MID_BRICK = 1.0e4
"""Stiffness of the potential crack in the middle of a brick, N/mm3."""

STIFFER = 10.0
"""Modulus of a loading beam over that of the bricks."""


@dataclass(frozen=True)
class Masonry:
    """A wall that was tested.

    half_brick: length, thickness, height.  joint: constants of `Material.from_masonry`, or of
    `Material.from_joint` for dry joints.  crack: strength and fracture energy of a brick.  beam: height of a
    stiff loading beam on top and of a foundation, with joints to the wall, which is moved at a `level` above
    the foundation and may turn; without a beam the top stays horizontal and its height is held.  pressure: at
    the base, with the weight (per volume) of the wall.
    """

    columns: int
    courses: int
    half_brick: tuple[float, float, float]
    pressure: float
    joint: dict[str, float]
    E: float = 16700.0
    nu: float = 0.15
    crack: tuple[float, float] = (2.0, 0.08)
    beam: float = 0.0
    level: float = 0.0
    weight: float = 0.0

    def heights(self) -> Floats:
        """Heights of the courses, of a foundation and of a beam, from below."""
        end = [self.beam] * (self.beam > 0.0)
        return np.r_[end, np.full(self.courses, self.half_brick[2]), end]

    def stiff(self) -> np.ndarray:
        """Which of `heights` are foundation and beam."""
        end = [True] * (self.beam > 0.0)
        return np.r_[end, np.zeros(self.courses, bool), end].astype(bool)


UNBROKEN = (100.0, 1.0)
"""Strength and fracture energy of blocks that do not break."""

STIFF, SOFT = {"kn": 110.0, "ks": 50.0}, {"kn": 82.0, "ks": 36.0}
STRONG = {"ft": 0.25, "GfI": 0.018, "c": 0.35, "GfII": 0.125, "tan_phi": 0.75}
WEAK = {"ft": 0.16, "GfI": 0.012, "c": 0.224, "GfII": 0.05, "tan_phi": 0.75}

BRICK = Masonry(9, 16, (110.0, 100.0, 62.5), 0.3, SOFT | STRONG)
GRANITE = Masonry(10, 8, (100.0, 200.0, 150.0), 0.0, {}, 20000.0, 0.2, UNBROKEN, 250.0, 1325.0, 2.6e-5)
SANDSTONE = Masonry(10, 10, (100.0, 200.0, 100.0), 0.0, {}, 15500.0, 0.2, UNBROKEN, 100.0, 1000.0, 2.4e-5)


def dry(wall: Masonry, force: float, kn: float, mu: float) -> Masonry:
    """Wall of dry joints under a vertical force in kN; ks = 0.4 kn."""
    area = wall.columns * wall.half_brick[0] * wall.half_brick[1]
    return replace(wall, pressure=1e3 * force / area, joint={"kn": kn, "ks": 0.4 * kn, "mu": mu})


WALLS = {
    "J4D": BRICK,
    "J6D": replace(BRICK, pressure=1.21, joint=STIFF | WEAK),
    "J7D": replace(BRICK, pressure=2.12, joint=SOFT | WEAK),
    "WS40": dry(GRANITE, 44.8, 5.9, 0.65),
    "WS100": dry(GRANITE, 104.8, 7.9, 0.65),
    "WS175": dry(GRANITE, 179.8, 12.3, 0.65),
    "WS250": dry(GRANITE, 254.8, 12.9, 0.65),
    "SW30": dry(SANDSTONE, 33.6, 5.9, 0.62),
    "SW100": dry(SANDSTONE, 103.6, 7.9, 0.62),
    "SW200": dry(SANDSTONE, 203.6, 12.3, 0.62),
    "SW250": dry(SANDSTONE, 253.6, 12.9, 0.62),
}
"""Walls by the names of their tests; docs/validation/walls.md has the sources."""


def laws(
    wall: Masonry, pattern: Pattern, height: float, kc: float, tau_v: float, **changed: float
) -> tuple[Interface, Interface]:
    """Laws of the joints and of the flat cracks in mid-brick; `changed` are constants of the joint."""
    material = Material.from_joint if "mu" in wall.joint else Material.from_masonry
    joint = replace(material(**wall.joint | changed), height=height)
    if "mu" not in wall.joint:
        joint = replace(joint, kc=kc, tau_v=tau_v)
    strength, energy = wall.crack
    crack = Material(
        strength, energy, 1.0 - strength**2 / (2.0 * MID_BRICK * energy), 0.75, kc=1.0, tau_v=tau_v
    )
    return Interface(joint, pattern), Interface(crack, Pattern.regular(0, 0.0))


def cells(grid: np.ndarray) -> np.ndarray:
    """Corners (cells, 2^d) of the cells of a grid of node numbers; the last axis changes fastest."""
    ends = (slice(None, -1), slice(1, None))
    return np.stack([grid[corner].ravel() for corner in itertools.product(ends, repeat=grid.ndim)], 1)


def stiffness(n: np.ndarray, size: Floats, thickness: float, E: float, nu: float) -> Floats:
    """Stiffness of a block of n elements along its axes: bricks, or rectangles in plane stress."""
    d, nodes = len(n), cells(np.arange(np.prod(n + 1)).reshape(n + 1))
    x = np.array(list(itertools.product((-1, 1), repeat=d)), dtype=float)
    f = (1.0 + x * (x / 3**0.5)[:, None]) / 2.0  # factors of the shape functions at the Gauss points
    g = np.stack([x[:, k] * np.delete(f, k, 2).prod(2) * n[k] / size[k] for k in range(d)], 2)
    G, lam = E / (2.0 * (1.0 + nu)), E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
    lam = 2.0 * lam * G / (lam + 2.0 * G) if d == 2 else lam
    k = lam * np.einsum("pai,pbj->aibj", g, g) + G * np.einsum("paj,pbi->aibj", g, g)
    k += G * np.einsum("pak,pbk,ij->aibj", g, g, np.eye(d))
    k *= thickness * np.prod(size / n) / 2**d
    dof = (nodes[:, :, None] * d + np.arange(d)).reshape(len(nodes), -1)
    K = np.zeros((np.prod(n + 1) * d,) * 2)
    np.add.at(K, (dof[:, :, None], dof[:, None, :]), k.reshape(dof.shape[1], -1))
    return K


def shares(n: int) -> Floats:
    """Shares of the nodes of n elements in their length."""
    return np.r_[0.5, np.ones(n - 1), 0.5] / n


class Joints:
    """Pairs of nodes with one law.

    axes (3, d): N, Tx, Ty; area: of each pair; faces: the pairs at the corners of each element of the joint.
    """

    def __init__(
        self,
        law: Interface,
        minus: np.ndarray,
        plus: np.ndarray,
        area: Floats,
        axes: Floats,
        faces: np.ndarray,
    ) -> None:
        """Begin with virgin points."""
        self.law, self.nodes, self.area, self.axes, self.faces = (
            law,
            np.stack([minus, plus], 1),
            area,
            axes,
            faces,
        )
        self.s, self.state = np.zeros((len(area), 3)), np.zeros((len(area), law.nstatv))
        self.growth, self.moved = np.zeros(len(area)), np.zeros((len(area), 3))

    def separation(self, u: Floats) -> Floats:
        """Separations (N, Tx, Ty) at displacements of the nodes."""
        return (u[self.nodes[:, 1]] - u[self.nodes[:, 0]]) @ self.axes.T

    def forces(self, traction: Floats) -> Floats:
        """Internal forces (pairs, 2, d)."""
        f = self.area[:, None] * (traction @ self.axes)
        return np.stack([-f, f], 1)

    def blocks(self, tangent: Floats) -> Floats:
        """Stiffness of the pairs: (pairs, 2, d, 2, d)."""
        k = np.einsum("kd,pkl,le,p->pde", self.axes, tangent, self.axes, self.area, optimize=True)
        return np.einsum("ij,pde->pidje", [[1.0, -1.0], [-1.0, 1.0]], k)


class Mesh:
    """Half-bricks with meshes of their own, and joints between their nodes.

    Half-bricks are numbered rank by rank, nodes half-brick by half-brick.  A rank has the points of the
    joints whose minus side it owns.
    """

    def __init__(
        self,
        masonry: Masonry,
        laws: tuple[Interface, Interface],
        elements: Sequence[int],
        grid: Sequence[int] = (1, 1),
        rank: int = 0,
    ) -> None:
        """Mesh the part of a rank; elements: of a half-brick along 2 or 3 axes; grid: ranks along them."""
        n = np.array(elements)
        self.d = d = len(n)
        keep = [0, 1, 2] if d == 3 else [0, 2]
        length, thickness, _ = masonry.half_brick
        heights, stiff = masonry.heights(), masonry.stiff()
        nc, nr = masonry.columns, len(heights)
        i, j = np.divmod(np.arange(nc * nr), nr)
        owner = (i * grid[0] // nc) * grid[1] + j * grid[1] // nr
        order = np.argsort(owner, kind="stable")
        mine, place = order[owner[order] == rank], np.argsort(order)
        numbers = np.arange(np.prod(n + 1)).reshape(n + 1)
        self.nn, self.nb = nn, nb = numbers.size, len(mine)
        self.lo, self.own = place[mine[0]] * nn, nb * nn
        self.stiff = stiff[j[mine]]
        self.K = [
            stiffness(n, np.array((length, thickness, h))[keep], thickness if d == 2 else 1.0, E, masonry.nu)
            for h, E in ((masonry.half_brick[2], masonry.E), (heights[0], STIFFER * masonry.E))
        ]

        # joints: which half-bricks, their neighbours, nodes of both faces, area of a face, axes N, Tx, Ty
        x, y, z = np.eye(3)[:, keep]
        across = shares(n[1]) if d == 3 else np.ones(1)
        sides, above = mine[i[mine] + 1 < nc], mine[j[mine] + 1 < nr]
        head = ((i[sides] + j[sides]) % 2 == 1) & ~stiff[j[sides]]
        upright = numbers[-1], numbers[0], np.outer(across, shares(n[-1])).ravel(), (x, z, -y)
        flat = numbers[..., -1], numbers[..., 0], np.outer(shares(n[0]), across).ravel() * length, (z, x, y)
        pairs = []
        for law, minus, step, (low, high, part, axes), depth in (
            (laws[0], sides[head], nr, upright, heights[j[sides[head]]]),
            (laws[1], sides[~head], nr, upright, heights[j[sides[~head]]]),
            (laws[0], above, 1, flat, np.ones(len(above))),
        ):
            nodes = [
                (place[b] * nn)[:, None] + face.ravel() for b, face in ((minus, low), (minus + step, high))
            ]
            area = np.outer(depth, part) * thickness
            on_face = cells(np.arange(low.size).reshape(low.shape))
            faces = (low.size * np.arange(len(minus))[:, None, None] + on_face).reshape(-1, 2 ** (d - 1))
            pairs.append((law, nodes[0].ravel(), nodes[1].ravel(), area.ravel(), np.array(axes), faces))
        used = np.unique(np.concatenate([pair[2] for pair in pairs]))
        ghosts = used[(used < self.lo) | (used >= self.lo + self.own)]

        def local(nodes: np.ndarray) -> np.ndarray:
            inside = (nodes >= self.lo) & (nodes < self.lo + self.own)
            return np.where(inside, nodes - self.lo, self.own + np.searchsorted(ghosts, nodes))

        self.nodes = np.r_[self.lo + np.arange(self.own), ghosts]  # numbers of the owned nodes and the ghosts
        self.joints = [Joints(law, local(a), local(b), *rest) for law, a, b, *rest in pairs]
        base = np.r_[0.0, np.cumsum(heights)]
        brick, inside = order[self.nodes // nn], np.stack(np.unravel_index(self.nodes % nn, n + 1), 1) / n
        corner = np.stack([i[brick] * length, 0.0 * brick, base[j[brick]]], 1)[:, keep]
        size = np.stack([0.0 * brick + length, 0.0 * brick + thickness, heights[j[brick]]], 1)[:, keep]
        self.X = corner + inside * size
        self.bottom, self.top = self.X[:, -1] < 1e-6, self.X[:, -1] > base[-1] - 1e-6
        at = masonry.beam + masonry.level if masonry.beam else base[-1]
        self.pushed = (j[brick] == nr - 1) & (np.abs(self.X[:, -1] - at) < 1e-6)
        face = np.zeros(n + 1)
        face[..., -1] = flat[2].reshape(face[..., -1].shape) * thickness
        volume = np.einsum(
            "i,jk->ijk" if d == 3 else "i,jk->ik", shares(n[0]), np.outer(across, shares(n[-1]))
        )
        self.area = np.tile(face.ravel(), nb) * self.top[: self.own]
        self.volume = np.outer(heights[j[mine]] * length * thickness * ~self.stiff, volume).ravel()
        self.solids = (np.arange(nb)[:, None, None] * nn + cells(numbers)).reshape(-1, 2**d)

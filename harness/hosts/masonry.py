"""Masonry walls that were tested: constants, laws of joints and cracks, meshes; mm, N, MPa."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from asperity.interface import Interface
from asperity.material import Material
from asperity.mesh import Jointed, split
from asperity.pattern import Pattern

from harness.hosts.structured import grid

MID_BRICK, STIFFER = 1.0e4, 10.0
"""Stiffness of the potential crack in a brick, N/mm3; modulus of a beam over that of the bricks."""

LEAST = 1e-5
"""Least step of a top that is moved, mm."""


@dataclass(frozen=True)
class Masonry:
    """A wall that was tested.

    half_brick: length, thickness, height.  joint: constants of `Material.from_masonry`, or of
    `Material.from_joint` for dry joints.  crack: strength and fracture energy of a brick; None: it stays
    whole.  beam: height of a stiff loading beam on top and of a foundation, with joints to the wall, which is
    moved at a `level` above the foundation and may turn; without a beam the top stays horizontal and its
    height is held.  pressure: at the base, with the weight (per volume) of the wall.
    """

    columns: int
    courses: int
    half_brick: tuple[float, float, float]
    pressure: float
    joint: dict[str, float]
    E: float = 16700.0
    nu: float = 0.15
    crack: tuple[float, float] | None = (2.0, 0.08)
    beam: float = 0.0
    level: float = 0.0
    weight: float = 0.0


STIFF, SOFT = {"kn": 110.0, "ks": 50.0}, {"kn": 82.0, "ks": 36.0}
STRONG = {"ft": 0.25, "GfI": 0.018, "c": 0.35, "GfII": 0.125, "tan_phi": 0.75}
WEAK = {"ft": 0.16, "GfI": 0.012, "c": 0.224, "GfII": 0.05, "tan_phi": 0.75}

BRICK = Masonry(9, 16, (110.0, 100.0, 62.5), 0.3, SOFT | STRONG)
GRANITE = Masonry(10, 8, (100.0, 200.0, 150.0), 0.0, {}, 20000.0, 0.2, None, 250.0, 1325.0, 2.6e-5)
SANDSTONE = Masonry(10, 10, (100.0, 200.0, 100.0), 0.0, {}, 15500.0, 0.2, None, 100.0, 1000.0, 2.4e-5)


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


def sized(wall: Masonry, columns: int, courses: int, bare: bool = False) -> Masonry:
    """Wall with so many half-bricks and courses (0: as tested); bare: without beams, level and weight."""
    of_beams = {"beam": 0.0, "level": 0.0, "weight": 0.0} if bare else {}
    return replace(wall, columns=columns or wall.columns, courses=courses or wall.courses, **of_beams)


def check_options(
    parser: ArgumentParser, o: Namespace, dimensions: tuple[int, ...], *others: tuple[str, object, str]
) -> None:
    """End a program with a message if elements, size, step or another option is not as expected.

    dimensions: admissible counts of elements.  others: name, whether the option is right, what is expected.
    """
    counts = " or ".join(str(d) for d in dimensions)
    for name, right, text in (
        (
            "elements",
            len(o.elements) in dimensions and min(o.elements) >= 1,
            f"{counts} numbers of at least 1",
        ),
        ("size", min(o.size) >= 0, "2 numbers of at least 0"),
        ("step", LEAST <= o.step <= o.most < np.inf, f"between {LEAST:g} and --most"),
        *others,
    ):
        if not right:
            parser.error(f"--{name} {getattr(o, name)}: expected {text}")


CRUSHED = "fc", "Gfc", "Css", "kp", "fcr"
"""Constants of a joint that crushes, which a wall has not by itself."""


def laws(
    wall: Masonry, pattern: Pattern, height: float, tau_v: float, changed: dict[str, float]
) -> dict[str, Interface]:
    """Laws of the joints and of the flat cracks in mid-brick; `changed` are constants of the joint."""
    crushed = {name: changed[name] for name in CRUSHED if name in changed}
    changed = {name: value for name, value in changed.items() if name not in CRUSHED}
    if unknown := set(changed) - set(wall.joint):
        raise ValueError(f"{', '.join(sorted(unknown))}: expected {', '.join([*wall.joint, *CRUSHED])}")
    if "mu" in wall.joint:
        joint = Material.from_joint(**wall.joint | changed)
        if tau_v:
            raise ValueError(f"tau = {tau_v:g}: expected 0 for dry joints, which do not soften")
    else:
        joint = replace(Material.from_masonry(**wall.joint | changed), kc=1.0, tau_v=tau_v)
    laws_by_name = {"joint": Interface(replace(joint, height=height, **crushed), pattern)}
    if wall.crack:
        strength, energy = wall.crack
        eta = 1.0 - strength**2 / (2.0 * MID_BRICK * energy)
        crack = Material(strength, energy, eta, 0.75, kc=1.0, tau_v=tau_v)
        laws_by_name["crack"] = Interface(crack, Pattern.regular(0, 0.0))
    return laws_by_name


def mesh(wall: Masonry, elements: Sequence[int]) -> Jointed:
    """Mesh with joints; elements: of a half-brick.  Groups bottom and top, blocks beam_N."""
    d = len(elements)
    length, thickness, height = wall.half_brick
    beams = [wall.beam] if wall.beam > 0.0 else []
    heights = np.array([*beams, *[height] * wall.courses, *beams])
    nc, nr, n = wall.columns, len(heights), elements[-1]
    up = np.concatenate([[0.0], *(base + h * np.arange(1, n + 1) / n for base, h in zip(
        np.cumsum(heights) - heights, heights, strict=True))])  # fmt: skip
    axes = [np.arange(nc * elements[0] + 1) * length / elements[0], up]
    if d == 3:
        axes.insert(1, np.arange(elements[1] + 1) * thickness / elements[1])
    parts = [len(a) - 1 for a in axes]
    i, *_, j = np.indices(parts).reshape(d, -1)
    i, j = i // elements[0], j // n
    stiff = (wall.beam > 0.0) & ((j == 0) | (j == nr - 1))
    brick = np.where(stiff, 0, i if wall.crack else (i + j % 2) // 2)
    tags = j * (nc + 1) + brick
    names = {f"beam_{k}": k * (nc + 1) for k in (0, nr - 1) if wall.beam}
    unsplit = grid(*axes, block=tags.reshape(parts), names=names)
    if not wall.crack:
        return split(unsplit)
    block = np.unique(tags)

    def cracks(a: np.ndarray, b: np.ndarray, x: np.ndarray, normal: np.ndarray) -> np.ndarray:
        row, column = np.divmod(block[a], nc + 1)
        return (np.abs(normal[:, 0]) > 0.5) & ((row + column) % 2 == 0)

    return split(unsplit, {"crack": cracks, "joint": ("*", "*")})

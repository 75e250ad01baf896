"""Section of the dam of Code_Aster's tests ssnp142a, e and i, with the joint along its base; m, N.

Vertical upstream, base 5 m, crest 1.5 m, height 10 m, on a foundation of 15 m x 5 m.  A parapet without
weight keeps water that is higher than the dam.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import meshio
import numpy as np
from asperity.contract import Floats
from asperity.mesh import Jointed, split
from asperity.options import add_options

BASE, CREST, HEIGHT, PARAPET = 5.0, 1.5, 10.0, 13.0
"""Widths of the dam and levels of its crest and of the top of the parapet."""

WEIGHT, WATER = 2400.0 * 9.81, 1000.0 * 9.81
"""Of concrete and of water, N/m3."""

STIFFNESS = 1e12
"""Of the joint, Pa/m, in closing and in shear."""

VISCOSITY, A_0 = 1e-3, 1e-8
"""Of water, Pa s, and first and least aperture of the joint, m."""

UPLIFTS = "none", "linear", "flow"
"""Water in the joint."""


def section(parts: int) -> Jointed:
    """Section with so many quadrilaterals along the base; triangles and other meshes would do, too."""
    along, size = np.linspace(0.0, BASE, parts + 1), BASE / parts
    far = np.geomspace(size, 6.0 * size, 40)
    far = BASE * np.cumsum(far) / far.sum()
    x, y = np.r_[-far[::-1], along, BASE + far], np.r_[-far[::-1], 0.0]
    above = np.linspace(HEIGHT, PARAPET, math.ceil((PARAPET / HEIGHT - 1.0) * parts) + 1)
    up = np.r_[np.linspace(0.0, HEIGHT, parts + 1), above[1:]]
    slender = 1.0 - (1.0 - CREST / BASE) * np.minimum(up, HEIGHT) / HEIGHT
    rock = np.stack(np.meshgrid(x, y, indexing="ij"), 2)
    dam = np.stack([along[:, None] * slender, np.broadcast_to(up, (parts + 1, len(up)))], 2)
    number = np.arange(rock.size // 2).reshape(rock.shape[:2])
    more = number.max() + 1 + np.arange(dam.size // 2).reshape(dam.shape[:2])
    more[:, 0] = number[len(far) : len(far) + parts + 1, -1]  # the dam stands on nodes of the rock
    points = np.concatenate([rock.reshape(-1, 2), dam.reshape(-1, 2)])
    cells = [
        np.stack([block[:-1, :-1], block[1:, :-1], block[1:, 1:], block[:-1, 1:]], 2).reshape(-1, 4)
        for block in (number, more)
    ]
    weightless = np.repeat([up[:-1] >= HEIGHT - 1e-9], parts, 0).ravel()
    outside = np.r_[number[0, ::-1], number[:, 0], number[-1]]
    lines = [np.stack([chain[:-1], chain[1:]], 1) for chain in (more[0], more[-1], outside)]
    lines[2] = lines[2][lines[2][:, 0] != lines[2][:, 1]]
    names = {"rock": (1, 2), "dam": (2, 2), "parapet": (3, 2), "upstream": (4, 1), "downstream": (5, 1),
             "outside": (6, 1)}  # fmt: skip
    tags = [np.r_[np.full(len(cells[0]), 1), np.where(weightless, 3, 2)]]
    tags += [np.full(len(line), 4 + k) for k, line in enumerate(lines)]
    kinds = [("quad", np.concatenate(cells)), *(("line", line) for line in lines)]
    data = {"gmsh:physical": tags}
    fields = {name: np.array(tag) for name, tag in names.items()}
    return split(meshio.Mesh(points, kinds, cell_data=data, field_data=fields), {"base": ("rock", "dam")})


def program(profile: Callable[..., Floats], doc: str | None, uplifts: Sequence[str], parts: int = 50) -> None:
    """Print rows of a function of uplift, level, parts along the base, E and nu, which the options give."""
    parser = argparse.ArgumentParser(description=doc)
    add_options(
        parser,
        ("uplift", f"one of {', '.join(uplifts)}", str, {"choices": uplifts}),
        ("--level M", "of the water", 9.0),
        ("--E PA", "of dam and foundation", 3e12),
        ("--nu NU", "of both", 0.0),
        ("--parts N", "elements along the base", parts),
        ("--out FILE", "rows x, s_N, p", Path),
    )
    o = parser.parse_args()
    rows = profile(o.uplift, o.level, o.parts, o.E, o.nu)
    np.savetxt(o.out or sys.stdout, rows, "%.9g", ",", header="x,s_N,p", comments="")

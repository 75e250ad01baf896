"""Prestressed bed joint in Kratos: two bricks that carry pressure and shear from the start, then slide.

All stresses are uniform, so every outer face has a known load.  2D plane strain, mm, N, MPa, thickness 1.
Run as a script it prints a row for each state of the joint.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from asperity import contract
from kratos_model import Floats, Structure
from triplet import HEIGHT, JOINT, LENGTH, POISSON, PRESSURE, THETA, TOLERANCE, YOUNG

SHEAR = 0.15
TRACTION = np.array([-PRESSURE, SHEAR, 0.0])
"""Traction of the joint, (N, Tx, Ty)."""

SLIPS = np.arange(1, 31) * 0.01
"""Slips, mm; at the last one the joint is fully damaged."""

PARTLY = np.array([1.0, 0.5, 0.0])
"""Damage of the planes of a joint that is cracked in part."""

COLUMNS, ROWS = 12, 3


@dataclass(frozen=True)
class Result:
    """Histories with one row for each step; the first step has no motion.

    displacement (steps, nodes, 2); reaction of the ground (steps, 2); separation and traction (steps, points,
    3); norms of Newton's iterations.
    """

    displacement: Floats
    reaction: Floats
    separation: Floats
    traction: Floats
    norms: list[list[float]]


def run(state: Floats | None = None, slips: Floats | None = None, bricks_stressed: bool = True) -> Result:
    """A step under the loads of the stress; then the ends of the upper brick are moved by the slips, mm.

    state: initial state variables (nstatv,) of the joint, None for virgin; bricks_stressed: whether the
    bricks start from their stress.
    """
    s = Structure(2)
    brick = s.elastic(YOUNG, POISSON)
    joint = s.umat(JOINT, **({} if state is None else {"STATE_VARIABLES": state.tolist()}))
    x, y = np.linspace(0.0, LENGTH, COLUMNS + 1), np.linspace(0.0, HEIGHT, ROWS + 1)
    bricks = []
    for k in range(2):
        n = s.add_nodes(np.stack(np.meshgrid(x, y + k * HEIGHT, indexing="ij"), axis=-1))
        bricks.append(n)
        for i in range(COLUMNS):
            for j in range(ROWS):
                s.add_solid([n[i, j], n[i + 1, j], n[i + 1, j + 1], n[i, j + 1]], brick)
    for i in range(COLUMNS):
        s.add_interface(bricks[0][i : i + 2, -1], bricks[1][i : i + 2, 0], joint)
    ground, top, ends = bricks[0][:, 0], bricks[1][:, -1], bricks[1][[0, -1]].ravel()
    s.fix(ground, 0, 1)
    loads: dict[int, Floats] = defaultdict(lambda: np.zeros(3))
    for node, share in zip(top.tolist(), _shares(x), strict=True):
        loads[node] += [SHEAR * share, -PRESSURE * share, 0.0]
    for n in bricks:
        for node, other, share in zip(n[0].tolist(), n[-1].tolist(), _shares(y), strict=True):
            loads[node] -= [0.0, SHEAR * share, 0.0]
            loads[other] += [0.0, SHEAR * share, 0.0]
    s.load({node: force.tolist() for node, force in loads.items()})
    if bricks_stressed:
        s.stress_solids([0.0, -PRESSURE, SHEAR])

    rows, norms = [], []
    for k, slip in enumerate([0.0, *([] if slips is None else slips.tolist())]):
        if k == 1:
            s.fix(ends, 0)
        if k > 0:
            s.move(ends, 0, slip)
        norms.append(s.step(TOLERANCE))
        rows.append((s.displacements(), s.reaction(ground), *s.points()))
    return Result(*(np.array(column) for column in zip(*rows, strict=True)), norms)


def _shares(x: Floats) -> list[float]:
    """Length of a face that belongs to each of its nodes."""
    shares = np.full(len(x), x[1] - x[0])
    shares[[0, -1]] *= 0.5
    return shares.tolist()


def slipped() -> Floats:
    """Slips (Np, 2) of the planes of a joint that was sheared by 0.5 mm, up on them."""
    planes = JOINT.confined_slip(0.0, [0.5], -PRESSURE, tolerance=1e-3).state[-1, contract.N_POINT_STATEV :]
    slips: Floats = planes.reshape(-1, contract.N_PLANE_STATEV)[:, 1:]
    return slips


def strength(result: Result) -> Floats:
    """Shear over pressure, of the whole joint, for each step."""
    normal, shear = result.traction[:, :, 0].mean(axis=1), result.traction[:, :, 1].mean(axis=1)
    return np.abs(shear / normal)


def residual_strength(direction: float) -> float:
    """Shear over pressure, sliding up the facing plane (direction 1) or back down it (-1)."""
    return float(JOINT.material.residual_strength(direction * THETA))


STARTS = (
    ("virgin", JOINT.initial(TRACTION), 1.0),
    ("cracked in part", JOINT.initial(TRACTION, PARTLY), 1.0),
    ("cracked", JOINT.initial(TRACTION, 1.0), 1.0),
    ("cracked and slipped, going back down", JOINT.initial(TRACTION, 1.0, slipped()), -1.0),
)
"""Name, state variables, direction of the slip."""


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="Prestressed bed joint in Kratos.")
    parser.parse_args()
    print(f"{'start':36}moves by its loads [mm]  largest strength  at the end  closed form")
    for name, state, direction in (*STARTS, ("no initial stress", None, 1.0)):
        result = run(state, direction * SLIPS, bricks_stressed=state is not None)
        moved, found = np.abs(result.displacement[0]).max(), strength(result)
        closed = residual_strength(direction)
        print(f"{name:36}{moved:23.1e}{found.max():18.3f}{found[-1]:12.6f}{closed:13.6f}")


if __name__ == "__main__":
    main()

"""Dam on the joint along its base in Kratos, whose interface elements carry the water of their nodes; m, N.

As a script this module prints the separations at a level of the water without uplift or with a linear one;
harness/hosts/fenicsx/dam.py does the same on FEniCSx, with flow, too.  Newton's method is plain: without
uplift on 50 elements it goes to and fro between two sets of closed nodes and ends with an error.
"""

from __future__ import annotations

import sys
from pathlib import Path

import KratosMultiphysics as Kratos
import numpy as np
from asperity import Interface, Material, Pattern
from asperity.contract import Floats
from asperity.mesh import Jointed
from kratos_model import Structure

sys.path.append(str(Path(__file__).parents[1]))
from dam_section import BASE, STIFFNESS, UPLIFTS, WATER, WEIGHT, program, section  # isort: skip

LAW = Interface(Material.from_joint(kn=STIFFNESS, ks=STIFFNESS, mu=1000.0), Pattern.regular(0, 0.0))
"""No bond, no sliding."""

PARTS = 40
"""Elements along the base."""

TOLERANCE = 1e-3
"""Norm of the residual, N; the thrust is 4e5 N."""


def give_weight(s: Structure, block: str, solid: Kratos.Properties, weight: float) -> None:
    """Give a block of the mesh its weight per volume, and properties of an elastic solid of its own."""
    solid.SetValue(Kratos.DENSITY, weight)
    for element in s.part.GetSubModelPart(block).Elements:
        element.Properties = solid
        for node in element.GetNodes():
            node.SetSolutionStepValue(Kratos.VOLUME_ACCELERATION, Kratos.Array3([0.0, -1.0, 0.0]))


def thrust(mesh: Jointed, name: str, level: float, weight: float) -> Floats:
    """Nodal forces of the water on a group of edges, linear on each."""
    [edges] = mesh.face_nodes(mesh.surfaces[name])
    x = mesh.points[edges]
    p = weight * np.maximum(level - x[:, :, 1], 0.0)
    along = x[:, 1] - x[:, 0]
    normal = np.stack([along[:, 1], -along[:, 0]], 1)
    forces = np.zeros_like(mesh.points)
    for k in (0, 1):
        np.add.at(forces, edges[:, k], -normal * (2.0 * p[:, k] + p[:, 1 - k])[:, None] / 6.0)
    return forces


def profile(uplift: str, level: float, parts: int, E: float = 3e12, nu: float = 0.0) -> Floats:
    """Rows x, s_N, p of the joint at a level; Lost where Newton's method finds no equilibrium."""
    mesh = section(parts)
    s = Structure(2)
    s.add_mesh(mesh, s.elastic(E, nu), s.umat(LAW, BIOT_COEFFICIENT=1.0))
    give_weight(s, "dam", s.elastic(E, nu), WEIGHT)
    s.fix(mesh.nodes("outside") + 1, 0, 1)
    water = thrust(mesh, "upstream", level, WATER)
    wet = np.flatnonzero(np.abs(water).sum(1))
    s.load({int(k) + 1: [0.0, 0.0, 0.0] for k in wet})
    [joint] = mesh.joints["base"]
    below, above = np.unique(np.stack([joint.minus, joint.plus], -1).reshape(-1, 2), axis=0).T
    x = mesh.points[below, 0]
    p = WATER * level * (1.0 - x / BASE) * (uplift == "linear")

    s.step(TOLERANCE)
    for k in wet.tolist():
        s.set_load(k + 1, [*water[k], 0.0])
    for nodes in (below, above):
        for k, pressure in zip(nodes.tolist(), p.tolist(), strict=True):
            s.part.Nodes[k + 1].SetSolutionStepValue(Kratos.WATER_PRESSURE, -pressure)
    s.step(TOLERANCE)
    u = s.displacements()
    order = np.argsort(x)
    return np.column_stack([x, (u[above] - u[below])[:, 1], p])[order]


if __name__ == "__main__":
    program(profile, __doc__, UPLIFTS[:2], PARTS)

"""The dam of docs/how-to/dam.md in Kratos, whose interface elements carry the water of their nodes."""

from __future__ import annotations

import sys
from pathlib import Path

import meshio
import numpy as np
import pytest
from asperity import Interface, Material, Pattern
from asperity.contract import Floats
from asperity.mesh import Jointed, split

Kratos = pytest.importorskip("KratosMultiphysics", reason="no packages of Kratos")
pytest.importorskip("KratosMultiphysics.GeoMechanicsApplication", reason="no packages of Kratos")
pytest.importorskip("gmsh")
from kratos_model import Lost, Structure  # noqa: E402  # after what it needs

sys.path.append(str(Path(__file__).parents[1] / "fenicsx"))
from gravity_dam_mesh import BASE, CREST, HEIGHT, mesh  # noqa: E402

CONCRETE, WATER, FRICTION = 0.024, 0.00981, 1.0
DAM, ROCK = 24e3, 20e3
LEAST = 1e-3
"""Last cut of the factor of the thrust."""


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


def joint(kn: float, mu: float) -> Interface:
    """Flat joint without bond."""
    return Interface(Material.from_joint(kn=kn, ks=kn / 2.0, mu=mu), Pattern.regular(0, 0.0))


@pytest.mark.parametrize("uplift", [False, True])
def test_gravity_dam(tmp_path: Path, uplift: bool) -> None:
    """It slides at (W - U) tan phi within 0.2 %, the last cut of the thrust and the residual.

    The water is the pressure of the nodes of the joint, -p, fixed on both sides, with BIOT_COEFFICIENT 1.
    """
    mesh(str(tmp_path / "dam.msh"), 6.0)
    section = split(meshio.read(tmp_path / "dam.msh"), {"fault": None, "base": ("rock", "dam")})
    s = Structure(2)
    laws = {"base": joint(2e4, FRICTION), "fault": joint(1e4, 0.6)}
    joints = {name: s.umat(law, BIOT_COEFFICIENT=1.0) for name, law in laws.items()}
    s.add_mesh(section, s.elastic(ROCK, 0.2), joints)
    s.fix(section.nodes("bottom") + 1, 1)
    s.fix(section.nodes("ends") + 1, 0)
    give_weight(s, "dam", s.elastic(DAM, 0.2), CONCRETE)
    parts = {name: thrust(section, name, HEIGHT, WATER) for name in ("upstream", "reservoir")}
    loaded = np.flatnonzero(sum(np.abs(forces).sum(1) for forces in parts.values()))
    s.load({int(k) + 1: [0.0, 0.0, 0.0] for k in loaded})
    [base] = section.joints["base"]
    at = np.unique([base.minus, base.plus])

    def step(filled: float, factor: float, again: bool) -> None:
        forces = filled * (factor * parts["upstream"] + parts["reservoir"])
        for k in loaded.tolist():
            s.set_load(k + 1, [*forces[k], 0.0])
        for k in at.tolist():
            p = uplift * filled * WATER * HEIGHT * (1.0 - section.points[k, 0] / BASE)
            s.part.Nodes[k + 1].SetSolutionStepValue(Kratos.WATER_PRESSURE, -p)
        s.step(1e-6, again)

    for filled in (0.0, 0.25, 0.5, 0.75, 1.0):
        step(filled, 1.0, False)
    reached, size, again = 1.0, 0.02, False
    while size > LEAST / 2.0:
        try:
            step(1.0, reached + size, again)
        except Lost:
            size, again = size / 2.0, True
        else:
            reached, again = reached + size, False
    dead = CONCRETE * HEIGHT * (BASE + CREST) / 2.0
    expected = FRICTION * (dead - uplift * WATER * HEIGHT * BASE / 2.0)
    assert reached * WATER * HEIGHT**2 / 2.0 == pytest.approx(expected, rel=2e-3)

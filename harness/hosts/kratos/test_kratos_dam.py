"""The dams of docs/how-to/dam.md and docs/validation/dam.md in Kratos, whose elements carry the water."""

from __future__ import annotations

import sys
from pathlib import Path

import meshio
import numpy as np
import pytest
from asperity import Interface, Material, Pattern
from asperity.mesh import split

from harness.studies.validation import dam

Kratos = pytest.importorskip("KratosMultiphysics", reason="no packages of Kratos")
pytest.importorskip("KratosMultiphysics.GeoMechanicsApplication", reason="no packages of Kratos")
pytest.importorskip("gmsh")
from dam_kratos import PARTS, give_weight, profile, thrust  # noqa: E402  # after what it needs
from kratos_model import Lost, Structure  # noqa: E402

sys.path.append(str(Path(__file__).parents[1] / "fenicsx"))
from gravity_dam_mesh import BASE, CREST, HEIGHT, mesh  # noqa: E402

CONCRETE, WATER, FRICTION = 0.024, 0.00981, 1.0
DAM, ROCK = 24e3, 20e3
LEAST = 1e-3
"""Last cut of the factor of the thrust."""


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


@pytest.mark.parametrize("uplift", ["none", "linear"])
def test_beside_code_aster(uplift: str) -> None:
    """Separations along the joint are those of Code_Aster's coarser mesh."""
    x, s_N, p = profile(uplift, dam.LEVEL, PARTS).T
    expected = np.array(dam.OTHERS[uplift]["Code_Aster"])
    assert np.interp(dam.PLACES, x, s_N) == pytest.approx(expected, abs=dam.BESIDE * np.abs(expected).max())
    assert p[[0, -1]] == pytest.approx([dam.WATER * dam.LEVEL * (uplift == "linear"), 0.0])

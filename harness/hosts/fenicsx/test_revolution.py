"""Bodies of revolution on FEniCSx: a thick ring, and a fibre pulled out, beside closed forms."""

from __future__ import annotations

import pytest
from on_ranks import RANKS, WITH_FENICSX, assert_refused, of_all_ranks

from harness.studies.validation.wall_runs import ROOT

pytestmark = WITH_FENICSX

RING = """
radii, E, nu, p = np.linspace(1.0, 2.0, 65), 1000.0, 0.3, 2.0
stiff = Interface(Material(3e6, 3e5, 0.9, 0.5), Pattern.regular(0, 0.0))
flat = grid(radii, [0.0, 0.05], block=np.repeat([0, 1], 32)[:, None])
ring = split(flat, axisymmetric=True) if COMM.rank == 0 else None
m = Model(ring, {"joint": stiff}, E, nu)
"""
"""Two rings with a joint between them that is stiffer than they are by 1e5, in plane strain."""

LAME = """
still = Conditions(m.dofs(np.ones(m.n, bool), 1), pressures={"left": p})
u = solve(m, State.virgin(m), still).taken().u.reshape(-1, 2)
exact = (1 + nu) / E * p / 3.0 * ((1 - 2 * nu) * m.x[:, 0] + 4.0 / m.x[:, 0])
results["error"] = float(largest(np.abs(u[:, 0] / exact - 1.0)))
results["volume"] = float(total(m.body([0.0, 1.0]).reshape(-1, 2)[:, 1].sum()))
"""

FIBRE = f"""
import sys, tempfile
from pathlib import Path
sys.path.insert(0, {str(ROOT / "harness" / "examples")!r})
import pull_out as one
with tempfile.TemporaryDirectory() as folder:
    path = Path(folder, "fibre.inp")
    path.write_text(one.deck(), encoding="utf-8")
    fibre = split(path, axisymmetric=True) if COMM.rank == 0 else None
m = Model(fibre, {{"joint": Interface(one.BOND, Pattern.regular(0, 0.0))}}, one.E, 0.0)
block, end = m.solid("BLOCK").reshape(-1, 2)[:, 0] > 0.0, m.x[:, 1] > one.L * (1.0 - 1e-9)
axis, pulled = m.x[:, 0] < 1e-9, m.dofs(end & ~block, 1)
fixed = np.concatenate([m.dofs(block, 0, 1), m.dofs(axis, 0), pulled])

def held(share):
    values = np.zeros(len(fixed))
    values[len(fixed) - len(pulled):] = share * one.LAST * one.BOND.s_f
    return Conditions(fixed, values)

path = Follow(m, State.virgin(m), held, 1.0 / one.STEPS)
forces = [float(total(report.reaction[pulled].sum())) for report in path.to(1.0)]
stiffness, strength = one.closed_forms()
first = one.LAST * one.BOND.s_f / one.STEPS
results |= {{"stiffness": forces[0] / first / stiffness, "strength": max(forces) / strength}}
"""


@pytest.mark.parametrize("ranks", RANKS)
def test_ring_under_pressure(ranks: int) -> None:
    """Lame's displacements under a pressure in the bore, within the error of elements, and the volume."""
    results = of_all_ranks(RING + LAME, ranks)
    assert results["error"] < 1e-4
    assert results["volume"] == pytest.approx(3.0 * 3.141592653589793 * 0.05, rel=1e-12)


@pytest.mark.parametrize("ranks", RANKS)
def test_fibre(ranks: int) -> None:
    """Initial stiffness and largest force of a long fibre, as elements in NumPy have them."""
    results = of_all_ranks(FIBRE, ranks)
    assert results["stiffness"] == pytest.approx(1.0, rel=2e-3)
    assert results["strength"] == pytest.approx(1.0, rel=2e-3)


REFUSED = {
    'Model(ring, {"joint": stiff}, E, nu, thickness=2.0)': "thickness = 2.0: expected 1 of a body of",
    "State.initial(m, np.eye(2))": "initial stress of a body of revolution: expected a plane mesh",
    'measure(m, "joint", State.virgin(m))': "resultants of a body of revolution: expected a plane mesh",
}


def test_what_a_body_of_revolution_has_not() -> None:
    """A width of its own, resultants and stresses without that around the axis are refused."""
    assert_refused(REFUSED, RING, 1)

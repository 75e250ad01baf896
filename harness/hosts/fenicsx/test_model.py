"""Models and steps on FEniCSx: wrong input is refused by one line, and so is a step without equilibrium."""

from __future__ import annotations

import pytest
from on_ranks import WITH_FENICSX, assert_refused, of_all_ranks

pytestmark = WITH_FENICSX

WRONG = {
    'model(plane="strian")': "plane = 'strian': expected 'stress' or 'strain'",
    "model(nu=0.6)": "nu = 0.6: expected -1 < nu < 0.5",
    "model(0.0)": "E of block_0 = 0.0: expected above 0",
    'model({"block_0": 1.0})': "E of block_0: expected one of block_1, too",
    'model({"block_0": 1.0, "block_1": 1.0, "rock": 1.0})': "E of rock: no such block: expected one of",
    'model(laws={"bed": law})': "laws of bed: expected those of joint",
    "model(thickness=-1.0)": "thickness = -1.0: expected above 0",
    "(m := model()).dofs(m.x[:, 0] < 1, 2)": "component 2: expected 0 to 1 in 2D",
    "(m := model()).dofs(np.ones(3, bool), 0)": "a mask of the shape (3,): expected one for",
    "(m := model()).dofs(np.array([10**6]), 0)": "nodes 1000000 to 1000000: expected owned ones",
    'model().solid("rock")': "rock: no such block: expected one of block_0, block_1",
    'model().group("roof")': "roof: no such group: expected one of",
    'model().body([0.0, -1.0], "rock")': "rock: no such block: expected one of block_0, block_1",
    "model().body([0.0, -1.0, 0.0])": "force [0.0, -1.0, 0.0]: expected 2 finite components",
    "model().body([0.0, 1j])": "force[1] = 1j: expected a finite number",
    "steps([])": "nothing is fixed and there is no drag",
    "steps([10**6])": "expected components 0 to",
    "steps(tolerance=0.0)": "tolerance = 0.0: expected between 0 and 1",
    "steps(drag=[1.0])": "drag of the shape (1,): expected",
    "(s := steps()).solve(np.zeros(3), s.load)": "values of the shape (3,): expected",
    "(s := steps()).solve(0.0 * s.fixed, s.load[:-1])": "load of the shape",
    "(s := steps()).solve(0.0 * s.fixed + np.nan, s.load)": "values: expected finite numbers",
    "(s := steps()).solve(0.0 * s.fixed, s.load, 0.0)": "dt = 0.0: expected above 0",
    "Follow(steps(), None, 0.1, 0.05)": "step = 0.1, most = 0.05, least = 1e-05: expected",
    'steps(options="-snes_linesearch_type nonesuch")': "has no line search nonesuch: expected PETSc 3.24",
}
"""Expressions and what their errors say."""


@pytest.mark.parametrize("ranks", [1, 2])
def test_wrong_input(ranks: int) -> None:
    """Every rank has the error, and it is one line."""
    assert_refused(WRONG, "", ranks)


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("search", ["cp", "bisection", "bt", "basic"])
def test_no_equilibrium_without_forces(search: str, ranks: int) -> None:
    """A block slides under more than the friction, whatever PETSc says of the step.

    The line search cp reports convergence without an iteration, where it finds no way down.
    """
    code = f"""
s = steps(m=model(), options="-snes_linesearch_type {search}")
m = s.model
down, push = (m.body(force, "block_1") for force in ([0.0, -1e-2], [1e-2, 0.0]))
none = np.zeros(len(s.fixed))
results["solved"] = [s.solve(none, down + share * push) for share in (0.0, 0.3, 0.45, 0.51, 0.55, 0.6)]
"""
    assert of_all_ranks(code, ranks)["solved"] == [True, True, True, False, False, False]

"""Models and steps on FEniCSx: wrong input is refused by one line, and so is a step without equilibrium."""

from __future__ import annotations

import pytest

from harness.studies.validation.wall_runs import PROGRAM, PYTHON, start

pytestmark = pytest.mark.skipif(
    not PYTHON.exists(), reason="no build/fenicsx: harness/hosts/fenicsx/install.sh"
)

MODEL = f"""
import sys
sys.path[:0] = [{str(PROGRAM.parent)!r}, {str(PROGRAM.parents[1])!r}]
import numpy as np
from jointed import *
from asperity import Interface, Material, Pattern
from asperity.mesh import split
from structured import grid

law = Interface(Material.from_joint(kn=200.0, ks=80.0, mu=0.5), Pattern.regular(0, 0.0))
mesh = split(grid(range(4), range(3), block=[0, 1])) if COMM.rank == 0 else None

def model(E=2e4, nu=0.2, laws=None, **other):
    return Model(mesh, laws or {{"joint": law}}, E, nu, **other)

def steps(fixed=None, m=None, **other):
    m = m or model()
    return Steps(m, m.dofs(m.x[:, 1] < 1e-6, 0, 1) if fixed is None else np.array(fixed, int), **other)
"""
"""A model of two blocks."""

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
    code = MODEL + f"""
for expression in {list(WRONG)!r}:
    try:
        eval(expression)
        text = "accepted"
    except ValueError as error:
        text = str(error)
    texts = COMM.gather(text)
    if COMM.rank == 0:
        print(expression + " -> " + " | ".join(texts))
"""  # fmt: skip
    done = start("", ranks=ranks, code=code)
    assert done.returncode == 0, done.stderr
    printed = dict(line.split(" -> ") for line in done.stdout.splitlines())
    assert printed.keys() == WRONG.keys()
    for expression, expected in WRONG.items():
        texts = printed[expression].split(" | ")
        assert len(texts) == ranks
        for text in texts:
            assert expected in text, (expression, text)


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("search", ["cp", "bisection", "bt", "basic"])
def test_no_equilibrium_without_forces(search: str, ranks: int) -> None:
    """A block slides under more than the friction, whatever PETSc says of the step.

    The line search cp reports convergence without an iteration, where it finds no way down.
    """
    code = MODEL + f"""
s = steps(m=model(), options="-snes_linesearch_type {search}")
m = s.model
down, push = (m.body(force, "block_1") for force in ([0.0, -1e-2], [1e-2, 0.0]))
none = np.zeros(len(s.fixed))
solved = [s.solve(none, down + share * push) for share in (0.0, 0.3, 0.45, 0.51, 0.55, 0.6)]
if COMM.rank == 0:
    print(solved)
"""  # fmt: skip
    done = start("", ranks=ranks, code=code)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "[True, True, True, False, False, False]"

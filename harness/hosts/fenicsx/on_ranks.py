"""Codes that tests run on ranks of MPI, and what each rank stores in the dictionary `results`.

The ranks print nothing, as their lines may end up in one: rank 0 gathers and prints.
"""

from __future__ import annotations

import json

import pytest

from harness.studies.validation.wall_runs import PYTHON, ROOT, start

WITH_FENICSX = pytest.mark.skipif(
    not PYTHON.exists(), reason="no build/fenicsx: harness/hosts/fenicsx/install.sh"
)

MODEL = """
from dataclasses import replace
import numpy as np
from asperity import Interface, Material, Pattern
from asperity.fenicsx import *
from asperity.mesh import split
from harness.hosts.structured import grid

law = Interface(Material.from_joint(kn=200.0, ks=80.0, mu=0.5), Pattern.regular(0, 0.0))
mesh = split(grid(range(4), range(3), block=[0, 1])) if COMM.rank == 0 else None

def model(E=2e4, nu=0.2, laws=None, **settings):
    return Model(mesh, laws or {"joint": law}, E, nu, **settings)

def bottom(m):
    return m.dofs(m.x[:, 1] < 1e-6, 0, 1)

def found(terms=None, m=None, **conditions):
    m = m or model()
    return solve(m, State.virgin(m), Conditions(**{"fixed": bottom(m)} | conditions), terms)
"""
"""A model of two blocks."""

BEGINNING = """
results = {}
"""

ENDING = """
import json
of_ranks = COMM.gather(results)
if COMM.rank == 0:
    print(json.dumps(of_ranks))
"""

WRONG_INPUT = """
for expression in EXPRESSIONS:
    try:
        eval(expression)
        results[expression] = "accepted"
    except ValueError as error:
        results[expression] = str(error)
"""


def assert_installed() -> None:
    """The solver of this tree is what build/fenicsx has."""
    [installed] = (PYTHON.parents[1] / "lib").glob("python3.*/site-packages/asperity/fenicsx")
    here, there = (
        {file.name: file.read_bytes() for file in folder.glob("*.py")}
        for folder in (ROOT / "python" / "asperity" / "fenicsx", installed)
    )
    assert here == there, "build/fenicsx has another solver: harness/hosts/fenicsx/install.sh build/fenicsx"


def of_each_rank(code: str, ranks: int) -> list[dict]:
    """Results of a code that goes on from the model of two blocks, by rank."""
    assert_installed()
    done = start("", ranks=ranks, code=BEGINNING + MODEL + code + ENDING)
    assert done.returncode == 0, done.stderr
    of_ranks = json.loads(done.stdout.splitlines()[-1])
    assert len(of_ranks) == ranks
    return of_ranks


def of_all_ranks(code: str, ranks: int) -> dict:
    """Results that are the same on all ranks."""
    first, *others = of_each_rank(code, ranks)
    assert others == [first] * len(others)
    return first


def assert_refused(expected: dict[str, str], code: str, ranks: int) -> None:
    """Every rank refuses each expression by one line, which contains what is expected."""
    for texts in of_each_rank(code + WRONG_INPUT.replace("EXPRESSIONS", repr([*expected])), ranks):
        assert texts.keys() == expected.keys()
        assert {name: text for name, text in texts.items() if expected[name] not in text} == {}
        assert not any("\n" in text for text in texts.values())

"""Time steps on FEniCSx: a block that slides and flutters, walls that rock, wrong input."""

from __future__ import annotations

from functools import cache

import pytest
from test_model import MODEL

from harness.studies.validation.wall_runs import PYTHON, start

pytestmark = pytest.mark.skipif(
    not PYTHON.exists(), reason="no build/fenicsx: harness/hosts/fenicsx/install.sh"
)


@cache
def numbers(words: str, ranks: int = 1) -> dict[str, list[float]]:
    """Numbers that the program prints, by name."""
    done = start(words, "shaken", ranks)
    assert done.returncode == 0, done.stderr
    found = {}
    for line in done.stdout.splitlines():
        name, _, rest = line.partition(": ")
        found[name] = [float(word) for word in rest.split()]
    return found


def test_flutter() -> None:
    """The block that slides gains vibration; damping of the solids ends that, a dashpot alone does not."""
    found = {name: one for name, (one,) in numbers("growth").items()}
    # eigenvalues of a script of its own with the matrices of this model
    assert found["growth"] == pytest.approx(34.4, abs=0.05)
    assert found["growth beta"] < 0.0 < found["growth c"] < found["growth"] < found["growth fine"]
    assert abs(found["growth stiff"]) < 1e-6 and abs(found["growth frictionless"]) < 1e-6


def test_slip_after_a_pulse() -> None:
    """With damping the slip does not depend on step and mesh, and is that of explicit time integration."""
    found = numbers("slip")
    # by central differences with steps of .06 ms
    for name in ("slip", "slip half", "slip fine"):
        assert found[name][0] == pytest.approx(0.8805, rel=1e-3)


def test_two_ranks() -> None:
    """The ranks share the ledger and the cuts."""
    one, two = numbers("coarse")["coarse"], numbers("coarse", 2)["coarse"]
    assert two == pytest.approx(one, rel=1e-4)


def test_petsc() -> None:
    """TSALPHA2 of PETSc with the parameters of Bossak's method slides as far."""
    assert numbers("alpha2")["alpha2"][0] == pytest.approx(numbers("coarse")["coarse"][0], rel=1e-3)


@pytest.mark.parametrize("name", ["wall", "edges"])
def test_energy_of_a_rocking_wall(name: str) -> None:
    """Impacts create no energy: never more than 1.02 of that at the start."""
    largest, _, end, *_ = numbers(name)[name]
    assert 1.0 <= largest <= 1.02
    assert end == pytest.approx(0.55)


WRONG = {
    "shake(mass=0.0 * m.u)": "mass: expected finite numbers above 0",
    "shake(mass=np.ones(3))": "mass: expected finite numbers above 0 of the shape",
    "shake(load=np.ones(3))": "load: expected the shape",
    "shake(step=0.0)": "step = 0.0, least = 1e-06: expected",
    "shake(beta=-1.0)": "beta = -1.0: expected >= 0",
    "shake(rho=1.5)": "rho = 1.5: expected 0 to 1",
    "shake(ground=lambda t: [1.0]).advance(0.1)": "ground at 0: expected 2 finite components, not [1.0]",
    "shake(ground=lambda t: [1.0, np.nan]).advance(0.1)": "ground at 0: expected 2 finite components",
    "(m.pressure('joint', 1.0), shake())": "water in the model: expected none",
}
"""Expressions and what their errors say."""


@pytest.mark.parametrize("ranks", [1, 2])
def test_wrong_input(ranks: int) -> None:
    """Every rank has the error, and it is one line."""
    code = MODEL + f"""
m = model()

def shake(mass=None, load=None, step=1e-3, **other):
    mass = np.abs(m.body([1.0, 1.0])) if mass is None else mass
    load = 0.0 * m.u if load is None else load
    return Shake(steps(m=m), mass, load, step, 1e-6, **other)

for expression in {list(WRONG)!r}:
    try:
        eval(expression)
        text = "accepted"
    except ValueError as error:
        text = str(error)
    found = COMM.gather(text)
    if COMM.rank == 0:
        print(expression + " -> " + " | ".join(found))
"""  # fmt: skip
    done = start("", ranks=ranks, code=code)
    assert done.returncode == 0, done.stderr
    found = dict(line.split(" -> ") for line in done.stdout.splitlines())
    assert found.keys() == WRONG.keys()
    for expression, expected in WRONG.items():
        assert all(expected in text for text in found[expression].split(" | ")), found[expression]

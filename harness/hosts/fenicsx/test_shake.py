"""Time steps on FEniCSx: a block that slides and flutters, walls that rock, wrong input."""

from __future__ import annotations

from functools import cache

import pytest
from on_ranks import RANKS, SEVERAL_RANKS, WITH_FENICSX, assert_refused, done_by, of_all_ranks, of_each_rank

from harness.studies.validation import wall_runs

pytestmark = WITH_FENICSX


@cache
def numbers(words: str, ranks: int = 1) -> dict[str, list[float]]:
    """Numbers that the program prints, by name."""
    return dict(wall_runs.printed_by(words, "shaken", ranks, done_by))


def test_flutter() -> None:
    """The block that slides gains vibration; damping of the solids ends that, a dashpot alone does not."""
    growth = {name: value for name, (value,) in numbers("growth").items()}
    # eigenvalues of a script of its own with the matrices of this model
    assert growth["growth"] == pytest.approx(34.4, abs=0.05)
    assert growth["growth beta"] < 0.0 < growth["growth c"] < growth["growth"] < growth["growth fine"]
    assert abs(growth["growth stiff"]) < 1e-6 and abs(growth["growth frictionless"]) < 1e-6


def test_slip_after_a_pulse() -> None:
    """With damping the slip does not depend on step and mesh, and is that of explicit time integration."""
    slips = numbers("slip")
    # by central differences with steps of .06 ms
    for name in ("slip", "slip half", "slip fine"):
        assert slips[name][0] == pytest.approx(0.8805, rel=1e-3)


@SEVERAL_RANKS
def test_two_ranks() -> None:
    """The ranks share the ledger and the cuts."""
    one_rank, two = numbers("coarse")["coarse"], numbers("coarse", 2)["coarse"]
    assert two == pytest.approx(one_rank, rel=1e-4)


def test_petsc() -> None:
    """TSALPHA2 of PETSc with the parameters of Bossak's method slides as far."""
    assert numbers("alpha2")["alpha2"][0] == pytest.approx(numbers("coarse")["coarse"][0], rel=1e-3)


SLIPS = {0.0: 0.14715, 10.0: 0.067544, 20.0: 0.023766}
"""Way of a rigid slab along planes by their inclination: a1 t0^2/2 (1 + a1/a2), see shaken_points.py."""


@pytest.mark.parametrize(("d", "ranks"), [(2, 1), (3, 1), pytest.param(3, 2, marks=SEVERAL_RANKS)])
def test_slip_along_planes(d: int, ranks: int) -> None:
    """A slab on inclined planes goes as far as a rigid one, in space in any direction, on any ranks."""
    slips = numbers(f"climb{d}", ranks)
    for theta, closed in SLIPS.items():
        # of the spring and of the increment, both first order
        assert slips[f"climb{d} {theta:g}"][0] == pytest.approx(closed, rel=0.01)
        assert slips[f"climb{d} {theta:g}"][0] == pytest.approx(
            numbers("climb2")[f"climb2 {theta:g}"][0], rel=1e-4
        )


SCENE = """
import tempfile
from pathlib import Path

G, DENSITY, UP = 9.81, 0.0024, -1

def shake(seed, d, folder=None):
    rng = np.random.default_rng(seed)
    lines = [np.linspace(0.0, rng.uniform(0.5, 3.0), int(rng.integers(2, 4))) for _ in range(d - 1)]
    up = np.r_[-0.1, 0.0, np.cumsum(rng.uniform(0.1, 0.5, 2))]
    kn, mu, mass = 10.0 ** rng.uniform(4.0, 5.3), rng.uniform(0.2, 0.8), DENSITY * up[-1]
    c = 2.0 * rng.choice([0.0, 0.3, 1.0]) * np.sqrt(kn * mass)
    pattern = Pattern.regular(int(rng.choice([0, 2, 4])), rng.uniform(3.0, 20.0), turn=rng.uniform(0.0, 90.0))
    law = Interface(Material.from_joint(kn, 0.4 * kn, mu, c=c), pattern)
    mesh = split(grid(*lines, up, block=np.arange(3))) if COMM.rank == 0 else None
    m = Model(mesh, {"joint": law}, 10.0 ** rng.uniform(3.0, 4.5), 0.2, plane="strain")
    down = m.body(np.r_[np.zeros(d - 1), -DENSITY * G])
    conditions = Conditions(np.flatnonzero(m.solid("block_0")), load=down)
    start = solve(m, State.virgin(m), conditions, Terms(dt=1e6, tolerance=1e-8)).taken()
    A, f = G * rng.uniform(0.3, 1.5, d) * np.r_[np.ones(d - 1), 0.4], rng.uniform(3.0, 12.0, d)
    ground = lambda t: A * np.sin(2.0 * np.pi * f * t) * (t < 0.06)
    dt = min(1e-3, np.pi * np.sqrt(mass / kn))
    mass = np.abs(m.body([DENSITY] * d))
    return Shake(m, start, conditions, mass, dt, ground=ground, beta=rng.choice([0.0, 1e-5])), down
"""
"""Blocks on a rock, shaken for .06 s; all of it is drawn."""


@pytest.mark.parametrize("d", [2, 3])
def test_no_energy_from_nothing(d: int) -> None:
    """The balance of all energies hardly rises; once the base has stopped, mechanical energy only falls."""
    code = (
        SCENE
        + f"""
from asperity import contract
for seed in range(6):
    s, down = shake(seed, {d})
    m, stored, energies, rises, lowest = s.model, contract.statev_index("stored"), [], [0.0], np.inf
    while not s.reason and s.at < 0.12:
        if s.advance(0.06 if s.at < 0.06 else 0.12):
            lowest = min(lowest, s._start, s.ledger.balance)
            rises.append(s.ledger.balance - lowest)
            if s.at >= 0.06:
                u = s.state.u
                energy = 0.5 * s.mass @ s.state.v**2 + u @ (0.5 * m.stiff(u) - down)
                energies.append(energy + m.area @ s.state.joints[0][:, stored])
    E = np.array(energies)
    rise = (E - np.minimum.accumulate(E)).max() / s._size
    results[seed] = s.reason, max(rises) / s._size, rise, s.ledger.spent
"""
    )
    rows = of_all_ranks(code, 1)
    assert len(rows) == 6
    for reason, balance, mechanical, spent in rows.values():
        assert not reason and spent > 0.0
        # of what a run may gain
        assert balance <= 0.01 and mechanical <= 0.01


def test_energy_that_creeps_in() -> None:
    """Where each step gains little, but all together too much, the run does not end without a reason."""
    code = (
        SCENE
        + """
class Creeping(Shake):
    def _energies(self, state, damped, work):
        return super()._energies(state, damped, work - 4e-3 * self._size)

s, down = shake(0, 2)
s = Creeping(s.model, s.state, replace(s.conditions, load=down), s.mass, s.most, ground=s.ground)
try:
    results.update(reached=bool(s.run(0.002)))
except Stopped as stopped:
    results.update(reached=False, cuts=s.cuts, reason=str(stopped))
"""
    )
    run = of_all_ranks(code, 1)
    assert not run["reached"] and run["cuts"] > 0
    assert run["reason"].startswith("ended at 0.002, but all energies have risen by")


@pytest.mark.parametrize("ranks", RANKS)
def test_resume(ranks: int) -> None:
    """A run that goes on from its file ends where the run without a pause ends."""
    code = (
        SCENE
        + """
whole, _ = shake(3, 3)
whole.run(0.03)
whole.run(0.08)
first, _ = shake(3, 3)
first.run(0.03)
folder = Path(COMM.bcast(tempfile.mkdtemp() if COMM.rank == 0 else None))
first.save(str(folder / "half"))
again, _ = shake(3, 3)
again.resume(str(folder / "half"))
assert again.at == first.at and again.taken == first.taken
again.run(0.08)
results["differences"] = again.state.differences(whole.state)
results["same"] = bool(again.taken == whole.taken and again.ledger == whole.ledger)
broken, _ = shake(4, 3)
results["refused"] = []
for name in ("half", "none"):
    try:
        broken.resume(folder / name)
    except ValueError as error:
        results["refused"].append(str(error))
"""
    )
    for results in of_each_rank(code, ranks):
        assert results["differences"] == {} and results["same"]
        assert len(results["refused"]) == 2
        for text in results["refused"]:
            assert "expected the files of a run with the same mesh, laws and ranks" in text


@pytest.mark.parametrize("name", ["wall", "edges"])
def test_energy_of_a_rocking_wall(name: str) -> None:
    """Impacts create no energy: never more than 1.02 of that at the start."""
    largest, _, end, *_ = numbers(name)[name]
    assert 1.0 <= largest <= 1.02
    assert end == pytest.approx(0.55)


WRONG = {
    "shake(mass=zero)": "mass: expected finite numbers above 0",
    "shake(mass=np.ones(3))": "mass: expected finite numbers above 0 of the shape",
    "shake(load=np.ones(3))": "load of the shape (3,): expected 0 or",
    "shake(load=np.nan)": "load: expected finite numbers",
    "shake(v=np.nan * zero)": "v of the state: expected finite numbers",
    "shake(values=1.0)": "values of the fixed components differ from the state by 1",
    "shake().run(np.nan)": "end = nan: expected a time, 0 or later",
    "shake().run(-1.0)": "end = -1.0: expected a time, 0 or later",
    "(s := shake()).run(0.01) and s.advance(0.005)": "end = 0.005: expected a time, 0.01 or later",
    "shake().advance(np.nan)": "end = nan: expected a time, 0 or later",
    "shake().resume(Path('none'))": "none: expected the files of a run with the same mesh, laws and ranks",
    "shake(step=0.0)": "step = 0.0, least = 1e-06: expected",
    "shake(step='short')": "step = short: expected a finite number",
    "shake(rho=True)": "rho = True: expected a finite number",
    "shake(ground=1.0)": "ground 1.0: expected a function of time",
    "shake().run('end')": "end = end: expected a time, 0 or later",
    "shake(beta=-1.0)": "beta = -1.0: expected >= 0",
    "shake(terms=Terms(drag=1.0))": "passes, drag or damping of the terms: expected none",
    "shake(terms=Terms(passes=1))": "passes, drag or damping of the terms: expected none",
    "shake(rho=1.5)": "rho = 1.5: expected 0 to 1",
    "shake(ground=refused).advance(0.1)": "no motion at 0",
    "shake(ground=lambda t: [1.0]).advance(0.1)": "ground at 0: expected 2 finite components, not [1.0]",
    "shake(ground=lambda t: [1.0, np.nan]).advance(0.1)": "ground at 0: expected 2 finite components",
}
"""Expressions and what their errors say."""


@pytest.mark.parametrize("ranks", RANKS)
def test_wrong_input(ranks: int) -> None:
    """Every rank has the error, and it is one line."""
    code = """
from pathlib import Path
m = model()
zero = np.zeros(m.n * m.d)

def refused(t):
    if COMM.rank == COMM.size - 1:  # one rank alone
        raise ValueError(f"no motion at {t:g}")
    return [0.0, 0.0]

def shake(mass=None, load=0.0, step=1e-3, v=zero, values=0.0, **settings):
    mass = np.abs(m.body([1.0, 1.0])) if mass is None else mass
    start = replace(State.virgin(m), v=v)
    return Shake(m, start, Conditions(bottom(m), values, load), mass, step, 1e-6, **settings)
"""
    assert_refused(WRONG, code, ranks)

"""A state on FEniCSx is what accepted equilibria make it: attempts that fail or raise leave no trace."""

from __future__ import annotations

import pytest
from on_ranks import RANKS, WITH_FENICSX, of_all_ranks, of_each_rank

pytestmark = WITH_FENICSX

SCENES = """
import tempfile
from pathlib import Path
from asperity.fenicsx import equilibrium, newton, passes
from asperity.fenicsx.tangent import equations_of

STRENGTH = 0.25
BOND = Interface(Material(sigma0=STRENGTH, Gc=0.018, eta=0.97882791327913, mu=0.75), Pattern.regular(0, 0.0))
folder = Path(COMM.bcast(tempfile.mkdtemp() if COMM.rank == 0 else None))

def weights(m):
    return [m.body(force, "block_1") for force in ([0.0, -1e-2], [1e-2, 0.0])]

def pulled(m, factor=1.0):
    # a share of the strength of the joint, as a force on the top
    top, area = m.group("top")
    pull = np.zeros((m.n, 2))
    pull[top, 1] = factor * STRENGTH * area
    return lambda t: Conditions(bottom(m), load=t * pull.ravel())

def moved(m):
    top = m.group("top")[0]
    fixed = np.r_[bottom(m), m.dofs(top, 0, 1)]
    along, up = (np.isin(fixed, m.dofs(top, k)) for k in (0, 1))
    return lambda t: Conditions(fixed, 0.2 * t * along + 0.01 * np.sin(9.0 * t) * up)

def wet(m):
    down, _ = weights(m)
    joint = lambda t: lambda x, s: np.clip(2e-3 + 5e2 * t * np.maximum(s + 1e-4, 0.0), 0.0, 0.01)
    left = lambda t: lambda x: 2e-3 * t * (x[:, 1] > 1.0)
    return lambda t: Conditions(bottom(m), load=down, pressures={"joint": joint(t), "left": left(t)})

def flowing(m):
    down, _ = weights(m)
    flow = lambda t: Flow("joint", {"left": 0.01 * t, "right": 0.0}, 1e-9, 1e-3, 1e-4)
    return lambda t: Conditions(bottom(m), load=down, flows=[flow(t)])

def pushed(m):
    down, push = weights(m)
    return lambda t: Conditions(bottom(m), load=down + 0.49 * np.sin(t) * push)

def begun(kind):
    m = model(laws={"joint": BOND} if kind in ("newton", "passes") else None)
    of = {"newton": moved, "passes": moved, "wet": wet, "flowing": flowing, "pushed": pushed}[kind](m)
    start = solve(m, State.virgin(m), of(0.0)).taken()
    return Follow(m, start, of, 0.05, 0.1, always=kind == "passes")

def trace(follow, end=1.0, most=60):
    for _ in range(most):
        if follow.at == end:
            break
        follow.advance(end)
    return follow
"""
"""Two blocks that are pulled, moved, pressed by water or pushed."""

KINDS = "newton", "passes", "wet", "flowing", "pushed"


def run(code: str, ranks: int = 1) -> dict:
    """Results of the scenes, which all ranks have."""
    return of_all_ranks(SCENES + code, ranks)


def test_arrays_are_read_only() -> None:
    """No array of a state or a report can be written to, whoever made it; states and models do not change."""
    results = run("""
mine = np.ones(48)
m = model()
state = replace(State.virgin(m), u=mine)
mine[:] = 7.0
results["copied"] = float(state.u.max())
names = ("u", "s", "t", "p", "forces", "stress", "v", "a")
arrays = [*(getattr(state, name) for name in names), *state.joints, m.x, m.area, m.pairs, m.axes]
report = found(m=m, load=weights(m)[0])
arrays += [getattr(report, name) for name in ("reaction", "x", "load", "fixed", "first", "p")]
results["written"] = 0
for array in arrays:
    try:
        array[...] = 0.0
        results["written"] += 1
    except ValueError:
        pass
for thing, name in ((state, "u"), (m, "scale")):
    try:
        setattr(thing, name, 0.0)
        results["written"] += 1
    except AttributeError:
        pass
""")
    assert results == {"copied": 1.0, "written": 0}


@pytest.mark.parametrize("passes", [False, True])
def test_no_load_above_the_strength(passes: bool) -> None:
    """Attempts far above the strength of a bond do not widen what counts as nothing in the next ones.

    The own residual of each accepted state is below the tolerance, and no state carries more than the
    strength, also where steps are taken by passes.
    """
    results = run(f"""
for factor in (1.0, 10.0, 1e3, 1e5):
    m = model(laws={{"joint": BOND}})
    of = pulled(m)
    follow = Follow(m, State.virgin(m), of, factor, factor, 1e-4, always={passes})
    worst = 0.0
    while not follow.reason and follow.at < factor:
        if follow.advance(factor):
            worst = max(worst, follow.report.residual)
    results[str(factor)] = follow.at, worst, follow.cuts, follow.state.scale / STRENGTH / 3.0
""")
    for factor, (at, worst, cuts, scale) in results.items():
        assert 1.0 - 2e-4 <= at <= 1.0 + 1e-5, factor
        # the forces of the scale are those of the state: all components, also those across the pull
        assert worst <= 1e-6 and at <= scale <= 1.2 * at, factor
        assert cuts > 0 or factor == "1.0"


def test_a_pass_that_converges_before_one_that_fails() -> None:
    """The first pass of an attempt converges, the next one fails: the step after is that without it."""
    results = run("""
def steps(attempt):
    follow = begun("passes")
    trace(follow, most=4)
    if attempt:
        calls, true = [0], passes.newton
        def failing(*words, **names):
            calls[0] += 1
            found = true(*words, **names)
            return found if calls[0] == 1 else replace(found, good=False, reason="planted")
        passes.newton = failing
        try:
            taken = follow.advance(follow.at + 0.07)
        finally:
            passes.newton = true
        results["attempt"] = [taken, calls[0], follow.report.passes]
    # the same step in both
    report = solve(follow.model, follow.state, follow.conditions(follow.at + 0.01), Terms(passes=8))
    return follow.state, report.taken()

(a, b), (c, d) = steps(False), steps(True)
results["same"] = [a.differences(c), b.differences(d)]
""")
    taken, calls, passed = results["attempt"]
    assert not taken and calls == passed == 2
    assert results["same"] == [{}, {}]


@pytest.mark.parametrize("kind", KINDS)
def test_an_exception_at_any_call_of_the_law(kind: str) -> None:
    """An exception inside the n-th call of the law leaves model and state as they were: the run goes on."""
    results = run(f"""
whole = trace(begun({kind!r}), most=3)
true, calls = newton.respond, [0]
def counted(*words, **names):
    calls[0] += 1
    if calls[0] == at:
        raise KeyboardInterrupt
    return true(*words, **names)
newton.respond = passes.respond = counted
at, raised, left = 0, 0, {{}}
probe = trace(begun({kind!r}), most=3)
number = calls[0]
for at in range(1, number + 1):
    calls[0], follow = 0, begun({kind!r}) if at == 1 else None
    first = follow or first
    follow = Follow(first.model, first.before, first.conditions, 0.05, 0.1, always={kind == "passes"})
    for _ in range(3):
        before = follow.state
        try:
            follow.advance(1.0)
        except KeyboardInterrupt:
            raised += 1
            left |= follow.state.differences(before)
            follow.advance(1.0)
    left |= follow.state.differences(whole.state)
newton.respond = passes.respond = true
results.update(number=number, raised=raised, left=left, same=probe.state.differences(whole.state))
""")
    assert results["raised"] >= 5 and results["left"] == results["same"] == {}


@pytest.mark.parametrize("ranks", RANKS)
@pytest.mark.parametrize("kind", KINDS)
def test_resume_anywhere(kind: str, ranks: int) -> None:
    """A run that goes on from its files, after any attempt, has every bit of the run without a pause."""
    code = f"""
whole = begun({kind!r})
saved = 0
while whole.at < 1.0 and saved < 12:
    whole.save(folder / f"{{saved}}")
    saved += 1
    whole.advance(1.0)
results["differences"] = {{}}
for k in range(0, saved, 1 if COMM.size == 1 else 5):
    again = begun({kind!r})
    again.resume(folder / f"{{k}}")
    for _ in range(saved - k):
        again.advance(1.0)
    results["differences"] |= again.state.differences(whole.state)
    same = all(getattr(again, name) == getattr(whole, name) for name in ("cuts", "taken", "count", "step"))
    results["differences"] |= {{}} if same else {{"rules": k}}
"""
    for results in of_each_rank(SCENES + code, ranks):
        assert results["differences"] == {}


def test_names_with_a_point() -> None:
    """States and runs that are saved by the value of the path have files of their own, and come back."""
    results = run("""
follow = begun("pushed")
for end in (0.05, 0.1, 0.15):
    follow.run(end)
    follow.state.save(folder / f"at_{follow.at:.2f}")
    follow.save(str(folder / f"run_{follow.at:.2f}"))
results["names"] = sorted(file.name for file in folder.iterdir() if "_" in file.name)
results["state"] = State.load(folder / "at_0.05", follow.model).at
follow.resume(folder / "run_0.10")
results["run"] = follow.at
""")
    names = [f"{kind}_{at}.0.npz" for kind in ("at", "run") for at in ("0.05", "0.10", "0.15")]
    assert results == {"names": names, "state": 0.05, "run": 0.1}


def test_pressures_of_an_attempt() -> None:
    """Pressures that conditions give above a level only do not act below it after an attempt above it."""
    results = run("""
for step in (0.1, 0.3, 0.4):
    m = model()
    down, push = weights(m)
    def of(t):
        face = {"left": lambda x: 8e-3 * (x[:, 1] > 1.0), "joint": lambda x, s: 9e-3 + 0.0 * s}
        return Conditions(bottom(m), load=down + t * push, pressures=face if t > 0.25 else {})
    follow = Follow(m, solve(m, State.virgin(m), of(0.0)).taken(), of, step, step, 1e-3)
    while follow.at < 0.2:
        follow.advance(0.2 if step == 0.1 else 1.0)
    inner = follow.report.reaction.reshape(-1, 2)
    results[str(step)] = total(inner[m.x[:, 1] < 1e-6, 0].sum()) / follow.at, largest(follow.state.p)
""")
    for reaction, p in results.values():
        assert reaction == pytest.approx(-3e-2, rel=1e-6) and p == 0.0  # 3 mm2 by 1e-2


def test_a_stopped_path_is_whole() -> None:
    """After a path has stopped its last level is solved again as it is, and the path refuses to go on."""
    results = run("""
m = model()
down, _ = weights(m)
water = lambda t: {"left": lambda x: t * (x[:, 1] > 1.0), "joint": 0.1 * t}
of = lambda t: Conditions(bottom(m), load=down, pressures=water(t))
follow = Follow(m, solve(m, State.virgin(m), of(0.0)).taken(), of, 4e-3, 4e-3, 1e-4)
state = follow.run_to_limit(1.0)
report = solve(m, state, of(state.at))
results["again"] = [report.good, largest(report.taken().u - state.u) / largest(state.u)]
results["p"] = abs(largest(state.p) - 0.1 * state.at)
results["stopped"] = []
for call in (lambda: follow.advance(1.0), lambda: follow.run(1.0), lambda: [*follow.to(1.0)]):
    try:
        call()
    except Stopped as stopped:
        results["stopped"].append(str(stopped))
results["there"] = follow.advance(follow.at)
try:
    follow.run_to_limit(follow.at)
except ValueError as error:
    results["reached"] = str(error)
""")
    assert results["again"][0] and results["again"][1] < 1e-6 and results["p"] < 1e-15
    assert len(results["stopped"]) == 3 and all("stopped at 0.0" in text for text in results["stopped"])
    assert results["there"] is False  # a step of no length is none
    assert "expected a value beyond the limit" in results["reached"]


def test_an_exception_in_a_solution_with_an_old_factor() -> None:
    """What ends a solution that goes on from the factor of an iteration before leaves that factor behind."""
    results = run("""
class Ended:
    def solve(self, b, y):
        raise KeyboardInterrupt

flat = split(grid(range(4), range(3), range(3), block=[0, 1])) if COMM.rank == 0 else None
m = Model(flat, {"joint": law}, 2e4, 0.2)
down, push = (m.body(force, "block_1") for force in ([0.0, 0.0, -1e-2], [4.5e-3, 0.0, 0.0]))
fixed = m.dofs(m.x[:, 2] < 1e-6, 0, 1, 2)
start = solve(m, State.virgin(m), Conditions(fixed, load=down)).taken()
of = Conditions(fixed, load=down + push)
before = solve(m, start, of)
[solver] = equations_of(m, np.sort(fixed), "").solvers.values()
stale, solver.stale = solver.stale, Ended()
try:
    solve(m, start, of)
except KeyboardInterrupt:
    results["ended"] = True
solver.stale = stale
after = solve(m, start, of)
results["iterations"] = [before.iterations, after.iterations]
results["same"] = before.taken().differences(after.taken())
""")
    assert results["ended"] and results["same"] == {} and len({*results["iterations"]}) == 1


@pytest.mark.parametrize("ranks", RANKS)
def test_a_model_that_is_gone(ranks: int) -> None:
    """Nothing keeps a model that has been solved, nor the options of its linear equations."""
    results = run(
        """
import gc, weakref
from petsc4py import PETSc
gone = []
for _ in range(3):
    m = model()
    solve(m, State.virgin(m), pushed(m)(0.5)).taken()
    gone.append(weakref.ref(m))
del m
gc.collect()
results["kept"] = sum(there() is not None for there in gone)
results["options"] = [name for name in PETSc.Options().getAll() if name.startswith("asperity_")]
""",
        ranks,
    )
    assert results == {"kept": 0, "options": []}


def test_drivers_share_no_state() -> None:
    """Two paths and a run in time of one model do not meet; a static step after a run in time has no mass."""
    results = run("""
m = model()
down, push = weights(m)
of = lambda t: Conditions(bottom(m), load=down + t * push)
start = solve(m, State.virgin(m), of(0.0)).taken()
alone = trace(Follow(m, start, of, 0.05, 0.1), 0.4)
first, other = Follow(m, start, of, 0.05, 0.1), Follow(m, start, lambda t: of(-t), 0.03, 0.03)
shake = Shake(m, start, of(0.0), np.abs(m.body([1e-5] * 2)), 1e-3, ground=lambda t: np.array([800.0, 0.0]))
while first.at < 0.4:
    first.advance(0.4)
    if other.at < 0.4:
        other.advance(0.4)
    shake.advance(1.0)
results["same"] = first.state.differences(alone.state)
results["above friction"] = solve(m, start, of(0.6)).good
""")
    assert results == {"same": {}, "above friction": False}


def test_water_in_time() -> None:
    """A run in time carries the water of its joint: a block at rest stays there, and its ledger closes.

    A pressure that is more than the state has at the start lifts the block.
    """
    results = run("""
for p in (0.0, 4e-3, 9e-3):
    m = model()
    down, push = weights(m)
    of = Conditions(bottom(m), load=down, pressures={"joint": p})
    mass, terms = np.abs(m.body([1e-5] * 2)), Terms(tolerance=1e-10)
    shake = Shake(m, solve(m, State.virgin(m), of, terms).taken(), of, mass, 1e-3, terms=terms)
    dry = solve(m, State.virgin(m), replace(of, pressures={}), terms).taken()
    lifted = Shake(m, dry, of, mass, 2e-5, terms=terms)
    start = lifted.ledger.balance
    shake.run(0.01)
    lifted.run(2e-3)
    ledger = lifted.ledger
    lost = (start - ledger.balance) / (abs(ledger.work) or 1.0)
    opened = total(m.area @ (lifted.state.s - dry.s)[:, 0])
    results[str(p)] = largest(shake.state.v), lost, ledger.work, (p - 1e-2) * opened
""")
    *_, work, _ = results.pop("0.0")
    assert work == pytest.approx(0.0, abs=1e-12)
    for p, (v, lost, work, closed) in results.items():
        assert v < 1e-6, p
        # of the water less that of the weight, as the block is stiff; numerical damping takes a part
        assert work == pytest.approx(closed, rel=0.03) and closed < 0.0, p
        assert -1e-3 <= lost < 0.3, p

"""Paths by forces on FEniCSx end at their limit load and go on beyond it, as closed forms say."""

from __future__ import annotations

import numpy as np
import pytest
from on_ranks import RANKS, WITH_FENICSX, assert_refused, of_all_ranks
from scipy.optimize import brentq

pytestmark = WITH_FENICSX

BOND = """
STRENGTH, GC = 0.25, 0.018
bond = Interface(Material(sigma0=STRENGTH, Gc=GC, eta=0.97882791327913, mu=0.75), Pattern.regular(0, 0.0))

def pulled(E, least=1e-4):
    # a share of the strength of the joint, as a force on the top
    m = model(E, 0.0, laws={"joint": bond})
    top, area = m.group("top")
    pull = np.zeros((m.n, 2))
    pull[top, 1] = STRENGTH * area
    of = lambda t: Conditions(bottom(m), load=t * pull.ravel())
    follow = Follow(m, State.virgin(m), of, 0.15, 0.15, least)
    follow.run_to_limit(2.0)
    return follow
"""
"""Two blocks with a bond, of which a force pulls the upper one."""


@pytest.mark.parametrize("ranks", RANKS)
def test_a_bond_that_softens_under_a_force(ranks: int) -> None:
    """Beyond its strength the force is that of the law at each opening, and its work is Gc.

    The path ends within 1e-4 of the strength.  Blocks of 2 MPa are so soft that the end goes back there.
    """
    results = of_all_ranks(
        BOND
        + """
for E in (2e4, 2.0):
    follow = pulled(E)
    results["limit"] = follow.kind, follow.at
    branch, rows, top = follow.beyond(0.01), [], [largest(follow.state.u)]
    for _ in branch.to(lambda state: state.at < 1e-3):
        opening = total(branch.model.area @ branch.state.s[:, 0]) / 3.0
        law = bond.update([[opening, 0.0, 0.0]]).traction[0, 0] / STRENGTH
        rows.append(abs(branch.at - law))
        top.append(largest(branch.state.u))
    ledger = branch.ledger
    results[str(E)] = max(rows), ledger.work / 3.0 / GC, branch.unbalanced, len(rows), top[-1] - top[0]
""",
        ranks,
    )
    kind, at = results.pop("limit")
    assert kind == "limit" and at == pytest.approx(1.0, abs=1e-4)
    stiff, soft = results["20000.0"], results["2.0"]
    for error, work, unbalanced, count, _ in (stiff, soft):
        # the tolerance of the residual is 1e-6 of the forces, a step of the work is a trapezoid
        assert error < 1e-5 and count > 10
        assert work == pytest.approx(1.0, rel=5e-3) and abs(unbalanced) < 5e-3
    assert soft[4] < -0.05 and stiff[4] > 0.1


@pytest.mark.parametrize("ranks", RANKS)
def test_a_load_that_still_grows_is_no_limit(ranks: int) -> None:
    """A branch that is given up after one attempt says that nothing was found."""
    code = """
from asperity.fenicsx import path
path.LOOK = 1
try:
    pulled(2e4, 0.1)
except Stopped as error:
    results["end"] = str(error)
"""
    results = of_all_ranks(BOND + code, ranks)
    assert "not found: the load still grows after 1 attempts" in results["end"]


@pytest.mark.parametrize("ranks", RANKS)
def test_water_that_follows_openings_up_to_the_limit(ranks: int) -> None:
    """A block slides where the push is mu N, with water whose pressure is linear in the opening.

    The water carries U = p (A - N/(kn c)) of the weight W, as the openings of the closed joint are -t_N/kn.
    """
    results = of_all_ranks(
        """
kn, mu, p, c, width = 50.0, 0.6, 0.004, 1e-3, 3.0
dry = Interface(Material.from_joint(kn=kn, ks=20.0, mu=mu), Pattern.regular(0, 0.0))
pieces = split(grid(np.linspace(0, width, 7), [-0.5, 0.0, 0.5], block=[0, 1])) if COMM.rank == 0 else None
m = Model(pieces, {"joint": dry}, 3e4, 0.2)
down, push = (m.body(force, "block_1") for force in ([0.0, -0.01], [0.01, 0.0]))
water = {"joint": lambda x, opening: p * np.clip(1.0 + opening / c, 0.0, 1.0)}
of = lambda t: Conditions(m.dofs(m.x[:, 1] < -0.4, 0, 1), load=down + t * push, pressures=water)
start = solve(m, State.virgin(m), of(0.0)).taken()
follow = Follow(m, start, of, 0.02, 0.1, 1e-5)
follow.run_to_limit(2.0)
W = 0.01 * 0.5 * width
results["limit"] = follow.at, mu * (W - p * width) / (1.0 - p / (kn * c)) / W
branch, results["after"], results["iterations"] = follow.beyond(0.1), [], []
for _ in range(5):
    if branch.advance():
        results["after"].append(branch.at)
        results["iterations"].append(branch.report.iterations)
""",
        ranks,
    )
    found, expected = results["limit"]
    assert found == pytest.approx(expected, rel=3e-5)
    assert results["after"] == pytest.approx([expected] * 5, rel=3e-5)
    assert max(results["iterations"]) <= 3


@pytest.mark.parametrize("ranks", RANKS)
def test_conditions_that_end_at_the_limit(ranks: int) -> None:
    """A path whose conditions raise ValueError for a load that the branch asks for ends and says so."""
    results = of_all_ranks(
        BOND
        + """
m = model(2e4, 0.0, laws={"joint": bond})
top, area = m.group("top")
pull = np.zeros((m.n, 2))
pull[top, 1] = STRENGTH * area
def of(t):
    if t > 0.97:
        raise ValueError("no more than .97")
    return Conditions(bottom(m), load=t * pull.ravel())
follow = Follow(m, State.virgin(m), of, 0.15, 0.15, 1e-4)
follow.run(0.95)
branch = follow.beyond(1.0)
try:
    for _ in branch.to(lambda state: state.at < 0.5): pass
except Stopped as stopped:
    results["end"] = branch.at, str(stopped)
""",
        ranks,
    )
    at, text = results["end"]
    assert 0.95 <= at <= 0.97 and "the conditions at 0.9" in text and "no more than .97" in text


@pytest.mark.parametrize("ranks", RANKS)
def test_water_that_ends_on_the_branch(ranks: int) -> None:
    """A branch to openings for which a pressure is negative, or refuses to be found, ends and says so."""
    results = of_all_ranks(
        BOND
        + """
def refused(x, opening):
    if (opening > 0.01).any():
        raise ValueError("no p there")
    return 0.01 + 0.0 * opening

for name, p in {"negative": lambda x, opening: 0.01 - opening, "refused": refused}.items():
    m = model(2e4, 0.0, laws={"joint": bond})
    top, area = m.group("top")
    pull = np.zeros((m.n, 2))
    pull[top, 1] = STRENGTH * area
    of = lambda t: Conditions(bottom(m), load=t * pull.ravel(), pressures={"joint": p})
    follow = Follow(m, State.virgin(m), of, 0.15, 0.15, 1e-4)
    follow.run(0.9)
    branch = follow.beyond(1e-3)
    try:
        for _ in branch.to(lambda state: state.at < 1e-3): pass
    except Stopped as stopped:
        results[name] = largest(branch.state.s[:, 0]), str(stopped)
""",
        ranks,
    )
    opening, text = results["negative"]
    assert 0.009 < opening <= 0.01 and "joint: p = -" in text
    opening, text = results["refused"]
    assert 0.009 < opening <= 0.01 and "no p there" in text


@pytest.mark.parametrize("ranks", RANKS)
def test_water_that_ends_on_a_path(ranks: int) -> None:
    """A path to openings, or to a level, at which a pressure is negative is cut there and says so.

    No step is left behind: the last state is the one that the same steps without an attempt find.
    """
    results = of_all_ranks(
        BOND
        + """
m = model(2e4, 0.0, laws={"joint": bond})
top, area = m.group("top")
fixed = np.r_[bottom(m), m.dofs(top, 1)]
up, pull = np.isin(fixed, m.dofs(top, 1)), np.zeros((m.n, 2))
pull[top, 1] = 0.1 * STRENGTH * area
for name, water, load in (
    ("opening", lambda t: lambda x, opening: 0.01 - opening, False),
    ("level", lambda t: lambda x, opening: 0.01 - t + 0.0 * opening, False),
    ("loads", lambda t: lambda x, opening: 0.01 - t + 0.0 * opening, True),
):
    def of(t):
        words = {"fixed": bottom(m), "load": t * pull.ravel()} if load else {"fixed": fixed, "values": t * up}
        return Conditions(**words, pressures={"joint": water(t)})
    follow = Follow(m, State.virgin(m), of, 3e-3, 3e-3, 1e-5)
    try:
        follow.run(1.0)
    except Stopped as stopped:
        report = solve(m, follow.before, of(follow.at), Terms(at=follow.at))
        apart = largest(report.taken().u - follow.state.u) / largest(follow.state.u)
        opening = largest(follow.state.s[:, 0])
        results[name] = follow.at, opening, follow.cuts, apart, str(stopped), follow.kind
""",
        ranks,
    )
    for name, (at, opening, cuts, apart, text, kind) in results.items():
        assert 0.0099 < (opening if name == "opening" else at) <= 0.01, name
        assert cuts > 3 and apart < 1e-6 and kind == "not found", name
        assert text.startswith("stopped at 0.0") and "joint: p = -" in text, name


@pytest.mark.parametrize("ranks", RANKS)
def test_a_path_that_leaves_a_branch(ranks: int) -> None:
    """Up to a value an exception at any call of the law leaves no trace on a branch; back it is left.

    Half of the strength of the bond is carried by the linear joint: u is half of that at the strength.
    """
    results = of_all_ranks(
        BOND
        + """
import tempfile
from pathlib import Path
from asperity.fenicsx import branch, newton
file = Path(COMM.bcast(tempfile.mkdtemp() if COMM.rank == 0 else None)) / "branch"
m = model(2e4, 0.0, laws={"joint": bond})
top, area = m.group("top")
pull = np.zeros((m.n, 2))
pull[top, 1] = STRENGTH * area
of = lambda t: Conditions(bottom(m), load=t * pull.ravel())
true, calls, at = newton.respond, [0], 0
def counted(*words, **names):
    calls[0] += 1
    if calls[0] == at:
        raise KeyboardInterrupt
    return true(*words, **names)
newton.respond = branch.respond = counted
def begun():
    follow = Follow(m, State.virgin(m), of, 0.15, 0.15, 0.1)
    if file.with_suffix(f".{COMM.rank}.npz").exists():
        follow.resume(file)
    return follow
follow = begun()
while not follow.branch:
    follow.advance(2.0)
follow.save(file)
results["entered"] = follow.at
follow.run(0.5)
results["back"] = follow.at, largest(follow.state.t[:, 0] / STRENGTH - 0.5)
calls[0], whole = 0, begun()
while whole.at != 0.99:
    whole.advance(0.99)
number, results["raised"], results["left"] = calls[0], 0, {}
for at in range(1, number + 1):
    calls[0], follow = 0, begun()
    while follow.at != 0.99:
        try:
            follow.advance(0.99)
        except KeyboardInterrupt:
            results["raised"] += 1
    results["left"] |= follow.state.differences(whole.state) | follow.before.differences(whole.before)
    if follow.ledger != whole.ledger or follow.count != whole.count:
        results["left"]["ledger"] = at
results["number"] = number
""",
        ranks,
    )
    at, off = results["back"]
    assert results["entered"] > 0.8 and at == 0.5 and off < 1e-6
    assert results["raised"] == results["number"] > 5 and results["left"] == {}


@pytest.mark.parametrize("ranks", RANKS)
def test_energy_that_a_snap_releases(ranks: int) -> None:
    """A bond in series with soft blocks breaks in a jump: their energy at its strength less Gc is released.

    Stiff blocks release nothing, also in long steps: those whose energies do not balance are taken in parts,
    also where the strain energy falls in them, but none below the least step.  The bond is linear up to its
    strength, with 82 N/mm3.
    """
    results = of_all_ranks(
        BOND
        + """
for E, steps, share in (
    (2e4, 200, 0), (2e4, 12, 0), (60.0, 6, 0), (30.0, 12, 0), (60.0, 6, 0.4), (60.0, 6, 0.5),
    (2.0, 200, 0), (1.0, 20, 0),
):
    m = model(E, 0.0, laws={"joint": bond})
    fixed = np.r_[bottom(m), m.dofs(m.group("top")[0], 1)]
    up = np.isin(fixed, m.dofs(m.group("top")[0], 1))
    end = 2.0 * STRENGTH / E + 0.3
    most = end / steps
    of, least = lambda t: Conditions(fixed, t * up), share * most or 1e-5
    follow = Follow(m, State.virgin(m), of, most, most, least)
    *moves, rest = [(follow.at - follow.before.at) / most for _ in follow.to(end)]
    ledger = follow.ledger
    sums = ledger.released, ledger.spent, ledger.work
    results[f"{E} {steps} {share}"] = *sums, follow.unbalanced, min(moves)
""",
        ranks,
    )
    strength, Gc, area, kn = 0.25, 0.018, 3.0, 82.0
    for case in ("20000.0 200 0", "20000.0 12 0", "60.0 6 0", "30.0 12 0"):
        released, spent, work, unbalanced, _ = results[case]
        assert abs(released) < 1e-9 and spent == pytest.approx(Gc * area, rel=1e-3), case
        assert work == pytest.approx(Gc * area, rel=5e-3) and abs(unbalanced) < 5e-3, case
    assert results["60.0 6 0"][-1] < 0.3
    for share in (0.4, 0.5):
        assert results[f"60.0 6 {share}"][-1] == pytest.approx(0.5, rel=1e-9), share
    for E, case in ((2.0, "2.0 200 0"), (1.0, "1.0 20 0")):
        released, spent, work, unbalanced, _ = results[case]
        # the force goes on at most for a step beyond its strength, 2.2 % of the work
        assert work == pytest.approx(0.5 * strength**2 * area * (1.0 / kn + 2.0 / E), rel=3e-2)
        assert spent == pytest.approx(Gc * area, rel=1e-3)
        assert released == pytest.approx(work - Gc * area, rel=5e-3) and abs(unbalanced) < 5e-3


def test_a_dead_load_takes_part_in_a_snap() -> None:
    """Soft blocks that break apart release the same energy with a dead load at the joint, which moves too.

    Two springs of 0.5 N/mm in series give back the square of the strength over twice that of one, less what
    the bond takes; the strength is reached 1 % too late.
    """
    results = of_all_ranks(
        BOND
        + """
for share in (0.0, 0.24):
    m = model(0.5, 0.0, laws={"joint": bond})
    top, dead = m.group("top")[0], np.zeros((m.n, 2))
    dead[m.pairs[:, 1], 1] = share * STRENGTH * m.area
    fixed = np.r_[bottom(m), m.dofs(top, 0, 1)]
    of = lambda t: Conditions(fixed, t * np.isin(fixed, m.dofs(top, 1)), load=dead.ravel())
    follow = Follow(m, solve(m, State.virgin(m), of(0.0)).taken(), of, 0.01, 0.02)
    follow.run(1.4)
    results[f"{share}"] = follow.ledger.released, follow.unbalanced
""",
        1,
    )
    exact = 3.0 * (0.25**2 / 0.5 + 0.25**2 / (2.0 * 82.0) - 0.018)
    for released, unbalanced in results.values():
        assert released == pytest.approx(exact, rel=0.015) and abs(unbalanced) < 1e-3


@pytest.mark.parametrize("ranks", RANKS)
def test_one_of_bonds_in_series_breaks(ranks: int) -> None:
    """Of bonds in series the one that is weakest by 0.1 % softens, and the others unload, also in long steps.

    That all soften at once is an equilibrium, too, of twice the force, from which the model moves by itself.
    """
    results = of_all_ranks(
        BOND
        + """
for count, weaker in ((2, 1e-3), (2, 0.0), (4, 1e-3)):
    stacked = grid(range(3), range(count + 2), block=[range(count + 1)] * 2)
    joints = {f"j{k}": (f"block_{k}", f"block_{k + 1}") for k in range(count)}
    mesh = split(stacked, joints) if COMM.rank == 0 else None
    material = replace(bond.material, eta=0.95, mu=0.0)
    laws = {name: Interface(material, bond.pattern) for name in joints}
    weak = replace(material, sigma0=STRENGTH * (1.0 - weaker))
    m = Model(mesh, laws | {"j0": Interface(weak, bond.pattern)}, 2e4, 0.0)
    top = m.group("top")[0]
    fixed = np.r_[bottom(m), m.dofs(top, 0, 1)]
    up = np.isin(fixed, m.dofs(top, 1))
    follow = Follow(m, State.virgin(m), lambda t: Conditions(fixed, t * up), 0.01, 0.02)
    follow.run(0.1)
    force = total(follow.report.reaction[m.dofs(top, 1)].sum())
    open_joints = sum(largest(follow.state.s[part, 0]) > 0.09 for part in m.parts)
    results[f"{count} {weaker}"] = force, open_joints, follow.report.stable, abs(follow.unbalanced)
""",
        ranks,
    )
    s_0, s_f = 0.05 * 0.144, 0.144
    for case, (force, opened, stable, unbalanced) in results.items():
        count, weaker = map(float, case.split())
        # openings of the weakest bond, of the others and of the blocks make 0.1
        strength = 0.25 * (1.0 - weaker)
        others = (count - 1.0) * s_0 / 0.25 + (count + 1.0) / 2e4
        fall = strength / (s_f * 0.25 / strength - s_0)
        exact = fall * (s_f * 0.25 / strength - 0.1) / (1.0 - fall * others)
        assert force == pytest.approx(2.0 * exact, rel=5e-3), case
        assert opened == 1 and stable and unbalanced < 2e-3, case


@pytest.mark.parametrize("ranks", RANKS)
def test_the_bond_that_softens_first_breaks(ranks: int) -> None:
    """Of two bonds the weaker one opens, whatever energy the other one releases and whatever else is soft.

    A block of 1 MPa on top carries nothing, and the loads are noise: they change by their rounding errors.
    """
    results = of_all_ranks(
        BOND
        + """
def pulled_bonds(bonds, most, E=2e4, noise=0.0):
    count = len(bonds)
    rows = [*range(count + 2), *(count + 1 + 0.5 * np.arange(1, 21))]
    stacked = grid(range(3), rows, block=[*range(count + 1), *[count + 1] * 20])
    joints = {f"j{k}": (f"block_{k}", f"block_{k + 1}") for k in range(count)}
    mesh = split(stacked, joints) if COMM.rank == 0 else None
    flat = Pattern.regular(0, 0.0)
    laws = {name: Interface(Material(**bond, mu=0.0), flat) for name, bond in zip(joints, bonds, strict=True)}
    stiffness = {f"block_{k}": 2e4 for k in range(count + 1)} | {f"block_{count + 1}": E}
    m = Model(mesh, laws, stiffness, 0.0)
    driven = np.abs(m.x[:, 1] - count - 1.0) < 1e-9
    below = m.x[:, 1] < count + 1.0 + 1e-9
    fixed = np.r_[m.dofs(m.x[:, 1] < 1e-9, 1), m.dofs(driven, 1), m.dofs(below, 0)]
    up = np.isin(fixed, m.dofs(driven, 1))
    weight = m.body([0.0, -1e-5], "block_1")
    of = lambda t: Conditions(fixed, t * up, load=weight * (1.0 + noise * t))
    follow = Follow(m, solve(m, State.virgin(m), of(0.0)).taken(), of, most, 2.0 * most)
    judged = [report.stable for report in follow.to(0.08)]
    force = total(follow.report.reaction[m.dofs(driven, 1)].sum())
    return force, [largest(follow.state.s[part, 0]) for part in m.parts], judged

tough, brittle = dict(sigma0=0.2, Gc=0.02, eta=0.9), dict(sigma0=0.2004, Gc=0.008, eta=0.9)
for most in (0.02, 0.0025):
    results[f"brittle, {most}"] = pulled_bonds([tough, brittle], most)
equal = dict(sigma0=0.2, Gc=0.02, eta=0.9)
results["soft"] = pulled_bonds([equal, equal], 0.01, E=1.0)
results["noise"] = pulled_bonds([equal, equal], 0.01, noise=1e-9)
results["one"] = pulled_bonds([equal], 0.01)
""",
        ranks,
    )
    # the softening branch from s_0 = 0.1 s_f, where s_f = 2 Gc / sigma0, with the compliances of the rest
    s_f, strength = 0.2, 0.2
    fall = strength / (0.9 * s_f)
    for case, (force, openings, judged) in results.items():
        compliance = 3.0 / 2e4
        if case == "one":
            compliance -= 1.0 / 2e4
        else:
            compliance += 0.1 * 2.0 * 0.008 / 0.2004**2 if "brittle" in case else 0.1
        exact = fall * (s_f - 0.08) / (1.0 - fall * compliance)
        # the weight is 1e-4 of the force
        assert force == pytest.approx(2.0 * exact, rel=2e-4), case
        opened = [opening > 0.05 for opening in openings]
        assert sum(opened) == 1 and (opened[0] or "brittle" not in case), case
        assert judged[-1] is True and False not in judged, case


@pytest.mark.parametrize("ranks", RANKS)
def test_strain_energy_from_before_hides_no_error(ranks: int) -> None:
    """Blocks that are pressed from their sides before a bond breaks are halved in the steps of others.

    Their energy E d^2/(2 L) times the height is 80 times that of the bond.
    """
    results = of_all_ranks(
        BOND
        + """
E, steps = 60.0, 6
m = model(E, 0.0, laws={"joint": bond})
left, right = (np.abs(m.x[:, 0] - x) < 1e-6 for x in (0.0, 3.0))
low, (top, _) = m.x[:, 1] < 1e-6, m.group("top")
fixed = np.r_[m.dofs(low, 1), m.dofs(top, 1), m.dofs(left | right, 0)]
up, side = np.isin(fixed, m.dofs(top, 1)), np.isin(fixed, m.dofs(right, 0))
end = 2.0 * STRENGTH / E + 0.3
d = np.sqrt(80.0 * GC * 3.0 * 2.0 * 3.0 / (E * 2.0))
of = lambda t: Conditions(fixed, t * up - d * side)
start = solve(m, State.virgin(m), of(0.0)).taken()
follow = Follow(m, start, of, end / steps, end / steps, limit=0.2)
before = follow.ledger.strain
follow.run(end)
ledger = follow.ledger
results["all"] = before / (GC * 3.0), ledger.released, ledger.spent, ledger.work, follow.unbalanced
""",
        ranks,
    )
    before, released, spent, work, unbalanced = results["all"]
    assert before == pytest.approx(80.0, rel=1e-6)
    assert spent == pytest.approx(0.018 * 3.0, rel=1e-3) and abs(released) < 1e-9
    assert work == pytest.approx(spent, rel=5e-3) and abs(unbalanced) < 5e-3


@pytest.mark.parametrize("ranks", RANKS)
def test_a_force_that_rises_hides_no_error(ranks: int) -> None:
    """Sides that are let go while a bond softens release nothing, as the joint spends what is lost."""
    results = of_all_ranks(
        BOND
        + """
m = model(60.0, 0.0, laws={"joint": bond})
upper = m.solid("block_1").reshape(-1, 2)[:, 0] > 0.0
top, left, right = m.group("top")[0], upper & (m.x[:, 0] < 1e-6), upper & (m.x[:, 0] > 3.0 - 1e-6)
fixed = np.r_[bottom(m), m.dofs(top, 1), m.dofs(left | right, 0)]
up, side = np.isin(fixed, m.dofs(top, 1)), np.isin(fixed, m.dofs(right, 0))
end = 2.0 * STRENGTH / 60.0 + 0.3
pressed = lambda t: -0.02 * np.interp(6.0 * t / end, [0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 1.0, 0.0])
of = lambda t: Conditions(fixed, t * up + pressed(t) * side)
follow = Follow(m, State.virgin(m), of, end / 6.0, end / 6.0, 1e-5, limit=0.2)
follow.run(end)
results["all"] = follow.ledger.released, follow.ledger.work, follow.ledger.spent, follow.unbalanced
""",
        ranks,
    )
    released, work, spent, unbalanced = results["all"]
    assert spent == pytest.approx(0.018 * 3.0, rel=1e-3)
    assert abs(released) < 1e-9 and work == pytest.approx(spent, rel=5e-3) and abs(unbalanced) < 5e-3


@pytest.mark.parametrize("ranks", RANKS)
def test_a_block_that_rocks(ranks: int) -> None:
    """A force that tips a rigid block is that of no-tension springs at every rotation, up to the toe.

    The block is 3 wide and 1 high and carries its weight at four points.
    """
    results = of_all_ranks(
        """
stiff = Interface(Material.from_joint(kn=200.0, ks=80.0, mu=20.0), Pattern.regular(0, 0.0))
m = model(2e8, laws={"joint": stiff})
down = m.body([0.0, -1e-2], "block_1")
top, area = m.group("top")
push = np.zeros((m.n, 2))
push[top, 0] = area / 3.0
of = lambda t: Conditions(bottom(m), load=down + t * push.ravel())
start = solve(m, State.virgin(m), of(0.0)).taken()
follow = Follow(m, start, of, 1e-3, 5e-3, 1e-5)
follow.run_to_limit(1.0)
results["limit"] = follow.kind, follow.at
rows = np.concatenate(COMM.allgather(np.column_stack([m.places[:, 0], follow.state.s[:, 0]])))
results["alone"] = int((rows[:, 1] < -1e-12).sum())
mid = Follow(m, start, of, 1e-3, 5e-3, 1e-5)
mid.run(0.03)
branch = mid.beyond(1e-3)
results["rows"] = []
for _ in range(12):
    if branch.advance():
        rows = np.concatenate(COMM.allgather(np.column_stack([m.places[:, 0], branch.state.s[:, 0]])))
        slope = float(np.polyfit(*rows.T, 1)[0])
        results["rows"].append([-slope, branch.at])
""",
        ranks,
    )
    W, kn, height = 3e-2, 200.0, 1.0
    x, area = np.arange(4.0), np.array([0.5, 1.0, 1.0, 0.5])

    def force(rotation: float) -> float:
        def pressed(settled: float) -> np.ndarray:
            return kn * area * np.maximum(settled + rotation * (x - 1.5), 0.0)

        settled = brentq(lambda z: pressed(z).sum() - W, -1.0, 1.0, xtol=1e-15)
        return float(pressed(settled) @ (x - 1.5)) / height

    kind, at = results["limit"]
    assert kind == "limit" and at == pytest.approx(1.5 * W / height, rel=1e-4)
    assert results["alone"] == 1
    assert len(results["rows"]) > 5
    for rotation, at in results["rows"]:
        assert at == pytest.approx(force(rotation), rel=1e-3)


@pytest.mark.parametrize("ranks", RANKS)
def test_a_second_bond_carries_more_than_the_first(ranks: int) -> None:
    """A force whose long step breaks one of two bonds jumps to the other, whose strength is the limit.

    The change of the jump is no guess of the next one: it led past the second strength, to a limit of 1.125.
    """
    code = """
flat = Pattern.regular(0, 0.0)
brittle = Interface(Material(sigma0=1.0, Gc=0.002, eta=0.98, mu=0.0), flat)
tough = Interface(Material(sigma0=1.3, Gc=0.2, eta=0.9, mu=0.0), flat)
blocks = grid(range(4), range(4), block=[0, 1, 2])
joints = {"low": ("block_0", "block_1"), "high": ("block_1", "block_2")}
mesh = split(blocks, joints) if COMM.rank == 0 else None
m = Model(mesh, {"low": brittle, "high": tough}, 2e4, 0.2)
fixed = np.union1d(bottom(m), m.dofs(m.x[:, 1] > 3.0 - 1e-6, 0, 1))
# the middle block has the volume 3, each joint the area 3
push = m.body([1.0, 0.0], "block_1")
for most in (0.1, 0.3):
    follow = Follow(m, State.virgin(m), lambda t: Conditions(fixed, load=t * push), 0.05, most)
    follow.run_to_limit(3.0)
    results[str(most)] = follow.kind, follow.at
"""
    for kind, at in of_all_ranks(code, ranks).values():
        assert kind == "limit" and at == pytest.approx(1.3, rel=2e-3)


def test_levels_of_a_dam() -> None:
    """Neither the stiffness of a dam nor the tolerance changes the level at which it fails.

    A thousandfold stiffness has rounding errors above the finer tolerance, which the report tells.
    """
    results = of_all_ranks(
        """
from harness.hosts.fenicsx.dam import JOINTS, Dam
for E in (3e12, 3e15):
    for tolerance in (1e-6, 1e-8):
        dam = Dam("none", Interface(JOINTS["held"][0], Pattern.regular(0, 0.0)), 10, E, 0.0)
        dam.terms = Terms(tolerance=tolerance)
        dam.fill(0.0)
        follow = Follow(dam.model, dam.state, dam.filled, 1.0, 1.0, 1e-3, dam.terms)
        reports = []
        try:
            for report in follow.to(12.0):
                reports.append(report)
        except Stopped:
            reports += [follow.report]
        results[f"{E:g} {tolerance:g}"] = follow.at, follow.kind, max(report.floor for report in reports)
""",
        1,
    )
    levels = [level for level, _, _ in results.values()]
    assert {kind for _, kind, _ in results.values()} == {"limit"}
    assert max(levels) / min(levels) < 1.0 + 1e-4, levels
    assert results["3e+12 1e-06"][2] < 1e-8 and results["3e+15 1e-06"][2] > 1e-8


WRONG = {
    "follow.beyond(0.0)": "most = 0.0: expected above 0",
    "Follow(m, follow.state, follow.conditions, 0.1).beyond(1.0)": "expected a step of a path",
    "Branch(m, follow.state, follow.before, None, 1.0)": "conditions None: expected a function of a number",
    "Branch(m, follow.state, None, follow.conditions, 1.0)": "state of the type NoneType: expected State",
    "follow.beyond('far')": "most = far: expected above 0",
    "Branch(m, follow.state, follow.before, follow.conditions, 1.0, Terms(drag=1.0))": "drag or damping: ",
}
"""Expressions and what their errors say."""


@pytest.mark.parametrize("ranks", RANKS)
def test_wrong_input(ranks: int) -> None:
    """Every rank has the error, and it is one line."""
    assert_refused(WRONG, BOND + "follow = pulled(2e4)\nm = follow.model\n", ranks)

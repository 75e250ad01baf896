"""Fits that must tell a bond from asperities, and the drawn tests of the study of fits."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, Pattern, contract
from asperity.case_files import drive
from asperity.tools.fit import Fit, ShearTest, fit
from asperity.tools.fit.kinds import kind_of
from asperity.tools.fit.model import Model
from asperity.tools.fit.predict import predict
from asperity.tools.fit.report import case_of
from asperity.tools.fit.search import Solution, by_law, residuals, searched

from harness.studies import fit_times, fits, other_laws, other_strengths
from harness.studies.validation import push_off

pytestmark = [pytest.mark.usefixtures("folder"), pytest.mark.filterwarnings("ignore::asperity.ModelWarning")]

GUESS = "not tell a bond from asperities"
"""Words of the reason why a bond is no result."""


@pytest.mark.slow
def test_crack_has_no_bond() -> None:
    """Cracked concrete under two pressures, which differ as specimens do: no bond is taken for one."""
    result = fit(push_off.tests())
    assert not result.solution.model.bond
    assert not result.is_result and any("not determined" in text for text in result.reasons)


@pytest.mark.slow
def test_bond_that_no_row_shows() -> None:
    """A bond that would break before the first row is no result: a joint of the law without bond has none."""
    material = Material(sigma0=1.745, Gc=0.0872, eta=0.9, mu=0.3528, kc=20.0, height=0.141, damage0=1.0)
    joint = Interface(material, Pattern.regular(2, theta=14.56))
    slip, tests = np.linspace(0.0, 3.0, 40), []
    for pressure in (0.3, 1.6):
        box = joint.confined_slip(0.0, slip, sigma_N=-pressure)
        opening = box.separation[:, 0] - box.separation[0, 0]
        tests.append(ShearTest(str(pressure), slip, box.traction[:, 1], opening, -pressure))
    result, rock = fit(tests), fit(tests, joint="rock")
    assert not result.solution.model.bond or not result.is_result
    assert rock.is_result and rock.values["mu"] == pytest.approx(0.3528, rel=0.01)
    # the laboratory knows that there is a bond, and no row shows its constants
    known = fit(tests, joint="mortar")
    assert not known.is_result and any("rows do not show the bond" in text for text in known.reasons)
    free, values = ("kT", "mu", "theta", "height"), {"sigma0": 1e-3, "Gc": 1e-6}
    given = fit(tests, fixed=values, free=free)
    assert not any("bond" in text for text in given.reasons)
    assert any("its constants are assumed" in text for text in given.notes)


def drawn_tests(
    kind: str, seed: int, pressures: Callable[[list[float]], bool]
) -> tuple[list[ShearTest], dict]:
    """First drawn tests of a law whose pressures meet a condition, and their constants."""
    for number in range(200):
        drawn = other_laws.KINDS[kind](np.random.default_rng([seed, number]))
        if pressures([test.pressure for test in drawn.tests]):
            return fits.tests_of(drawn), drawn.truth
    raise AssertionError


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_softening_that_grows_with_the_pressure(seed: int) -> None:
    """Asperities that soften as a bond, at pressures of a ratio below 1.5: no bond is a result."""
    tests, _ = drawn_tests(
        "parabolic asperities, no dilation", seed, lambda p: len(p) == 2 and p[1] < 1.5 * p[0]
    )
    result = fit(tests)
    assert not (result.solution.model.bond and result.is_result)


def test_profile_that_the_law_does_not_have() -> None:
    """The first slope of asperities that end lies in the interval, and is told."""
    tests, truth = drawn_tests("parabolic asperities", 8, lambda p: len(p) == 2)
    result = fit(tests)
    estimate = result.estimates["theta"]
    assert estimate.low <= truth["theta"][0] <= estimate.high
    assert any("slope along a line" in text for text in result.notes)
    # of asperities of the law the other profile is excluded
    tests, _ = drawn_tests("Mohr-Coulomb, decaying dilation", 8, lambda p: len(p) == 2)
    result = fit(tests)
    assumption = next(part for part in result.assumptions if "along a line" in part.name)
    assert not assumption.admissible and not any("slope along a line" in text for text in result.notes)


@pytest.mark.slow
def test_profile_of_cycles() -> None:
    """In cycles the first strokes tell another profile: slope and height lie in the intervals."""
    drawn = other_laws.parabolic_strokes(np.random.default_rng([20610, 17]))
    tests, truth = fits.tests_of(drawn), drawn.truth
    result = fit(tests)
    assert result.is_result and any("slope along a line" in text for text in result.notes)
    for name in ("mu", "theta", "height"):
        assert result.estimates[name].low <= truth[name][0] <= result.estimates[name].high


def test_straight_softening_of_asperities_is_no_bond() -> None:
    """Asperities that end soften along a line, as a bond: several pressures or a dilation tell them apart."""
    tests, truth = drawn_tests(
        "parabolic asperities, no dilation", 77, lambda p: len(p) == 3 and p[-1] < 1.2 * p[0]
    )
    result = fit(tests)
    assert result.is_result and not result.solution.model.bond
    for name in ("mu", "theta"):
        assert result.estimates[name].low <= truth[name][0] <= result.estimates[name].high
    single, truth = drawn_tests("parabolic asperities", 77, lambda p: len(p) == 1)
    result = fit(single)
    assert not result.solution.model.bond
    assert result.estimates["theta"].low <= truth["theta"][0] <= result.estimates["theta"].high


def test_friction_that_acts_from_the_first_slip_on() -> None:
    """Friction beside a bond that does not wait for its damage, as that of the law does: energy inside."""
    slip, rng, tests = np.linspace(0.005, 1.0, 200), np.random.default_rng(3), []
    bond, energy, mu, stiffness = 0.9, 0.14, 0.75, 80.0
    for pressure in (0.2, 0.5, 1.0):
        own = np.linspace(0.0, 1.0, 20001)
        strength = bond * np.maximum(0.0, 1.0 - own * bond / (2.0 * energy)) + mu * pressure
        tau = np.minimum(stiffness * slip, np.interp(slip, own + strength / stiffness, strength))
        tau += rng.normal(0.0, 0.02, slip.size)
        tests.append(ShearTest(str(pressure), slip, tau, None, -pressure))
    result = fit(tests)
    assert result.is_result and result.solution.model.bond
    for name, true in (("mu", mu), ("sigma0", bond), ("Gc", energy)):
        assert result.estimates[name].low <= true <= result.estimates[name].high
    assert any("friction acts before the bond is damaged" in text for text in result.notes)


@pytest.mark.parametrize("spring", ["kT", "ks"])
def test_joint_that_never_slides(spring: str) -> None:
    """Rows that only rise show no friction, wherever the elastic slip lies."""
    slip = np.linspace(0.1, 1.0, 20)
    tau = 0.5 * slip + np.random.default_rng(1).normal(0.0, 0.005, slip.size)
    result = fit([ShearTest("rising", slip, tau, None, -1.0)], free=(spring, "mu"))
    assert any("before the joint slides" in text for text in result.reasons)


@pytest.mark.slow
def test_cycles_behind_a_spring() -> None:
    """The elastic slip of cycles is that of the spring of the drawn law; case and predictions have it."""
    tests, truth = drawn_tests("Plesha, cycles", 4, lambda p: len(p) == 1)
    result = fit(tests)
    assert result.spring > 0.0 and not result.solution.model.bond
    assert result.estimates["theta"].low <= truth["theta"][0] <= result.estimates["theta"].high
    Path("joint.nml").write_text(case_of(result))
    (history,) = drive(Path("joint.nml")).values()
    # each loop of the case ends at the slip of the box at which that of the test does
    slid = history.separation[:, 1] + history.traction[:, 1] / result.spring
    ends = [tests[0].slip.max(), tests[0].slip.min()]
    assert [slid.max(), slid.min()] == pytest.approx(ends, rel=1e-3)
    again = predict(result.interface, tests, result.spring)
    assert again.rms["tau"] == pytest.approx(result.scatter["tau"], rel=1e-6)


def test_strengths_at_pressures_close_together() -> None:
    """A strength that softens at two like pressures shows no bond, unless the laboratory knows of one."""
    slip, rng, tests = np.linspace(0.05, 2.0, 30), np.random.default_rng(7), []
    for pressure in (1.0, 1.1):
        # between the straight softening of a bond and the exponential one of asperities
        softening = 0.25 * np.exp(-slip / 0.4) + 0.15 * np.maximum(0.0, 1.0 - slip)
        tau = np.minimum(10.0 * slip, 0.6 * pressure + softening) + rng.normal(0.0, 0.04, slip.size)
        tests.append(ShearTest(str(pressure), slip, tau, None, -pressure))
    result, known = fit(tests), fit(tests, joint="mortar")
    assert result.solution.model.bond and known.solution.model.bond
    assert not result.is_result and any(GUESS in text for text in result.reasons)
    assert not any(GUESS in text for text in known.reasons)


SLOPED = {"kT": 40.0, "sigma0": 0.6, "Gc": 0.1, "mu": 0.7, "theta": 15.0, "height": 0.2}
FLAT = {"kT": 40.0, "sigma0": 0.3, "Gc": 1.5, "mu": 0.6}


def curves_of_law(truth: dict[str, float], pressures: tuple[float, ...], noise: float) -> list[ShearTest]:
    """Tests of the law with these constants, with noise over the largest value; a slope has a dilation."""
    rng = np.random.default_rng(2)
    slip = np.concatenate([np.linspace(0.004, 0.1, 15), np.linspace(0.12, 2.5, 70)])
    dilates, made = "theta" in truth, []
    tests = [ShearTest(str(p), slip, slip, slip if dilates else None, -p) for p in pressures]
    problem = Model(tuple(truth), 2 if dilates else 0).problem(tests, law=True)
    values = problem.values(problem.x(truth))
    for test, (_, rows), (tau, s_N, _) in zip(tests, problem.paths, problem.curves(values), strict=True):
        columns = [column[rows] for column in (tau, s_N)[: 1 + dilates]]
        columns = [column + noise * np.ptp(column) * rng.normal(size=slip.size) for column in columns]
        made.append(ShearTest(test.name, slip, columns[0], columns[1] if dilates else None, test.sigma_N))
    return made


def test_search_of_a_bond_ends_at_the_law() -> None:
    """Exact tests of a bond beside a slope give its constants, which its closed form misses."""
    tests, model = curves_of_law(SLOPED, (0.4, 1.2), 0.0), Model(tuple(SLOPED))
    solution = searched(tests, model, [{name: 1.2 * value for name, value in SLOPED.items()}])
    for name, value in SLOPED.items():
        assert solution.values[name] == pytest.approx(value, rel=0.01), name
    closed = model.problem(tests)
    assert closed.is_closed_form and not solution.problem.is_closed_form
    misfit = residuals(closed, closed.x(SLOPED))
    assert np.sqrt(np.mean(misfit**2)) > 10.0 * np.sqrt(np.mean(solution.residuals**2))


@pytest.mark.parametrize("joint", ["auto", "mortar"])
@pytest.mark.parametrize(
    "truth", [FLAT, FLAT | {"Gc": 0.5, "theta": 25.0, "height": 0.2}], ids=["flat", "slope"]
)
def test_bond_that_hardly_softens(truth: dict[str, float], joint: str) -> None:
    """The fit finds the constants of the law's own curves where friction waits long for the damage."""
    result = fit(curves_of_law(truth, (0.3, 0.8, 1.5), 0.01), joint)
    assert result.is_result and result.grade == "good"
    for name, value in truth.items():
        assert result.estimates[name].low <= value <= result.estimates[name].high, name
    assert result.values["Gc"] == pytest.approx(truth["Gc"], rel=0.05)


@pytest.mark.parametrize(("Gc", "shown"), [(1000.0, False), (20.0, True)])
def test_energy_of_a_bond_that_does_not_soften(Gc: float, shown: bool) -> None:
    """The elastic slip of a bond is no energy: without softening the rows do not show it."""
    slip = np.linspace(0.005, 1.2, 200)
    tau = np.where(slip < 0.1, 80.0 * slip, 8.0 - (slip - 0.1) * 32.0 / Gc)
    tau = tau + 0.08 * np.random.default_rng(7).normal(size=slip.size)
    result = fit([ShearTest("anchor", slip, tau, None, 0.0)])
    assert result.is_result == shown and ("Gc" in result.loose) != shown
    assert any("Gc is not determined" in reason for reason in result.reasons) != shown
    low, high = result.estimates["Gc"][1:]
    assert (low <= Gc <= high) == shown


def in_closed_form(model: Model, truth: dict[str, float], tests: list[ShearTest]) -> Solution:
    """Constants in closed form, with their residuals."""
    problem = model.problem(tests)
    assert problem.is_closed_form
    return Solution(model, problem, problem.x(truth), residuals(problem, problem.x(truth)))


@pytest.mark.parametrize("bond", [{}, {"sigma0": 0.4, "Gc": 0.004}], ids=["rock", "brittle"])
def test_law_only_where_it_is_not_the_closed_form(bond: dict[str, float]) -> None:
    """The closed form stays where the law has its misfit."""
    truth = bond | {"kT": 40.0, "mu": 0.6}
    tests = curves_of_law(truth, (0.3, 0.8), 0.03)
    solution = in_closed_form(Model(tuple(truth), 0), truth, tests)
    assert by_law(solution) is solution and solution.problem.is_closed_form


@pytest.mark.parametrize("reversed_", [False, True], ids=["first stroke", "cycles"])
def test_compressive_strength_that_the_tests_reach(reversed_: bool) -> None:
    """It is no part of the fit, which is that without it, and no result."""
    rng, slip = np.random.default_rng(3), np.linspace(0.05, 1.0, 30)
    if reversed_:
        slip = np.concatenate([slip, np.linspace(0.9, -1.0, 30)])
    tau = 0.7 * np.where(np.arange(slip.size) < 30, np.minimum(20.0 * slip, 1.0), -1.0)
    tests = [ShearTest("one", slip, tau + 0.01 * rng.normal(size=slip.size), None, -1.0)]
    alone = fit(tests, "rock")
    known = fit(tests, "rock", {"fc": 1.5, "Gfc": 1.0, "Css": 9.0, "kp": 0.1})
    assert any("fc = 1.5, which the fit leaves out, moves a peak" in text for text in known.reasons)
    assert any("stays below 0.5 do not crush" in text for text in known.reasons)  # with kp from fc/3 on
    assert known.estimates == alone.estimates and known.interface.material.fc == 1.5
    assert not any("fc" in text for text in alone.reasons)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ({"free": ["mu", "kT", "fc"], "fixed": {"Gfc": 1.0}}, "free: fc: expected known"),
        ({"fixed": {"Gfc": 1.0}}, "Gfc: expected with fc > 0"),
    ],
)
def test_compressive_strength_is_known_as_a_whole(words: dict, told: str) -> None:
    """It cannot be fitted, and its constants do nothing without it."""
    slip = np.linspace(0.05, 1.0, 30)
    test = ShearTest("one", slip, np.minimum(10.0 * slip, 0.7), None, -1.0)
    with pytest.raises(ValueError, match=told):
        fit([test], "rock", **words)


def test_compressive_strength_beyond_the_tests() -> None:
    """It changes nothing: the same constants, intervals and other shapes as without."""
    tests, _ = drawn_tests("Mohr-Coulomb, decaying dilation", 3, lambda p: len(p) == 2)
    known = fit(tests, "rock", {"fc": 50.0, "Gfc": 1.0, "Css": 9.0, "kp": 0.1})
    alone = fit(tests, "rock")
    assert [part.name for part in known.assumptions] == [part.name for part in alone.assumptions]
    assert any("along a line" in part.name for part in known.assumptions)
    for name, estimate in alone.estimates.items():
        assert known.estimates[name] == pytest.approx(estimate, rel=1e-9)


def test_eta_that_is_known() -> None:
    """The value that the fit itself assumes tries what the fit tries; one without a closed form says so."""
    rng, slip, tests = np.random.default_rng(1), np.linspace(0.03, 1.5, 50), []
    for pressure in (0.2, 0.5, 1.0):
        # the spring is stiffer than the first row shows
        tau = np.minimum(300.0 * slip, 0.5 * np.maximum(0.0, 1.0 - slip / 0.6) + 0.7 * pressure)
        tests.append(ShearTest(str(pressure), slip, tau + 0.01 * rng.normal(size=50), None, -pressure))
    alone, known = fit(tests, "mortar"), fit(tests, "mortar", {"eta": 0.999})
    assert [part.name for part in known.assumptions] == [part.name for part in alone.assumptions] != []
    for name, estimate in alone.estimates.items():
        assert known.estimates[name] == pytest.approx(estimate, rel=1e-9)
    untold = fit(tests, "mortar", {"eta": 0.9})
    assert not untold.assumptions and any("shapes of slope" in note for note in untold.notes)


def test_shape_of_a_bond_that_is_free() -> None:
    """With eta free, friction from the first slip on stays among the assumptions, and in the intervals."""
    tests = curves_of_law({"kT": 60.0, "sigma0": 0.6, "Gc": 0.3, "mu": 0.65}, (0.0, 0.3, 0.8), 0.01)
    result = fit(tests, free=("sigma0", "Gc", "mu", "eta"))
    names = [assumption.name for assumption in result.assumptions]
    assert "friction at once behind a spring" in names
    for name, true in (("sigma0", 0.6), ("Gc", 0.3), ("mu", 0.65)):
        assert result.estimates[name].low <= true <= result.estimates[name].high, name


@pytest.mark.slow
def test_eta_of_a_bond_without_pressure() -> None:
    """A form whose eta is fixed says nothing of it: the interval of eta is that of the rows."""
    rng, slip = np.random.default_rng(5), np.linspace(0.004, 0.34, 70)
    tau = 5.2 * np.minimum(slip / 0.045, np.maximum(0.0, (0.26 - slip) / 0.215)) + 0.08 * rng.normal(size=70)
    result = fit([ShearTest("slip", slip, tau, None, 0.0)], free=("sigma0", "Gc", "eta"))
    low, high = result.estimates["eta"].low, result.estimates["eta"].high
    assert low <= 1.0 - 0.045 / 0.26 <= high and high - low < 0.02
    assert not result.assumptions


@pytest.mark.slow
def test_sides_of_the_user_stay() -> None:
    """Four sides have no closed form, and no other form takes their place."""
    rng, tests = np.random.default_rng(4), []
    for pressure in (0.4, 1.2):
        slip = np.linspace(0.01, 2.5, 60)
        slope = np.tan(np.radians(15.0)) * np.exp(-slip / 0.6)
        tau = np.minimum(40.0 * slip, 0.65 * pressure + 0.6 * np.exp(-slip / 0.4) + slope * pressure)
        tau += 0.01 * rng.normal(size=slip.size)
        dilation = 0.6 * np.tan(np.radians(15.0)) * (1.0 - np.exp(-slip / 0.6))
        tests.append(ShearTest(f"p {pressure}", slip, tau, dilation, -pressure))
    result = fit(tests, "mortar", sides=4)
    assert kind_of(result.tests).interface(result).props()[contract.index("m")] == 4.0


def test_pressure_of_a_held_test() -> None:
    """It is the geometric mean of the ends, and none beside a single pressure."""
    assert other_laws.between([0.5, 0.9, 2.0]) == pytest.approx(1.0)
    assert other_laws.between([0.7]) == 0.0


def test_set_without_dilation() -> None:
    """A drawn set has strengths alone; the study compares a test that the fit has not seen."""
    kind, number = "dilation not measured", 0
    while len(other_laws.without_dilation(np.random.default_rng([3, number])).tests) != 2:
        number += 1
    drawn = other_laws.without_dilation(np.random.default_rng([3, number]))
    assert all(test.dilation is None for test in (*drawn.tests, drawn.held))
    pressures = [test.pressure for test in drawn.tests]
    assert min(pressures) < drawn.held.pressure < max(pressures)
    head, *rows = fits.judged((kind, 3, number))
    assert head["code"] in (0, 3) and 0.0 <= head["between"] < np.inf
    assert {row["name"] for row in rows} <= {"mu", "theta", "sigma0"}
    assert all(drawn.truth[row["name"]] == (row["true_low"], row["true_high"]) for row in rows)


def test_held_test_by_the_law(monkeypatch: pytest.MonkeyPatch) -> None:
    """The study judges the curve that the case has between the pressures, and no closed form."""
    kind, seed, number = "Mohr-Coulomb, decaying dilation", 20610, 0
    while other_laws.KINDS[kind](np.random.default_rng([seed, number])).held is None:
        number += 1
    found: list[Fit] = []

    def noted(tests: list[ShearTest], joint: str) -> Fit:
        found.append(fit(tests, joint))
        return found[-1]

    monkeypatch.setattr(fits, "fit", noted)
    head, *_ = fits.judged((kind, seed, number))
    drawn, (result,) = other_laws.KINDS[kind](np.random.default_rng([seed, number])), found
    held = fits.tests_of(drawn._replace(tests=[drawn.held]))
    (row,) = predict(result.interface, held, result.spring).compared
    assert head["between"] == pytest.approx(max(row.errors["peak"], row.errors["residual"]), rel=1e-6)


def test_asperities_that_end() -> None:
    """At the end the strength is friction alone and the opening the height; one curve has neither."""
    for number in range(5):
        drawn = other_laws.parabola(np.random.default_rng([4, number]))
        mu, height = (drawn.truth[name][0] for name in ("mu", "height"))
        for test in drawn.tests:
            last = slice(-test.slip.size // 10, None)
            # noise of up to 5 % of the largest value, three rows at least
            assert np.mean(test.tau[last]) == pytest.approx(mu * test.pressure, abs=0.1 * test.tau.max())
            assert np.mean(test.dilation[last]) == pytest.approx(height, rel=0.1)
    alone = other_laws.one_curve(np.random.default_rng([4, 0]))
    assert len(alone.tests) == 1 and alone.tests[0].dilation is None and alone.held is None


@pytest.mark.slow
def test_cycles_that_are_judged() -> None:
    """Cycles on teeth that are flattened give their friction, and no constant without an interval."""
    # a set of the study with few reversals
    head, *rows = fits.judged(("Plesha, cycles", 20610, 19))
    drawn = other_laws.plesha(np.random.default_rng([20610, 19]))
    assert head["code"] == 0
    [mu] = [row for row in rows if row["name"] == "mu"]
    assert (mu["true_low"], mu["true_high"]) == drawn.truth["mu"]
    assert mu["low"] <= drawn.truth["mu"][0] <= mu["high"] < 1.5 * mu["low"]


@pytest.mark.parametrize("kind", [name for name in other_strengths.STRENGTHS if "nonsense" not in name])
def test_strengths_of_other_criteria(kind: str) -> None:
    """Peaks of other criteria end with a result that holds between their pressures and has them inside."""
    sets = [fits.judged((kind, 5, number)) for number in range(4)]
    for number, (head, *rows) in enumerate(sets):
        drawn = other_strengths.STRENGTHS[kind](np.random.default_rng([5, number]))
        peaks = [row for row in rows if row["name"] == "peak"]
        assert head["between"] < fits.WRONG or head["code"] == 3, number
        assert [row["true_low"] for row in peaks] == pytest.approx(drawn.exact.tolist())
    assert sum(head["code"] == 0 for head, *_ in sets) >= 3
    every = [row for _, *rows in sets for row in rows if row["name"] == "peak"]
    # 0.95 intervals; 0.9 of two dozen peaks
    assert np.mean([row["low"] <= row["true_low"] <= row["high"] for row in every]) >= 0.9


def test_strengths_that_are_judged() -> None:
    """The study finds c within its interval and the peaks of all tests, and no result in nonsense."""
    head, *rows = fits.judged(("strengths: c + phi", 6, 0))
    drawn = other_strengths.coulomb(np.random.default_rng([6, 0]))
    assert head["code"] == 0 and head["between"] < fits.WRONG
    assert sum(row["name"] == "peak" for row in rows) == drawn.pressure.size
    assert [row["true_low"] for row in rows if row["name"] == "peak"] == pytest.approx(drawn.exact.tolist())
    assert [fits.judged(("strengths: nonsense", 6, number))[0]["code"] for number in range(3)] == [3, 3, 3]


def test_files_of_the_times() -> None:
    """Files have the rows that the page says, and the command fits them."""
    rng = np.random.default_rng(8)
    sizes = {law: len(drawn(rng)) for law, (_, drawn) in fit_times.FILES.items() if law != "strengths"}
    cyclic = sizes.pop("Plesha, cycles")
    assert {*sizes.values()} == {900} and cyclic == pytest.approx(fit_times.CYCLIC, rel=0.02)
    assert 0.0 < fit_times.seconds(fit_times.strengths(rng)) < 60.0

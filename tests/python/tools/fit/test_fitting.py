"""The fit of shear tests: truths of other laws within intervals, grades, blind predictions, files."""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from asperity.case_files import drive, read_case
from asperity.tools.fit import Fit, ShearTest, fit
from asperity.tools.fit.model import Model
from asperity.tools.fit.report import case_of
from asperity.tools.fit.rigid import law_peak
from asperity.tools.fit.strength import Strength
from asperity.tools.fit.strengths import fit_strengths
from asperity.tools.fit.verdict import Comparison, missed_peaks

from harness.studies import fits, other_laws

pytestmark = [pytest.mark.usefixtures("folder"), pytest.mark.filterwarnings("ignore::asperity.ModelWarning")]


@cache
def rock(seed: int, count: int = 2) -> tuple[list[ShearTest], dict[str, tuple[float, float]]]:
    """Tests of a joint of Mohr and Coulomb with constant pressure, and its constants."""
    for draw in range(100):
        drawn = other_laws.mohr_coulomb(np.random.default_rng([seed, draw]))
        if len(drawn.tests) == count and drawn.tests[0].k_N == 0.0:
            return fits.tests_of(drawn), drawn.truth
    raise AssertionError


@pytest.fixture(scope="module")
def result() -> Fit:
    """Fit of two tests of a rock joint."""
    return fit(rock(0)[0])


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_constants_of_another_law(seed: int) -> None:
    """Constants of a joint of Mohr and Coulomb lie in intervals as narrow as two tests allow: a result."""
    tests, truth = rock(seed)
    result = fit(tests)
    assert result.is_result and result.grade != "poor"
    for name, (value, _) in truth.items():
        estimate = result.estimates[name]
        # a 0.95 interval, widened by half of itself for the twentieth that misses
        margin = 0.5 * (estimate.high - estimate.low)
        assert estimate.low - margin <= value <= estimate.high + margin, name
        # two specimens show a slope to 28 %, and another shape may be behind it
        assert estimate.half < 0.4


@pytest.mark.slow
def test_bond_of_another_law() -> None:
    """Cohesion, energy and friction of tests with linear softening at two pressures."""
    for draw in range(100):
        drawn = other_laws.cohesion(np.random.default_rng([11, draw]))
        if len(drawn.tests) == 2 and drawn.tests[0].dilation is None:
            break
    else:
        raise AssertionError
    result = fit(fits.tests_of(drawn))
    assert result.is_result and result.solution.model.bond
    for name in ("mu", "sigma0", "Gc"):
        estimate = result.estimates[name]
        # as above
        margin = 0.5 * (estimate.high - estimate.low)
        assert estimate.low - margin <= drawn.truth[name][0] <= estimate.high + margin, name


def test_peak_that_the_law_misses() -> None:
    """A joint of friction alone lacks the peaks of asperities: no result, which names the worst."""
    tests = rock(1)[0]
    result = fit(tests, free=("kT", "mu"))
    off = [row.predicted["peak"] / row.measured["peak"] - 1.0 for row in result.fitted]
    most = int(np.argmax(np.abs(off)))
    sentence = f"the peak of the law lies {abs(off[most]):.0%} below that of {tests[most].name} ("
    assert off[most] < -0.15
    assert [reason for reason in result.reasons if reason.startswith(sentence)]


@pytest.mark.parametrize("noise", [0.02, 1.0])
def test_dilation_that_is_noise(noise: float) -> None:
    """A gauge that stands still excludes asperities; one whose noise hides their lift does not."""
    rng, slip = np.random.default_rng(51), np.linspace(0.08, 8.0, 100)
    slope = np.tan(np.radians(15.0)) * np.exp(-slip * np.tan(np.radians(15.0)) / 1.5)
    tau = np.minimum(4.0 * slip, 2.0 * (0.6 + slope) / (1.0 - 0.6 * slope)) + 0.02 * rng.normal(size=100)
    dilation = noise * rng.normal(size=100)
    result = fit([ShearTest("asperities", slip, tau, dilation, -2.0)])
    assert result.solution.model.bond and result.solution.problem.tests[0].s_N is None
    doubts = [reason for reason in result.reasons if "the strength alone does not tell a bond" in reason]
    assert len(doubts) == (noise == 1.0)


@pytest.mark.parametrize(
    ("off", "ratio", "sizes"),
    [
        # a trend over the pressure is the law's, also where it is 0 on average
        ([-0.12, -0.12, -0.12, -0.12, -0.12], 2.0, (0.0, 0.12)),
        ([0.12, 0.12, 0.12, 0.12, 0.12], 2.0, (0.12, 0.0)),
        ([-0.2, -0.1, 0.0, 0.1, 0.2], 2.0, (0.2, 0.2)),
        # a larger miss below hides none above
        ([-0.13, -0.05, 0.03, 0.11], 2.0, (0.11, 0.13)),
        # specimens differ without one, and a machine's pressures by its noise
        ([0.1, -0.1, 0.0, -0.1, 0.1], 2.0, (0.0, 0.0)),
        ([-0.2, -0.1, 0.0, 0.1, 0.2], 1.001, (0.0, 0.0)),
    ],
)
def test_peaks_of_specimens_are_not_missed(
    off: list[float], ratio: float, sizes: tuple[float, float]
) -> None:
    """What differs without a trend over the logarithm of the pressure is that of the specimens."""
    slip, pressures = np.linspace(0.1, 1.0, 10), ratio ** np.arange(len(off))
    tests = [ShearTest(f"{p}", slip, p * np.minimum(slip, 0.5), None, -p) for p in pressures]
    rows = [
        Comparison(test.name, {"peak": 1.0}, {"peak": 1.0 + part}, {})
        for test, part in zip(tests, off, strict=True)
    ]
    above, below = missed_peaks(rows, tests)
    assert (above[0], below[0]) == pytest.approx(sizes, abs=1e-12)
    assert "above that of" in above[2] and above[1] == 0.10
    assert "below that of" in below[2] and below[1] == 0.15


def test_peak_above_beside_a_larger_one_below() -> None:
    """A law that is too strong by more than 10 % is no result, also where it lies lower elsewhere."""
    rng, slip, tests = np.random.default_rng(6), np.linspace(0.01, 3.0, 100), []
    for number, pressure in enumerate([0.6] * 4 + [2.0] * 2):
        # strength grows with the root of the pressure, as that of asperities which are crushed
        strength = 0.55 * pressure + 0.45 * np.sqrt(pressure) * np.exp(-slip / 0.5)
        tau = np.minimum(30.0 * pressure * slip, strength)
        tau = tau + 0.01 * tau.max() * rng.normal(size=slip.size)
        tests.append(ShearTest(f"test {number}", slip, tau, None, -pressure))
    result = fit(tests, free=("kT", "mu", "theta", "height"))
    errors = [row.predicted["peak"] / row.measured["peak"] - 1.0 for row in result.fitted]
    assert max(errors) > 0.10 and -0.15 < min(errors) < -max(errors)
    (reason,) = result.reasons
    assert "above that of test" in reason and "expected at most 10%" in reason
    assert any("below that of test" in note for note in result.notes)


@cache
def nonsense(draw: int) -> other_laws.Drawn:
    """A drawn set of nonsense."""
    return other_laws.nonsense(np.random.default_rng([5, draw]))


@pytest.mark.parametrize("kind", range(14))
def test_nonsense_is_no_result(kind: int) -> None:
    """Noise, halving strengths, shuffled rows and wrong signs are refused or give no constants to use."""
    for draw in range(200):
        drawn = nonsense(draw)
        if drawn.truth["kind"][0] == kind and len(drawn.tests) <= 3 and drawn.tests[0].slip.size <= 80:
            break
    else:
        raise AssertionError
    try:
        result = fit(fits.read_back(fits.tests_of(drawn)))
    except ValueError as error:
        assert "expected" in str(error)
    else:
        assert result.reasons and not result.is_result


def test_blind_numbers_are_those_of_the_other_tests(result: Fit) -> None:
    """The blind peak of a test is that of a fit of the other test alone with the same model."""
    tests = result.tests
    assert len(result.blind) == len(tests) and result.errors["blind peak"] > 0.0
    alone = fit([tests[1]], free=result.free, fixed=dict(result.solution.model.fixed))
    slip = float(np.abs(tests[0].slip).max())
    path = alone.interface.confined_slip(0.0, np.linspace(0.0, slip, 400), tests[0].sigma_N)
    # at the end the traction hardly changes with the slip, also by that of the spring
    assert result.blind[0].predicted["residual"] == pytest.approx(path.tau[-40:].mean(), rel=0.02)


def test_case_has_the_spring_of_the_fit(result: Fit) -> None:
    """The curves of the case that is written are those of the fit, with the spring in series."""
    assert result.spring > 0.0
    Path("joint.nml").write_text(case_of(result))
    histories = drive(Path("joint.nml"))
    for test, (slips, rows), (tau, *_) in zip(
        result.tests,
        result.solution.problem.paths,
        result.solution.problem.curves(result.values),
        strict=True,
    ):
        key = min((v for v in histories if v is not None), key=lambda v: abs(v - test.sigma_N))
        history = histories[key]
        slid = history.separation[:, 1] + history.traction[:, 1] / result.spring
        after = np.flatnonzero(slid > 1e-6)
        at = np.interp(slips[rows], slid[after], history.traction[after, 1])
        # increments of a hundredth of the slip against 150 and more
        assert np.abs(at - tau[rows])[5:].max() < 0.03 * tau.max()


@pytest.mark.parametrize("k_N", [0.0, 2.0])
@pytest.mark.parametrize("more", [(), ("height",), ("crush",), ("height", "crush")], ids="-".join)
def test_closed_form_of_a_search_is_the_law(k_N: float, more: tuple[str, ...]) -> None:
    """Strength and dilation of two rigid sides in closed form are those of the law behind the same spring."""
    slip = np.linspace(0.05, 4.0, 80)
    test = ShearTest("one", slip, slip, slip, -1.3, k_N)
    model = Model(("kT", "mu", "theta", *more))
    problem, closed_form = model.problem([test], law=True), model.problem([test])
    values = problem.values(problem.x({
        "kT": 8.0, "mu": 0.6, "theta": 18.0, "height": 0.5, "crush": 3.0,
    }))  # fmt: skip
    assert closed_form.is_closed_form and not problem.is_closed_form
    (tau, s_N, rows), (rough, opening, _) = problem.curves(values)[0], closed_form.curves(values)[0]
    # the contact of the law gives way by 1/kc of the elastic slip, the rise to the strength is 1/1000
    assert rows > slip.size and np.abs(rough - tau).max() < 0.02 * tau.max()
    assert np.abs(opening - s_N).max() < 0.01 * s_N.max()


def test_friction_alone_without_dilation_at_one_pressure() -> None:
    """One curve of the strength shows no slope beside the friction."""
    tests, _ = rock(0)
    result = fit([replace(tests[0], s_N=None)], joint="rock")
    assert "theta" not in result.free and any("one test" in text for text in result.notes)


def test_envelope_of_the_law_is_that_of_the_driver() -> None:
    """Strengths computed by a rigid joint give its constants back; the closed form has no solver."""
    from asperity import Interface, Material, Pattern

    kc, theta, crush = 100.0, 25.0, 4.0
    joint = Interface(
        Material.from_joint(kn=kc * 1e5, ks=1e5, mu=0.6, crush=crush), Pattern.regular(2, theta, flat=0.0)
    )
    tests, slips = [], np.linspace(0.0, 0.2, 400)
    truth = {"mu": 0.6, "theta": theta, "crush": crush}
    # the closed form neglects the compliance of the contact, in the slope and in the pressure
    tolerance = 2.0 * (1.0 + np.tan(np.radians(theta)) ** 2) / kc
    for pressure in (0.3, 0.6, 1.0, 2.0, 3.0, 4.0):
        peak = joint.confined_slip(0.0, slips, -pressure).tau.max()
        assert law_peak(np.array([pressure]), truth)[0] == pytest.approx(peak, rel=tolerance)
        tests.append(Strength(f"{pressure}", -pressure, float(peak), 0.6 * pressure, slip=5.0))
    result = fit_strengths(tests)
    assert result.is_result and result.grade == "good"
    assert result.values["mu"] == pytest.approx(0.6, rel=tolerance)


@pytest.mark.parametrize("power", [0.0, -0.5])
def test_strength_that_does_not_grow_with_the_pressure(power: float) -> None:
    """One strength for all pressures, or one that falls, shows no friction and is no result."""
    pressures = (0.9, 1.1, 1.5, 1.6, 2.0)
    result = fit_strengths(
        [Strength(str(p), -p, 2.0 * p**power * (1.0 + 0.01 * (-1) ** i)) for i, p in enumerate(pressures)]
    )
    assert not result.is_result and any("does not grow" in text for text in result.reasons)


def test_strengths_keep_or_refuse_what_is_known() -> None:
    """A known constant is that of the result; one that strengths do not have is an error, not ignored."""
    tests = [Strength(str(p), -p, 0.3 + 0.7 * p, 0.6 * p) for p in (0.2, 0.6, 1.0, 1.5)]
    for name, value in (("theta", 10.0), ("sigma0", 0.2), ("mu", 0.5)):
        result = fit_strengths(tests, fixed={name: value})
        assert result.values[name] == value
    for known, message in (
        ({"qq": 1.0}, "qq: strengths alone have only mu"),
        ({"kc": 20.0}, "kc: strengths alone have only mu"),
        ({"theta": 10.0, "sigma02": 0.2}, "no model has all of that"),
        ({"theta": 95.0}, "theta = 95: expected 0 <= theta < 90"),
    ):
        with pytest.raises(ValueError, match=message):
            fit_strengths(tests, fixed=known)


def test_tests_that_are_the_same_are_an_error() -> None:
    """Copies of a curve are an error, as are two strengths; one pressure is told."""
    tests, _ = rock(0)
    copy = replace(tests[0], name="copy")
    part = replace(copy, slip=copy.slip[::2], tau=copy.tau[::2], s_N=None, sigma_N=-3.0)
    for copied in (copy, part):
        with pytest.raises(ValueError, match=r"copy: the rows are those of test 1: expected different tests"):
            fit([*tests, copied])
    with pytest.raises(ValueError, match="2 tests: expected at least 3 tests"):
        fit_strengths([Strength(f"line {i}", -1.0, 1.5) for i in range(2)])
    result = fit_strengths([Strength(f"{peak}", -1.0, peak) for peak in (1.5, 1.52, 1.49)])
    assert any("one pressure" in text for text in result.notes)


def test_residuals_of_strengths(said: Callable) -> None:
    """The rows have every measured strength, and its errors are those of the fitted and blind values."""
    Path("peaks.csv").write_text("sigma_N,peak,residual\n0.5,0.62,0.36\n1,1.14,0.73\n2,1.97,1.4\n3,2.6,\n")
    said("fit peaks.csv --residuals rows.csv")
    head, *rows = [line.split(",") for line in Path("rows.csv").read_text().splitlines()]
    assert len(rows) == 7
    for row in rows:
        cells = dict(zip(head, row, strict=True))
        measured = float(cells["measured"])
        for name, error in (("fitted", "relative_error"), ("blind", "blind_relative_error")):
            assert float(cells[error]) == pytest.approx(float(cells[name]) / measured - 1.0, abs=1e-5)


def test_command_writes_what_it_found(said: Callable) -> None:
    """Report, case, intervals, residuals and page agree; the exit code is that of the verdict."""
    tests, _ = rock(0)
    rows = "\n".join(
        f"{t.name},{u},{tau},{s},{-t.sigma_N}"
        for t in tests
        for u, tau, s in zip(t.slip, t.tau, t.s_N, strict=True)
    )
    Path("record.csv").write_text(f"test,slip,tau,dilation,sigma_N\n{rows}\n")
    out, _ = said(
        "fit record.csv --units mm,MPa -o joint.nml --report joint.html --residuals rows.csv --card abaqus"
    )
    content = json.loads(Path("joint.fit.json").read_text())
    assert content["grade"] in ("good", "fair") and not content["no result"]
    mu = content["values"][content["parameters"].index("mu")]
    assert re.search(rf"^mu +{mu:.4g}", out, re.MULTILINE)
    assert read_case(Path("joint.nml")).runs[0].material.mu == pytest.approx(mu, rel=1e-5)
    assert f"grade {content['grade']}" in Path("joint.nml").read_text().lower()
    card, _ = said("card abaqus joint.nml")
    assert f"Grade {content['grade']}; 0.95 intervals: " in card
    page = Path("joint.html").read_text()
    assert f"{mu:.4g}" in page and "://" not in page and "data:image/png;base64" in page
    assert len(Path("rows.csv").read_text().splitlines()) == 1 + 2 * sum(t.slip.size for t in tests)
    out, _ = said("uncertainty joint.nml --samples 10 --jobs 1")
    assert f"grade       {content['grade']}" in out


def test_command_of_no_result(said: Callable) -> None:
    """A strength that halves ends with 3, says why, and the files say the same."""
    rows = "\n".join(f"{i},{0.95 - 0.05 * i},1" for i in range(1, 10))
    Path("record.csv").write_text(f"slip,tau,sigma_N\n{rows}\n")
    out, _ = said("fit record.csv -o joint.nml", 3)
    assert "no result   " in out and "grade       poor" in out
    assert "no result" in Path("joint.nml").read_text()
    _, err = said(
        "fit record.csv --card abaqus --set theta=10 --set height=0.001 --set sigma0=.1 --set Gc=1", 3
    )
    assert err.startswith("asperity: warning: s_f = 2 Gc/sigma0")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"fixed": {"nu": 0.3}}, "nu is unknown"),
        ({"free": ("mu",), "fixed": {"mu": 0.5}}, "mu: expected it free or fixed, not both"),
        ({"joint": "clay"}, "joint = 'clay': expected rock, mortar or auto"),
        ({"fixed": {"theta": 0.01}}, "a radian is 57.3"),
        ({"fixed": {"theta": 95.0}}, "theta = 95: expected 0 <= theta < 90"),
        ({"joint": "rock", "fixed": {"Gc": 1.0}}, "constants of a bond"),
        ({"fixed": {"mu": -0.5}}, "mu = -0.5: expected a finite value >= 0"),
    ],
)
def test_arguments_are_checked(arguments: dict, message: str) -> None:
    """Wrong arguments are refused by their names and values."""
    with pytest.raises(ValueError, match=re.escape(message)), warnings.catch_warnings():
        fit(rock(0)[0], **arguments)


def test_prediction_of_tests_that_were_not_fitted(result: Fit, said: Callable) -> None:
    """The joint of one pressure predicts a test at another one; the errors are those of the table."""
    unseen, fitted = rock(0)[0]
    alone = fit([fitted], free=result.free, fixed=dict(result.solution.model.fixed))
    Path("joint.nml").write_text(case_of(alone))
    for factor, code, grades in ((1.0, 0, ("good", "fair")), (0.5, 3, ("poor",))):
        pairs = zip(unseen.slip, factor * unseen.tau, strict=True)
        rows = "\n".join(f"{u},{tau},{-unseen.sigma_N}" for u, tau in pairs)
        Path("unseen.csv").write_text(f"slip,tau,sigma_N\n{rows}\n")
        out, _ = said("predict joint.nml unseen.csv --plot predict.png", code)
        assert re.search(r"^grade +(\w+)$", out, re.MULTILINE)[1] in grades
        row = next(line for line in out.splitlines() if line.startswith("unseen.csv"))
        (peak, predicted), _, residuals = [
            map(float, pair.split(" / ")) for pair in re.findall(r"\S+ / \S+", row)
        ]
        errors = [abs(predicted / peak - 1.0), abs((end := [*residuals])[1] / end[0] - 1.0)]
        shown = [float(number) / 100.0 for number in re.findall(r"(?:peak|residual) ([\d.]+)%", out)]
        # four digits in the table, a tenth of a per cent below it
        assert shown == pytest.approx(errors, abs=1e-3)
        assert Path("predict.png").read_bytes().startswith(b"\x89PNG")

"""A fit that is no result exits with 3, prints no PROPS and proposes a command that gives a result.

The tests of HELD_OUT have constants and random numbers that were not used when thresholds were chosen.
"""

from __future__ import annotations

import re
import shlex
import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from asperity import Interface, Material, Pattern
from asperity.case_files import read_case, slip_tests
from asperity.cli import main
from asperity.options import PICTURES, may_replace
from asperity.tools.fit import fit, read_tests
from asperity.tools.fit.command import COVARIANCE, HEADING
from asperity.tools.fit.result import failed_checks
from asperity.tools.uncertainty import uncertainty

from harness.studies import synthetic as study

HELD_OUT = {"sigma0": 1.1, "Gc": 0.09, "eta": 0.85, "mu": 0.55, "theta": 18.0, "flat": 0.3, "kc": 30.0}
SIGMA_N = (-0.5, -3.0)
SEED, NOISE = 1017, 0.02
ENVELOPE = "sigma_N,peak,residual,slip\n"

Command = Callable[[Sequence[str] | str], tuple[int, str]]


@pytest.fixture
def command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    """Return a function that runs a command in an empty folder; a warning of NumPy fails the test."""
    monkeypatch.chdir(tmp_path)

    def run(arguments: Sequence[str] | str) -> tuple[int, str]:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            code = main(shlex.split(arguments) if isinstance(arguments, str) else arguments)
        printed = capsys.readouterr()
        assert "Warning" not in printed.err
        return code, printed.out

    return run


def record(**arguments: Any) -> None:
    """Write the record of HELD_OUT."""
    truth = arguments.pop("truth", HELD_OUT)
    given = {"sigma_N": SIGMA_N} | arguments
    study.write_record(Path("record.csv"), study.synthetic(NOISE, SEED, truth, **given))


def interval(out: str, name: str) -> tuple[float, float] | None:
    """Interval of a constant in a report."""
    found = re.search(rf"^{name} +\S+ +([\d.e+-]+) +([\d.e+-]+)  \S", out, re.MULTILINE)
    return (float(found[1]), float(found[2])) if found else None


def holds(code: int, out: str, truth: dict[str, float] = HELD_OUT) -> None:
    """Check that a fit is a result, whose intervals contain the true constants but for one in twenty."""
    assert code == 0 and "PROPS(" in out
    found = {name: interval(out, name) for name in truth}
    missed = [name for name, one in found.items() if one and not one[0] <= truth[name] <= one[1]]
    assert len(missed) <= 1 and any(found.values()), missed


def refused(code: int, out: str, why: str = "") -> str:
    """Check that a fit is no result, and return the command that it proposes, with a value for VALUE."""
    assert code == 3 and "PROPS(" not in out and "\nno result: " in out
    proposed = re.search(rf"^next: asperity (fit .*)\n{why}", out, re.MULTILINE)
    assert proposed, out[-600:]
    return proposed[1].replace("=VALUE", "=18")


@pytest.mark.slow
def test_plain_fit_is_right(command: Command) -> None:
    """Without options every constant is free; picture, card and a case that commands read are written."""
    record()
    code, out = command("fit record.csv -o joint.nml --plot fit.png --card abaqus")
    holds(code, out)
    assert "*User Material" in out and "MPa mm" in out
    assert out.endswith("fit.png\njoint.nml\njoint.fit.json\n")
    for one, start in (("fit.png", PICTURES[".png"]), ("joint.nml", HEADING), ("joint.fit.json", COVARIANCE)):
        assert may_replace(Path(one), start)
    case = read_case(Path("joint.nml"))
    props, line = case.runs[0].interface.props(), re.search(r"^PROPS\(\d+\)   (.*)$", out, re.MULTILINE)
    assert line and [float(text) for text in line[1].split(",")] == pytest.approx(props.tolist(), rel=1e-5)
    tests = list(slip_tests(case))
    assert [test.sigma_N for test in tests] == list(SIGMA_N)
    assert tests[0].slips[-1] == pytest.approx(study.TURNS[-1])
    assert command("run joint.nml -o rows.csv")[0] == 0


@pytest.mark.parametrize(
    ("changes", "options", "proposed"),
    [
        # a ridge fitted with the default pattern
        pytest.param(
            {"sides": 2}, "--set eta=0.85 --set flat=0.3 --set kc=30", "--sides 2", marks=pytest.mark.slow
        ),
        # a value that contradicts the tests
        pytest.param({}, "--sides 8 --set eta=0.95 --set flat=0.3", "--sides 8", marks=pytest.mark.long),
        # inclined planes on a flat joint
        pytest.param(
            {"sides": 0, "dilation": False}, "--set theta=18", "fit record.csv", marks=pytest.mark.long
        ),
    ],
)
def test_proposal(command: Command, changes: dict[str, Any], options: str, proposed: str) -> None:
    """What is wrong is refused, without case and card; the command that is proposed finds the constants."""
    record(**changes)
    printed = command(f"fit record.csv {options} -o joint.nml --card abaqus")
    words = refused(*printed, "      fits better: sum of squares")
    assert not Path("joint.nml").exists() and proposed in words
    holds(*command(words))
    assert Path("joint.nml").exists()


@pytest.mark.long
def test_what_the_tests_do_not_contain(command: Command) -> None:
    """Without dilation theta is not fitted and proposed to be set; with theta set there is a result."""
    record(dilation=False)
    code, out = command("fit record.csv")
    assert "theta       is not fitted, as no dilation was measured" in out
    assert refused(code, out) == "fit record.csv --set theta=18"
    holds(*command("fit record.csv --set theta=18"))
    # what is free is set by the proposal; patterns without planes, which are tried, have no theta
    code, out = command(refused(*command("fit record.csv --starts 2 --free sigma0,Gc,eta,mu,theta,flat,kc")))
    assert code in (0, 3) and "scatter" in out


def test_strengths_without_bond(command: Command) -> None:
    """Residual strengths alone do not give the bond: exit code 3; report and picture have the test."""
    text = "".join(f"{-p},{1.05 * p},{1.05 * p},0.6\n" for p in (1, 2, 3))
    Path("box.csv").write_text(ENVELOPE + text, encoding="utf-8")
    known = "--set 'eta=0.9 kc=20 flat=0.3333 mu=0.5 theta=20' --starts 1"
    code, out = command(f"fit box.csv --sides 2 {known} --free sigma0,Gc --plot")
    assert code == 3 and "line 2: peak 1.05, residual 1.05, sigma_N -1" in out and "no result" in out
    assert Path("fit.png").stat().st_size > 10000


@pytest.mark.parametrize(("law", "found"), [("cohesion", False), ("noise", True)])
def test_strengths_of_another_law(command: Command, law: str, found: bool) -> None:
    """Strengths c + mu p, which the law cannot follow, are no result unless the difference is accepted."""
    random = np.random.default_rng(SEED)
    flat = Interface(Material(sigma0=0.5, Gc=0.1, eta=0.9, mu=0.6), Pattern.regular(0, 0.0))
    text = ""
    for p in (0.5, 1.0, 2.0, 4.0):
        tau = flat.confined_slip(0.0, np.linspace(0.0, 1.0, 401)[1:], -p).tau
        peak, end = (tau.max(), tau[-1]) if law == "noise" else (0.5 + 0.6 * p, 0.6 * p)
        peak, end = np.array([peak, end]) * (1.0 + 0.01 * random.standard_normal(2))
        text += f"{-p},{max(peak, end)},{end},1\n"
    Path("box.csv").write_text(ENVELOPE + text, encoding="utf-8")
    code, out = command("fit box.csv --set Gc=0.1 -o joint.nml")
    assert code == (0 if found else 3) and Path("joint.nml").exists() == found
    if not found:
        assert "no result: the law differs from the tests by more than noise: scatter" in out
        code, out = command(refused(code, out))
        error = re.search(r"accepted with the law misses the tests by (\S+) % of tau", out)
        assert code == 0 and error and float(error[1]) > 5.0


@pytest.mark.slow
def test_outliers(command: Command) -> None:
    """A row that is far off is found, and a fit that it moves is no result."""
    record(sigma_N=SIGMA_N[:1])
    lines = Path("record.csv").read_text(encoding="utf-8").splitlines()
    known = "--set 'eta=0.85 flat=0.3 kc=30' --joint mortar --starts 2"
    code, out = command(f"fit record.csv {known}")
    assert code == 0 and "outlier" not in out
    cells = lines[41].split(",")
    cells[2] = f"{1.5 * float(cells[2]):.5g}"
    Path("record.csv").write_text("\n".join([*lines[:41], ",".join(cells), *lines[42:]]), encoding="utf-8")
    code, out = command(f"fit record.csv {known}")
    assert code == 3 and f"no result: outlier: record.csv: test 1: line 42, tau {cells[2]} is" in out
    reading = "Errors of reading? Put # before record.csv: test 1: line 42 and fit again. If the values are "
    assert f"\n{reading}right:\nnext: asperity fit record.csv" in out


def test_reasons() -> None:
    """Starts go on until three agree; each reason is told; an accepted error widens the intervals."""
    fixed = {name: HELD_OUT[name] for name in HELD_OUT if name != "mu"}
    tests = study.synthetic(NOISE, SEED, HELD_OUT, SIGMA_N)
    found = fit(tests, fixed=fixed, starts=4)
    assert found.agreeing >= 3 and not failed_checks(found)
    alone = replace(found, costs=(found.costs[0], *(2.0 * cost for cost in found.costs[1:])))
    assert failed_checks(alone) == ["only one start reached the smallest sum of squares: raise --starts"]
    assert "the increments are too long" in failed_checks(replace(found, shift=1.0))[0]
    # a flat joint has no dilation
    wrong = {name: HELD_OUT[name] for name in ("sigma0", "Gc", "eta", "kc")}
    missed, wide = (fit(tests, ("mu",), wrong, sides=0, starts=1, model_error=e) for e in (0.0, 0.9))
    assert "more than noise" in failed_checks(missed)[0] and not failed_checks(wide)
    n = missed.neighbours
    assert wide.widening == pytest.approx(np.sqrt((1.0 + n) / (1.0 - n)))
    widths = [np.log(one.estimates["mu"].high / one.values["mu"]) for one in (missed, wide)]
    assert widths[1] / widths[0] == pytest.approx(wide.widening)


@pytest.mark.slow
def test_accepted_constants_are_marked(command: Command) -> None:
    """What is accepted is in report, case, covariance and card, and widens the band of `uncertainty`."""
    record(sides=2)
    code, out = command(
        "fit record.csv --starts 1 --sides 0 --joint mortar -o joint.nml --accept --card abaqus"
    )
    accepted = re.search(r"^accepted with (.*)$", out, re.MULTILINE)
    assert code == 0 and accepted and "neighbouring rows" in accepted[1] and "PROPS" in out
    assert re.match(r"the law misses the tests by \S+ % of tau and \S+ % of s_N; ", accepted[1])
    assert out.count("accepted with") == 2  # in the report and in the card
    text = Path("joint.nml").read_text(encoding="utf-8")
    assert text.startswith(f"{HEADING}\n! Accepted with {accepted[1]}.\n")
    code, out = command("card abaqus joint.nml")
    assert code == 0 and "ccepted with the law misses" in out
    spreads = uncertainty("joint.nml", samples=400)
    for one, test in zip(spreads, read_tests("record.csv"), strict=True):
        low, high = np.quantile(one.results[:, 0], (0.05, 0.95))
        assert low < test.tau.max() < high, (low, test.tau.max(), high)


def sheared(slip: np.ndarray, pressure: float, mu: float, theta: float, ks: float, height: float) -> Any:
    """tau and dilation of a joint that is elastic up to Coulomb friction on a slope, which its climb ends.

    Closed form, with the slope tan(theta) exp(-d tan(theta)/height) after the sliding d.
    """
    steep, d, found = np.tan(np.radians(theta)), 0.0, []
    for u in np.interp(np.arange(10.0 * (slip.size - 1) + 1), 10.0 * np.arange(slip.size), slip):
        slope = steep * np.exp(-d * steep / height)
        tau = min(ks * (u - d), pressure * (mu + slope) / (1.0 - mu * slope))
        d = max(d, u - tau / ks)
        found.append((tau, height * (1.0 - np.exp(-d * steep / height))))
    return np.transpose(found[::10])


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
def test_form_of_the_joint(command: Command) -> None:
    """Constants of a closed form without bond are found, and that there is no bond."""
    truth = {"mu": 0.577, "theta": 14.0, "height": 0.4}
    slip, random = np.linspace(0.0, 4.0, 101), np.random.default_rng(SEED)
    for pressure in (0.5, 1, 2):
        curves = sheared(slip, pressure, ks=20.0, **truth)
        columns = [y + 0.01 * np.ptp(y) * random.standard_normal(101) for y in curves]
        text = "".join("{:.4f},{:.5f},{:.6f}\n".format(*row) for row in zip(slip, *columns, strict=True))
        Path(f"{pressure}.csv").write_text(f"slip,tau,dilation\n{text}", encoding="utf-8")
    code, out = command("fit 0.5.csv 1.csv 2.csv --sigma-N 0.5,1,2 --sides 2 --set flat=0 --auto")
    assert code == 0 and "form        rock joint, without bond; information criterion (BIC): mortar" in out
    for name, value in truth.items():
        assert np.mean(interval(out, name)) == pytest.approx(value, rel=0.02)  # type: ignore[arg-type]

"""A fit that is no result exits with 3, prints no PROPS and proposes a command that gives a result.

The tests of HELD_OUT have constants and random numbers that were not used when thresholds were chosen.
"""

from __future__ import annotations

import argparse
import re
import shlex
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, Pattern, contract
from asperity.case_files import read_case
from asperity.cli import main
from asperity.fit.command import add_arguments
from asperity.fit.fitting import fit
from asperity.fit.outcome import Fit
from asperity.fit.records import read_tests
from asperity.fit.search import HEADING
from asperity.fit.shear_test import saturates
from asperity.fit.verdict import Change, outliers, propose, refusals
from asperity.options import command_line
from asperity.uncertainty import uncertainty

from harness.studies import synthetic as study

HELD_OUT = {"sigma0": 1.1, "Gc": 0.09, "eta": 0.85, "mu": 0.55, "theta": 18.0, "flat": 0.3, "kc": 30.0}
SIGMA_N = (-0.5, -3.0)
SEED, NOISE = 1017, 0.02

Command = Callable[[Sequence[str]], tuple[int, str]]


@pytest.fixture
def command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    """Return a function that runs a command in an empty folder; a warning of NumPy fails the test."""
    monkeypatch.chdir(tmp_path)

    def run(arguments: Sequence[str]) -> tuple[int, str]:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            code = main(arguments)
        printed = capsys.readouterr()
        assert "Warning" not in printed.err
        return code, printed.out

    return run


def record(**arguments: object) -> None:
    """Write the record of HELD_OUT."""
    tests = study.synthetic(NOISE, SEED, HELD_OUT, SIGMA_N, **arguments)  # type: ignore[arg-type]
    study.write_record(Path("record.csv"), tests)


def holds(out: str) -> None:
    """Check that the intervals of all constants in a report contain the true ones, but for one in twenty."""
    missed = []
    for name, value in HELD_OUT.items():
        found = re.search(rf"^{name} +\S+ +(\S+) +(\S+)  \S", out, re.MULTILINE)
        if found and not float(found[1]) <= value <= float(found[2]):
            missed.append((name, found[0]))
    assert len(missed) <= 1, missed


def refused(code: int, out: str) -> list[str]:
    """Check that a fit is no result, and return the arguments of the command that it proposes."""
    assert code == 3 and "PROPS" not in out
    proposed = re.search(r"^next: (asperity fit .*)\n      it has a result", out, re.MULTILINE)
    assert proposed, out[-600:]
    return shlex.split(proposed[1])[1:]


@pytest.mark.slow
def test_plain_fit_is_right(command: Command) -> None:
    """Without options every constant is free, and the case that is written has the fitted ones."""
    record()
    code, out = command(["fit", "record.csv", "-o", "joint.nml"])
    assert code == 0
    holds(out)
    line = re.search(rf"^PROPS\({contract.N_FIXED_PROPS}\)   (.*)$", out, re.MULTILINE)
    assert line
    props = read_case(Path("joint.nml")).runs[0].interface.props()
    assert [float(text) for text in line[1].split(",")] == pytest.approx(props.tolist(), rel=1e-5)


@pytest.mark.slow
def test_wrong_pattern(command: Command) -> None:
    """A ridge fitted with the default pattern is refused; the proposed command finds its constants."""
    record(sides=2)
    given = ["--set", " ".join(f"{name}={HELD_OUT[name]}" for name in ("eta", "flat", "kc"))]
    code, out = command(["fit", "record.csv", *given, "-o", "joint.nml", "--card", "abaqus"])
    proposed = refused(code, out)
    assert "no result: " in out and "correlated" in out and "*User Material" not in out
    assert not Path("joint.nml").exists()
    assert "--sides" in proposed and proposed[proposed.index("--sides") + 1] == "2"
    code, out = command(proposed)
    assert code == 0 and Path("joint.nml").exists()
    holds(out)


@pytest.mark.long
def test_record_of_the_tutorial(command: Command) -> None:
    """The plain fit of the tutorial's record is no result; the proposed one has the true constants."""
    page = (Path(__file__).parents[2] / "docs" / "how-to" / "tutorial.md").read_text(encoding="utf-8")
    code = re.search(r"^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    assert code
    exec(compile(code[1], "tutorial", "exec"), {})
    proposed = refused(*command(["fit", "record.csv"]))
    assert proposed == ["fit", "record.csv", "--sides", "2"]
    code, out = command(proposed)
    assert code == 0
    for name, value in {"sigma0": 0.3, "Gc": 0.03, "eta": 0.95, "mu": 0.6, "theta": 10.0, "kc": 20.0}.items():
        found = re.search(rf"^{name} +\S+ +(\S+) +(\S+)  \S", out, re.MULTILINE)
        assert found and float(found[1]) <= value <= float(found[2]), name


@pytest.mark.long
def test_wrong_value(command: Command) -> None:
    """A value that contradicts the tests is refused; the proposal frees it; its error can be accepted."""
    record()
    narrow = command(["fit", "record.csv", "--sides", "8", "--set=eta=0.95", "--set", "flat=0.3"])
    assert refused(*narrow) == ["fit", "record.csv", "--sides", "8"]
    code, out = command(["fit", "record.csv", "--set", "eta=0.95 flat=0.3", "--model-error", "0.15"])
    assert code == 0 and "intervals are widened by a factor" in out
    factor = float(re.search(r"by a factor of about (\S+)", out)[1])  # type: ignore[index]
    widths = []
    for text in (out, narrow[1]):
        row = re.search(r"^mu +\S+ +(\S+) +(\S+)  -", text, re.MULTILINE)
        widths.append(float(row[2]) - float(row[1]))  # type: ignore[index]
    # printed to two digits and one decimal
    assert widths[0] / widths[1] == pytest.approx(factor, rel=0.1)


@pytest.mark.long
def test_what_the_tests_do_not_contain(command: Command) -> None:
    """Without dilation theta is not fitted and proposed to be set; with theta set there is a result."""
    record(dilation=False)
    code, out = command(["fit", "record.csv"])
    assert (
        code == 3 and "PROPS(" not in out and "theta       is not fitted, as no dilation was measured" in out
    )
    assert "next: asperity fit record.csv --set theta=VALUE" in out
    code, out = command(["fit", "record.csv", "--set", "theta=18"])
    assert code == 0
    holds(out)


@pytest.mark.long
def test_flat_joint(command: Command) -> None:
    """Inclined planes on a flat joint are refused; the proposal is a flat pattern, and holds."""
    record(sides=0, dilation=False)
    proposed = refused(*command(["fit", "record.csv", "--set", "theta=18"]))
    assert "--sides" in proposed and proposed[proposed.index("--sides") + 1] == "0"
    code, out = command(["fit", "record.csv", "--sides", "0"])
    assert code == 0
    holds(out)


@pytest.mark.slow
def test_outliers() -> None:
    """A row that is far off is found, and a fit that it moves is no result."""
    told = {name: value for name, value in HELD_OUT.items() if name not in study.FREE}
    tests = study.synthetic(NOISE, SEED, HELD_OUT, SIGMA_N)
    start = {name: HELD_OUT[name] for name in study.FREE}
    assert outliers(fit(tests, fixed=told, start=start, starts=1)) == []
    for factor in (-1.0, 1.5):
        tau = tests[1].tau.copy()
        tau[40] *= factor
        changed = [tests[0], study.replace(tests[1], tau=tau, lines=tuple(range(2, 62)))]
        found = fit(changed, fixed=told, start=start, starts=1)
        [one] = outliers(found)
        assert one.place == "test 2: line 42" and f"tau {tau[40]:g} is" in one.text
        assert refusals(found) == ["outliers move the constants (test 2: line 42)"]


def having(found: Fit, model_error: float = 0.0, **properties: object) -> Fit:
    """The fit with other values of properties that it computes."""
    changed = study.replace(found, model_error=model_error)
    vars(changed).update(properties)
    return changed


def test_starts_go_on() -> None:
    """The same starts are tried until three agree; one that is alone at the end is a reason to refuse."""
    tests = study.synthetic(NOISE, SEED, HELD_OUT, SIGMA_N)
    fixed = {name: HELD_OUT[name] for name in HELD_OUT if name != "mu"}
    found = fit(tests, fixed=fixed, starts=4)
    assert found.agreeing >= 3 and not refusals(found)
    assert fit(tests, fixed=fixed, starts=4).values == found.values
    alone = study.replace(found, costs=(found.costs[0], *(2.0 * cost for cost in found.costs[1:])))
    assert refusals(alone) == ["only one start reached the smallest sum of squares"]
    late = having(study.replace(found, shift=1.0), converged=False)
    assert refusals(late) == ["the least squares did not converge", "the increments are too long"]
    correlated = having(found, neighbours=0.5)
    assert refusals(correlated) == ["the residuals of neighbouring rows are correlated (0.50)"]
    assert refusals(having(found, 0.05, neighbours=0.5)) == []
    # a scatter of less than a thousandth is no reason
    exact = having(found, neighbours=0.5, scatter=(1e-4, 1e-4))
    assert refusals(exact) == []
    few = having(found, neighbours=0.5, residuals=np.zeros(16))
    assert not few.dependent


def test_crush_is_tried_at_several_pressures_only() -> None:
    """Where a fit is no result, crush is tried for tests at two pressures, and never for one test."""
    fixed = {name: HELD_OUT[name] for name in HELD_OUT if name != "mu"}
    for pressures in (SIGMA_N, SIGMA_N[:1]):
        tests = study.synthetic(NOISE, SEED, HELD_OUT, pressures)
        found = having(fit(tests, fixed=fixed, starts=1), neighbours=0.9)
        tried: list[Change] = []

        def refuse(change: Change, tried: list[Change] = tried) -> Fit:
            tried.append(change)
            raise ValueError("refused")

        assert refusals(found) and propose(found, Change(), refuse) is None
        freed = [one.free for one in tried if one.free is not None]
        assert (("+crush",) in freed) == (len(pressures) > 1)


def again(out: str) -> list[str]:
    """Arguments of the command that a report proposes, with a value where it asks for one."""
    proposed = re.search(r"^next: (?:put .*\n      )?(asperity fit .*)$", out, re.MULTILINE)
    assert proposed, out[-600:]
    return shlex.split(proposed[1].replace("=VALUE", "=18"))[1:]


FREE = "sigma0,Gc,eta,mu,theta,flat,kc"


@pytest.mark.parametrize(
    ("changes", "options"),
    [
        # the command of fit.md, on tests of a flat joint: patterns without planes have no theta
        pytest.param(
            {"sides": 0},
            ["--free=sigma0,Gc,mu,theta,height", "--set", "eta=0.85 flat=0.3 kc=30"],
            marks=pytest.mark.slow,
        ),
        # what is free is set by the proposal
        pytest.param({"dilation": False}, ["--free", FREE], marks=pytest.mark.long),
    ],
)
def test_every_proposal_runs(command: Command, changes: dict[str, object], options: list[str]) -> None:
    """A fit that is no result prints its report and a command that is not refused."""
    record(**changes)
    code, out = command(["fit", "record.csv", "--starts", "2", *options])
    assert code == 3 and out.index("correlation") < out.index("no result: ")
    code, out = command(again(out))
    assert code in (0, 3) and "scatter" in out


def test_proposals_repeat_the_options() -> None:
    """A command that is written from its options has the same ones; changed options replace the given."""
    parser = argparse.ArgumentParser(prog="asperity fit")
    add_arguments(parser)
    given = "a.csv b.csv --free=mu,theta --set kc=30 --set=eta=0.9 --plot --k-N 5 --sides 4 --columns"
    options = parser.parse_args([*given.split(), "tau=Shear stress", "-o", "joint.nml", "--accept"])
    words = command_line(parser, options, {})
    assert words[:4] == ["asperity", "fit", "a.csv", "b.csv"]
    assert vars(parser.parse_args(words[2:])) == vars(options)
    changed = parser.parse_args(
        command_line(parser, options, {"free": None, "set": ["mu=0.5"], "sides": 0})[2:]
    )
    assert (changed.free, changed.set, changed.sides) == (None, ["mu=0.5"], 0)


@pytest.mark.long
def test_height_is_free_where_the_dilation_ends(command: Command) -> None:
    """Where the dilation ends, the height is free, and found."""
    truth = HELD_OUT | {"height": 0.06}
    tests = study.synthetic(NOISE, SEED, truth, SIGMA_N)
    assert all(saturates(test) for test in tests)
    assert not any(saturates(test) for test in study.synthetic(NOISE, SEED, HELD_OUT, SIGMA_N))
    study.write_record(Path("record.csv"), tests)
    code, out = command(["fit", "record.csv"])
    found = re.search(r"^height +\S+ +(\S+) +(\S+)  \S", out, re.MULTILINE)
    assert code == 0 and found and float(found[1]) <= truth["height"] <= float(found[2])


@pytest.mark.slow
def test_accepted_constants_are_marked(command: Command) -> None:
    """What is accepted is in report, case, covariance and card, and widens the band of `uncertainty`."""
    record(sides=2)
    arguments = [
        "fit",
        "record.csv",
        "--starts",
        "1",
        "--sides",
        "0",
        "--joint",
        "mortar",
        "-o",
        "joint.nml",
        "--accept",
    ]
    code, out = command([*arguments, "--card", "abaqus"])
    accepted = re.search(r"^accepted with (.*)$", out, re.MULTILINE)
    assert code == 0 and accepted and "neighbouring rows are correlated" in accepted[1] and "PROPS" in out
    assert re.match(r"the law differs from the tests by \S+ % of tau and \S+ % of s_N; ", accepted[1])
    assert out.count("accepted with") == 2  # in the report and in the card
    text = Path("joint.nml").read_text(encoding="utf-8")
    assert text.startswith(f"{HEADING}\n! Accepted with {accepted[1]}.\n")
    code, out = command(["card", "abaqus", "joint.nml"])
    assert code == 0 and "ccepted with the law differs" in out
    spreads = uncertainty("joint.nml", samples=400)
    for one, test in zip(spreads, read_tests(["record.csv"]), strict=True):
        low, high = np.quantile(one.results[:, 0], (0.05, 0.95))
        assert low < test.tau.max() < high, (low, test.tau.max(), high)


@pytest.mark.slow
def test_form_of_the_joint(command: Command) -> None:
    """A joint without bond is found as such, by its information criterion; --auto runs what is proposed."""
    rock = Interface(Material.from_joint(kn=100.0, ks=20.0, mu=0.577, height=0.4), Pattern.regular(8, 14.0))
    slip, random = np.linspace(0.0, 4.0, 201), np.random.default_rng(SEED)
    text = "slip,tau,dilation,sigma_N\n"
    for sigma_N in (-0.5, -1.0, -2.0):
        run = rock.confined_slip(0.0, slip, sigma_N)
        columns = [slip, run.tau, run.dilation - run.dilation[0]]
        columns[1:] = [one + 0.01 * np.ptp(one) * random.standard_normal(one.size) for one in columns[1:]]
        text += "".join(f"{x:.4f},{y:.5f},{z:.6f},{sigma_N}\n" for x, y, z in zip(*columns, strict=True))
        Path(f"box{-sigma_N:g}.csv").write_text(text, encoding="utf-8")
        text = text.splitlines()[0] + "\n"
    files = ["box0.5.csv", "box1.csv", "box2.csv"]
    code, out = command(["fit", *files, "--auto"])
    assert code == 0 and "form        rock joint, without bond: the information criterion (BIC) is" in out
    found = {
        name: float(re.search(rf"^{name} +(\S+)", out, re.MULTILINE)[1]) for name in ("mu", "theta", "height")
    }  # type: ignore[index]
    assert found == pytest.approx({"mu": 0.577, "theta": 14.0, "height": 0.4}, rel=0.05)
    code, out = command(["fit", *files, "--joint", "mortar"])
    assert "form        mortar joint, with bond\n" in out

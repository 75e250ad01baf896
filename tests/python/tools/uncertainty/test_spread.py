"""Command `asperity uncertainty`: closed forms, the chain from a fit, load paths of every kind."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from statistics import NormalDist

import numpy as np
import pytest
from asperity import EquilibriumLost, Interface, Material, Pattern
from asperity.case_files import Case, drive, read_case
from asperity.tools.fit import Fit, fit, written
from asperity.tools.fit.model import SCALES
from asperity.tools.fit.report import case_of, intervals_text
from asperity.tools.fit.thresholds import CONFIDENCE
from asperity.tools.uncertainty.distribution import of_deviations, read
from asperity.tools.uncertainty.spread import RESULTS, load_path, spread

from harness.studies import synthetic as study

LAW = "&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5, kc = 100.0 /\n"
FLAT = LAW + "&pattern sides = 0 /\n&step t_N = -2.0, increments = 5 /\n&step slip = 0.6, increments = 60 /\n"
ROUGH = LAW + "&pattern sides = 4, theta = 30.0 /\n"
CYCLE = (
    "&step t_N = -1.0, increments = 20 /\n&step slip = 0.2, -0.2, direction = 30.0, increments = 20, 40 /\n"
)
END = RESULTS.index("traction at the end")

pytestmark = pytest.mark.usefixtures("folder")


def case(text: str) -> Case:
    """A case in the current folder."""
    Path("case.nml").write_text(text)
    return read_case(Path("case.nml"))


@pytest.fixture(scope="module")
def result() -> Fit:
    """A fit of a synthetic record."""
    return fit(study.synthetic(0.03, 0), "mortar", study.SET, study.FREE, study.SIDES)


def test_friction_of_a_flat_joint() -> None:
    """The sliding joint carries mu |sigma_N|: its quantiles are those of the normal distribution of mu."""
    count, sd, levels = 2000, 0.05, (0.05, 0.5, 0.95)
    law = case(FLAT)
    distribution = of_deviations(law.runs[0].props, {"mu": sd}, {})
    path = load_path(law.path, law.runs[0])
    spreads = spread(path, distribution, count, 1, np.array(levels), ThreadPoolExecutor(1))
    assert not spreads.out and len(spreads.results) == count
    for i, level in enumerate(levels):
        exact = 2.0 * NormalDist(0.5, sd).inv_cdf(level)
        # four standard errors of a quantile of `count` samples
        density = NormalDist(1.0, 2.0 * sd).pdf(exact)
        error = 4.0 * np.sqrt(level * (1.0 - level) / count) / density
        quantile = np.quantile(spreads.results[:, END], level)
        assert abs(quantile - exact) < error
        assert spreads.curves[i, -1, 0] == pytest.approx(quantile, rel=1e-6)
    assert spreads.case[1][END] == pytest.approx(1.0, rel=1e-9)


def test_correlations_of_the_samples() -> None:
    """Deviations and correlations of many samples are the given ones in any unit; the seed decides them."""
    drawn = []
    for unit in (1.0, 1e6):
        joint = Interface(Material(3.0 * unit, 0.3 * unit, 0.9, 0.5), Pattern.regular(4, 30.0))
        sizes = {"sigma0": 0.3 * unit, "mu": 0.05, "theta": 2.0}
        asked = of_deviations(joint.props(), sizes, {("mu", "theta"): -0.8, ("sigma0", "mu"): 0.5})
        drawn.append(asked.draw(20000, 7) / [unit, 1.0, 1.0])
    np.testing.assert_allclose(drawn[0].mean(axis=0), [3.0, 0.5, 30.0], rtol=0.005)
    np.testing.assert_allclose(drawn[0].std(axis=0), [0.3, 0.05, 2.0], rtol=0.03)
    assert np.corrcoef(drawn[0].T)[1] == pytest.approx([0.5, 1.0, -0.8], abs=0.02)
    np.testing.assert_allclose(drawn[1], drawn[0], rtol=1e-12)
    np.testing.assert_array_equal(asked.draw(9, 7), asked.draw(9, 7))
    assert not np.array_equal(asked.draw(9, 7), asked.draw(9, 8))


@pytest.mark.slow
def test_samples_of_a_fit_have_its_intervals(result: Fit) -> None:
    """The file of a fit gives samples whose intervals are as wide as those of the fit."""
    Path("case.fit.json").write_text(intervals_text(result))
    known = read(Path("case.fit.json"))
    drawn = known.draw(40000, 3)
    tails = [0.5 * (1.0 - CONFIDENCE), 0.5 * (1.0 + CONFIDENCE)]
    assert known.grade.startswith(result.grade) and {*known.names} == {*study.FREE}
    for i, name in enumerate(known.names):
        estimate = result.estimates[name]
        low, high = np.quantile(drawn[:, i], tails)
        # those of other assumptions have two sides, the samples are symmetric
        assert high - low == pytest.approx(estimate.high - estimate.low, rel=0.05)


@pytest.mark.parametrize(
    "text",
    [
        ROUGH + CYCLE,
        ROUGH + "&step s_N = 0.01, s_Tx = 0.05, increments = 40 /\n&step s_Ty = 0.02 /\n",
        LAW + "&pattern normals = 1, 0.5, 0, 1, -0.5, 0, weights = 0.4, 0.6 /\n" + CYCLE,
        ROUGH + "&step t_N = -1.0, increments = 10 /\n&step slip = 0.2, k_N = 5.0, increments = 20 /\n",
        (ROUGH + CYCLE).replace("kc", "tau_v = 0.5, kc"),
    ],
    ids=["slip", "opening", "listed", "spring", "viscous"],
)
def test_curves_are_those_of_the_driver(text: str) -> None:
    """Slip tests, prescribed paths, springs and viscous damage: the curves are the rows of the driver."""
    law = case(text)
    path, rows = load_path(law.path, law.runs[0]), drive(law.path)[None]
    values, work = path.curve(np.array(path.run.props))
    assert len(work) == len(path.x) <= len(rows) + 1 and path.x[0] == 0.0
    n = min(len(rows), len(path.x) if path.first >= 0 else len(path.x) - 1)
    for ours, theirs in (
        (values[:, 0], rows.traction @ path.e),
        (values[:, 1], rows.dilation),
        (work, rows.work),
        (path.x, rows.separation @ path.e),
    ):
        np.testing.assert_allclose(ours[-n:], theirs[-n:], rtol=0.0, atol=1e-9)


def test_samples_without_a_result_are_counted(said: Callable) -> None:
    """Samples out of range and without equilibrium are counted by reason, and the exit code is 3."""
    last, longer, count, sd = 0.02, 0.1, 400, 0.15
    law = case(LAW + f"&pattern sides = 0 /\n&step t_N = 2.0, increments = 5 /\n&step slip = {last} /\n")
    out, _ = said(f"uncertainty case.nml --sd Gc={sd} --samples {count} --jobs 1", 3)
    energies = of_deviations(law.runs[0].props, {"Gc": sd}, {}).draw(count, 0)
    refused = np.sum(energies <= 0.0)
    assert f"{refused} out of the range of Gc" in out
    # the slip at which equilibrium under tension is lost is proportional to s_f, and so to Gc
    slips = np.linspace(0.0, longer, 2001)
    with pytest.raises(EquilibriumLost) as lost:
        Interface(Material(3.0, 0.3, 0.9, 0.5), Pattern.regular(0, 0.0)).confined_slip(0.0, slips, 2.0)
    smallest = 0.3 * last / slips[lost.value.row]
    counted = re.search(r"(\d+) without equilibrium on the whole path", out)
    least, most = (np.sum(energies < (1.0 + near) * smallest) - refused for near in (-0.02, 0.02))
    assert counted and least <= int(counted[1]) <= most
    assert f"no result: {(refused + int(counted[1])) / count:.2%} of the samples have none" in out
    case(ROUGH + CYCLE)
    out, _ = said("uncertainty case.nml --sd 'eta=1e-4 theta=20' --samples 50 --jobs 1", 3)
    assert re.search(r"left out    \d+ out of the range of theta$", out, re.MULTILINE)


@pytest.mark.slow
def test_from_a_record_to_quantiles(result: Fit, said: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    """`fit -o` then `uncertainty`, with the same output for any number of jobs."""
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    case(case_of(result))
    Path("case.fit.json").write_text(intervals_text(result))
    command = "uncertainty case.nml --samples 100 -o out.csv"
    printed = [said(f"{command} --jobs {n} --plot {n}.png")[0].replace(f"{n}.png", "") for n in (1, 2)]
    assert printed[0] == printed[1] and printed[0].count("left out    sigma_N") == 3
    assert Path("1.png").read_bytes() == Path("2.png").read_bytes()
    rows = np.genfromtxt("out.csv", delimiter=",", names=True, deletechars="")
    assert {*rows["sigma_N"]} == {-1.0, -2.0, -4.0}
    low, high = (rows[f"traction_{level}"] for level in ("0.05", "0.95"))
    assert np.all(low <= high) and np.any(low < high)
    changed = json.loads(Path("case.fit.json").read_text())
    changed["values"][0] *= 1.01
    Path("case.fit.json").write_text(json.dumps(changed))
    _, message = said(command, 1)
    assert "is stale: " in message and "expected a case with the constants of the fit" in message


SOUND = {
    "parameters": ["mu"], "values": [0.5], "scales": [SCALES["mu"]], "covariance on the scales": [[0.01]],
    "model error of tau and s_N": [0.0, 0.0], "grade": "good", "no result": [], "not determined": [],
    "units": ["mm", "MPa"], "pressures": [1.0, 2.0], "slip": 3.0,
}  # fmt: skip


@pytest.mark.parametrize(
    "changed",
    [
        None,
        {"parameters": None},
        {"covariance on the scales": [[1, 2]]},
        {"covariance on the scales": [[-1]]},
        {"values": [float("nan")]},
        {"values": [10**400]},
        {"values": [-0.5]},
        {"values": [0.0]},
        {key: [] for key in ("parameters", "values", "scales", "covariance on the scales")},
        {"values": [True]},
        {"parameters": ["mean"]},
        {"parameters": ["mu", "mu"], "values": [0.5, 0.5], "scales": 2 * [SCALES["mu"]]},
        {"scales": ["linear"]},
        {"model error of tau and s_N": [-0.1, 0.0]},
        {"model error of tau and s_N": [0.1, np.nan]},
        {"not determined": "mu"},
        {key: 2 * SOUND[key] for key in ("parameters", "values", "scales")}
        | {"covariance on the scales": [[1, np.inf], [np.inf, 1]], "model error of tau and s_N": [0.0, 0.0]},
    ],
)
def test_file_that_is_none_of_a_fit(changed: dict[str, object] | None) -> None:
    """Another file than that of a fit is refused by its name."""
    path = Path("case.fit.json")
    path.write_text(json.dumps(SOUND))
    assert read(path).names == ("mu",)
    path.write_text("{" if changed is None else json.dumps(SOUND | changed))
    with pytest.raises(ValueError, match=r"case\.fit\.json: .*expected"):
        read(path)


@pytest.mark.parametrize("number", [np.inf, -np.inf, np.nan])
@pytest.mark.parametrize("key", ["covariance on the scales", "model error of tau and s_N"])
def test_scatter_without_bound_is_refused(key: str, number: float) -> None:
    """A covariance or model error that is not finite is named; a prediction and uncertainty read it alike."""
    path = Path("case.fit.json")
    path.write_text(json.dumps(SOUND | {key: [[number]] if key.startswith("cov") else [0.1, number]}))
    for reader in (read, written.read):
        with pytest.raises(ValueError, match=rf"case\.fit\.json: .*{key} = {number:g}: expected a number"):
            reader(path)

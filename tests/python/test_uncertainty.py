"""Command `asperity uncertainty`: closed forms, the chain from a fit, load paths of every kind, refusals."""

from __future__ import annotations

import csv
import json
import os
import re
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from statistics import NormalDist

import numpy as np
import pytest
from asperity import EquilibriumLost, Interface, Material, Pattern
from asperity.case_files import drive, read_case
from asperity.cli import main
from asperity.fit.fitting import fit
from asperity.fit.outcome import Fit, residual_ratio
from asperity.fit.report import case_of, covariance_text
from asperity.uncertainty.distribution import of_deviations, read
from asperity.uncertainty.paths import load_paths
from asperity.uncertainty.spread import RESULTS, spread

from harness.studies import synthetic as study

LAW = "&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5, kc = 100.0 /\n"
FLAT = LAW + "&pattern sides = 0 /\n&step t_N = -2.0, increments = 5 /\n&step slip = 0.6, increments = 60 /\n"
ROUGH = LAW + "&pattern sides = 4, theta = 30.0 /\n"
CYCLE = (
    "&step t_N = -1.0, increments = 20 /\n&step slip = 0.2, -0.2, direction = 30.0, increments = 20, 40 /\n"
)


@pytest.fixture
def case(tmp_path: Path):
    """Return a function that writes a case and reads it."""

    def write(text: str):
        path = tmp_path / "case.nml"
        path.write_text(text)
        return read_case(path)

    return write


@pytest.fixture(scope="module")
def found() -> Fit:
    """A fit of a synthetic record."""
    return fit(study.synthetic(0.03, 0), study.FREE, study.SET, starts=1)


def test_friction_of_a_flat_joint(case) -> None:
    """The sliding joint carries mu |sigma_N|: its quantiles are those of the normal distribution of mu."""
    count, sd, levels = 4000, 0.05, (0.05, 0.5, 0.95)
    distribution = of_deviations({"mu": 0.5}, {"mu": sd}, {})
    [path] = load_paths(case(FLAT))
    found = spread(path, ("mu",), distribution.draw(count, 1), levels, ThreadPoolExecutor(1))
    assert found.lost == 0 and not found.refused and len(found.results) == count
    end = found.results[:, RESULTS.index("traction at the end")]
    for i, level in enumerate(levels):
        exact = 2.0 * NormalDist(0.5, sd).inv_cdf(level)
        # four standard errors of a quantile of `count` samples
        density = NormalDist(1.0, 2.0 * sd).pdf(exact)
        error = 4.0 * np.sqrt(level * (1.0 - level) / count) / density
        assert abs(np.quantile(end, level) - exact) < error
        assert found.curves[i, -1, 0] == pytest.approx(np.quantile(end, level), rel=1e-6)
    assert found.case[1][RESULTS.index("traction at the end")] == pytest.approx(1.0, rel=1e-9)


def test_correlations_of_the_samples() -> None:
    """Mean, deviations and correlations of many samples are the given ones; the seed decides the samples."""
    sizes = {"sigma0": 0.3, "mu": 0.05, "theta": 2.0}
    values = {"sigma0": 3.0, "mu": 0.5, "theta": 30.0}
    asked = of_deviations(values, sizes, {("mu", "theta"): -0.8})
    drawn = asked.draw(20000, 7)
    np.testing.assert_allclose(drawn.mean(axis=0), list(values.values()), rtol=0.005)
    np.testing.assert_allclose(drawn.std(axis=0), list(sizes.values()), rtol=0.03)
    assert np.corrcoef(drawn.T)[1, 2] == pytest.approx(-0.8, abs=0.02)
    np.testing.assert_array_equal(drawn, asked.draw(20000, 7))
    assert not np.array_equal(drawn, asked.draw(20000, 8))


def test_units_do_not_change_samples() -> None:
    """Samples in other units are the same ones, also of constants of other units beside them."""
    drawn = []
    for unit in (1.0, 1e6):
        values = {"sigma0": 3.0 * unit, "mu": 0.5, "theta": 30.0}
        sizes = {"sigma0": 0.3 * unit, "mu": 0.05, "theta": 1.0}
        asked = of_deviations(values, sizes, {("mu", "theta"): -0.8, ("sigma0", "mu"): 0.5})
        drawn.append(asked.draw(20000, 7) / [unit, 1.0, 1.0])
    np.testing.assert_allclose(drawn[1], drawn[0], rtol=1e-12)
    assert np.corrcoef(drawn[1].T)[1, 2] == pytest.approx(-0.8, abs=0.02)


@pytest.mark.slow
def test_samples_of_a_fit_have_its_intervals(found: Fit, tmp_path: Path) -> None:
    """The file of a fit gives samples whose intervals are those of the fit, also of the residual ratio."""
    path = tmp_path / "case.fit.json"
    path.write_text(covariance_text(found))
    known = read(path)
    drawn = known.draw(40000, 3)
    tail = 0.5 * (1.0 - found.confidence)
    for i, name in enumerate(known.names):
        one = found.estimates[name]
        np.testing.assert_allclose(
            np.quantile(drawn[:, i], [tail, 1.0 - tail]), [one.low, one.high], rtol=0.01
        )
    ratios = [residual_ratio(found.values | dict(zip(known.names, row, strict=True))) for row in drawn[:4000]]
    one = found.of(residual_ratio)
    np.testing.assert_allclose(np.quantile(ratios, [tail, 1.0 - tail]), [one.low, one.high], rtol=0.01)


def test_curves_are_those_of_the_driver(case) -> None:
    """Slip tests, prescribed paths, springs and viscous damage: the curves are the rows of the driver."""
    spring = "&step t_N = -1.0, increments = 10 /\n&step slip = 0.2, k_N = 5.0, increments = 20 /\n"
    for text in (
        ROUGH + CYCLE,
        ROUGH + "&step s_N = 0.01, s_Tx = 0.05, increments = 40 /\n&step s_Ty = 0.02 /\n",
        LAW + "&pattern normals = 1, 0.5, 0, 1, -0.5, 0, weights = 0.4, 0.6 /\n" + CYCLE,
        ROUGH + spring,
        (ROUGH + CYCLE).replace("kc", "tau_v = 0.5, kc"),
    ):
        one = case(text)
        [path], rows = load_paths(one), drive(one.path)[None]
        values, work = path.curve(path.props)
        assert len(work) == len(path.x) <= len(rows) + 1
        n = min(len(rows), len(path.x) if path.first >= 0 else len(path.x) - 1)
        np.testing.assert_allclose(values[-n:, 0], rows.traction[-n:] @ path.e, rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(values[-n:, 1], rows.separation[-n:, 0], rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(work[-n:], rows.work[-n:], rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(path.x[-n:], rows.separation[-n:] @ path.e, rtol=0.0, atol=1e-12)
        assert path.x[0] == 0.0


def test_workers_make_no_difference(case) -> None:
    """Processes give the same bits as one process."""
    [path] = load_paths(case(ROUGH + CYCLE))
    samples = of_deviations({"mu": 0.5}, {"mu": 0.1}, {}).draw(600, 0)
    with ProcessPoolExecutor(2, get_context("spawn")) as processes:
        found = [spread(path, ("mu",), samples, (0.1, 0.9), one) for one in (None, processes)]
    np.testing.assert_array_equal(found[0].curves, found[1].curves)
    np.testing.assert_array_equal(found[0].results, found[1].results)


def test_samples_without_a_result_are_counted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Samples out of range and without equilibrium are counted by reason, and the exit code is 3."""
    path = tmp_path / "case.nml"
    last, longer = 0.02, 0.1
    path.write_text(LAW + f"&pattern sides = 0 /\n&step t_N = 2.0, increments = 5 /\n&step slip = {last} /\n")
    count, sd = 400, 0.15
    code = main(["uncertainty", str(path), "--sd", f"Gc={sd}", "--samples", str(count), "--jobs", "1"])
    out = capsys.readouterr().out
    assert code == 3
    energies = of_deviations({"Gc": 0.3}, {"Gc": sd}, {}).draw(count, 0)
    refused = np.sum(energies <= 0.0)
    assert f"{refused} out of the range of Gc" in out
    # the slip at which equilibrium under tension is lost is proportional to s_f, and so to Gc
    slips = np.linspace(0.0, longer, 2001)
    with pytest.raises(EquilibriumLost) as lost:
        Interface(Material(3.0, 0.3, 0.9, 0.5), Pattern.regular(0, 0.0)).confined_slip(0.0, slips, 2.0)
    smallest = 0.3 * last / slips[lost.value.row]
    found = re.search(r"(\d+) without equilibrium on the whole path", out)
    near = 0.02
    least, most = (np.sum(energies < (1.0 + side * near) * smallest) - refused for side in (-1.0, 1.0))
    assert found and least <= int(found[1]) <= most
    assert f"no result: {(refused + int(found[1])) / count:.2%} of the samples have none" in out


@pytest.mark.slow
def test_from_a_record_to_quantiles(
    found: Fit, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """`fit -o` then `uncertainty`, with the same output for any number of jobs."""
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    path, beside = tmp_path / "case.nml", tmp_path / "case.fit.json"
    path.write_text(case_of(found))
    beside.write_text(covariance_text(found))
    command = ["uncertainty", str(path), "--samples", "100", "-o", str(tmp_path / "out.csv")]
    printed = []
    for jobs in ("1", "2"):
        assert main([*command, "--jobs", jobs, "--plot", str(tmp_path / f"{jobs}.png")]) == 0
        printed.append(capsys.readouterr().out.replace(f"{jobs}.png", ""))
    assert printed[0] == printed[1]
    assert printed[0].count("left out    sigma_N") == 3
    assert (tmp_path / "1.png").read_bytes() == (tmp_path / "2.png").read_bytes()
    with (tmp_path / "out.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {row["sigma_N"] for row in rows} == {"-1", "-2", "-4"}
    low, high = (np.array([float(row[f"traction_{level}"]) for row in rows]) for level in ("0.05", "0.95"))
    assert np.all(low <= high) and np.any(low < high)
    changed = json.loads(beside.read_text())
    changed["values"][0] *= 1.01
    beside.write_text(json.dumps(changed))
    assert main(command) == 1
    message = capsys.readouterr().err
    assert "is stale: " in message and "expected a case with the constants of the fit" in message


@pytest.mark.parametrize(
    "content", ["{", "{}", '{"parameters": ["nu"], "values": [1], "transforms": [""], '
    '"covariance of the transformed values": [[1]]}', '{"parameters": ["mu"], "values": [1], "transforms": '
    '["log mu"], "covariance of the transformed values": [[1, 2]]}', '{"parameters": ["mu"], "values": [1], '
    '"transforms": ["log mu"], "covariance of the transformed values": [[-1]]}', '{"parameters": ["mu"], '
    '"values": [NaN], "transforms": ["log mu"], "covariance of the transformed values": [[1]]}'],
)  # fmt: skip
def test_file_that_is_none_of_a_fit(content: str, tmp_path: Path) -> None:
    """Another file than that of a fit is refused by its name."""
    path = tmp_path / "case.fit.json"
    path.write_text(content)
    with pytest.raises(ValueError, match=r"case\.fit\.json: expected"):
        read(path)


PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "uncertainty.md"

FEW = 400
"""Samples of the test of the page, which has 20000."""

DEVIATIONS = 5.0
"""Difference of two means that counts as none, in standard errors of the mean of FEW samples."""


@pytest.mark.long
def test_page(tmp_path: Path) -> None:
    """The commands of the page give its numbers: those of the case, and the mean within its error."""
    blocks = re.findall(
        r"```console\n(.*?)```\n[^`]*```text\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL
    )
    assert len(blocks) == 1
    for commands, shown in blocks:
        few = re.sub(r"--samples \d+", f"--samples {FEW}", commands)
        path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
        run = subprocess.run(
            ["sh", "-ec", few],
            capture_output=True,
            text=True,
            cwd=tmp_path,
            env=os.environ | {"PATH": path, "PYTHONPATH": str(PAGE.parents[2])},
            check=True,
        )
        rows = [
            [line for line in text.splitlines() if line.startswith(RESULTS)] for text in (shown, run.stdout)
        ]
        # the page has the first of three pressures
        assert 3 * len(rows[0]) == len(rows[1]) == 3 * len(RESULTS)
        for old, new in zip(*rows, strict=False):
            assert old[:22] == new[:22]
            (case, mean, sd, *_), (own, found, *_) = (map(float, line[22:].split()) for line in (old, new))
            assert own == pytest.approx(case, rel=1e-3)
            # the fifth digit is rounded
            assert abs(found - mean) < DEVIATIONS * sd / np.sqrt(FEW) + 1e-4 * abs(mean)

"""Tests of the program of the speed charts on the output of a real run of the benchmark."""

from __future__ import annotations

import csv
import subprocess
from pathlib import Path

import matplotlib.image
import pytest

from harness.studies import speed as charts
from harness.studies.timings import BENCH

PLANES = {"2 planes": 2, "RT": 3} | {f"RP-{m}": m + 1 for m in (3, 4, 6, 8, 16, 32, 63)}
"""Planes of the patterns: inclined ones and, but for the first, the flat one."""

FACETS = {"RP-4 HW0": 5, "RT H": 3} | {f"RP-{m} H": m + 1 for m in (4, 8, 16, 32)}
"""Planes of the patterns with a finite height; the first has wear, too."""

pytestmark = pytest.mark.long

FIVE = ("RT", "RP-3", "RP-4", "RP-6", "RP-32")


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the path of the CSV of a short run."""
    path = tmp_path_factory.mktemp("bench") / "bench.csv"
    subprocess.run([BENCH, "--csv", path, "--quick"], check=True, capture_output=True)
    return path


def test_rows(measured: Path) -> None:
    """The CSV has the promised rows for every pattern.

    These are single points, blocks in both precisions, both with and without tangent, and the lower limits.
    """
    timings = charts.read_timings(measured)
    assert {t.pattern: t.planes for t in timings} == PLANES | FACETS
    assert all(t.ns_per_point > 0.0 for t in timings)
    have = {(t.pattern, t.kernel, t.precision, t.tangent) for t in timings}
    double = "double"
    for pattern in PLANES:
        assert {(pattern, "textbook", double, t) for t in (True, False)} <= have
        assert {(pattern, kernel, double, True) for kernel in ("point", "umat", "test")} <= have
        for precision in (double, "single"):
            assert {(pattern, "block", precision, t) for t in (True, False)} <= have
            assert (pattern, "roots", precision, False) in have
            limits = {(pattern, kernel, precision, False) for kernel in ("vumat", "stream")}
            assert limits <= have if pattern in FIVE else not limits & have
    assert {t.states for t in timings} == {"slip", "all slip", "zones", "scattered"}
    assert {("RP-4", kernel, double, False) for kernel in ("points", "copy")} <= have


@pytest.mark.parametrize("name", ["speed.png", "speed.pdf"])
def test_chart_of_a_file(
    name: str, measured: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The command draws a CSV; the picture has the format of its file name extension."""
    output = tmp_path / name
    assert charts.main([str(measured), "-o", str(output)]) == 0
    assert capsys.readouterr().out == f"{output}\n"
    assert output.read_bytes().startswith(b"%PDF" if name.endswith("pdf") else b"\x89PNG")


def test_chart_runs_the_benchmark(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Without a CSV the command runs the benchmark, which prints its table."""
    output = tmp_path / "speed.png"
    assert charts.main(["--quick", "-o", str(output)]) == 0
    image = matplotlib.image.imread(output)
    assert image.shape[0] > 500 and image[..., :3].min() < 0.1 < 0.9 < image[..., :3].max()
    assert "ns/point" in capfd.readouterr().out


def test_table(measured: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The table has one row for each pattern with the times of the CSV."""
    assert charts.main([str(measured), "--table", "-o", str(tmp_path / "speed.png")]) == 0
    head, _, *lines = (line.strip("|").split("|") for line in capsys.readouterr().out.splitlines()[:-1])
    rows = {line[0].strip(): dict(zip(head[1:], line[1:], strict=True)) for line in lines}
    assert {row[" kernels "].strip() for row in rows.values()} <= {"portable", "AVX2", "one set of kernels"}
    assert {name: int(row[" planes "]) for name, row in rows.items()} == PLANES | FACETS
    with measured.open(encoding="utf-8", newline="") as file:
        single = {
            row["pattern"]: f"{float(row['ns_per_point']):.1f}"
            for row in csv.DictReader(file)
            if (row["kernel"], row["precision"], row["tangent"], row["states"])
            == ("block", "single", "no", "slip")
        }
    assert {name: row[" block, single "].strip() for name, row in rows.items()} == single


@pytest.mark.parametrize(
    ("text", "arguments", "expected"),
    [
        ("a,b\n1,2\n", [], "bench.csv: expected a CSV written by bench --csv"),
        ("pattern,planes\n", [], "bench.csv: expected rows written by bench --csv"),
        ("a,b\n1,2\n", ["--quick"], "--quick: expected without"),
    ],
)
def test_wrong_csv(
    text: str, arguments: list[str], expected: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The error message names a file that is not an output of the benchmark."""
    path = tmp_path / "bench.csv"
    path.write_text(text, encoding="utf-8")
    assert charts.main([str(path), "-o", str(tmp_path / "x.png"), *arguments]) == 1
    assert expected in capsys.readouterr().err


def test_wrong_argument_of_bench() -> None:
    """The error message of the benchmark names an unknown argument."""
    done = subprocess.run([BENCH, "--fast"], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr.startswith("bench: --fast: expected --csv FILE, --quick or --profile")

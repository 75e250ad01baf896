"""Programs that write the results pages: their numbers at small sizes, pictures and tables."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from refresh import words_and_numbers

from harness.studies import accuracy, concepts, speed
from harness.studies.stability import symmetric
from harness.studies.stability.__main__ import main as stability
from harness.studies.stability.branches import steep_snap
from harness.studies.stability.entries import MODES, TABLE_2, as_expected

DOCS = Path(__file__).parents[2] / "docs"


def is_drawn(path: Path) -> bool:
    """Whether a picture has a size and shows something dark on white."""
    image = matplotlib.image.imread(path)
    return image.shape[0] > 400 and image[..., :3].min() < 0.3 and image[..., :3].max() > 0.9


# --- accuracy -----------------------------------------------------------------------------------------------


def test_errors_fall_with_the_increments() -> None:
    """All errors decrease with eight times as many increments; tractions converge at about first order."""
    errors = list(accuracy.step_errors((60, 480)).itertuples())
    assert len(errors) == 2 * len(accuracy.PATHS) * len(accuracy.SIGMA_N)
    for coarse, fine in zip(errors[::2], errors[1::2], strict=True):
        assert (coarse.path, coarse.sigma_N) == (fine.path, fine.sigma_N)
        assert (coarse.rows, fine.rows) == (60, 480)
        for name in ("tau_L", "s_N", "work"):
            assert 0.0 < getattr(fine, name) < getattr(coarse, name) < 0.5
        assert fine.tau_L < 0.35 * coarse.tau_L or coarse.sigma_N == 0.0


@pytest.mark.long
@pytest.mark.parametrize("study", accuracy.STUDIES)
def test_chart_of_accuracy(study: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The command draws the picture of a study and writes its tables between the markers of a page."""
    page = tmp_path / "page.md"
    page.write_text(f"before\n<!-- accuracy-{study} -->\nold\n<!-- /accuracy-{study} -->\nafter\n")
    arguments = ["--only", study, "--quick", "--page", str(page), "--folder", str(tmp_path / "new")]
    assert accuracy.main(arguments) == 0
    [picture] = (tmp_path / "new").iterdir()
    assert picture.name == f"accuracy_{study}.png" in capsys.readouterr().out and is_drawn(picture)
    text = page.read_text(encoding="utf-8")
    assert text.startswith("before\n<!-- accuracy-") and text.endswith("-->\nafter\n")
    assert "old" not in text and "| --- |" in text and "nan" not in text


# --- concepts -----------------------------------------------------------------------------------------------


@pytest.mark.long
def test_pictures_of_concepts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The command draws every picture; each is committed and shown on a page."""
    assert concepts.main(["--folder", str(tmp_path)]) == 0
    drawn = [Path(line) for line in capsys.readouterr().out.splitlines()]
    assert [path.stem for path in drawn] == list(concepts.PICTURES)
    names = ("concepts.md", "solver.md", "extensions.md")
    pages = "".join((DOCS / name).read_text(encoding="utf-8") for name in names)
    for path in drawn:
        assert path.stat().st_size > 10000 and (DOCS / "images" / path.name).is_file()
        assert f"(images/{path.name})" in pages


# --- catalogue of failure modes -----------------------------------------------------------------------------


@pytest.mark.parametrize("name", MODES)
def test_failure_and_survival(name: str) -> None:
    """One method fails and another one does not, and the page has the section of the entry.

    Compilers round differently, which changes numbers of iterations and errors.
    """
    mode = MODES[name]
    trials = mode.run()
    assert as_expected(trials)
    page = (DOCS / "results" / "stability.md").read_text(encoding="utf-8")
    [(entries)] = re.findall(r"<!-- stability -->\n(.*?)\n<!-- /stability -->", page, re.DOTALL)
    [section] = re.findall(rf"^### {name}\n[\s\S]*?(?=\n\n### |\Z)", entries, re.MULTILINE)
    (words, counted), (known, shown) = map(words_and_numbers, (mode.section(trials), section))
    ours, theirs = np.array(counted), np.array(shown)
    assert words == known
    ratio = np.divide(ours, theirs, out=np.ones_like(ours), where=np.abs(theirs) > 1e-9)
    assert np.all((ratio >= 0.5) & (ratio <= 2.0)) and np.all(np.abs(ours[theirs == 0.0]) < 1e-9)


def test_a_snap_is_drawn(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """An entry is printed and drawn; the area between jump and branch is released or dissipated."""
    # the chart beside it, of which nothing is asked here, is one of few joints
    monkeypatch.setattr(symmetric, "FRICTION", symmetric.FRICTION[::5])
    monkeypatch.setattr(symmetric, "SLOPES", symmetric.SLOPES[::6])
    monkeypatch.setattr(symmetric, "DRAWN", 100)
    assert stability(["--only", "snap", "--folder", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert f"{tmp_path / 'stability_snap.png'}" in printed and "- *Fails:* plain Newton, RP-16" in printed
    assert is_drawn(tmp_path / "stability_snap.png")
    # the motion of the jump is accurate to 3e-4 K s_0^2
    for mu, within in ((0.0, 3e-4), (0.5, 0.01)):
        snap = steep_snap(mu)
        lost = snap.released + (snap.dissipated_more if mu else 0.0)
        assert snap.area == pytest.approx(lost, abs=within * TABLE_2.K * TABLE_2.s_0**2)
        assert len(snap.turns) == 2


# --- speed --------------------------------------------------------------------------------------------------


@pytest.mark.long
def test_benchmark_is_drawn(tmp_path: Path) -> None:
    """The CSV of a short run has the times of all patterns and kernels that the picture shows."""
    measured = tmp_path / "bench.csv"
    subprocess.run([speed.BENCH, "--csv", measured, "--quick"], check=True, capture_output=True)
    assert (speed.read_timings(measured).ns_per_point > 0.0).all()
    for name, start in (("speed.png", b"\x89PNG"), ("speed.pdf", b"%PDF")):
        assert speed.main([str(measured), "-o", str(tmp_path / name)]) == 0
        assert (tmp_path / name).read_bytes().startswith(start)

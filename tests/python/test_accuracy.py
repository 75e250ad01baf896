"""Tests of the work-precision studies at small sizes, and of the page with their results."""

from __future__ import annotations

from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from asperity import Interface, Pattern
from asperity.slip_curves import slip_curves

from harness.studies import accuracy

DOCS = Path(__file__).parents[2] / "docs"

PICTURES = {
    "increments": ["increments"],
    "planes": ["planes"],
    "materials": ["materials"],
}
"""Pictures of each study."""


def test_paths() -> None:
    """The slip paths have equal increments, the prescribed end points, and rows at the reversals."""
    np.testing.assert_allclose(accuracy.monotonic(3), [0.2, 0.4, 0.6], rtol=0.0, atol=1e-15)
    slips = accuracy.cycle(20)
    assert len(slips) == 20
    assert np.ptp(np.abs(np.diff(slips, prepend=0.0))) < 1e-15
    np.testing.assert_allclose(slips[[3, 11, 19]], [0.4, -0.4, 0.4], rtol=0.0, atol=1e-15)


def test_errors_fall_with_the_increments() -> None:
    """All errors decrease with eight times as many increments; tractions converge at about first order."""
    errors = list(accuracy.step_errors((60, 480)))
    assert len(errors) == 2 * len(accuracy.PATHS) * len(accuracy.SIGMA_N)
    for coarse, fine in zip(errors[::2], errors[1::2], strict=True):
        assert (coarse.path, coarse.sigma_N, coarse.rows) == (fine.path, fine.sigma_N, 60)
        assert fine.rows == 480
        for name in ("tau_L", "s_N", "work"):
            assert 0.0 < getattr(fine, name) < getattr(coarse, name) < 0.5
        assert fine.tau_L < 0.35 * coarse.tau_L or coarse.sigma_N == 0.0


@pytest.mark.parametrize("sides", [4, 8])
def test_residual_is_that_of_a_long_slip(sides: int) -> None:
    """The closed form of the residual strength agrees with the traction after a slip of 40 s_f.

    The pressure is small.  The slip directions are up the slope of a plane and midway between two planes.
    """
    interface = Interface(accuracy.material(), Pattern.regular(sides, 30.0))
    angles = np.array([0.0, 180.0 / sides])
    found = slip_curves(interface, angles, np.linspace(0.0, 8.0, 801)[1:], -0.5)
    strengths = 0.5 * interface.material.residual_strength(30.0, angles)
    np.testing.assert_allclose(found.tau_L[:, -1], strengths, rtol=1e-9)
    spread = found.tau_L[0, -1] / found.tau_L[1, -1] - 1.0
    assert accuracy.residual_spread(sides, 30.0, 0.5) == pytest.approx(spread, rel=1e-7)
    assert spread == pytest.approx({4: 0.256, 8: 0.058}[sides], abs=5e-4)  # docs/theory.md, section 8


def test_reference_is_isotropic_and_odd_patterns_cancel_in_loops() -> None:
    """The errors of RP-64 are small; loops of RP-7 spread less than those of RP-6 and RP-8."""
    chosen = (6, 7, 8, 64)
    found = {e.sides: e for e in accuracy.plane_errors(chosen, tractions=(-1.0,))}
    assert max(found[64].tau_L, found[64].across, found[64].s_N) < 2e-3
    assert found[7].loop < 0.6 * min(found[6].loop, found[8].loop)
    assert found[6].tau_L > 10.0 * found[64].tau_L > 0.0
    none = next(accuracy.plane_errors(chosen[:1], tractions=(0.0,)))
    assert np.isnan(none.loop) and none.work == pytest.approx(0.0030, abs=2e-4)  # docs/theory.md, RP-6


@pytest.mark.long
@pytest.mark.parametrize("study", accuracy.STUDIES)
def test_chart(study: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The command draws the pictures of a study and writes its tables between the markers of a page."""
    page = tmp_path / "page.md"
    page.write_text(f"before\n<!-- accuracy-{study} -->\nold\n<!-- /accuracy-{study} -->\nafter\n")
    arguments = ["--only", study, "--quick", "--page", str(page), "--folder", str(tmp_path / "new")]
    assert accuracy.main(arguments) == 0
    names = [f"accuracy_{stem}.png" for stem in PICTURES[study]]
    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == names
    assert all(name in capsys.readouterr().out for name in names[:1])
    for name in names:
        image = matplotlib.image.imread(tmp_path / "new" / name)
        assert image.shape[0] > 400 and image[..., :3].min() < 0.3
    text = page.read_text(encoding="utf-8")
    assert text.startswith("before\n<!-- accuracy-") and text.endswith("-->\nafter\n")
    assert "old" not in text and "| --- |" in text and "nan" not in text


def test_chart_without_a_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without a page the tables are printed; with --pdf the pictures are vector graphics."""
    options = ["--only", "increments", "--quick", "--pdf", "--folder", str(tmp_path)]
    assert accuracy.main(options) == 0
    assert "| monotonic | 0 |" in capsys.readouterr().out
    assert (tmp_path / "accuracy_increments.pdf").read_bytes().startswith(b"%PDF")


def test_page_without_markers(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The error message names a page that has no markers."""
    page = tmp_path / "page.md"
    page.write_text("text\n")
    assert accuracy.main(["--page", str(page), "--folder", str(tmp_path)]) == 1
    assert "page.md: expected markers such as <!-- accuracy-planes -->" in capsys.readouterr().err


def test_page_of_the_docs_is_filled() -> None:
    """The page in docs has the tables and pictures of every study."""
    text = (DOCS / "results" / "accuracy.md").read_text(encoding="utf-8")
    for study in accuracy.STUDIES:
        inside = text.split(f"<!-- accuracy-{study} -->")[1].split(f"<!-- /accuracy-{study} -->")[0]
        assert inside.count("\n|") > 3
        for stem in PICTURES[study]:
            assert f"(../images/accuracy_{stem}.png)" in text
            assert (DOCS / "images" / f"accuracy_{stem}.png").is_file()

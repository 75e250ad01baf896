"""Tests of the work-precision studies at small sizes, and of the page with their results."""

from __future__ import annotations

from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from asperity import Interface, Material, Pattern
from asperity.slip_curves import slip_curves

from harness.studies.accuracy import __main__ as command
from harness.studies.accuracy import common, increments, planes, precision, tangents

DOCS = Path(__file__).parents[2] / "docs"

PICTURES = {
    "increments": ["adaptive", "increments"],
    "planes": ["planes", "spread"],
    "materials": ["materials"],
    "precision": ["precision"],
    "tangents": ["tangents"],
}
"""Pictures of each study."""


def test_paths() -> None:
    """The slip paths have equal increments, the prescribed end points, and rows at the reversals."""
    np.testing.assert_allclose(common.monotonic(3), [0.2, 0.4, 0.6], rtol=0.0, atol=1e-15)
    slips = common.cycle(20)
    assert len(slips) == 20
    assert np.ptp(np.abs(np.diff(slips, prepend=0.0))) < 1e-15
    np.testing.assert_allclose(slips[[3, 11, 19]], [0.4, -0.4, 0.4], rtol=0.0, atol=1e-15)


def test_errors_fall_with_the_increments() -> None:
    """All errors decrease with eight times as many increments; tractions converge at about first order."""
    errors = list(increments.step_errors((60, 480), (), repeats=1))
    assert len(errors) == 2 * len(common.PATHS) * len(common.SIGMA_N)
    for coarse, fine in zip(errors[::2], errors[1::2], strict=True):
        assert (coarse.path, coarse.sigma_N, coarse.rows) == (fine.path, fine.sigma_N, 60)
        assert fine.rows == 480 and fine.seconds > 0.0
        for name in ("tau_L", "s_N", "work", "line"):
            assert 0.0 < getattr(fine, name) < getattr(coarse, name) < 0.5
        assert fine.tau_L < 0.35 * coarse.tau_L or coarse.sigma_N == 0.0


def test_adaptive_increments_draw_the_curve_with_fewer_rows() -> None:
    """The curve stays within 1.5 times the tolerance with fewer rows than fixed increments need."""
    errors = list(increments.step_errors((480,), (1e-3,), repeats=1))
    for fixed, adaptive in zip(errors[::2], errors[1::2], strict=True):
        assert (fixed.tolerance, adaptive.tolerance) == (0.0, 1e-3)
        assert adaptive.line < 1.5e-3 and adaptive.rows < 350


@pytest.mark.parametrize("sides", [3, 4, 5])
def test_rings_of_equal_inclination_are_the_regular_pattern(sides: int) -> None:
    """A ring of m planes and a ring of m planes rotated by 180/m degrees form RP-2m."""
    rings = planes.two_rings(sides, 30.0, 0.0).pattern
    regular = Pattern.regular(2 * sides, 30.0, turn=180.0)
    order = np.lexsort(np.round(rings.normals, 12).T), np.lexsort(np.round(regular.normals, 12).T)
    np.testing.assert_allclose(rings.normals[order[0]], regular.normals[order[1]], rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(rings.weights[order[0]], regular.weights[order[1]], rtol=1e-14)


@pytest.mark.parametrize("sides", [4, 8])
def test_residual_is_that_of_a_long_slip(sides: int) -> None:
    """The closed form of the residual strength agrees with the traction after a slip of 40 s_f.

    The pressure is small.  The slip directions are up the slope of a plane and midway between two planes.
    """
    interface = Interface(common.material(), Pattern.regular(sides, 30.0))
    angles = np.array([0.0, 180.0 / sides])
    found = slip_curves(interface, angles, np.linspace(0.0, 8.0, 801)[1:], -0.5)
    strengths = 0.5 * interface.material.residual_strength(30.0, angles)
    np.testing.assert_allclose(found.tau_L[:, -1], strengths, rtol=1e-9)
    spread = found.tau_L[0, -1] / found.tau_L[1, -1] - 1.0
    assert planes.residual_spread(sides, 30.0, 0.5) == pytest.approx(spread, rel=1e-7)
    assert spread == pytest.approx({4: 0.256, 8: 0.058}[sides], abs=5e-4)  # docs/theory.md, section 8


def test_reference_is_isotropic_and_odd_patterns_cancel_in_loops() -> None:
    """The errors of RP-64 are small; loops of RP-7 spread less than those of RP-6 and RP-8."""
    chosen = [planes.regular(m, 30.0) for m in (6, 7, 8, 64)]
    found = {e.sides: e for e in planes.plane_errors(chosen, 30.0, 0.5, (-1.0,), repeats=1)}
    assert max(found[64].tau_L, found[64].across, found[64].s_N) < 2e-3
    assert found[7].loop < 0.6 * min(found[6].loop, found[8].loop)
    assert found[6].tau_L > 10.0 * found[64].tau_L > 0.0
    none = next(planes.plane_errors(chosen[:1], 30.0, 0.5, (0.0,), repeats=1))
    assert np.isnan(none.loop) and none.work == pytest.approx(0.0030, abs=2e-4)  # docs/theory.md, RP-6


def test_pareto() -> None:
    """The Pareto front holds the points for which no other point is better in both values."""
    points = [(1.0, 5.0), (2.0, 5.0), (2.0, 3.0), (3.0, 4.0), (4.0, 1.0)]
    assert planes.pareto(points) == [(1.0, 5.0), (2.0, 3.0), (4.0, 1.0)]


def test_compensation_cures_the_sums() -> None:
    """In single precision compensated sums of the increments are more accurate than plain sums.

    This applies to the separation and to the energies.
    """
    found = {(d.pattern, d.way): d for d in precision.drifts(100_000, 20_000)}
    total, added, kept = (found["RP-4", way] for way in precision.WAYS.values())
    assert added.traction[-1] > 30.0 * kept.traction[-1]
    assert max(total.traction[-1], kept.traction[-1]) < 5e-6  # about K s eps divided by the traction
    assert min(total.work[-1], added.work[-1]) > 3.0 * kept.work[-1]
    flat = [found["flat", way].traction[-1] for way in precision.WAYS.values()]
    assert max(flat) < 1e-4


def test_error_grows_with_the_slip() -> None:
    """The error grows as eps K s, unless gap and elastic part of the slip are the stored variables."""
    found = {d.way: d for d in precision.distances(2000, 100.0)}
    total, carried = found[precision.WAYS[1]], found[precision.CARRIED]
    early = np.searchsorted(total.slip, 10.0)
    assert total.traction[-1] > 3.0 * total.traction[early]
    assert carried.traction[-1] < 0.3 * total.traction[-1]
    assert 0.0 < carried.traction[-1] < 1e-4


def test_single_precision_refuses_constants_beyond_it() -> None:
    """An error status of the single-precision library raises a ValueError."""
    interface = Interface(Material(1e25, 1e25, 0.9, 0.5), Pattern.regular(0, 0.0))
    with pytest.raises(ValueError, match="within the range of single precision"):
        precision.single_replay(interface, 1, np.zeros((1, 3)), 1)


def test_tangents() -> None:
    """Every tangent reaches the tolerance; the consistent tangent needs fewer than half the iterations.

    The numerical tangent needs as many as the consistent one.
    """
    runs = {t: tangents.tangent_run(t, -5.0, 20, 1e-10, 1) for t in tangents.TANGENTS}
    assert all(run.end == "converged" and run.residuals[-1] <= 1e-10 for run in runs.values())
    consistent = runs["consistent"]
    assert 2.0 < consistent.mean < 5.0
    assert all(runs[t].mean > 2.0 * consistent.mean for t in ("symmetrised", "secant", "elastic"))
    assert runs["numerical"].mean == pytest.approx(consistent.mean, abs=0.5)


@pytest.mark.slow
@pytest.mark.parametrize("study", command.STUDIES)
def test_chart(study: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The command draws the pictures of a study and writes its tables between the markers of a page."""
    page = tmp_path / "page.md"
    page.write_text(f"before\n<!-- accuracy-{study} -->\nold\n<!-- /accuracy-{study} -->\nafter\n")
    arguments = ["--only", study, "--quick", "--page", str(page), "--folder", str(tmp_path / "new")]
    assert command.main([*arguments]) == 0
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
    options = ["--only", "tangents", "--quick", "--pdf", "--folder", str(tmp_path)]
    assert command.main([*options]) == 0
    assert "| consistent |" in capsys.readouterr().out
    assert (tmp_path / "accuracy_tangents.pdf").read_bytes().startswith(b"%PDF")


def test_page_without_markers(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The error message names a page that has no markers."""
    page = tmp_path / "page.md"
    page.write_text("text\n")
    assert command.main(["--page", str(page), "--folder", str(tmp_path)]) == 1
    assert "page.md: expected markers such as <!-- accuracy-planes -->" in capsys.readouterr().err


def test_page_of_the_docs_is_filled() -> None:
    """The page in docs has the tables and pictures of every study."""
    text = (DOCS / "results" / "accuracy.md").read_text(encoding="utf-8")
    for study in command.STUDIES:
        inside = text.split(f"<!-- accuracy-{study} -->")[1].split(f"<!-- /accuracy-{study} -->")[0]
        assert inside.count("\n|") > 3
        for stem in PICTURES[study]:
            assert f"(../images/accuracy_{stem}.png)" in text
            assert (DOCS / "images" / f"accuracy_{stem}.png").is_file()

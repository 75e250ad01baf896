"""Tests of the work-precision studies at small sizes, and of the page with their results."""

from __future__ import annotations

from pathlib import Path

import matplotlib.image
import pytest

from harness.studies import accuracy

DOCS = Path(__file__).parents[2] / "docs"

PICTURES = {
    "increments": ["increments"],
    "planes": ["planes"],
}
"""Pictures of each study."""


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

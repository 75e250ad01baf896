"""Tests of the style of the pictures: labels at curves, curves that coincide, files."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import matplotlib
import matplotlib.image
import numpy as np
import pytest
from asperity import Interface, Material, Pattern, plot
from asperity.curve_pictures import curves, merged
from asperity.plots import figure_of
from asperity.style import DPI, TWO, label_ends, new_figure, printed, save
from matplotlib.text import Annotation


def boxes(ends: list[float], log: bool = False) -> list[tuple[float, float]]:
    """Lower and upper edge of the labels of curves with these ends, from the lowest label up, pixels."""
    with printed():
        figure, (ax,) = new_figure(3.5, 2.5)
        for i, end in enumerate(ends):
            ax.plot([1.0, 2.0], [1.0, end], label=f"curve {i}")
        if log:
            ax.set_yscale("log")
        label_ends(ax, "unit")
        figure.draw_without_rendering()
        texts = [text for text in ax.texts if isinstance(text, Annotation)]
        assert [text.get_text() for text in texts] == [*(f"curve {i}" for i in range(len(ends))), "unit"]
        found = [text.get_window_extent() for text in texts]
    return sorted((box.y0, box.y1) for box in found)


@pytest.mark.parametrize("log", [False, True])
@pytest.mark.parametrize("ends", [[1.0, 1.0, 1.0, 5.0], [2.0, 4.0, 3.0], [1.0, 1.01, 9.0, 8.99, 8.98]])
def test_labels_do_not_overlap(ends: list[float], log: bool) -> None:
    """Labels of curves that end at one point or close to each other do not overlap."""
    assert all(upper <= lower + 0.5 for (_, upper), (lower, _) in pairwise(boxes(ends, log)))


def test_curves_that_coincide_are_one() -> None:
    """Two equal curves become one with both names; a curve that differs by 1 % stays."""
    x = np.linspace(0.0, 1.0, 11)
    lines = [("0", x, x, False), ("45", x, 1.01 * x, False), ("90", x, x, False)]
    assert [line[0] for line in merged(lines)] == ["0, 90", "45"]
    assert [line[0] for line in merged([lines[0], ("45", x, x, False), lines[2]])] == ["0 to 90"]
    # one of them ends because equilibrium is lost
    assert len(merged([lines[0], ("90", x, x, True)])) == 2


def test_arrows_along_a_path_with_reversals() -> None:
    """Each of the three branches of a cycle has an arrow that points along it; a monotonic path has none."""
    _, (ax,) = new_figure(3.5, 2.5)
    x = np.concatenate([np.linspace(0, 1, 11), np.linspace(0.8, -1, 10), np.linspace(-0.8, 1, 10)])
    curves(ax, [("", x, x, False)], "", "")
    arrows = [text for text in ax.texts if isinstance(text, Annotation)]
    assert [np.sign(arrow.xy[0] - arrow.xyann[0]) for arrow in arrows] == [1.0, -1.0, 1.0]
    _, (ax,) = new_figure(3.5, 2.5)
    curves(ax, [("", x[:11], x[:11], False)], "", "")
    assert not ax.texts


@pytest.mark.parametrize("ending", [".png", ".pdf"])
def test_files(ending: str, tmp_path: Path) -> None:
    """A picture has the width of two columns; the same picture gives the same bytes."""
    names = [tmp_path / f"one{ending}", tmp_path / f"other{ending}"]
    for name in names:
        with printed():
            figure, (ax,) = new_figure(TWO, 2.0)
            ax.plot([0.0, 1.0], [0.0, 1.0])
            save(figure, name)
    assert names[0].read_bytes() == names[1].read_bytes()
    if ending == ".png":
        assert matplotlib.image.imread(names[0]).shape[1] == round(TWO * DPI)


def test_other_formats_are_refused(tmp_path: Path) -> None:
    """A picture of an unknown format is refused with the formats that are known, and nothing is written."""
    figure, _ = new_figure(1.0, 1.0)
    with pytest.raises(ValueError, match=r"x\.jpg: expected a name that ends in \.png or \.pdf"):
        save(figure, tmp_path / "x.jpg")
    assert not list(tmp_path.iterdir())


def test_settings_of_the_caller_stay() -> None:
    """Drawing a history changes no setting of Matplotlib outside."""
    before = dict(matplotlib.rcParams)
    joint = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=20.0), Pattern.regular(2, 30.0))
    history = joint.confined_slip(0.0, np.linspace(0.0, 0.1, 11), -0.5)
    plot(history)
    assert dict(matplotlib.rcParams) == before


LISTED = Pattern.planes([(1, 0, 0), (1, 0.2, 0)], [0.5, 0.5])


@pytest.mark.parametrize(
    "pattern", [Pattern.regular(0, 0.0), Pattern.regular(2, 45.0), Pattern.regular(6, 5.0), LISTED]
)
def test_geometry_beside_the_curves(pattern: Pattern) -> None:
    """Regular patterns have a panel with kc; a list of planes has none."""
    joint = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.2, kc=7.0), pattern)
    rows = joint.confined_slip(0.0, np.linspace(0.0, 0.01, 3), -0.5)
    figure = figure_of({None: rows}, "", "", "mm", "MPa", joint)
    texts = [text.get_text() for ax in figure.axes for text in ax.texts]
    assert any("kc = 7" in text for text in texts) == (pattern.m >= 0)

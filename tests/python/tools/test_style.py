"""Style of the pictures: labels at curves, curves that coincide, arrows, geometry, files."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from asperity import Interface, Material, Pattern
from asperity.tools.plots import figure_of
from asperity.tools.style import label_ends, merged, new_figure, printed
from matplotlib.axes import Axes
from matplotlib.text import Annotation

X = np.linspace(0.0, 1.0, 11)


def notes(ax: Axes) -> list[Annotation]:
    """Labels and arrows of axes."""
    return [text for text in ax.texts if isinstance(text, Annotation)]


@pytest.mark.parametrize("log", [False, True])
@pytest.mark.parametrize("ends", [[1.0, 1.0, 1.0, 5.0], [2.0, 4.0, 3.0], [1.0, 1.01, 9.0, 8.99, 8.98]])
def test_labels_do_not_overlap(ends: list[float], log: bool) -> None:
    """Labels of curves that end at one point or close to each other do not overlap."""
    with printed():
        figure, (ax,) = new_figure(3.5, 2.5)
        for i, end in enumerate(ends):
            ax.plot([1.0, 2.0], [1.0, end], label=f"curve {i}")
        if log:
            ax.set_yscale("log")
        label_ends(ax, "unit")
        figure.draw_without_rendering()
        assert [text.get_text() for text in notes(ax)] == [*(f"curve {i}" for i in range(len(ends))), "unit"]
        boxes = sorted((box.y0, box.y1) for box in (text.get_window_extent() for text in notes(ax)))
    assert all(upper <= lower + 0.5 for (_, upper), (lower, _) in pairwise(boxes))


def test_curves_that_coincide_are_one() -> None:
    """Two equal curves become one with both names; a curve that differs by 1 % stays."""
    curve, apart, same = ("0", X, X, False), ("45", X, 1.01 * X, False), ("90", X, X, False)
    assert [line[0] for line in merged([curve, apart, same])] == ["0, 90", "45"]
    assert [line[0] for line in merged([curve, ("45", X, X, False), same])] == ["0 to 90"]
    # one of them ends because equilibrium is lost
    assert len(merged([curve, ("90", X, X, True)])) == 2


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

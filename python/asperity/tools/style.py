"""Style of the pictures: widths, fonts, colours, curves with labels at their ends, polar diagrams, files."""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import matplotlib
import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.optimize import isotonic_regression

from ..contract import Floats
from ..options import check_picture
from ..steps import turns_of

if TYPE_CHECKING:
    from matplotlib.projections.polar import PolarAxes
    from matplotlib.typing import ColorType, RcKeyType

ONE, TWO = 3.5, 7.2
"""Widths of a picture for one column and for two columns of a journal, inches.

A picture is drawn at the size at which it is printed, so its texts have the size of the type of a journal.
"""

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#000000", "#E69F00", "#CC79A7")
"""Colours that colour-blind readers can distinguish (Okabe and Ito), for up to six curves."""

LINES = ("-", "--", "-.", ":")  # line styles, for print in black and white
DPI = 200  # resolution of PNG files, dots per inch
TYPE = 8.0  # size of the type, points
_SETTINGS: dict[RcKeyType, Any] = {
    "font.size": TYPE,
    "axes.titlesize": TYPE,
    "axes.labelsize": TYPE,
    "xtick.labelsize": TYPE - 1.0,
    "ytick.labelsize": TYPE - 1.0,
    "legend.fontsize": TYPE - 1.0,
    "legend.title_fontsize": TYPE - 1.0,
    "figure.titlesize": TYPE + 1.0,
    "lines.linewidth": 1.2,
    "lines.markersize": 4.0,
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "grid.linewidth": 0.5,
    "legend.frameon": False,
    "hatch.linewidth": 0.6,
    "pdf.fonttype": 42,
}
"""Settings of Matplotlib; PDF files have TrueType fonts, as publishers want them."""

MOST_TURNS = 12  # largest number of reversals of a path whose branches get arrows
PLACE = 0.35  # place of an arrow on its branch, as a fraction of the slip; not the middle, where loops cross
SAME_END = 0.02
"""Curves end side by side if their ends are at most this fraction of the width of the axes apart."""

NEAR_FRAME = 0.75  # labels of curves that end beyond this fraction of the width stand outside the frame


Line = tuple[str, Floats, Floats, bool]  # label, x, y of a curve, and whether equilibrium is lost at its end
COINCIDE = 5.0e-3
"""Curves that differ by less than this fraction of the largest value are drawn as one: a line is as thick."""


@contextmanager
def printed() -> Iterator[None]:
    """Use the settings of this style in a block or, as a decorator, in a function; then restore others."""
    with matplotlib.rc_context(_SETTINGS):
        yield


def new_figure(width: float, height: float, **subplots: Any) -> tuple[Figure, np.ndarray]:
    """Figure of a size in inches and the array of its axes; subplots: as of `Figure.subplots`."""
    figure = Figure(figsize=(width, height), layout="constrained")  # no window shows it
    return figure, np.ravel(figure.subplots(**subplots))


@printed()
def save(figure: Figure, path: Path) -> None:
    """Write a figure to a file whose name ends in .png or .pdf."""
    check_picture(path)
    path.write_bytes(encoded(figure, path.suffix))


def encoded(figure: Figure, ending: str) -> bytes:
    """File of a figure: PNG with a palette of 256 colours, or PDF; equal figures give equal files."""
    buffer = io.BytesIO()
    if ending == ".pdf":
        metadata = {"CreationDate": None, "Producer": None, "Creator": "asperity"}
        figure.savefig(buffer, format="pdf", metadata=metadata)
        return buffer.getvalue()
    from PIL import Image, PngImagePlugin

    info = PngImagePlugin.PngInfo()
    info.add_text("Software", "asperity")  # commands replace only pictures of this package
    figure.savefig(buffer, format="png", dpi=DPI, metadata={"Software": None})
    small = io.BytesIO()
    with Image.open(buffer) as image:
        # shades of one colour beside each other compress well; a pattern of dots (dither) does not
        palette = image.convert("RGB").quantize(256, dither=Image.Dither.NONE)
        palette.save(small, format="png", optimize=True, pnginfo=info)
    return small.getvalue()


def label_axes(ax: Axes, x: str, y: str) -> None:
    """Write the labels of the axes, and draw a grid."""
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    ax.grid(alpha=0.3)


def direction_arrows(ax: Axes, x: Floats, y: Floats, colour: ColorType) -> None:
    """Draw an arrow on each branch of a path with reversals; a path without a reversal gets none."""
    turns = turns_of(x).tolist()
    if not 2 < len(turns) <= MOST_TURNS + 2:
        return
    for first, last in pairwise(turns):
        wanted = x[first] + PLACE * (x[last] - x[first])
        at = max(first + int(np.argmin(np.abs(x[first : last + 1] - wanted))), 1)
        style = {"arrowstyle": "-|>", "shrinkA": 0, "shrinkB": 0, "mutation_scale": 11, "color": colour}
        ax.annotate("", (x[at], y[at]), (x[at - 1], y[at - 1]), arrowprops=style)


def label_ends(ax: Axes, title: str = "") -> None:
    """Write the label of each line of the axes at its right end, in its colour, without overlap.

    title: what the labels are, such as a symbol and its unit; it stands above the uppermost label.  Call this
    after all curves and limits are set.
    """
    lines = [line for line in ax.lines if not str(line.get_label()).startswith("_")]
    figure = cast("Figure", ax.figure)  # all axes of this package are in a figure, none in a part of one
    figure.draw_without_rendering()  # the layout determines how high the axes are
    height = TYPE * 1.15 / (ax.get_window_extent().height * 72.0 / figure.dpi)
    to_axes = ax.transData + ax.transAxes.inverted()
    ends = []
    for line in lines:
        x, y = (np.asarray(values, dtype=float) for values in line.get_data())
        drawn = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
        last = int(drawn[np.argmax(x[drawn])]) if drawn.size else 0
        right, level = to_axes.transform((x[last], y[last])).tolist()
        ends.append((1.0 if right > NEAR_FRAME else right, level))
    groups: dict[int, list[int]] = {}
    for i, (right, _) in enumerate(ends):
        near = next((j for j in groups if abs(ends[j][0] - right) <= SAME_END), i)
        groups.setdefault(near, []).append(i)
    rightmost = max(groups, key=lambda j: ends[j][0], default=None)
    for first, members in groups.items():
        levels = _apart([float(np.clip(ends[i][1], 0.0, 1.0)) for i in members], height)
        right = max(ends[i][0] for i in members)
        style: dict[str, Any] = {
            "xycoords": "axes fraction", "textcoords": "offset points", "va": "center",
            "fontsize": TYPE - 1.0, "annotation_clip": False,
        }  # fmt: skip
        for i, level in zip(members, levels, strict=True):
            line = lines[i]
            ax.annotate(str(line.get_label()), (right, level), (4.0, 0.0), color=line.get_color(), **style)
        if title and first == rightmost:
            ax.annotate(title, (right, max(levels) + 1.2 * height), (4.0, 0.0), color="0.35", **style)


def _apart(levels: Sequence[float], height: float) -> list[float]:
    """Levels moved apart to at least the height of a text, in their order, as little as possible."""
    order = np.argsort(levels, kind="stable")
    steps = height * np.arange(len(levels))
    places = np.empty(len(levels))
    places[order] = isotonic_regression(np.array(levels)[order] - steps).x + steps
    return [float(level) for level in places]


def literal(text: str) -> str:
    """Text of a user, such as the title of a case, in which a dollar sign begins no formula."""
    return text.replace("$", r"\$")


def labels_of(slips: bool, length: str, stress: str) -> list[str]:
    """Labels of the abscissa, of the traction, of the dilation (with slip only) and of the damage."""
    length, stress = literal(length), literal(stress)
    if not slips:
        return [f"opening $s_N$ [{length}]", rf"traction $\sigma_N$ [{stress}]", "damage [-]"]
    traction, dilation = rf"traction $\tau_L$ [{stress}]", f"dilation $s_N$ [{length}]"
    return [f"slip $s_L$ [{length}]", traction, dilation, "damage [-]"]


SLIP, TRACTION, DILATION, _ = labels_of(True, "mm", "MPa")
ENERGY = r"$G_T$ [N/mm]"


def colour(i: int, count: int) -> ColorType:
    """Colour of curve i, from the palette or, for many curves, from a scale without its lightest colours."""
    return COLOURS[i % len(COLOURS)] if count <= len(COLOURS) else colormaps["viridis"](0.9 * i / (count - 1))


def merged(lines: Sequence[Line]) -> list[Line]:
    """Lines without those that coincide with another one, whose label then has all their names."""
    top = max(float(np.abs(y).max()) for _, _, y, _ in lines)
    kept: list[tuple[list[str], Line]] = []
    for line in lines:
        _, x, y, lost = line
        for names, (_, x_0, y_0, lost_0) in kept:
            same = lost == lost_0 and x.shape == x_0.shape and np.allclose(x, x_0)
            if same and np.abs(y - y_0).max() < COINCIDE * top:
                names.append(line[0])
                break
        else:
            kept.append(([line[0]], line))
    range_of_names = len(lines) > 2 and len(kept) == 1
    return [
        (f"{names[0]} to {names[-1]}" if range_of_names else ", ".join(names), *line[1:])
        for names, line in kept
    ]


def curves(
    ax: Axes, lines: Iterable[Line], x_label: str, y_label: str, labels: str = "", inside: bool = False
) -> None:
    """Draw curves with labels at their ends; a cross marks a lost equilibrium, arrows mark reversals.

    labels: what the labels are, with a unit; without it there are none.  inside: whether a legend inside the
    axes has the labels, for curves that end at one point.
    """
    lines = list(lines)
    for i, (label, x, y, lost) in enumerate(lines):
        shade = colour(i, len(lines))
        ax.plot(x, y, LINES[i % len(LINES)], color=shade, label=label)
        direction_arrows(ax, x, y, shade)
        if lost:
            ax.plot(x[-1], y[-1], "x", color=shade, markersize=5)
    label_axes(ax, x_label, y_label)
    if labels and inside:
        ax.legend(title=labels)
    elif labels:
        label_ends(ax, labels)


def polar(
    ax: PolarAxes, directions: Floats, values: Floats, limits: tuple[float, float], title: str = ""
) -> None:
    """Draw G_T in N/mm over the direction of slip; the radius starts at the first of the limits."""
    angles = np.radians(np.append(directions, directions[0]))
    ax.plot(angles, np.append(values, values[0]), color=COLOURS[0])
    ax.set_rlim(*limits)
    ticks = np.linspace(*limits, 4)[1:]
    ax.set_rticks(ticks, [f"{tick:.2f}" for tick in ticks[:-1]] + [f"{ticks[-1]:.2f} N/mm"])
    ax.set_rlabel_position(22.5)
    ax.tick_params(axis="both", labelsize=6.0, pad=0)
    ax.grid(alpha=0.4)
    if title:
        ax.set_title(title)

"""Picture of a scanned surface: classified facets, normals, slopes over the scale, residual strength."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..contract import Floats
from ..pattern import Pattern, unit_vector
from ..style import COLOURS, TWO, label_axes, printed, save
from .scan import Scan
from .slopes import Facets, Planes, Slips

MOST_CELLS = 600
"""Largest number of drawn cells along a side of a map."""

AROUND = ("#D55E00", "#F0E442", "#0072B2", "#CC79A7")
"""Colours of slopes that rise towards Tx, Ty, -Tx, -Ty (Okabe and Ito), mixed for other directions."""

LONGEST = 12.0
"""Length of the drawn part of a profile over its height: the picture is to scale."""


@printed()
def draw(
    scan: Scan,
    found: Facets,
    patterns: tuple[Pattern, Pattern],
    chosen: Pattern,
    label: np.ndarray,
    slips: Slips,
    scales: Floats,
    png: Path,
    title: str,
) -> None:
    """Draw facets, normals, slopes over the scale and, for a map, the residual strength.

    patterns: listed and regular; label: plane of the chosen pattern for every facet; scales (n, 3 or more):
    sampling length, mean and rms slope.
    """
    planes = Planes.of(chosen)
    listed, regular = map(Planes.of, patterns)
    name = "list" if chosen == patterns[0] else "nearest regular pattern"
    figure = Figure(figsize=(TWO, 4.4 if scan.is_profile else 6.2), layout="constrained")
    if scan.is_profile:
        grid = figure.add_gridspec(2, 2, height_ratios=(1.0, 1.6))
        _profile(figure.add_subplot(grid[0, :]), scan, found, planes, label, name)
        _inclinations(figure.add_subplot(grid[1, 0]), found, listed, regular, slips.angles[0])
        _scales(figure.add_subplot(grid[1, 1]), scan, scales)
    else:
        grid = figure.add_gridspec(2, 2)
        _map(figure.add_subplot(grid[0, 0]), scan, planes, label, name)
        _normals(figure.add_subplot(grid[0, 1], projection="polar"), found, listed, regular)
        _scales(figure.add_subplot(grid[1, 0]), scan, scales)
        _strengths(figure.add_subplot(grid[1, 1]), listed, regular, slips)
    figure.suptitle(title)
    save(figure, png)


def _colours(planes: Planes) -> Floats:
    """Colour of every plane by azimuth; steeper planes have stronger colours."""
    depth = planes.slopes / max(planes.slopes.max(), 1.0e-12)
    knots = np.array([to_rgb(colour) for colour in (*AROUND, AROUND[0])])
    at = planes.azimuth % (2.0 * np.pi) / (0.5 * np.pi)
    base = np.column_stack([np.interp(at, np.arange(5), channel) for channel in knots.T])
    share = (0.3 + 0.7 * depth)[:, None] * (depth > 0.0)[:, None]
    colours: Floats = share * base + (1.0 - share) * 0.85  # grey where a facet is flat
    return colours


def _profile(ax: Axes, scan: Scan, found: Facets, planes: Planes, label: np.ndarray, name: str) -> None:
    """Draw heights above the average plane, each segment in the colour of its plane."""
    z = scan.heights()[0]
    points = np.column_stack([scan.x, z])
    segments = np.stack([points[:-1], points[1:]], axis=1)
    along = _signed(planes, _axis(found))
    steepest = max(np.abs(along).max(), 1.0e-12)
    lines = LineCollection(segments, array=along[label], cmap="coolwarm", linewidths=1.6, zorder=3)
    lines.set_clim(-steepest, steepest)
    ax.plot(scan.x, z, color=COLOURS[3], linewidth=2.4)  # The outline is needed because flat facets are pale.
    ax.add_collection(lines)
    ax.autoscale_view()
    # angles are shown as they are, so a long profile is cut instead of compressed
    length = float(np.ptp(scan.x))
    shown = min(length, max(LONGEST * float(np.ptp(z)), length / 100.0))
    ax.set_xlim(scan.x[0] - 0.01 * shown, scan.x[0] + 1.01 * shown)
    ax.set_aspect("equal", adjustable="datalim" if np.ptp(z) == 0.0 else "box")
    bar = ax.figure.colorbar(lines, ax=ax, orientation="horizontal", aspect=50, shrink=0.6)
    bar.set_label("inclination of the plane [degrees]")
    ax.set_xlabel(f"x [{scan.unit}]")
    ax.set_ylabel(f"height [{scan.unit}]")
    part = "" if shown == length else f", the first {shown:.3g} of {length:.3g} {scan.unit}"
    ax.set_title(f"facets in the {len(planes.gamma)} planes of the {name}, to scale{part}")


def _map(ax: Axes, scan: Scan, planes: Planes, label: np.ndarray, name: str) -> None:
    """Draw cells in the colour of the plane of their first facet, with contours of the height."""
    z = scan.heights()
    cells = label.reshape(z.shape[0] - 1, z.shape[1] - 1, 4)[:, :, 0]
    step = max(1, max(cells.shape) // MOST_CELLS)
    y = scan.y if scan.y is not None else np.zeros(1)
    extent = (scan.x[0], scan.x[-1], y[0], y[-1])
    ax.imshow(_colours(planes)[cells[::step, ::step]], origin="lower", extent=extent, interpolation="nearest")
    if np.ptp(z) > 0.0:
        ax.contour(scan.x, y, z, 5, colors="black", linewidths=0.5)
    ax.set_xlabel(f"x [{scan.unit}]")
    ax.set_ylabel(f"y [{scan.unit}]")
    ax.set_title(f"facets in the {len(planes.gamma)} planes of\nthe {name}, heights as lines")


def _normals(ax: Axes, found: Facets, planes: Planes, regular: Planes) -> None:
    """Draw the density of facets over azimuth and inclination, and planes as marks of proportional area."""
    incl, azimuth = found.inclination, found.azimuth % (2.0 * np.pi)
    top = max(incl.max() * 1.02, 1.0e-3)
    density, a, r = np.histogram2d(
        azimuth, incl, bins=(72, 30), range=((0.0, 2.0 * np.pi), (0.0, top)), weights=found.gamma
    )
    density /= np.diff(a)[:, None] * np.diff(r**2)  # the density is per area of the plot
    shown = np.ma.masked_where(density == 0.0, density).T
    ax.pcolormesh(a, r, shown, cmap="Greys", vmin=0.0, vmax=2.0 * np.percentile(density[density > 0.0], 90.0))
    _marks(ax, planes, "o", COLOURS[3], f"{len(planes.gamma)} listed planes")
    _marks(ax, regular, "s", COLOURS[0], f"nearest regular, {len(regular.gamma)} planes")
    ax.set_ylim(0.0, top)
    ax.set_rlabel_position(22.5)
    ax.yaxis.set_major_locator(MaxNLocator(4))
    ax.yaxis.set_major_formatter("{x:g}°")
    ax.set_title("up-slope azimuth and inclination")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.08), ncols=2)


def _marks(ax: Axes, planes: Planes, mark: str, colour: str, label: str) -> None:
    ax.scatter(
        planes.azimuth,
        planes.inclination,
        s=10.0 + 600.0 * planes.gamma,
        marker=mark,
        facecolors=_colours(planes),
        edgecolors=colour,
        linewidths=1.4,
        label=label,
    )


def _inclinations(ax: Axes, found: Facets, planes: Planes, regular: Planes, start: float) -> None:
    """Draw the histogram of the signed inclination of the facets of a profile, and planes as sticks."""
    e = unit_vector(start)
    incl = _signed(found, e)
    top = max(np.abs(incl).max() * 1.05, 1.0e-3)
    bars = {"bins": 41, "range": (-top, top), "weights": 100.0 * found.gamma}
    ax.hist(incl, color="#BBBBBB", label="facets", **bars)
    for one, mark, colour, label in (
        (planes, "o-", COLOURS[1], "listed planes"),
        (regular, "s--", COLOURS[0], f"nearest regular, {len(regular.gamma)} planes"),
    ):
        for i, (at, share) in enumerate(zip(_signed(one, e), one.gamma, strict=True)):
            stick = {"color": colour, "markevery": [1], "markerfacecolor": "none"}
            ax.plot([at, at], [0.0, 100.0 * share], mark, label=None if i else label, **stick)
    label_axes(ax, "inclination, + rises along the profile [degrees]", "share of the true area [%]")
    ax.legend()


def _scales(ax: Axes, scan: Scan, scales: Floats) -> None:
    ax.semilogx(scales[:, 0], scales[:, 1], "o-", color=COLOURS[0], label="mean")
    ax.semilogx(scales[:, 0], scales[:, 2], "s--", color=COLOURS[1], label="rms")
    ax.axvline(scan.spacing, color=COLOURS[3], linestyle=":", label="in use")
    ax.set_ylim(0.0, 1.05 * scales[:, 1:3].max() or 1.0)
    ax.set_xticks(scales[:, 0], [f"{length:.3g}" for length in scales[:, 0]])
    ax.minorticks_off()
    ax.set_xlabel(f"sampling length [{scan.unit}]")
    ax.set_ylabel("slope, tangent [-]")
    ax.grid(alpha=0.3, which="both")
    ax.legend()


def _strengths(ax: Axes, planes: Planes, regular: Planes, slips: Slips) -> None:
    """Draw the residual strength over the direction of slip, without a line where the joint locks."""
    angles, mu = slips.angles, slips.mu
    degrees = np.degrees(np.append(angles, angles[0] + 2.0 * np.pi))
    found = (slips, *(one.slips(angles, mu) for one in (planes, regular)))
    labels = ("facets", "listed planes", f"nearest regular, {len(regular.gamma)} planes")
    colours = (COLOURS[3], COLOURS[1], COLOURS[0])
    for one, style, colour, label in zip(found, ("-", "-", "--"), colours, labels, strict=True):
        values = one.residual
        shown = np.where(np.isinf(values), np.nan, values)
        ax.plot(degrees, np.append(shown, shown[0]), style, color=colour, label=label)
    if np.isfinite(slips.residual).any():
        ax.set_ylim(bottom=0.0)
    label_axes(ax, "direction of slip, from Tx [degrees]", r"residual $\tau_L / |\sigma_N|$ [-]")
    ax.set_title(f"$\\mu$ = {mu:g}; upper bound: sides that fit and do not break")
    ax.legend()


def _axis(found: Facets) -> Floats:
    g = found.gradients[found.slopes.argmax()]
    size = float(np.hypot(*g))
    e = g / size if size > 0.0 else np.array([1.0, 0.0])
    return e if e[0] > 0.0 or (e[0] == 0.0 and e[1] > 0.0) else -e


def _signed(planes: Planes, e: Floats) -> Floats:
    found: Floats = np.degrees(np.arctan(planes.gradients @ e))
    return found

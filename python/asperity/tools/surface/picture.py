"""Picture of a scanned surface: classified facets, normals, slopes over the scale, residual strength."""

from __future__ import annotations

from pathlib import Path
from typing import cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.projections.polar import PolarAxes
from matplotlib.ticker import MaxNLocator

from ...contract import Floats
from ...pattern import Pattern, unit_vector
from ..style import COLOURS, TWO, label_axes, literal, printed, save
from .scan import Scan
from .slopes import Facets, Planes, Slips

MOST_CELLS = 600  # largest number of drawn cells along a side of a map
AROUND = ("#D55E00", "#F0E442", "#0072B2", "#CC79A7")
"""Colours of slopes that rise towards Tx, Ty, -Tx, -Ty (Okabe and Ito), mixed for other directions."""

LONGEST = 12.0  # length of the drawn part of a profile over its height: the picture is to scale


@printed()
def draw(
    scan: Scan,
    facets: Facets,
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
    flat = facets.profile
    figure = Figure(figsize=(TWO, 4.4 if flat else 6.2), layout="constrained")
    axes = figure.subplot_mosaic(
        [["scan", "scan"], ["planes", "scales"]] if flat else [["scan", "planes"], ["scales", "strengths"]],
        height_ratios=(1.0, 1.6) if flat else None,
        per_subplot_kw={} if flat else {"planes": {"projection": "polar"}},
    )
    _scales(axes["scales"], scan, scales)
    e = unit_vector(slips.angles[0])
    if flat:
        _profile(axes["scan"], scan, planes, label, e)
        _inclinations(axes["planes"], facets, listed, regular, e)
    else:
        _map(axes["scan"], scan, planes, label)
        _normals(cast("PolarAxes", axes["planes"]), facets, listed, regular)
        _strengths(axes["strengths"], listed, regular, slips)
    name = "list" if chosen == patterns[0] else "nearest regular pattern"
    above = axes["scan"].get_title()
    axes["scan"].set_title(f"facets in the {len(planes.gamma)} planes of {above.format(name)}")
    figure.suptitle(literal(title))
    save(figure, png)


def _colours(planes: Planes) -> Floats:
    """Colour of every plane by azimuth; steeper planes have stronger colours."""
    around = LinearSegmentedColormap.from_list("", (*AROUND, AROUND[0]))
    depth = (planes.slopes / max(planes.slopes.max(), 1.0e-12))[:, None]
    share = (0.3 + 0.7 * depth) * (depth > 0.0)
    # grey where a facet is flat
    colours: Floats = share * around(planes.azimuth / (2.0 * np.pi) % 1.0)[:, :3] + (1.0 - share) * 0.85
    return colours


def _signed(planes: Planes, e: Floats) -> Floats:
    """Inclination along a direction, degrees."""
    degrees: Floats = np.degrees(np.arctan(planes.gradients @ e))
    return degrees


def _profile(ax: Axes, scan: Scan, planes: Planes, label: np.ndarray, e: Floats) -> None:
    """Draw heights above the average plane, each segment in the colour of its plane."""
    points = np.column_stack([scan.x, scan.heights[0]])
    along = _signed(planes, e)
    steepest = max(np.abs(along).max(), 1.0e-12)
    segments = np.stack([points[:-1], points[1:]], axis=1)
    lines = LineCollection(list(segments), array=along[label], cmap="coolwarm", linewidths=1.6, zorder=3)
    lines.set_clim(-steepest, steepest)
    ax.plot(*points.T, color=COLOURS[3], linewidth=2.4)  # the outline is needed because flat facets are pale
    ax.add_collection(lines)
    ax.autoscale_view()
    # angles are shown as they are, so a long profile is cut instead of compressed
    length, high = np.ptp(points, axis=0)
    shown = min(length, max(LONGEST * high, length / 100.0))
    ax.set_xlim(scan.x[0] - 0.01 * shown, scan.x[0] + 1.01 * shown)
    ax.set_aspect("equal" if high > 0.0 else "auto")
    bar = ax.figure.colorbar(lines, ax=ax, orientation="horizontal", aspect=50, shrink=0.6)
    bar.set_label("inclination of the plane [degrees]")
    part = "" if shown == length else f", the first {shown:.3g} of {length:.3g} {scan.unit}"
    ax.set(xlabel=f"x [{scan.unit}]", ylabel=f"height [{scan.unit}]", title=f"the {{}}, to scale{part}")


def _map(ax: Axes, scan: Scan, planes: Planes, label: np.ndarray) -> None:
    """Draw cells in the colour of the plane of their first facet, with contours of the height."""
    (x, y), z = scan.axes, scan.heights
    cells = label.reshape(z.shape[0] - 1, z.shape[1] - 1, 4)[:, :, 0]
    step = max(1, max(cells.shape) // MOST_CELLS)
    extent = (x[0], x[-1], y[0], y[-1])
    ax.imshow(_colours(planes)[cells[::step, ::step]], origin="lower", extent=extent, interpolation="nearest")
    if np.ptp(z) > 0.0:
        ax.contour(x, y, z, 5, colors="black", linewidths=0.5)
    ax.set(xlabel=f"x [{scan.unit}]", ylabel=f"y [{scan.unit}]", title="\nthe {}, heights as lines")


def _normals(ax: PolarAxes, facets: Facets, planes: Planes, regular: Planes) -> None:
    """Draw the density of facets over azimuth and inclination, and planes as marks of proportional area."""
    top = max(facets.inclination.max() * 1.02, 1.0e-3)
    places, ends = (facets.azimuth % (2.0 * np.pi), facets.inclination), ((0.0, 2.0 * np.pi), (0.0, top))
    density, a, r = np.histogram2d(*places, bins=(72, 30), range=ends, weights=facets.gamma)
    density /= np.diff(a)[:, None] * np.diff(r**2)  # the density is per area of the plot
    shown = np.ma.masked_where(density == 0.0, density).T
    ax.pcolormesh(a, r, shown, cmap="Greys", vmin=0.0, vmax=2.0 * np.percentile(density[density > 0.0], 90.0))
    for drawn, mark, colour, text in (
        (planes, "o", COLOURS[3], "{} listed planes"),
        (regular, "s", COLOURS[0], "nearest regular, {} planes"),
    ):
        ax.scatter(
            drawn.azimuth,
            drawn.inclination,
            s=10.0 + 600.0 * drawn.gamma,
            label=text.format(len(drawn.gamma)),
            marker=mark,
            facecolors=_colours(drawn),
            edgecolors=colour,
            linewidths=1.4,
        )
    ax.set_ylim(0.0, top)
    ax.set_rlabel_position(22.5)
    ax.yaxis.set_major_locator(MaxNLocator(4))
    ax.yaxis.set_major_formatter("{x:g}°")
    ax.set_title("up-slope azimuth and inclination")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.08), ncols=2)


def _inclinations(ax: Axes, facets: Facets, planes: Planes, regular: Planes, e: Floats) -> None:
    """Draw the histogram of the signed inclination of the facets of a profile, and planes as sticks."""
    incl = _signed(facets, e)
    top = max(np.abs(incl).max() * 1.05, 1.0e-3)
    weights = 100.0 * facets.gamma
    ax.hist(incl, bins=41, range=(-top, top), weights=weights, color="#BBBBBB", label="facets")
    for drawn, line, mark, colour, label in (
        (planes, "-", "o", COLOURS[1], "listed planes"),
        (regular, "--", "s", COLOURS[0], f"nearest regular, {len(regular.gamma)} planes"),
    ):
        heads, sticks, _ = ax.stem(_signed(drawn, e), 100.0 * drawn.gamma, basefmt=" ", label=label)
        heads.set(marker=mark, color=colour, markerfacecolor="none")
        sticks.set(linestyle=line, color=colour)
    label_axes(ax, "inclination, + rises along the profile [degrees]", "share of the true area [%]")
    ax.legend()


def _scales(ax: Axes, scan: Scan, scales: Floats) -> None:
    length, mean, rms = scales[:, :3].T
    ax.semilogx(length, mean, "o-", color=COLOURS[0], label="mean")
    ax.semilogx(length, rms, "s--", color=COLOURS[1], label="rms")
    ax.axvline(scan.steps[1], color=COLOURS[3], linestyle=":", label="in use")
    ax.set_ylim(0.0, 1.05 * rms.max() or 1.0)
    ax.set_xticks(length, [f"{tick:.3g}" for tick in length])
    ax.minorticks_off()
    label_axes(ax, f"sampling length [{scan.unit}]", "slope, tangent [-]")
    ax.legend()


def _strengths(ax: Axes, planes: Planes, regular: Planes, slips: Slips) -> None:
    """Draw the residual strength over the direction of slip, without a line where the joint locks."""
    degrees = np.degrees(np.append(slips.angles, slips.angles[0] + 2.0 * np.pi))
    of_patterns = (drawn.slips(slips.angles, slips.mu) for drawn in (planes, regular))
    labels = ("facets", "listed planes", f"nearest regular, {len(regular.gamma)} planes")
    styles = (("-", COLOURS[3]), ("-", COLOURS[1]), ("--", COLOURS[0]))
    for curve, (style, colour), label in zip((slips, *of_patterns), styles, labels, strict=True):
        shown = np.where(np.isinf(curve.residual), np.nan, curve.residual)
        ax.plot(degrees, np.append(shown, shown[0]), style, color=colour, label=label)
    if np.isfinite(slips.residual).any():
        ax.set_ylim(bottom=0.0)
    label_axes(ax, "direction of slip, from Tx [degrees]", r"residual $\tau_L / |\sigma_N|$ [-]")
    ax.set_title(f"$\\mu$ = {slips.mu:g}; upper bound: sides that fit and do not break")
    ax.legend()

"""Reading of scanned profiles and height maps from CSV files, and of triangulated surfaces."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ... import contract
from ...contract import Floats
from ...material import ModelWarning
from ...mesh.files import read_mesh
from ...pattern import Pattern
from ..cells import EMPTY
from ..tables import Table, read_table, size
from .grids import is_grid, is_of_pixels, read_grid, read_pixels
from .holes import enough, refuse_spikes, without_codes, without_gaps
from .scan import EVEN, Scan, even
from .slopes import FLATNESS, bin_facets, directions_of, facets, nearest_regular, refuse_impossible

MESHES = (".stl", ".ply", ".obj", ".vtk", ".vtu", ".msh")
"""Endings of the files of triangles that meshio reads."""

EXPECTED = (
    "expected columns x, z (profile) or x, y, z (map), as x [mm],z [um]; --spacing for a matrix of heights"
)

MOST_MISSING = 0.5  # part of the points of a grid above which the others are taken to lie on none
MOST_POINTS = 1e7  # largest number of points of the grid that replaces triangles
PROFILE = 2  # columns of a profile
FAR, THIN = 3.5, 2.0
"""Longest side of a triangle between neighbours in a cloud, and area of a longer one along a straight
outline, each over its median; a larger triangle lies in a gap.
"""


def read_scan(
    path: Path,
    spacing: Sequence[float] | None = None,
    unit: str = "mm",
    nodata: Sequence[float] = (),
    keep_spikes: bool = False,
) -> Scan:
    """Read the profile, height map or cloud of points of a CSV; with a spacing (dx, dy) a matrix of heights.

    Lengths are converted to the unit of x; `unit` is that of a file that names none.  Files of triangles
    become heights on a grid of that spacing; a grid of ESRI and a map of pixels have their own.  Heights of
    `nodata`, in the unit of the file, words, and values that mark missing points are gaps: those that heights
    enclose are filled straight between the points around, others are cut off.  A ModelWarning has the number
    of both.  Raises ValueError with line and value, and for spikes unless `keep_spikes`.
    """
    scan = _read(path, spacing, unit, nodata)
    if not keep_spikes:
        refuse_spikes(path, scan.x, scan.y, scan.z)
    return scan


def _read(path: Path, spacing: Sequence[float] | None, unit: str, nodata: Sequence[float]) -> Scan:
    if unit != "mm":
        _size(path, unit)
    if path.suffix.lower() in MESHES:
        if nodata:
            raise ValueError(
                f"{path}: --nodata: expected for heights; a file of triangles leaves out missing ones"
            )
        return _surface(path, spacing, unit)
    if is_of_pixels(path):
        x, y, z = read_pixels(path, spacing)
        return without_gaps(path, x, y, without_codes(path, z, nodata), "mm")
    if is_grid(path):
        if spacing:
            raise ValueError(f"{path}: --spacing: expected without it, the grid has its cellsize")
        x, y, z, codes = read_grid(path)
        enough(path, "columns", len(x))
        enough(path, "rows", len(y))
        codes = [code for code in codes if (z == code).any()]
        return without_gaps(path, x, y, without_codes(path, z, [*codes, *nodata]), unit)
    table = read_table(path, "a CSV with a profile or a height map")
    table.warn_of_remarks()
    if not len(table.cells):
        raise ValueError(f"{path}: expected rows of numbers")
    places = [*range(table.cells.shape[1])]
    if spacing is not None:
        if table.headings and not table.hidden:
            wanted = "expected a matrix of numbers, as --spacing says"
            raise ValueError(f"{path}: {_header(table)}: {wanted}")
        apart = np.diff(table.lines)
        if len(apart) and (gap := apart > apart.min()).any():
            line = table.lines[int(gap.argmax())] + 1
            wanted = "expected a row of heights, with NaN where one is missing"
            raise ValueError(f"{path}, line {line}: {wanted}")
        names = [str(i + 1) for i in places]
        z = without_codes(path, _without_words(table, places).numbers(places, names, names), nodata)
        enough(path, "columns", z.shape[1])
        enough(path, "rows", z.shape[0])
        x, y = (step * np.arange(n) for step, n in zip((spacing[0], spacing[-1]), z.shape[::-1], strict=True))
        return without_gaps(path, x, y, z, unit)
    axes, places = _columns(table)
    units_of = [table.units[place] if table.units else "" for place in places]
    if any(units_of) and not all(units_of):
        raise ValueError(f"{path}: columns {_header(table)}: expected a unit for all or none, as x [mm]")
    units = [text or unit for text in units_of]
    unit = units[axes.index("x")]
    factors = [1.0 if text == unit else _size(path, text) / _size(path, unit) for text in units]
    place = axes.index("z")
    numbers = np.array(_without_words(table, [places[place]]).numbers(places, axes, ["z"]))
    numbers[:, place] = without_codes(path, numbers[:, place], nodata)
    numbers *= factors
    data = dict(zip(axes, numbers.T, strict=True))
    return (_profile if len(axes) == 2 else _map)(path, data, table.lines, unit)


def _header(table: Table) -> str:
    titles = zip(table.names, table.units, strict=True)
    return ", ".join(
        name + (f" [{unit_of_column}]" if unit_of_column else "") for name, unit_of_column in titles
    )


def _columns(table: Table) -> tuple[list[str], list[int]]:
    """Axes x, z or x, y, z of a table and their columns: by the names, or by place in a file without names.

    The points of a file that says their number have x, y, z first.  A ModelWarning names other columns.
    """
    width = table.cells.shape[1]
    names, header = [name.lower() for name in table.names], _header(table)
    if not names or (table.hidden and not any(table.units) and not {*names} & {*"xyz"}):
        # a comment that has as many words as there are columns is no header
        names = {2: ["x", "z"], 3: ["x", "y", "z"]}.get(min(width, 3) if table.counted else width, [])
        header = header if width > 3 else ""
    axes = ["x", "y", "z"] if "y" in names else ["x", "z"]
    if [name for name in sorted(names) if name in "xyz"] != axes or (width > len(axes) == PROFILE):
        columns = f"columns {header}" if header else f"{width} columns without names"
        raise ValueError(f"{table.path}: {columns}: {EXPECTED}")
    axes = [name for name in names if name in axes]
    if width > len(axes):
        unused = ", ".join(table.headings[i] for i, name in enumerate(names) if name not in axes)
        text = f"columns not used: {unused or f'{len(axes) + 1} to {width}'}"
        warnings.warn(f"{table.path}: {text}", ModelWarning, stacklevel=4)
    return axes, [names.index(name) for name in axes]


def _without_words(table: Table, places: Sequence[int]) -> Table:
    """Table with empty cells for words, as Bad and ***, in columns of heights; a ModelWarning counts them."""
    cells = table.cells.copy()
    words: Counter[str] = Counter()
    for place in places:
        word = ~cells[place].str.contains(r"\d") & ~cells[place].str.fullmatch(EMPTY)
        words.update(cells[place][word])
        cells[place] = cells[place].mask(word, "")
    for text, count in words.items():
        told = f"{count} heights are {text:.20}, which is no number: they are missing"
        warnings.warn(f"{table.path}: {told}", ModelWarning, stacklevel=4)
    return replace(table, cells=cells)


def _size(path: Path, unit: str) -> float:
    try:
        return size("length", unit)
    except ValueError as error:
        raise ValueError(f"{path}: unit {error}") from None


def planes_from_scan(
    scan: Scan | str | Path,
    directions: int | None = None,
    bins: int = 3,
    flat_below: float = 0.0,
    smooth: float | None = None,
    sampling: float | None = None,
    direction: float = 0.0,
    regular: bool = False,
) -> Pattern:
    """Pattern of a scanned surface: listed planes or, with `regular`, the nearest regular pattern.

    scan: heights, or a file that `asperity surface` reads.  directions: sectors of azimuth (None: 8, of a
    profile 2).  bins: classes of inclination in each.  flat_below: angle, degrees, up to which facets form
    the flat plane.  smooth, sampling: cut-off length of a Gaussian filter and length of the facets, in the
    unit of the scan.  direction: of a profile, or of the first sector, degrees from Tx towards Ty.  Raises
    ValueError for a file, a number or a length that cannot be used.

    Examples
    --------
    >>> import numpy as np
    >>> from asperity.tools.surface import Scan, planes_from_scan
    >>> x = np.linspace(0.0, 8.0, 81)
    >>> ridges = Scan(x, None, 0.5 * np.abs(x % 2.0 - 1.0)[None])
    >>> planes_from_scan(ridges).weights.round(6).tolist()
    [0.5, 0.5]
    >>> round(planes_from_scan(ridges, regular=True).theta, 6)
    26.565051
    """
    if not isinstance(scan, Scan | str | Path):
        raise ValueError(f"scan = {contract.shown(scan)}: expected a file, or Scan(x, y, z) of arrays")
    measured = scan if isinstance(scan, Scan) else read_scan(Path(scan))
    measured = measured if smooth is None else measured.smoothed(smooth)
    of_scan = facets(measured if sampling is None else measured.sampled(sampling), direction)
    refuse_impossible(of_scan)
    if of_scan.doubt:
        warnings.warn(of_scan.doubt, ModelWarning, stacklevel=2)
    # numbers out of range are refused with regular, too
    listed = bin_facets(of_scan, directions, bins, direction, flat_below)[0]
    if not regular:
        return listed
    return nearest_regular(of_scan, of_scan.slips(directions_of(of_scan, direction), 0.0), 0, direction)


def _profile(path: Path, data: dict[str, Floats], lines: list[int], unit: str) -> Scan:
    """Profile with increasing x; one with decreasing x is reversed.  Points without height are left out."""
    gaps = np.isnan(data["z"])
    x, z, lines = data["x"][~gaps], data["z"][~gaps], np.array(lines)[~gaps].tolist()
    text = f"{path}: {gaps.sum()} of {gaps.size} points are left out, because they have no height"
    if gaps.any():
        warnings.warn(text, ModelWarning, stacklevel=4)
    enough(path, "points", len(x))
    if (np.diff(x) < 0.0).all():
        x, z, lines = x[::-1], z[::-1], lines[::-1]
    steps = np.diff(x)
    if not (steps > 0.0).all():
        i = int((steps <= 0.0).argmax())
        what = "vertical" if steps[i] == 0.0 else "overhang, or the points are not in order"
        raise ValueError(
            f"{path}, line {lines[i + 1]}: x = {x[i + 1]:g} after {x[i]:g}: expected x to increase ({what})"
        )
    return Scan(x.copy(), None, z[None, ::1].copy(), unit)


def _map(path: Path, data: dict[str, Floats], lines: list[int], unit: str) -> Scan:
    """Map on the grid of its points, whose order in the file does not matter."""
    axes, places = [], []
    for name in ("x", "y"):
        values = data[name]
        ordered = np.sort(values)
        sizes = np.diff(ordered)
        # The values of a grid line may differ by rounding: a new line starts at a larger step.
        starts = ordered[1:][sizes > EVEN * sizes.max(initial=0.0)]
        place = np.searchsorted(starts, values, side="right")
        axis = np.bincount(place, values) / np.bincount(place)
        if len(axis) == 1:
            raise ValueError(f"{path}: {name} = {axis[0]:g} throughout: expected a map; a profile is x, z")
        enough(path, f"different {name}", len(axis))
        if np.abs(axis - even(axis)).max() > EVEN * np.diff(axis).mean():
            return _cloud(path, data, lines, unit)
        axes.append(even(axis))
        places.append(place)
    x, y = axes
    cells = places[1] * len(x) + places[0]
    count = np.bincount(cells, minlength=len(x) * len(y))
    if (count > 1).any():
        second = np.flatnonzero(cells == np.argmax(count > 1))[1]
        at = f"x = {x[places[0][second]]:g}, y = {y[places[1][second]]:g}"
        raise ValueError(f"{path}, line {lines[second]}: {at} again: expected one height a point")
    if np.mean(count == 0) > MOST_MISSING:
        return _cloud(path, data, lines, unit)
    z = np.full(count.size, np.nan)
    z[cells] = data["z"]
    return without_gaps(path, x, y, z.reshape(len(y), len(x)), unit)


def _cloud(path: Path, data: dict[str, Floats], lines: list[int], unit: str) -> Scan:
    """Map of points that lie on no grid, on one of their mean distance, without gaps between them."""
    from scipy.spatial import Delaunay, QhullError

    points = np.column_stack([data[name] for name in "xyz"])
    there = np.flatnonzero(np.isfinite(points[:, 2]))
    points = points[there]
    enough(path, "heights", len(points))
    _, first = np.unique(points[:, :2], axis=0, return_index=True)
    if len(first) < len(points):
        again = int(np.setdiff1d(np.arange(len(points)), first)[0])
        at = "x = {:g}, y = {:g}".format(*points[again, :2])
        raise ValueError(f"{path}, line {lines[there[again]]}: {at} again: expected one height a point")
    try:
        triangles = Delaunay(points[:, :2] - points[:, :2].mean(axis=0)).simplices
    except QhullError:
        raise ValueError(f"{path}: all points with heights are on one line: expected a map") from None
    a, b, c = points[triangles][..., :2].swapaxes(0, 1)
    longest = np.max([np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    twice = np.abs(np.linalg.det(np.stack([b - a, c - a], axis=1)))
    near = (longest <= FAR * np.median(longest)) | (twice <= THIN * np.median(twice))
    # between the outermost points, outside of which there are none
    x, y = (0.5 * (axis[1:, 1:] + axis[:-1, :-1]) for axis in _grid(path, points, float(twice[near].mean())))
    apart = f"heights {x[0, 1] - x[0, 0]:.4g} apart, straight between them"
    warnings.warn(f"{path}: {len(points)} points on no grid: {apart}", ModelWarning, stacklevel=4)
    return _heights(path, points, triangles[near], x, y, unit)


def _heights(path: Path, points: Floats, triangles: np.ndarray, x: Floats, y: Floats, unit: str) -> Scan:
    """Map of heights on triangles at positions x and y (ny, nx)."""
    from matplotlib.tri import LinearTriInterpolator, Triangulation

    low = points.min(axis=0)  # large coordinates would lose digits
    sheet = Triangulation(points[:, 0] - low[0], points[:, 1] - low[1], triangles)
    z = LinearTriInterpolator(sheet, points[:, 2] - low[2])(x - low[0], y - low[1]).filled(np.nan)
    return without_gaps(path, x[0], y[:, 0], z + low[2], unit)


def _grid(path: Path, points: Floats, area: float, spacing: Sequence[float] | None = None) -> list[Floats]:
    """Positions x and y (ny, nx) of a grid in the rectangle of points, in cells of about an area."""
    low, sides = points[:, :2].min(axis=0), np.ptp(points[:, :2], axis=0)
    steps = sides / np.maximum(1.0, np.round(sides / np.sqrt(area)))
    steps = steps if spacing is None else np.array([spacing[0], spacing[-1]])
    with np.errstate(over="ignore"):
        counts = np.floor(sides / steps * (1.0 + FLATNESS)) + 1.0
        if (count := counts.prod()) > MOST_POINTS:
            raise ValueError(f"{path}: {count:.3g} points at --spacing: expected at most {MOST_POINTS:g}")
    axes = (low[i] + np.minimum(steps[i] * np.arange(counts[i]), sides[i]) for i in (0, 1))
    return [*np.meshgrid(*axes)]


def _surface(path: Path, spacing: Sequence[float] | None, unit: str) -> Scan:
    """Heights of triangles on a grid that fills a rectangle along x and y within their outline."""
    from matplotlib.tri import Triangulation

    points, triangles = _triangles(path)
    corners = points[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    up = normals[:, 2] * np.sign(np.nansum(normals[:, 2]))
    flawed, above = np.sum(~(up > FLATNESS * np.linalg.norm(normals, axis=1))), "0"
    sheet = Triangulation(points[:, 0], points[:, 1], triangles)
    try:
        if not flawed:  # a triangle above another one is not the one that is found at its centre
            at_centre = sheet.get_trifinder()(*corners[..., :2].mean(axis=1).T)
            above = f"{np.sum(at_centre != np.arange(len(triangles)))}"
    except RuntimeError:
        above = "some"
    if flawed or above != "0":
        raise ValueError(
            f"{path}: of {len(triangles)} triangles {flawed} are vertical, turned over, without area or not "
            f"finite, and {above} above others: expected a height field, one z for each x, y"
        )
    # by default a cell has the mean area of two triangles
    x, y = _grid(path, corners.reshape(-1, 3), up.mean(), spacing)
    return _heights(path, points, triangles, x, y, unit)


def _triangles(path: Path) -> tuple[Floats, np.ndarray]:
    """Points (n, 3) and triangles (m, 3) of a file."""
    mesh = read_mesh(path, "a file of triangles", "surface")
    points, cells = np.asarray(mesh.points, dtype=float), mesh.cells_dict
    triangles = cells.pop("triangle", np.empty((0, 3), dtype=int))
    kinds = ", ".join(sorted(set(cells) - {"vertex", "line"})) or "none"
    if kinds != "none" or not triangles.size or points.shape[1:] != (3,) or triangles.max() >= len(points):
        content = f"{len(triangles)} triangles of {len(points)} points, other cells: {kinds}"
        raise ValueError(f"{path}: {content}: expected triangles in space alone")
    return points, triangles

"""Reading of scanned profiles and height maps from CSV files, and of triangulated surfaces."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ... import contract
from ...contract import Floats
from ...material import ModelWarning
from ...mesh.files import read_mesh
from ...pattern import Pattern
from ..tables import read_table, size
from .grids import is_grid, read_grid
from .holes import warn_of_spikes, without_codes
from .scan import EVEN, LEAST_POINTS, Scan, even
from .slopes import FLATNESS, bin_facets, directions_of, facets, nearest_regular

MESHES = (".stl", ".ply", ".obj", ".vtk", ".vtu", ".msh")
"""Endings of the files of triangles that meshio reads."""

EXPECTED = (
    "expected columns x, z (profile) or x, y, z (map), as x [mm],z [um]; --spacing for a matrix of heights"
)


MOST_MISSING = 0.5  # part of the points of a grid above which the others are taken to lie on none
MOST_POINTS = 1e7  # largest number of points of the grid that replaces triangles


def read_scan(
    path: Path, spacing: Sequence[float] | None = None, unit: str = "mm", nodata: Sequence[float] = ()
) -> Scan:
    """Read the profile, height map or cloud of points of a CSV; with a spacing (dx, dy) a matrix of heights.

    Lengths are converted to the unit of x; `unit` is that of a file that names none.  Files of triangles
    become heights on a grid of that spacing; a grid of ESRI has its own.  Heights of `nodata`, in the unit of
    the file, and those that mark missing points are holes, which are filled straight between the points
    around.  A ModelWarning has their number, and that of spikes.  Raises ValueError with line and value.
    """
    scan = _read(path, spacing, unit, nodata)
    warn_of_spikes(path, scan.x, scan.y, scan.z)
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
    if is_grid(path):
        if spacing:
            raise ValueError(f"{path}: --spacing: expected without it, the grid has its cellsize")
        x, y, z, codes = read_grid(path)
        _enough(path, "columns", len(x))
        _enough(path, "rows", len(y))
        codes = [code for code in codes if (z == code).any()]
        return _filled(path, *np.meshgrid(x, y), without_codes(path, z, [*codes, *nodata]), unit)
    table = read_table(path, "a CSV with a profile or a height map")
    table.warn_of_remarks()
    titles = zip(table.names, table.units, strict=True)
    header = ", ".join(name + (f" [{given}]" if given else "") for name, given in titles)
    if not len(table.cells):
        raise ValueError(f"{path}: expected rows of numbers")
    places = range(table.cells.shape[1])
    if spacing is not None:
        if header and not table.hidden:
            wanted = "expected a matrix of numbers, as --spacing says"
            raise ValueError(f"{path}: {header}: {wanted}")
        names = [str(i + 1) for i in places]
        z = without_codes(path, table.numbers(places, names, names), nodata)
        x, y = (step * np.arange(n) for step, n in zip((spacing[0], spacing[-1]), z.shape[::-1], strict=True))
        _enough(path, "columns", len(x))
        _enough(path, "rows", len(y))
        return _filled(path, *np.meshgrid(x, y), z, unit)
    names = [name.lower() for name in table.names]
    if not names or (table.hidden and not any(table.units) and not {*names} & {*"xyz"}):
        # a comment that has as many words as there are columns is no header
        names = {2: ["x", "z"], 3: ["x", "y", "z"]}.get(len(places), [])
        header = header if len(places) > 3 else ""
    if sorted(names) not in (["x", "z"], ["x", "y", "z"]):
        columns = f"columns {header}" if header else f"{len(places)} columns without names"
        raise ValueError(f"{path}: {columns}: {EXPECTED}")
    if any(table.units) and not all(table.units):
        raise ValueError(f"{path}: columns {header}: expected a unit for all or none, as x [mm]")
    units = [given for given in table.units if given] or [unit] * len(names)
    unit = units[names.index("x")]
    factors = [1.0 if given == unit else _size(path, given) / _size(path, unit) for given in units]
    numbers = np.array(table.numbers(places, names, ["z"]))
    place = names.index("z")
    numbers[:, place] = without_codes(path, numbers[:, place], nodata)
    numbers *= factors
    data = dict(zip(names, numbers.T, strict=True))
    return (_profile if len(names) == 2 else _map)(path, data, table.lines, unit)


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
    _enough(path, "points", len(x))
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
        given = data[name]
        ordered = np.sort(given)
        sizes = np.diff(ordered)
        # The values of a grid line may differ by rounding: a new line starts at a larger step.
        starts = ordered[1:][sizes > EVEN * sizes.max(initial=0.0)]
        place = np.searchsorted(starts, given, side="right")
        axis = np.bincount(place, given) / np.bincount(place)
        if len(axis) == 1:
            raise ValueError(f"{path}: {name} = {axis[0]:g} throughout: expected a map; a profile is x, z")
        _enough(path, f"different {name}", len(axis))
        if np.abs(axis - even(axis)).max() > EVEN * np.diff(axis).mean():
            return _cloud(path, data, unit)
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
        return _cloud(path, data, unit)
    z = np.full(count.size, np.nan)
    z[cells] = data["z"]
    return _filled(path, *np.meshgrid(x, y), z.reshape(len(y), len(x)), unit)


def _cloud(path: Path, data: dict[str, Floats], unit: str) -> Scan:
    """Map of points that lie on no grid, on one of their mean distance."""
    from scipy.interpolate import griddata

    points = np.column_stack([data[name] for name in "xyz"])
    points = points[np.isfinite(points[:, 2])]
    _enough(path, "heights", len(points))
    x, y = _grid(path, points, float(np.ptp(points[:, :2], axis=0).prod()) / len(points))
    apart = f"heights {x[0, 1] - x[0, 0]:.4g} apart, straight between them"
    warnings.warn(f"{path}: {len(points)} points on no grid: {apart}", ModelWarning, stacklevel=4)
    return _filled(path, x, y, griddata(points[:, :2], points[:, 2], (x, y)), unit, outline=True)


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


def _filled(path: Path, x: Floats, y: Floats, z: Floats, unit: str, outline: bool = False) -> Scan:
    """Map without its gaps: those at the outline are cut off, holes are filled between the points.

    outline: the points have an outline that is no rectangle, so that cutting off is no reason for a warning.
    """
    from scipy.interpolate import griddata
    from scipy.spatial import QhullError

    gaps = np.isnan(z)
    given = int((~gaps).sum())
    _enough(path, "heights", int((~gaps).sum()))
    if gaps.any():
        z = z.copy()
        try:
            z[gaps] = griddata((x[~gaps], y[~gaps]), z[~gaps], (x[gaps], y[gaps]))
        except QhullError:
            raise ValueError(f"{path}: all points with heights are on one line: expected a map") from None
    inner = np.s_[1:], np.s_[:-1], np.s_[:, 1:], np.s_[:, :-1]
    while (out := np.isnan(z)).any():
        missing = [side.mean() for side in (out[0], out[-1], out[:, 0], out[:, -1])]
        x, y, z, gaps = (values[inner[int(np.argmax(missing))]] for values in (x, y, z, gaps))
        if not z.size:
            break
    for i, name in enumerate("yx"):
        _enough(path, f"different {name} within the outline", z.shape[i])
    if not outline and (lost := given - int((~gaps).sum())):
        text = f"{path}: {lost} of {given} heights are cut off with the gaps at the outline"
        warnings.warn(text, ModelWarning, stacklevel=4)
    if gaps.any():
        text = f"{path}: {gaps.sum()} of {gaps.size} points are in holes: heights straight between the others"
        warnings.warn(text, ModelWarning, stacklevel=4)
    return Scan(x[0], y[:, 0], z, unit)


def _surface(path: Path, spacing: Sequence[float] | None, unit: str) -> Scan:
    """Heights of triangles on a grid that fills a rectangle along x and y within their outline."""
    from matplotlib.tri import LinearTriInterpolator, Triangulation

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
    z = LinearTriInterpolator(sheet, points[:, 2])(x, y).filled(np.nan)
    return _filled(path, x, y, z, unit, outline=True)


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


def _enough(path: Path, what: str, count: int) -> None:
    if count < LEAST_POINTS:
        raise ValueError(f"{path}: {count} {what}: expected at least {LEAST_POINTS}")

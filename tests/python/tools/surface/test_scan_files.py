"""Files of scans: profiles, maps, triangles, grids, holes and codes of missing points."""

from __future__ import annotations

import re
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from asperity import ModelWarning
from asperity.tools.surface import slopes
from asperity.tools.surface.scan import Scan
from asperity.tools.surface.scan_files import read_scan

from tools.surface.support_scans import EXACT, grid, profile, rows, write


def test_profile_in_units(folder: Path) -> None:
    """Heights in micrometres, x in mm, swapped columns and decreasing x are read."""
    x = np.arange(20) / 10
    z = np.sin(x)
    scan = read_scan(write(rows(1000 * z[::-1], x[::-1], header="z [um], x [mm]")))
    assert (scan.unit, scan.y) == ("mm", None)
    assert scan.x == pytest.approx(x) and scan.z[0] == pytest.approx(z)


@pytest.mark.parametrize("mark", [",", ";", " ", "\t"])
def test_map_in_any_order(folder: Path, mark: str) -> None:
    """Points of a grid in any order are the matrix."""
    a, b = np.arange(9) * 0.1, np.arange(8) * 0.3
    x, y = np.meshgrid(a, b)
    z = x + 10 * y**2
    order = np.random.default_rng(2).permutation(z.size)
    columns = [axis.ravel()[order] for axis in (x, y, z)]
    header = "# scanner 5\n" + mark.join(("x(mm)", "y(mm)", "z(mm)"))
    scan = read_scan(write(rows(*columns, header=header, mark=mark)))
    matrix = read_scan(write(rows(*z.T, mark=mark)), (0.1, 0.3))
    for heights in (scan, matrix):
        assert (
            heights.z == pytest.approx(z) and heights.x == pytest.approx(a) and heights.y == pytest.approx(b)
        )


def test_rounded_coordinates(folder: Path) -> None:
    """A grid of spacing 1/30 in three decimals, with distances of 0.033 or 0.034, counts as regular."""
    a = np.arange(31) / 30
    x, y = np.meshgrid(a, a)
    scan = read_scan(write(rows(x.ravel(), y.ravel(), (x + y**2).ravel(), form=".3f")))
    assert scan.x == pytest.approx(a, abs=EXACT) and scan.y == pytest.approx(a, abs=EXACT)


def test_overhang_of_the_average_plane() -> None:
    """A cliff that overhangs after levelling is an error."""
    x = np.linspace(0.0, 1.0, 101)
    z = 3.0 * x
    z[50:] -= 0.8
    message = r"1 facets, the first at x = 0.49, overhang the average plane, .* n_N > 0"
    with pytest.raises(ValueError, match=message):
        profile(x, z)


# --- triangles ----------------------------------------------------------------------------------------------


def sheet(n: int = 12, height: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Points of z = height + 0.1 sin 2 pi x sin 2 pi y at n cells a period, and triangles of two a cell."""
    _, x, y = grid(n, 1)
    points = np.stack([x, y, height + 0.1 * np.sin(2 * np.pi * x) * np.sin(2 * np.pi * y)], axis=-1)
    i = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (part.ravel() for part in (i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]))
    return points.reshape(-1, 3), np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


def save(name: str, points: np.ndarray, triangles: np.ndarray) -> Path:
    """A file of triangles in the current folder."""
    meshio.Mesh(points, [("triangle", triangles)]).write(name)
    return Path(name)


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("name", ["joint.stl", "joint.STL", "joint.ply", "joint.vtu"])
@pytest.mark.parametrize("turned", [False, True])
def test_triangles_have_the_slopes_of_the_grid(name: str, turned: bool) -> None:
    """Triangles between the points of a map give the scan of the map, whichever side they show."""
    points, triangles = sheet()
    scan = read_scan(save(name.lower(), points, triangles[:, ::-1] if turned else triangles).rename(name))
    expected = read_scan(write(rows(*points.T, header="x [mm],y [mm],z [mm]")))
    assert scan.z.shape == expected.z.shape
    assert scan.z == pytest.approx(expected.z, abs=1e-6)  # an STL has seven digits
    assert slopes.facets(scan).fabric == pytest.approx(slopes.facets(expected).fabric, rel=1e-5)


@pytest.mark.usefixtures("folder")
def test_outline_and_spacing_of_triangles() -> None:
    """Of a disc cut from a plane the grid has the given spacing, fills a rectangle, and keeps the slope."""
    points, triangles = sheet(40)
    points[:, 2] = 0.3 * points[:, 0] - 0.2 * points[:, 1]
    centres = points[triangles].mean(axis=1)
    disc = triangles[np.hypot(*(centres[:, :2] - 0.5).T) < 0.5]
    scan = read_scan(save("disc.stl", points, disc), (0.02, 0.04), "m")
    assert scan.unit == "m" and scan.y is not None
    assert np.diff(scan.x) == pytest.approx(0.02) and np.diff(scan.y) == pytest.approx(0.04)
    assert 0.4 < np.ptp(scan.x) * np.ptp(scan.y) <= 0.5  # the largest rectangle is a square of area 1/2
    assert np.gradient(scan.z, scan.y, scan.x)[1] == pytest.approx(0.3, abs=1e-4)


def bad_meshes() -> dict[str, tuple[np.ndarray, np.ndarray, str]]:
    """Meshes that are no height field, with the message of each."""
    points, triangles = sheet()
    above = np.concatenate([points, sheet(12, 1.0)[0]])
    twice = np.concatenate([triangles, triangles + len(points)])
    wall = np.concatenate([triangles, [[0, 1, len(points)]]])
    field = "are vertical, turned over, .*, and 0 above others: expected a height field"
    nan = np.where(np.arange(len(points))[:, None] == 30, np.nan, points)
    turned = np.concatenate([triangles, triangles[:3, ::-1]])
    # all of the second sheet is above one triangle of the first
    inside = np.concatenate([points * [100.0, 100.0, 1.0], points + np.array([55.0, 51.0, 1.0])])
    shifted = np.concatenate([points, sheet(12, 1.0)[0] + [0.31, 0.27, 0.0]])
    return {
        "shifted sheets": (shifted, twice, " 0 are .*, and some above others: expected a"),
        "wall": (above, wall, f"of 289 triangles 1 {field}"),
        "turned over": (points, turned, f"of 291 triangles 3 {field}"),
        "inside": (inside, twice, r" 0 are .*, and \d+ above others: expected a"),
        "nan": (nan, triangles, f"of 288 triangles 6 {field}"),
        "coarse": (*sheet(6), "7 different y within the outline: expected at least 8"),
        "empty": (points, triangles[:0], "expected a file of triangles"),
    }  # fmt: skip


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("name", bad_meshes())
def test_bad_meshes(name: str) -> None:
    """What is no height field is refused with the number found."""
    points, triangles, message = bad_meshes()[name]
    with pytest.raises(ValueError, match=f"joint.vtu: .*{message}"):
        read_scan(save("joint.vtu", points, triangles))


@pytest.mark.usefixtures("folder")
def test_unreadable_meshes(said: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file without triangles, a spacing that memory does not hold, and meshio that is missing."""
    message = r"asperity: \w+\.stl: .+: expected .*triangles.*\n"
    for text in ("", "nonsense", "solid a\nendsolid a\n"):
        Path("joint.stl").write_text(text, encoding="utf-8")
        out, err = said("surface joint.stl", 1)
        assert re.fullmatch(message, err) and not out
    assert re.fullmatch(message, said("surface none.stl", 1)[1])
    save("joint.stl", *sheet())
    for spacing in ("1e-5", "1e-300"):
        error = said(f"surface joint.stl --spacing {spacing}", 1)[1]
        assert "points at --spacing: expected at most 1e+07" in error
    monkeypatch.setitem(sys.modules, "meshio", None)
    assert "pip install 'asperity[surface]'" in said("surface joint.stl", 1)[1]


def test_holes_and_clouds_of_points(folder: Path) -> None:
    """Holes of maps, matrices and triangles are filled, and points on no grid become a map."""
    n, random = 21, np.random.default_rng(3)
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(n), np.arange(n)))
    z = 0.3 * x - 0.1 * y
    hole = np.hypot(x - 9, y - 12) < 2.5
    (folder / "map.csv").write_text(rows(x[~hole], y[~hole], z[~hole], header="x,y,z"), encoding="utf-8")
    matrix = rows(*np.where(hole, np.nan, z).reshape(n, n).T, form=".3f").replace("nan", "")
    (folder / "matrix.csv").write_text(matrix, encoding="utf-8")
    for name, spacing in (("map.csv", None), ("matrix.csv", (1.0, 1.0))):
        with pytest.warns(ModelWarning, match=f"{hole.sum()} of {n * n} points are in holes"):
            scan = read_scan(folder / name, spacing)
        assert scan.z == pytest.approx(z.reshape(n, n), abs=1e-9)
    x, y = random.uniform(0.0, 20.0, (2, 900))
    (folder / "cloud.csv").write_text(rows(x, y, 0.3 * x - 0.1 * y, header="x,y,z"), encoding="utf-8")
    with pytest.warns(ModelWarning, match=r"900 points on no grid: heights 0\.6\d+ apart"):
        scan = read_scan(folder / "cloud.csv")
    assert min(scan.z.shape) > 20
    assert scan.z == pytest.approx(0.3 * scan.x[None] - 0.1 * scan.y[:, None], abs=1e-6)
    points, triangles = sheet()
    save("joint.vtu", points, np.delete(triangles, [78, 78 + 144], axis=0))
    with pytest.warns(ModelWarning, match="16 of .* points are in holes"):
        read_scan(folder / "joint.vtu", (0.02, 0.02))


# --- holes, spikes, grids of ESRI, drawn files --------------------------------------------------------------


def ridge(code: float | None = None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points of ridges along y with slopes of 1/4, every half unit; some have a code."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(33) / 2.0, np.arange(17) / 2.0))
    z = 0.25 * np.abs(np.mod(x, 8.0) - 4.0)
    if code is not None:
        z[[40, 41, 100, 333]] = code
    return x, y, z


RIDGE = np.degrees(np.arctan(0.25))


def warned(text: str, spacing: tuple[float, ...] | None = None, **options: Any) -> tuple[Scan, list[str]]:
    """Scan of a file with this text, and the warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scan = read_scan(write(text), spacing, **options)
    return scan, [str(warning.message) for warning in caught]


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("code", "nodata", "message"),
    [
        (None, (), ""),
        (-9999.0, (), "4 of 561 heights are -9999, which marks missing points: they are holes"),
        (-32768.0, (), "4 of 561 heights are -32768, which marks missing points: they are holes"),
        (1e30, (), r"4 of 561 heights are 1e\+30, which marks missing points: they are holes"),
        (-32.768, (), "4 of 561 heights are -32.768, which marks missing points: they are holes"),
        (999.0, (), "4 of 561 heights are 999, which marks missing points: they are holes"),
        (7.5, (7.5,), r"4 of 561 heights are 7.5 \(--nodata\): they are holes"),
    ],
)
def test_codes_of_missing_points_are_holes(
    code: float | None, nodata: tuple[float, ...], message: str
) -> None:
    """The slope of the ridges is that without the codes, which a warning counts."""
    x, y, z = ridge(code)
    files = {"map": rows(x, y, z, header="x [mm],y [mm],z [mm]"), "matrix": rows(*z.reshape(17, 33).T)}
    head = "NCOLS 33\nNROWS 17\nXLLCORNER -0.25\nYLLCORNER -0.25\nCELLSIZE 0.5\n"
    rows_down = rows(*z.reshape(17, 33)[::-1].T).replace(",", " ")
    files["grid"] = head + f"NODATA_VALUE {code or 77:g}\n" + rows_down
    for kind, text in files.items():
        spacing = (0.5, 0.5) if kind == "matrix" else None
        scan, told = warned(text, spacing, nodata=() if kind == "grid" else nodata)
        named = kind == "grid" and code is not None
        expected = re.escape(f"4 of 561 heights are {code:g}") if named else message
        assert len(told) == (2 if message else 0)
        assert not message or (re.search(expected, told[0]) and "4 of 561 points are in holes" in told[1])
        assert (scan.x[0], scan.x[-1], scan.y[0], scan.y[-1]) == (0.0, 16.0, 0.0, 8.0)  # type: ignore[index]
        facets = slopes.facets(scan)
        assert np.percentile(facets.inclination, [5, 50, 90]) == pytest.approx([RIDGE] * 3, abs=EXACT)
        assert not facets.doubt


Y, X = np.mgrid[:24, :33] / 2.0
OUTLINES = {
    "notch": ~((np.abs(X - 7.0) < 1.5) & (Y < 3.0)),
    "corner": X + Y > 6.0,
    "disc": np.hypot(X / 8.0 - 1.0, Y / 6.0 - 1.0) <= 1.0,
    "L": ~((X > 9.0) & (Y > 7.0)),
}
"""Points of a map of 33 x 24 points that have a height."""


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("there", OUTLINES.values(), ids=OUTLINES)
@pytest.mark.parametrize("kind", ["points", "matrix", "cloud", "triangles"])
def test_gaps_at_the_outline_are_cut_off(kind: str, there: np.ndarray) -> None:
    """What no heights enclose is cut off with a warning, and no height is invented."""
    z = 0.25 * np.abs(X % 8.0 - 4.0)
    if kind == "points":
        path = write(rows(X[there], Y[there], z[there], header="x,y,z"))
    elif kind == "matrix":
        path = write(rows(*np.where(there, z, np.nan).T).replace("nan", "***"))
    elif kind == "cloud":
        x, y = np.random.default_rng(5).uniform(0.0, [16.0, 11.5], (4000, 2)).T
        inside = there[np.round(2.0 * y).astype(int), np.round(2.0 * x).astype(int)]
        path = write(rows(x[inside], y[inside], 0.25 * x[inside], header="x,y,z"))
    else:
        i = np.arange(z.size).reshape(z.shape)
        full = there[:-1, :-1] & there[1:, :-1] & there[:-1, 1:] & there[1:, 1:]
        a, b, c, d = (part[full] for part in (i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]))
        corners = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
        path = save("joint.stl", np.stack([X, Y, z], axis=-1).reshape(-1, 3), corners)
    with pytest.warns(ModelWarning, match=r"\d+ of \d+ heights are cut off with the gaps at the outline"):
        scan = read_scan(path, (0.5,) if kind == "matrix" else None)
    assert np.abs(np.diff(scan.z) / np.diff(scan.x)) == pytest.approx(0.25, abs=1e-5)
    assert scan.y is not None
    if kind != "matrix":  # its first point is at 0
        row, column = (np.round(2.0 * axis).astype(int) for axis in (scan.y, scan.x))
        assert there[row][:, column].mean() > (0.95 if kind == "cloud" else 0.999)


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("head", ["//X,Y,Z\n561\n", "//X,Y,Z\n", "561\n", "561\n// by hand\n//X,Y,Z\n"])
@pytest.mark.parametrize("more", [False, True])
def test_clouds_with_their_number(head: str, more: bool) -> None:
    """Heads of CloudCompare and of scanners; a number that is not that of the points is refused."""
    x, y, z = ridge()
    colour = [np.full(x.size, 200)] if more else []
    if more and "X" in head:
        head = head.replace("Z", "Z,Intensity")
    scan, told = warned(head + rows(x, y, z, *colour))
    assert scan.z.shape == (17, 33) and slopes.facets(scan).mean_slope == pytest.approx(0.25, abs=EXACT)
    assert len(told) == more and (not more or "columns not used: " in told[0])
    if "561" in head:
        with pytest.raises(ValueError, match="561 rows: expected 600 rows of numbers below their number"):
            read_scan(write(head.replace("561", "600") + rows(x, y, z, *colour)))


@pytest.mark.usefixtures("folder")
def test_rows_without_heights() -> None:
    """A row of a matrix that is empty keeps its place or is refused, so that the others are not moved."""
    z = 0.25 * np.abs(Y % 8.0 - 4.0)
    lines = rows(*z.T).splitlines()
    nothing = "," * (z.shape[1] - 1)
    with pytest.raises(ValueError, match="line 6: expected a row of heights, with NaN where one is missing"):
        read_scan(write("\n".join([*lines[:5], nothing, *lines[6:]])), (0.5,))
    missing = nothing.replace(",", "NaN,") + "NaN"
    scan, told = warned("\n".join([*lines[:5], missing, *lines[6:]]), (0.5,))
    assert "cut off" in told[0] and scan.y is not None and scan.y[0] == 3.0
    assert read_scan(write("\n\n".join(lines)), (0.5,)).z == pytest.approx(z)  # a blank line between all rows


PIXELS = """Zygo XYZ Data File - Format 1
0 3 0 0 "Tue"
0 0 41 30 1 255
7 5 41 30
""
""
""
0 0.5 6.328e-07 0 1 0 2e-06 1787677163
#
"""


@pytest.mark.usefixtures("folder")
def test_map_of_pixels() -> None:
    """Pixels of an interferometer are as far apart as the head says, and their heights are in micrometres."""
    j, i = np.mgrid[:30, :41]
    z = 0.5 * np.abs(i % 8 - 4.0)  # um; the pixels are 2 um apart
    word = np.where((i == 13) & (j == 9), "No Data", np.char.mod("%.4f", z))
    lines = [f"{7 + a} {5 + b} {text}" for a, b, text in zip(i.flat, j.flat, word.flat, strict=True)]
    scan, told = warned(PIXELS + "\n".join([*lines, "#"]))
    assert len(told) == 1 and "1 of 1230 points are in holes" in told[0]
    assert scan.unit == "mm" and np.diff(scan.x) == pytest.approx(0.002)
    assert slopes.facets(scan).mean_slope == pytest.approx(0.25, abs=EXACT)
    without = PIXELS.replace("2e-06", "0") + "\n".join(lines)
    with pytest.raises(ValueError, match="the head has no distance of the pixels: expected --spacing"):
        read_scan(write(without))
    assert read_scan(write(without), (0.004,)).x[1] == pytest.approx(0.004)
    for line, message in (
        ("7 5 1", "pixel 7, 5 again"),
        ("7 x 1", "expected column, row and height of a pixel"),
    ):
        with pytest.raises(ValueError, match=message):
            read_scan(write(PIXELS + "\n".join([*lines, line])))


@pytest.mark.usefixtures("folder")
def test_degrees_are_refused(said: Callable) -> None:
    """Longitude and latitude as x, y beside heights in metres give slopes that no surface has."""
    x, y, z = ridge()
    write(rows(7.5 + x / 1800.0, 46.25 + y / 1800.0, 30.0 * z, header="x,y,z"))
    assert "are x and y degrees of longitude and latitude?" in said("surface scan.csv", 1)[1]


@pytest.mark.usefixtures("folder")
def test_spikes_and_profiles_with_gaps() -> None:
    """A spike is refused by its place or kept, a gap of a profile is counted, a value that is none named."""
    x, y, z = ridge()
    z[100] = 30.0
    apart = np.where(x + y < 2.0, -5.0, ridge()[2])
    with pytest.raises(ValueError, match=f"{(x + y < 2.0).sum()} of 561 heights are spikes"):
        read_scan(write(rows(x, y, apart, header="x,y,z")))
    path = write(rows(x, y, z, header="x,y,z"))
    with pytest.raises(ValueError, match=r"1 of 561 heights are spikes, the first at x = 0.5, y = 1.5: "):
        read_scan(path)
    assert "is z in the unit of x?" in slopes.facets(read_scan(path, keep_spikes=True)).doubt
    with pytest.warns(ModelWarning, match="no height is 5: expected one that --nodata names"):
        read_scan(write(rows(x, y, ridge()[2], header="x,y,z")), nodata=[5.0])
    x = np.arange(400) * 0.1
    z = 0.25 * np.abs(np.mod(x, 1.0) - 0.5)
    z[[10, 20]] = -9999.0
    with pytest.warns(ModelWarning, match="2 of 400 points are left out"):
        scan = read_scan(write(rows(x, z, header="x,z")))
    assert scan.z.min() >= 0.0


@pytest.mark.usefixtures("folder")
def test_header_behind_a_sign() -> None:
    """Units behind # count; a comment of as many words as columns is none; bare units are refused."""
    x, y, z = ridge()
    scan = read_scan(write(rows(x, y, 1000.0 * z, header="# x [mm],y [mm],z [um]")))
    assert slopes.facets(scan).mean_slope == pytest.approx(0.25, abs=EXACT)
    scan = read_scan(write(rows(x, y, z, header="# made,by,hand")))
    assert slopes.facets(scan).mean_slope == pytest.approx(0.25, abs=EXACT)
    _, told = warned("# Value units: um\n" + rows(x, y, z, header="x,y,z"))
    expected = "scan.csv: line 1: # Value units: um: not read as units: expected them in the header,"
    assert len(told) == 1 and told[0].startswith(expected)
    for header, message in (
        ("# a [mm],b [mm],c [um]", "columns a .mm., b .mm., c .um.: expected columns x, z"),
        ("# mm,mm,um", "expected a line of names above|expected columns x, z"),
    ):
        with pytest.raises(ValueError, match=message):
            read_scan(write(rows(x, y, z, header=header)))


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("nrows 9", "nrows 8"), "81 heights: expected 8 rows of 9"),
        (("cellsize 1", "cellsize 0"), "expected a cellsize > 0"),
        (("nrows 9", "nrows 9.5"), "expected whole numbers"),
        (("nrows 9", "rows 9"), "line 2: rows 9: expected one of ncols, nrows"),
        (("0.5", "o.5"), "line 6: o.5: expected a number"),
    ],
)
def test_bad_grids(change: tuple[str, str], message: str) -> None:
    """What does not fit the head of a grid is refused."""
    body = "\n".join(" ".join(f"{0.5 * ((i + j) % 3)}" for i in range(9)) for j in range(9))
    text = f"ncols 9\nnrows 9\nxllcorner 0\nyllcorner 0\ncellsize 1\n{body}\n"
    assert read_scan(write(text)).z.shape == (9, 9)
    with pytest.raises(ValueError, match=message):
        read_scan(write(text.replace(*change, 1)))


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(("seed", "count"), [(1, 200), pytest.param(2, 1000, marks=pytest.mark.long)])
def test_drawn_scans(seed: int, count: int) -> None:
    """Of drawn scans with a damaged line all other points keep their heights, without an error or warning."""
    rng, whole = np.random.default_rng(seed), 0
    for number in range(count):
        nx, ny = rng.integers(8, 14, 2)
        step = float(rng.choice([0.1, 0.5, 25.0]))
        profile = number % 3 == 0
        x, y = np.meshgrid(step * np.arange(nx * (1 + 2 * profile)), step * np.arange(1 if profile else ny))
        z = np.round(0.3 * step * np.sin(x / step + rng.uniform(0.0, 6.0)) * np.cos(0.7 * y / step), 5)
        points = np.column_stack([axis.ravel() for axis in ((x, z) if profile else (x, y, z))])
        mark = str(rng.choice([",", ";", "\t", " "]))
        names = ["x", "z"] if profile else ["x", "y", "z"]
        unit = str(rng.choice(["", " [mm]"])) if mark != " " else ""
        lines = [str(rng.choice(["", "# "])) + mark.join(name + unit for name in names)]
        lines += [mark.join(f"{value:.5f}" for value in row) for row in points]
        at = int(rng.integers(0, len(lines)))
        damaged = lines[at]
        if number % 5:
            place, sign = int(rng.integers(0, len(damaged) + 1)), str(rng.choice([*'01,;.-#x \t"e']))
            more, five = damaged[:place] + sign + damaged[place:], mark.join(["1"] * 5)
            kinds = damaged[:place], more, f"{damaged}\n{damaged}", "", five, "-9999"
            damaged = str(rng.choice(kinds))
        try:
            scan, told = warned("\n".join([*lines[:at], damaged, *lines[at + 1 :]]) + "\n")
        except ValueError:
            assert number % 5
            continue
        if told:
            continue
        whole += 1
        assert scan.z.size >= len(points) - bool(number % 5), (number, damaged)
        kept = points[np.arange(len(points)) + 1 != at]
        row = 0 if profile else np.abs(scan.y[:, None] - kept[:, 1]).argmin(0)  # type: ignore[index]
        place = np.abs(scan.x[:, None] - kept[:, 0]).argmin(0)
        assert (np.abs(scan.x[place] - kept[:, 0]) < 0.05 * step).all(), (number, damaged)
        assert (np.abs(scan.z[row, place] - kept[:, -1]) <= 1e-9).all(), (number, damaged)
    assert whole > count // 5

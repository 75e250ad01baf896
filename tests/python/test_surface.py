"""Planes of scanned surfaces, on synthetic surfaces with slopes in closed form."""

from __future__ import annotations

import re
import sys
import warnings
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from asperity import Interface, Material, ModelWarning, Pattern
from asperity.case_files import read_case
from asperity.tools.surface import slopes
from asperity.tools.surface.command import HEADING
from asperity.tools.surface.scan import Scan
from asperity.tools.surface.scan_files import read_scan
from asperity.tools.surface.slopes import Planes, Slips

EXACT = 1.0e-9
"""Rounding error of heights of order 1 over a spacing of order 0.01, in degrees and fractions."""

THETA, MU = 30.0, 0.5
T = np.tan(np.radians(THETA))


def trapezoid(x: np.ndarray, period: float, flat: float, rise: float, fall: float) -> np.ndarray:
    """Heights with slopes `rise` and -`fall` (tangents) between flats of the given length at foot and top."""
    height = (period - 2.0 * flat) / (1.0 / rise + 1.0 / fall)
    knots = np.cumsum([0.0, flat, height / rise, flat, height / fall])
    return np.interp(np.mod(x, period), knots, [0.0, 0.0, height, height, 0.0])


def profile(x: np.ndarray, z: np.ndarray) -> slopes.Facets:
    """Facets of a profile."""
    return slopes.facets(Scan(x, None, z[None, :]))


def grid(n: int, periods: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Axis of `periods` unit periods of n cells each, and the mesh of two such axes."""
    a = np.arange(n * periods + 1) / n
    return a, *np.meshgrid(a, a)


def regular(found: slopes.Facets, sides: int = 0) -> Pattern:
    """Nearest regular pattern."""
    return slopes.nearest_regular(found, slips(found), sides)


def slips(found: slopes.Facets, mu: float = MU) -> Slips:
    """Slips of the facets along the directions that the command compares."""
    return found.slips(slopes.directions_of(found), mu)


def egg_box(amplitude: float, n: int, periods: int = 1) -> tuple[slopes.Facets, float]:
    """Facets of z = A sin kx sin ky, k = 2 pi, n cells a period, and A k as finite differences have it."""
    a, x, y = grid(n, periods)
    k = 2.0 * np.pi
    z = amplitude * np.sin(k * x) * np.sin(k * y)
    return slopes.facets(Scan(a, a, z)), amplitude * k * np.sinc(1.0 / n)


# --- profiles -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("flat", "direction"), [(0.0, 0.0), (0.25, 0.0), (0.25, 30.0)])
def test_ridge_is_the_trapezoid(flat: float, direction: float) -> None:
    """A trapezoidal profile gives the inclination of its sides and the flat fraction of its true length.

    Its planes slope along the direction of the profile, and RT is rotated to it.
    """
    x = np.arange(401) / 40
    found = slopes.facets(Scan(x, None, trapezoid(x, 2.0, flat, T, T)[None, :]), direction)
    share = 2.0 * flat / (2.0 * flat + (2.0 - 2.0 * flat) / np.cos(np.radians(THETA)))
    pattern = slopes.nearest_regular(found, None, 0, direction)
    assert pattern.m == 2
    assert [pattern.theta, pattern.flat, pattern.turn] == pytest.approx([THETA, share, direction], abs=EXACT)
    listed, label = slopes.bin_facets(found, 2, 3, direction)
    assert listed.normals == pytest.approx(pattern.normals, abs=EXACT)
    assert listed.weights == pytest.approx(pattern.weights, abs=EXACT)
    # every facet is assigned to its plane
    assert listed.normals[label] == pytest.approx(found.normals, abs=EXACT)


def test_tilted_ridge() -> None:
    """A scan rotated by 17 degrees has the same planes and heights, and another tilt."""
    x = np.arange(401) / 40
    z = trapezoid(x, 2.0, 0.25, T, T)
    c, s = np.cos(np.radians(17.0)), np.sin(np.radians(17.0))
    tilted = Scan(c * x - s * z, None, (s * x + c * z)[None, :])
    assert np.ptp(tilted.heights) == pytest.approx(np.ptp(z), rel=EXACT)
    found, level = slopes.facets(tilted), profile(x, z)
    assert found.tilt == pytest.approx(17.0, abs=EXACT)
    assert found.normals == pytest.approx(level.normals, abs=EXACT)
    assert found.gamma == pytest.approx(level.gamma, abs=EXACT)
    assert regular(found).theta == pytest.approx(THETA, abs=EXACT)


def test_unequal_sides() -> None:
    """Slopes of 20 and 40 degrees give two planes in balance, with one residual strength for a direction."""
    rise, fall = np.tan(np.radians([20.0, 40.0]))
    # five points up and five down, repeated four times
    period = np.concatenate([np.full(5, 0.2 / rise), np.full(5, 0.2 / fall)])
    x = np.concatenate([[0.0], np.cumsum(np.tile(period, 4))])
    z = np.tile(np.concatenate([np.arange(5), 5 - np.arange(5)]) / 5, 4)
    z = np.append(z, 0.0)
    found = profile(x, z)
    listed, _ = slopes.bin_facets(found, 2, 4)
    assert np.degrees(np.arctan(Planes.of(listed).slopes)) == pytest.approx([20.0, 40.0], abs=1e-6)
    assert listed.weights @ listed.normals[:, 1:] == pytest.approx([0.0, 0.0], abs=EXACT)
    # fractions of the true length: height over sine
    expected = 1.0 / np.sin(np.radians([20.0, 40.0]))
    assert listed.weights == pytest.approx(expected / expected.sum(), abs=EXACT)
    tangent = np.array([rise, fall])
    angles = np.array([0.0, np.pi])
    strength = (MU + tangent) / (1.0 - MU * tangent)
    assert found.slips(angles, MU).residual == pytest.approx(strength, rel=EXACT)
    # RT differs from this surface: its single angle lies between the two
    pattern = regular(found)
    errors = slopes.compare(pattern, found, found.slips(angles, MU), strength)
    middle = np.tan(np.radians(pattern.theta))
    of_pattern = (MU + middle) / (1.0 - MU * middle)
    assert rise < middle < fall
    assert errors["residual"] == pytest.approx(np.abs(of_pattern / strength - 1.0).max(), rel=EXACT)
    assert errors["mean slope"] == pytest.approx(0.0, abs=EXACT)


def test_filter_halves_a_wave_of_its_length() -> None:
    """Far from the ends the filter damps a wave by 2^-(cut-off length/wave length)^2."""
    x = np.arange(2001) / 100
    middle = slice(800, 1200)
    for wave, passed in ((1.0, 0.5), (0.4, 2.0**-6.25)):
        scan = Scan(x, None, np.sin(2.0 * np.pi * x / wave)[None, :]).smoothed(1.0)
        # the filter is truncated where its weight is exp(-14)
        assert np.ptp(scan.z[0, middle]) == pytest.approx(2.0 * passed, rel=1e-5)


# --- maps ---------------------------------------------------------------------------------------------------


def test_pyramids_with_ridges_along_the_axes() -> None:
    """z = tent(x) + tent(y) has the slopes (+-t, +-t) and gives RP-4 rotated by 45 degrees exactly."""
    a, x, y = grid(12, 2)
    found = slopes.facets(Scan(a, a, T * (np.abs(x % 1.0 - 0.5) + np.abs(y % 1.0 - 0.5))))
    pattern = regular(found)
    assert pattern.m == 4
    theta = np.degrees(np.arctan(np.sqrt(2.0) * T))
    assert [pattern.theta, pattern.flat] == pytest.approx([theta, 0.0], abs=EXACT)
    assert abs(pattern.turn) == pytest.approx(45.0, abs=EXACT)
    seen = slips(found, 0.3)
    errors = slopes.compare(pattern, found, seen, seen.residual)
    assert max(errors.values()) < EXACT
    listed, _ = slopes.bin_facets(found, 4, 3, 45.0)
    assert sorted(map(tuple, listed.normals.round(9).tolist())) == sorted(
        map(tuple, pattern.normals.round(9).tolist())
    )


def test_hexagons_have_six_sides() -> None:
    """Sides, theta, flat weight and rotation of RP-6 and RP-3 are identified from their own planes."""
    for sides, turn in ((3, 10.0), (5, 7.0), (6, -20.0), (2, 75.0)):
        given = Pattern.regular(sides, 25.0, 0.2, turn)
        found = slopes.Facets(given.normals, given.weights)
        pattern = regular(found)
        assert pattern.m == sides
        assert [pattern.theta, pattern.flat, pattern.turn] == pytest.approx([25.0, 0.2, turn], abs=1e-8)


def test_egg_box() -> None:
    """Moments of z = A sin kx sin ky: fabric (Ak)^2/4 I, mean uphill slope Ak (2/pi)^2/2, steepest Ak."""
    found, steepest = egg_box(0.04, 40)
    assert found.fabric == pytest.approx(0.25 * steepest**2 * np.eye(2), abs=EXACT)
    assert found.rms_slope == pytest.approx(steepest / np.sqrt(2.0), rel=EXACT)
    mean, rms = found.slips(np.array([0.0]), MU).uphill
    # the mean of |cos| over n points a period differs from 2/pi by up to (pi/n)^2/3, relatively
    assert mean[0] == pytest.approx(0.5 * (2.0 / np.pi) ** 2 * steepest, rel=(np.pi / 40) ** 2)
    assert rms[0] == pytest.approx(steepest / np.sqrt(8.0), rel=EXACT)
    # true area: E[sqrt(1 + g^2)] = 1 + E[g^2]/2 - E[g^4]/8, here E[g^4] = 5 (Ak)^4/16
    series = 1.0 + steepest**2 / 4 - 5.0 * steepest**4 / 128
    assert found.ratio == pytest.approx(series, abs=steepest**6 / 16)
    # along x the steepest facets carry; across they slope by less than Ak (pi/n)^2, which enters squared
    top = steepest * np.cos(np.pi / 40)
    strength = found.slips(np.array([0.0]), MU).residual[0]
    assert strength == pytest.approx((MU + top) / (1.0 - MU * top), rel=(steepest * (np.pi / 40) ** 2) ** 2)
    pattern = regular(found)
    assert pattern.m > 4
    planes = Planes.of(pattern)
    assert planes.mean_slope == pytest.approx(found.mean_slope, rel=EXACT)
    assert planes.fabric == pytest.approx(found.fabric, abs=EXACT)


@pytest.mark.slow
def test_errors_of_an_isotropic_pattern() -> None:
    """z = A sin kx sin 2ky with RP-8: every error is a closed form of the two moments, a and b = 4a."""
    a, x, y = grid(64, 1)
    k = 2.0 * np.pi
    found = slopes.facets(Scan(a, a, 0.03 * np.sin(k * x) * np.sin(2.0 * k * y)))
    # differences over a cell are the derivative times sinc; means of cos^2 and sin^2 over cells are 1/2
    steepest = 0.03 * k * np.array([np.sinc(1.0 / 64), 2.0 * np.sinc(2.0 / 64)])
    moments = steepest**2 / 4.0
    assert found.fabric == pytest.approx(np.diag(moments), abs=EXACT)
    errors = slopes.compare(regular(found, 8), found, (seen := slips(found)), seen.residual)
    # the fabric of the pattern has half of the trace along each axis
    apart = np.abs(moments[1] - moments[0]) / 2.0
    assert errors["fabric"] == pytest.approx(np.sqrt(2.0) * apart / np.hypot(*moments), rel=1e-6)
    assert errors["mean slope"] == pytest.approx(0.0, abs=EXACT)
    # half of the mean square faces each way: along x it is a/2, of the pattern (a + b)/4
    rms = np.sqrt([moments[0] / 2.0, moments[1] / 2.0])
    least = np.abs(np.sqrt(moments.sum() / 4.0) - rms).max() / rms[1]
    assert errors["uphill"] >= least * (1.0 - 1e-6)
    assert seen.uphill[1][[0, 18]] == pytest.approx(rms, rel=1e-6)


def test_bins() -> None:
    """Vector areas add up, all planes have a positive weight, and more bins preserve more of the fabric."""
    found, _ = egg_box(0.1, 30)
    lost = []
    for bins in (1, 2, 4, 7):
        listed, label = slopes.bin_facets(found, 8, bins)
        assert len(listed.weights) <= 8 * bins + 1
        assert listed.weights @ listed.normals[:, 1:] == pytest.approx([0.0, 0.0], abs=EXACT)
        assert Planes.of(listed).nominal.min() >= slopes.LEAST_SHARE
        for k in range(len(listed.weights)):
            vector = found.gamma[label == k] @ found.normals[label == k]
            assert vector / np.linalg.norm(vector) == pytest.approx(listed.normals[k], abs=EXACT)
        lost.append(1.0 - np.trace(Planes.of(listed).fabric) / np.trace(found.fabric))
    assert all(fine < coarse for coarse, fine in pairwise(lost))
    # with many classes the remaining error is the spread within a sector of 45 degrees, 1 - sinc(1/8)^2 = 5 %
    assert 0.0 < lost[-1] < 1.0 - np.sinc(1.0 / 8.0) ** 2


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
def test_residual_is_that_of_the_law() -> None:
    """The residual strength is that of the library at a large slip, also for planes of equal slope."""
    found, _ = egg_box(0.05, 24)
    listed, _ = slopes.bin_facets(found, 8, 2, 10.0)
    # all planes are fully damaged; the stiff contact makes the other planes open
    material, path = Material(3.0, 0.001, 0.9, MU, kc=1.0e4), np.linspace(0, 1, 2001)[1:]
    for pattern, degrees in ((listed, (0.0, 33.0, 200.0)), (Pattern.regular(2, THETA), (0.0, 90.0))):
        for direction in degrees:
            history = Interface(material, pattern).confined_slip(direction, path, -1.0)
            e = np.array([np.cos(np.radians(direction)), np.sin(np.radians(direction))])
            expected = Planes.of(pattern).slips(np.radians([direction]), MU).residual[0]
            assert history.damage[-1] == 1.0
            assert history.traction[-1, 1:] @ e == pytest.approx(expected, rel=1e-6)


def test_locking_is_told() -> None:
    """For mu tan(theta) = 1.15 the strength is infinite; if both lock, the difference is 0."""
    pattern = Pattern.regular(2, THETA)
    found = slopes.Facets(pattern.normals, pattern.weights)
    angles = np.array([0.0, np.pi])
    seen = found.slips(angles, 2.0)
    assert np.isinf(seen.residual).all()
    assert slopes.compare(pattern, found, seen, seen.residual)["residual"] == 0.0
    other = Pattern.regular(2, 20.0)
    assert np.isinf(slopes.compare(other, found, seen, seen.residual)["residual"])


# --- files --------------------------------------------------------------------------------------------------


@pytest.fixture
def no_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out the picture, which takes longest, where a test looks at the text only."""
    monkeypatch.setattr("asperity.tools.surface.picture.draw", lambda *_: None)


def write(text: str) -> Path:
    """A scan in the current folder."""
    Path("scan.csv").write_text(text, encoding="utf-8")
    return Path("scan.csv")


def rows(*columns: np.ndarray, header: str = "", mark: str = ",", form: str = ".12g") -> str:
    """Text of a CSV."""
    lines = [mark.join(format(value, form) for value in row) for row in np.column_stack(columns)]
    return "\n".join(([header] if header else []) + lines) + "\n"


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
    columns = [one.ravel()[order] for one in (x, y, z)]
    header = "# scanner 5\n" + mark.join(("x(mm)", "y(mm)", "z(mm)"))
    scan = read_scan(write(rows(*columns, header=header, mark=mark)))
    matrix = read_scan(write(rows(*z.T, mark=mark)), (0.1, 0.3))
    for one in (scan, matrix):
        assert one.z == pytest.approx(z) and one.x == pytest.approx(a) and one.y == pytest.approx(b)


def test_rounded_coordinates(folder: Path) -> None:
    """A grid of spacing 1/30 in three decimals, with distances of 0.033 or 0.034, counts as regular."""
    a = np.arange(31) / 30
    x, y = np.meshgrid(a, a)
    scan = read_scan(write(rows(x.ravel(), y.ravel(), (x + y**2).ravel(), form=".3f")))
    assert scan.x == pytest.approx(a, abs=EXACT) and scan.y == pytest.approx(a, abs=EXACT)


WAVE = np.arange(400) * 0.1
NOISE = np.random.default_rng(3).normal(0.0, 0.01, 400)


SPACINGS = np.meshgrid(WAVE[:40], 2.0 * WAVE[:20])


@pytest.mark.usefixtures("folder", "no_picture")
@pytest.mark.parametrize(
    ("z", "warning"),
    [
        (np.sin(WAVE), ""),
        (1e-4 * np.sin(WAVE), "an rms slope of 7e-05 is unusual: is z in the unit of x?"),
        (5.0 * np.sin(WAVE), "an rms slope of 3.9 is unusual"),
        (NOISE, r"the rms slope at 0.1 mm is \d+% above that at 0.2: there is no plateau"),
        (np.sin(SPACINGS[0]), r"points are 0.1 to 0.2 mm apart; --sampling 0.2 gives them one scale\Z"),
    ],
    ids=["plateau", "small", "steep", "noise", "two spacings"],
)
def test_warnings_of_scale(z: np.ndarray, warning: str, said: Callable) -> None:
    """Doubtful units, slopes of noise and two spacings give a warning, a plateau does not."""
    columns = (WAVE, z) if z.ndim == 1 else (*map(np.ravel, SPACINGS), z.ravel())
    write(rows(*columns, header="x [mm],z [mm]" if z.ndim == 1 else "x [mm],y [mm],z [mm]"))
    found = re.findall(r"^warning +(.*)$", said("surface scan.csv")[0], re.MULTILINE)
    assert len(found) == bool(warning) and all(re.match(warning, text) for text in found)


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
    x, y = (one.ravel() for one in np.meshgrid(np.arange(n), np.arange(n)))
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


# --- command ------------------------------------------------------------------------------------------------

BOX = """&material sigma0 = 0.3, Gc = 0.03, eta = 0.95, mu = 0.4, kc = 20.0 /
&pattern sides = 2, ! RT / as it was
         theta = 10.0 /
&sweep name = 'held', values = -0.2, -0.5 /
&step t_N = held /
&step slip = 0.8 /
"""
PRINTED = re.compile(r"^(&pattern.*?/)\n\nPROPS  (.*?)$", re.MULTILINE | re.DOTALL)


@pytest.mark.slow
@pytest.mark.parametrize("options", ["", "--regular", "--planes 33 --smooth 0.2 --sampling 0.1"])
def test_command(folder: Path, said: Callable, options: str) -> None:
    """The written case has the printed pattern and the template's rest; PROPS and CSV have the same planes.

    Driver, card and select read the case.
    """
    _, x, y = grid(20, 2)
    write(rows(*(0.05 * np.sin(2 * np.pi * x) * np.sin(2 * np.pi * y)).T))
    Path("box.nml").write_text(BOX, encoding="utf-8")
    out, _ = said(f"surface scan.csv --spacing 0.05 --case box.nml -o found {options}")
    assert Path("found.png").stat().st_size > 10000
    assert "mu = 0.4" in out and Path("box.nml").read_text(encoding="utf-8") == BOX
    [(lines, props)] = PRINTED.findall(out)
    expected = HEADING + re.sub(r"&pattern.*?10.0 /", lines, BOX, flags=re.DOTALL)
    assert Path("found.nml").read_text(encoding="utf-8") == expected
    interface = read_case(Path("found.nml")).runs[0].interface
    assert [float(value) for value in props.split(",")] == pytest.approx(interface.props(), abs=1e-8)
    assert interface.material.kc == 20.0
    table = np.genfromtxt("found.csv", delimiter=",", names=True)
    normals = np.column_stack([table[name] for name in ("n_N", "n_Tx", "n_Ty")])
    assert normals == pytest.approx(interface.pattern.normals, abs=1e-8)
    assert table["gamma"] == pytest.approx(interface.pattern.weights, abs=1e-8)
    theta, azimuth = np.radians([table["theta_deg"], table["azimuth_deg"]])
    slope = -np.sin(theta) * np.array([np.cos(azimuth), np.sin(azimuth)])
    assert normals[:, 1:] == pytest.approx(slope.T, abs=1e-7)
    said("run found.nml -o rows.csv")
    assert {path.name for path in folder.glob("rows_*.csv")} == {"rows_-0.2.csv", "rows_-0.5.csv"}
    assert f"*Depvar\n{interface.nstatv}," in said("card abaqus found.nml")[0]
    # CalculiX accepts no listed planes
    assert options == "--regular" or "regular" in said("card calculix found.nml", 1)[1]


@pytest.mark.usefixtures("folder", "no_picture")
def test_lines_of_a_flat_profile(said: Callable) -> None:
    """A straight profile gives the flat plane, listed or regular; without a material PROPS have names."""
    write(rows(np.arange(9.0), 0.5 * np.arange(9.0), header="x [mm], z [mm]"))
    out, _ = said("surface scan.csv --regular")
    assert "\n&pattern sides = 0 /\n" in out and "\nPROPS  sigma0, Gc, eta, mu, 0, 0, " in out
    out, _ = said("surface scan.csv --material sigma0=3,Gc=0.3,eta=0.9,mu=0.5")
    assert "&pattern normals = 1, 0, 0, weights = 1 /" in out and "\nPROPS  3, 0.3, " in out


# --- holes, spikes, grids of ESRI, drawn files --------------------------------------------------------------


def ridge(code: float | None = None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points of ridges along y with slopes of 1/4, every half unit; some have a code."""
    x, y = (one.ravel() for one in np.meshgrid(np.arange(33) / 2.0, np.arange(17) / 2.0))
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
    return scan, [str(one.message) for one in caught]


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("code", "nodata", "message"),
    [
        (None, (), ""),
        (-9999.0, (), "4 of 561 heights are -9999, which marks missing points: they are holes"),
        (-32768.0, (), "4 of 561 heights are -32768, which marks missing points: they are holes"),
        (1e30, (), r"4 of 561 heights are 1e\+30, which marks missing points: they are holes"),
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
        found = slopes.facets(scan)
        assert np.percentile(found.inclination, [5, 50, 90]) == pytest.approx([RIDGE] * 3, abs=EXACT)
        assert not found.doubt


@pytest.mark.usefixtures("folder")
def test_spikes_and_profiles_with_gaps() -> None:
    """A spike is named by its place, a gap of a profile is counted; a value that does not occur is named."""
    x, y, z = ridge()
    z[100] = 30.0
    apart = np.where(x + y < 2.0, -5.0, ridge()[2])
    told = warned(rows(x, y, apart, header="x,y,z"))[1]
    assert f"{(x + y < 2.0).sum()} of 561 heights are spikes" in told[0]
    with pytest.warns(ModelWarning, match=r"1 of 561 heights are spikes, the first at x = 0.5, y = 1.5: "):
        scan = read_scan(write(rows(x, y, z, header="x,y,z")))
    assert "is z in the unit of x?" in slopes.facets(scan).doubt
    with pytest.warns(ModelWarning, match="no height is 5: expected one that --nodata names"):
        read_scan(write(rows(x, y, ridge()[2], header="x,y,z")), nodata=[5.0])
    z = 0.25 * np.abs(np.mod(WAVE, 1.0) - 0.5)
    z[[10, 20]] = -9999.0
    with pytest.warns(ModelWarning, match="2 of 400 points are left out"):
        scan = read_scan(write(rows(WAVE, z, header="x,z")))
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
@pytest.mark.parametrize(("seed", "count"), [(1, 60), pytest.param(2, 1000, marks=pytest.mark.slow)])
def test_drawn_scans(seed: int, count: int) -> None:
    """Of drawn scans with a damaged line all other points keep their heights, without an error or warning."""
    rng, whole = np.random.default_rng(seed), 0
    for number in range(count):
        nx, ny = rng.integers(8, 14, 2)
        step = float(rng.choice([0.1, 0.5, 25.0]))
        profile = number % 3 == 0
        x, y = np.meshgrid(step * np.arange(nx * (1 + 2 * profile)), step * np.arange(1 if profile else ny))
        z = np.round(0.3 * step * np.sin(x / step + rng.uniform(0.0, 6.0)) * np.cos(0.7 * y / step), 5)
        points = np.column_stack([one.ravel() for one in ((x, z) if profile else (x, y, z))])
        mark = str(rng.choice([",", ";", "\t", " "]))
        names = ["x", "z"] if profile else ["x", "y", "z"]
        unit = str(rng.choice(["", " [mm]"])) if mark != " " else ""
        lines = [str(rng.choice(["", "# "])) + mark.join(name + unit for name in names)]
        lines += [mark.join(f"{one:.5f}" for one in row) for row in points]
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
        for i, point in enumerate(points):
            if i + 1 != at:
                row = 0 if profile else int(np.abs(scan.y - point[1]).argmin())  # type: ignore[operator]
                place = int(np.abs(scan.x - point[0]).argmin())
                assert abs(scan.x[place] - point[0]) < 0.05 * step, (number, damaged)
                assert scan.z[row, place] == pytest.approx(point[-1], abs=1e-9), (number, damaged)
    assert whole > count // 5

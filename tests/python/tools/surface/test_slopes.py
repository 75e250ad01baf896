"""Planes of scanned surfaces, on synthetic surfaces with slopes in closed form, and the command."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, Pattern
from asperity.case_files import read_case
from asperity.tools.surface import slopes
from asperity.tools.surface.command import HEADING
from asperity.tools.surface.scan import Scan
from asperity.tools.surface.slopes import Planes, Slips

from tools.surface.support_scans import EXACT, grid, profile, rows, write

THETA, MU = 30.0, 0.5
T = np.tan(np.radians(THETA))


def trapezoid(x: np.ndarray, period: float, flat: float, rise: float, fall: float) -> np.ndarray:
    """Heights with slopes `rise` and -`fall` (tangents) between flats of the given length at foot and top."""
    height = (period - 2.0 * flat) / (1.0 / rise + 1.0 / fall)
    knots = np.cumsum([0.0, flat, height / rise, flat, height / fall])
    return np.interp(np.mod(x, period), knots, [0.0, 0.0, height, height, 0.0])


def regular(facets: slopes.Facets, sides: int = 0) -> Pattern:
    """Nearest regular pattern."""
    return slopes.nearest_regular(facets, slips(facets), sides)


def slips(facets: slopes.Facets, mu: float = MU) -> Slips:
    """Slips of the facets along the directions that the command compares."""
    return facets.slips(slopes.directions_of(facets), mu)


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
    facets = slopes.facets(Scan(x, None, trapezoid(x, 2.0, flat, T, T)[None, :]), direction)
    share = 2.0 * flat / (2.0 * flat + (2.0 - 2.0 * flat) / np.cos(np.radians(THETA)))
    pattern = slopes.nearest_regular(facets, None, 0, direction)
    assert pattern.m == 2
    assert [pattern.theta, pattern.flat, pattern.turn] == pytest.approx([THETA, share, direction], abs=EXACT)
    listed, label = slopes.bin_facets(facets, 2, 3, direction)
    assert listed.normals == pytest.approx(pattern.normals, abs=EXACT)
    assert listed.weights == pytest.approx(pattern.weights, abs=EXACT)
    # every facet is assigned to its plane
    assert listed.normals[label] == pytest.approx(facets.normals, abs=EXACT)


def test_tilted_ridge() -> None:
    """A scan rotated by 17 degrees has the same planes and heights, and another tilt."""
    x = np.arange(401) / 40
    z = trapezoid(x, 2.0, 0.25, T, T)
    c, s = np.cos(np.radians(17.0)), np.sin(np.radians(17.0))
    tilted = Scan(c * x - s * z, None, (s * x + c * z)[None, :])
    assert np.ptp(tilted.heights) == pytest.approx(np.ptp(z), rel=EXACT)
    facets, level = slopes.facets(tilted), profile(x, z)
    assert facets.tilt == pytest.approx(17.0, abs=EXACT)
    assert facets.normals == pytest.approx(level.normals, abs=EXACT)
    assert facets.gamma == pytest.approx(level.gamma, abs=EXACT)
    assert regular(facets).theta == pytest.approx(THETA, abs=EXACT)


@pytest.mark.parametrize("cells", [16, 17, 22, 23, 29, 35, 48])
def test_ends_within_a_ridge(cells: int) -> None:
    """Planes differ from the ridges by the inclination of the line through the ends, 0 of whole ridges.

    Of ridges of 14.04 degrees and 16 cells of 0.5 mm, 35 cells have planes of 15.26 and 12.81 degrees.
    """
    x = 0.5 * np.arange(cells + 1)
    z = trapezoid(x, 8.0, 0.0, 0.25, 0.25)
    level = np.degrees(np.arctan2(z[-1] - z[0], x[-1]))
    facets, side = profile(x, z), np.degrees(np.arctan(0.25))
    assert facets.tilt == pytest.approx(abs(level), abs=EXACT)
    found = sorted({round(angle, 9) for angle in facets.inclination.tolist()})
    assert found == pytest.approx(sorted({round(side - level, 9), round(side + level, 9)}), abs=1e-8)
    assert (found[-1] - found[0] < 1e-9) == (cells % 16 == 0)
    if cells == 35:
        assert found == pytest.approx([12.81, 15.26], abs=0.005)


def test_unequal_sides() -> None:
    """Slopes of 20 and 40 degrees give two planes in balance, with one residual strength for a direction."""
    rise, fall = np.tan(np.radians([20.0, 40.0]))
    # five points up and five down, repeated four times
    period = np.concatenate([np.full(5, 0.2 / rise), np.full(5, 0.2 / fall)])
    x = np.concatenate([[0.0], np.cumsum(np.tile(period, 4))])
    z = np.tile(np.concatenate([np.arange(5), 5 - np.arange(5)]) / 5, 4)
    z = np.append(z, 0.0)
    facets = profile(x, z)
    listed, _ = slopes.bin_facets(facets, 2, 4)
    assert np.degrees(np.arctan(Planes.of(listed).slopes)) == pytest.approx([20.0, 40.0], abs=1e-6)
    assert listed.weights @ listed.normals[:, 1:] == pytest.approx([0.0, 0.0], abs=EXACT)
    # fractions of the true length: height over sine
    expected = 1.0 / np.sin(np.radians([20.0, 40.0]))
    assert listed.weights == pytest.approx(expected / expected.sum(), abs=EXACT)
    tangent = np.array([rise, fall])
    angles = np.array([0.0, np.pi])
    strength = (MU + tangent) / (1.0 - MU * tangent)
    assert facets.slips(angles, MU).residual == pytest.approx(strength, rel=EXACT)
    # RT differs from this surface: its single angle lies between the two
    pattern = regular(facets)
    errors = slopes.compare(pattern, facets, facets.slips(angles, MU), strength)
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
    facets = slopes.facets(Scan(a, a, T * (np.abs(x % 1.0 - 0.5) + np.abs(y % 1.0 - 0.5))))
    pattern = regular(facets)
    assert pattern.m == 4
    theta = np.degrees(np.arctan(np.sqrt(2.0) * T))
    assert [pattern.theta, pattern.flat] == pytest.approx([theta, 0.0], abs=EXACT)
    assert abs(pattern.turn) == pytest.approx(45.0, abs=EXACT)
    seen = slips(facets, 0.3)
    errors = slopes.compare(pattern, facets, seen, seen.residual)
    assert max(errors.values()) < EXACT
    listed, _ = slopes.bin_facets(facets, 4, 3, 45.0)
    assert sorted(map(tuple, listed.normals.round(9).tolist())) == sorted(
        map(tuple, pattern.normals.round(9).tolist())
    )


def test_hexagons_have_six_sides() -> None:
    """Sides, theta, flat weight and rotation of RP-6 and RP-3 are identified from their own planes."""
    for sides, turn in ((3, 10.0), (5, 7.0), (6, -20.0), (2, 75.0)):
        given = Pattern.regular(sides, 25.0, 0.2, turn)
        facets = slopes.Facets(given.normals, given.weights)
        pattern = regular(facets)
        assert pattern.m == sides
        assert [pattern.theta, pattern.flat, pattern.turn] == pytest.approx([25.0, 0.2, turn], abs=1e-8)


def test_egg_box() -> None:
    """Moments of z = A sin kx sin ky: fabric (Ak)^2/4 I, mean uphill slope Ak (2/pi)^2/2, steepest Ak."""
    facets, steepest = egg_box(0.04, 40)
    assert facets.fabric == pytest.approx(0.25 * steepest**2 * np.eye(2), abs=EXACT)
    assert facets.rms_slope == pytest.approx(steepest / np.sqrt(2.0), rel=EXACT)
    mean, rms = facets.slips(np.array([0.0]), MU).uphill
    # the mean of |cos| over n points a period differs from 2/pi by up to (pi/n)^2/3, relatively
    assert mean[0] == pytest.approx(0.5 * (2.0 / np.pi) ** 2 * steepest, rel=(np.pi / 40) ** 2)
    assert rms[0] == pytest.approx(steepest / np.sqrt(8.0), rel=EXACT)
    # true area: E[sqrt(1 + g^2)] = 1 + E[g^2]/2 - E[g^4]/8, here E[g^4] = 5 (Ak)^4/16
    series = 1.0 + steepest**2 / 4 - 5.0 * steepest**4 / 128
    assert facets.ratio == pytest.approx(series, abs=steepest**6 / 16)
    # along x the steepest facets carry; across they slope by less than Ak (pi/n)^2, which enters squared
    top = steepest * np.cos(np.pi / 40)
    strength = facets.slips(np.array([0.0]), MU).residual[0]
    assert strength == pytest.approx((MU + top) / (1.0 - MU * top), rel=(steepest * (np.pi / 40) ** 2) ** 2)
    pattern = regular(facets)
    assert pattern.m > 4
    planes = Planes.of(pattern)
    assert planes.mean_slope == pytest.approx(facets.mean_slope, rel=EXACT)
    assert planes.fabric == pytest.approx(facets.fabric, abs=EXACT)


@pytest.mark.slow
def test_errors_of_an_isotropic_pattern() -> None:
    """z = A sin kx sin 2ky with RP-8: every error is a closed form of the two moments, a and b = 4a."""
    a, x, y = grid(64, 1)
    k = 2.0 * np.pi
    facets = slopes.facets(Scan(a, a, 0.03 * np.sin(k * x) * np.sin(2.0 * k * y)))
    # differences over a cell are the derivative times sinc; means of cos^2 and sin^2 over cells are 1/2
    steepest = 0.03 * k * np.array([np.sinc(1.0 / 64), 2.0 * np.sinc(2.0 / 64)])
    moments = steepest**2 / 4.0
    assert facets.fabric == pytest.approx(np.diag(moments), abs=EXACT)
    errors = slopes.compare(regular(facets, 8), facets, (seen := slips(facets)), seen.residual)
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
    facets, _ = egg_box(0.1, 30)
    lost = []
    for bins in (1, 2, 4, 7):
        listed, label = slopes.bin_facets(facets, 8, bins)
        assert len(listed.weights) <= 8 * bins + 1
        assert listed.weights @ listed.normals[:, 1:] == pytest.approx([0.0, 0.0], abs=EXACT)
        assert Planes.of(listed).nominal.min() >= slopes.LEAST_SHARE
        for k in range(len(listed.weights)):
            vector = facets.gamma[label == k] @ facets.normals[label == k]
            assert vector / np.linalg.norm(vector) == pytest.approx(listed.normals[k], abs=EXACT)
        lost.append(1.0 - np.trace(Planes.of(listed).fabric) / np.trace(facets.fabric))
    assert all(fine < coarse for coarse, fine in pairwise(lost))
    # with many classes the remaining error is the spread within a sector of 45 degrees, 1 - sinc(1/8)^2 = 5 %
    assert 0.0 < lost[-1] < 1.0 - np.sinc(1.0 / 8.0) ** 2


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
def test_residual_is_that_of_the_law() -> None:
    """The residual strength is that of the library at a large slip, also for planes of equal slope."""
    facets, _ = egg_box(0.05, 24)
    listed, _ = slopes.bin_facets(facets, 8, 2, 10.0)
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
    facets = slopes.Facets(pattern.normals, pattern.weights)
    angles = np.array([0.0, np.pi])
    seen = facets.slips(angles, 2.0)
    assert np.isinf(seen.residual).all()
    assert slopes.compare(pattern, facets, seen, seen.residual)["residual"] == 0.0
    gentle = Pattern.regular(2, 20.0)
    assert np.isinf(slopes.compare(gentle, facets, seen, seen.residual)["residual"])


# --- command ------------------------------------------------------------------------------------------------


@pytest.fixture
def no_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out the picture, which takes longest, where a test looks at the text only."""
    monkeypatch.setattr("asperity.tools.surface.picture.draw", lambda *_: None)


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
    warnings = re.findall(r"^warning +(.*)$", said("surface scan.csv")[0], re.MULTILINE)
    assert len(warnings) == bool(warning) and all(re.match(warning, text) for text in warnings)


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
    out, _ = said(f"surface scan.csv --spacing 0.05 --case box.nml -o planes {options}")
    assert Path("planes.png").stat().st_size > 10000
    assert "mu = 0.4" in out and Path("box.nml").read_text(encoding="utf-8") == BOX
    [(lines, props)] = PRINTED.findall(out)
    expected = HEADING + re.sub(r"&pattern.*?10.0 /", lines, BOX, flags=re.DOTALL)
    assert Path("planes.nml").read_text(encoding="utf-8") == expected
    interface = read_case(Path("planes.nml")).runs[0].interface
    assert [float(value) for value in props.split(",")] == pytest.approx(interface.props(), abs=1e-8)
    assert interface.material.kc == 20.0
    table = np.genfromtxt("planes.csv", delimiter=",", names=True)
    normals = np.column_stack([table[name] for name in ("n_N", "n_Tx", "n_Ty")])
    assert normals == pytest.approx(interface.pattern.normals, abs=1e-8)
    assert table["gamma"] == pytest.approx(interface.pattern.weights, abs=1e-8)
    theta, azimuth = np.radians([table["theta_deg"], table["azimuth_deg"]])
    slope = -np.sin(theta) * np.array([np.cos(azimuth), np.sin(azimuth)])
    assert normals[:, 1:] == pytest.approx(slope.T, abs=1e-7)
    said("run planes.nml -o rows.csv")
    assert {path.name for path in folder.glob("rows_*.csv")} == {"rows_-0.2.csv", "rows_-0.5.csv"}
    assert f"*Depvar\n{interface.nstatv}," in said("card abaqus planes.nml")[0]
    # CalculiX accepts no listed planes
    assert options == "--regular" or "regular" in said("card calculix planes.nml", 1)[1]


@pytest.mark.usefixtures("folder", "no_picture")
def test_lines_of_a_flat_profile(said: Callable) -> None:
    """A straight profile gives the flat plane, listed or regular; without a material PROPS have names."""
    write(rows(np.arange(9.0), 0.5 * np.arange(9.0), header="x [mm], z [mm]"))
    out, _ = said("surface scan.csv --regular")
    assert "\n&pattern sides = 0 /\n" in out and "\nPROPS  sigma0, Gc, eta, mu, 0, 0, " in out
    out, _ = said("surface scan.csv --material sigma0=3,Gc=0.3,eta=0.9,mu=0.5")
    assert "&pattern normals = 1, 0, 0, weights = 1 /" in out and "\nPROPS  3, 0.3, " in out

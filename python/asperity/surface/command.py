"""Command `asperity surface`: listed planes or the nearest regular pattern of a scanned surface."""

from __future__ import annotations

import argparse
import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import fields
from pathlib import Path

import numpy as np
from tqdm import tqdm

from .. import contract
from ..case_files import read_case
from ..contract import Floats
from ..interface import Interface
from ..pattern import Pattern
from . import slopes
from .slopes import EVEN, Facets, Planes, Scan, Slips

UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9, "in": 0.0254}
"""Units of length that a header may name, in metres."""

MU = 0.5
"""Friction for the residual strength where no material is given (Table 2 of the paper)."""

REQUIRED = tuple(row.name for row in contract.props_table() if row.default is None)
"""Constants of a material that have no default."""

PLAUSIBLE = (3.0e-3, 3.0)
"""Rms slopes beyond these are told: z may be in another unit than x."""

GROWTH = 1.1
"""The slopes depend on the scale, and it is told, where half the sampling length raises their rms by this."""

UNLIKE = 1.5
"""Ratio of the largest to the smallest spacing from which on it is told: slopes depend on the spacing."""

PATIENCE = 2.0
"""Seconds before progress is shown."""

EXPECTED = (
    "expected columns x, z (profile) or x, y, z (map), as x [mm],z [um]; --spacing for a matrix of heights"
)

ROUNDING = 1.0e-9
"""Errors and angles (degrees) below this are shown as 0."""

PERCENT = (50, 90, 99, 100)
"""Percentiles of the inclination that are told."""

_COMMA = re.compile(r"^[-+]?\d*,\d+$")
"""A number with a decimal comma."""

_CELL = re.compile(r"^\W*([A-Za-z]\w*)\s*(?:[\[(]\s*([^\])]*?)\s*[\])])?\W*$")
"""Name of a column and its unit in brackets."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    parser.add_argument(
        "scan",
        type=Path,
        metavar="SCAN.csv",
        help="columns x, z (profile) or x, y, z (map), with units in the header as x [mm]; or --spacing",
    )
    parser.add_argument(
        "--spacing",
        type=_lengths,
        metavar="DX[,DY]",
        help="the file is a matrix of heights: x along a row, y down the rows",
    )
    parser.add_argument(
        "--unit",
        default="mm",
        help="of the lengths, where the header names none (default: %(default)s)",
    )
    scale = parser.add_argument_group("scale", "slopes depend on it; in the unit of x")
    scale.add_argument("--smooth", type=float, metavar="L", help="Gaussian filter of this cut-off first")
    scale.add_argument(
        "--sampling", type=float, metavar="L", help="facets of this length (default: the points')"
    )
    planes = parser.add_argument_group("planes")
    planes.add_argument(
        "--regular", action="store_true", help="the nearest regular pattern, not listed planes"
    )
    planes.add_argument("--sides", type=int, metavar="M", help="of the regular pattern (default: looked for)")
    planes.add_argument(
        "--directions", type=int, metavar="D", help="sectors of azimuth of the listed planes (default: 8)"
    )
    planes.add_argument("--bins", type=int, metavar="B", help="classes of inclination in each (default: 3)")
    planes.add_argument(
        "--planes", type=int, metavar="N", help="at most so many listed planes: as many bins as that allows"
    )
    planes.add_argument(
        "--flat-below",
        type=float,
        metavar="DEG",
        help="facets up to this are the flat plane (default: 0)",
    )
    planes.add_argument(
        "--direction",
        type=float,
        default=0.0,
        metavar="DEG",
        help="of the profile, or of the first sector, from Tx towards Ty (default: 0)",
    )
    planes.add_argument(
        "--material",
        type=_material,
        metavar="NAME=VALUE,...",
        help=f"{', '.join(REQUIRED)} for the PROPS line and the residual strength (default: names, "
        f"mu = {MU:g})",
    )
    parser.add_argument(
        "--case",
        type=Path,
        metavar="CASE.nml",
        help="a case of the driver: the same with this pattern is written, for run, card and select",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE.csv",
        help="table of the planes; picture, and with --case the case, are written beside it, .png and .nml "
        "(default: the name of the scan with _planes.csv, here)",
    )
    parser.set_defaults(action=_run)


def read_scan(path: Path, spacing: Sequence[float] | None = None, unit: str = "mm") -> Scan:
    """Profile or height map of a CSV; with a spacing (dx, dy) it is a matrix of heights.

    Separators are commas, semicolons or blanks; lines from # on are left out.  Lengths are turned into the
    unit of x; `unit` is that of a file that names none.  Raises ValueError that names line and value.
    """
    header, rows = _cells(path)
    if spacing is not None:
        if header:
            raise ValueError(f"{path}: {', '.join(header)}: expected a matrix of numbers, as --spacing says")
        z = _table(path, rows)
        dx, dy = spacing[0], spacing[-1]
        _enough(path, "columns", z.shape[1])
        _enough(path, "rows", z.shape[0])
        return Scan(dx * np.arange(z.shape[1]), dy * np.arange(z.shape[0]), z, unit)
    names, units = _columns(path, header, len(rows[0][1]) if rows else 0)
    table = _table(path, rows)
    unit = units[names.index("x")] or unit
    data = {n: table[:, i] * (_metres(path, u) / _metres(path, unit) if u else 1.0)
            for i, (n, u) in enumerate(zip(names, units, strict=True))}  # fmt: skip
    lines = [line for line, _ in rows]
    return _profile(path, data, lines, unit) if len(names) == 2 else _map(path, data, lines, unit)


def case_lines(pattern: Pattern) -> str:
    """Group &pattern of a case file, a plane a line."""
    if pattern.m >= 0:
        text = f"&pattern sides = {pattern.m}"
        if pattern.m > 0:
            text += f", theta = {pattern.theta:.9g}, flat = {pattern.flat:.9g}, turn = {pattern.turn:.9g}"
        return f"{text} /"
    rows = [", ".join(f"{value:.9f}" for value in normal) for normal in _rounded(pattern.normals)]
    weights = [f"{value:.9f}" for value in pattern.weights]
    wrapped = [", ".join(weights[i : i + 6]) for i in range(0, len(weights), 6)]
    join = ",\n" + " " * 19
    return f"&pattern normals = {join.join(rows)},\n         weights = {join.join(wrapped)} /"


def props_line(pattern: Pattern, material: Sequence[float] | None = None) -> str:
    """PROPS of a pattern, up to the last value that is not its default; names for a material not given."""
    defaults = [row.default for row in contract.props_table()]
    props = contract.pack(pattern.values())
    last = contract.N_FIXED_PROPS
    if pattern.m >= 0:
        last = max(i for i, value in enumerate(props) if i < 6 or value != defaults[i]) + 1
    first = list(REQUIRED) if material is None else [f"{value:.9g}" for value in material]
    rest = [f"{value:.9g}" for value in props[len(first) : last]]
    if pattern.m < 0:
        planes = np.column_stack([pattern.normals, pattern.weights])
        rest += [f"{value:.9f}" for value in _rounded(planes).ravel()]
    return ", ".join(first + rest)


def _run(options: argparse.Namespace) -> int:
    """Read, level, bin, compare, write."""
    _check(options)
    table, png, case = _outputs(options)
    template = None if options.case is None else read_case(options.case)
    of_case = None if template is None else template.runs[0].material
    if template is not None and any(run.material != of_case for run in template.runs):
        raise ValueError(f"{template.path}: &material: expected numbers, not the name of a sweep")
    mu = of_case.mu if of_case is not None else options.material[3] if options.material is not None else MU
    original = scan = read_scan(options.scan, options.spacing, options.unit)
    if options.smooth is not None:
        scan = scan.smoothed(options.smooth)
    smooth = scan
    if options.sampling is not None:
        scan = scan.sampled(options.sampling)
    found = slopes.facets(scan, options.direction)
    if found.profile and options.sides not in (None, 2):
        raise ValueError(f"--sides {options.sides}: expected 2 for a profile, which knows one direction")
    listed, label = _listed(options, found, _directions(options, found))
    angles = slopes.directions_of(found, options.direction)
    lengths = slopes.lengths_of(smooth)
    total = 2 * len(angles) + len(lengths)
    with tqdm(total=total, unit="step", disable=None, delay=PATIENCE, leave=False) as bar:
        slips = Slips.of(found, angles, mu, bar.update)
        regular = slopes.nearest_regular(found, slips, options.sides or 0, options.direction)
        scales = np.array(list(_scales(smooth, lengths, regular, options.direction, bar.update)))
    print("\n".join(_report(original, scan, found, slips, options)))
    print(f"\n{'pattern':<22}planes  mean slope    fabric    uphill  residual    listed")
    of_listed = Planes.of(listed).residual(angles, slips.mu)
    for pattern in (listed, regular):
        errors = slopes.compare(pattern, found, slips, of_listed)
        texts = [_shown(getattr(errors, field.name)) for field in fields(errors)]
        start = f"{_name(pattern):<22}{len(pattern.weights):>6}{texts[0]:>12}"
        print(start + "".join(f"{text:>10}" for text in texts[1:]))
    print(f"\n{f'sampling, {scan.unit}':>14}{'mean slope':>12}{'rms slope':>12}{'theta':>8}{'flat':>8}")
    for length, mean, rms, theta, flat in scales:
        print(f"{length:>14.4g}{mean:>12.4f}{rms:>12.4f}{theta:>8.2f}{flat:>8.3f}")
    remarks = [f"remark      {text}" for text in _remarks(scan, found, options.direction)]
    print("\n".join(["", *remarks, ""]) if remarks else "")
    chosen = regular if options.regular else listed
    written = [table, png]
    props = props_line(chosen, options.material)
    if template is not None and of_case is not None:
        case.write_bytes(template.before + case_lines(chosen).encode() + template.after)
        props = ", ".join(f"{value:.9g}" for value in Interface(of_case, chosen).props().tolist())
        written.append(case)
    print(f"{case_lines(chosen)}\n\nPROPS  {props}\n")
    _write(table, chosen)
    from .picture import draw

    shown = label if chosen is listed else _nearest(found, chosen)
    draw(scan, found, (listed, regular), chosen, shown, slips, scales, png, options.scan.name)
    print("\n".join(map(str, written)))
    return 0


def _check(options: argparse.Namespace) -> None:
    """Options that need no scan."""
    listing = (options.bins, options.planes, options.directions, options.flat_below)
    if options.regular and any(value is not None for value in listing):
        raise ValueError(
            "--regular: expected without --bins, --directions, --flat-below and --planes, which list planes"
        )
    if options.sides is not None and not options.regular:
        raise ValueError("--sides: expected with --regular, listed planes have no number of sides")
    if options.bins is not None and options.planes is not None:
        raise ValueError("--bins, --planes: expected one of them")
    if options.sides is not None and not 2 <= options.sides <= contract.MAX_INCLINED:
        raise ValueError(f"--sides {options.sides}: expected 2 to {contract.MAX_INCLINED}")
    if not np.isfinite(options.direction):
        raise ValueError(f"--direction {options.direction}: expected a finite angle")
    if options.unit not in UNITS:
        raise ValueError(f"--unit {options.unit}: expected one of {', '.join(UNITS)}")
    if options.case is not None and options.material is not None:
        raise ValueError("--case, --material: expected one of them, a case has its material")


def _outputs(options: argparse.Namespace) -> tuple[Path, Path, Path]:
    """Table, picture and case; never the scan or the case that is read, and in a folder that is there."""
    stem = options.output or Path(f"{options.scan.stem}_planes")
    if stem.suffix in (".csv", ".png", ".nml"):
        stem = stem.with_suffix("")
    if not stem.name:
        raise ValueError(f"-o {stem}: expected a name")
    if not stem.parent.is_dir():
        raise ValueError(f"-o {stem}: expected a folder that exists, {stem.parent} does not")
    table, png, case = (stem.with_name(stem.name + suffix) for suffix in (".csv", ".png", ".nml"))
    read = [path.resolve() for path in (options.scan, options.case) if path is not None]
    for path in (table, png, case):
        if path.resolve() in read:
            raise ValueError(f"-o {stem}: {path} is read: expected another name")
    return table, png, case


def _shown(error: float) -> str:
    """An error in the table."""
    if np.isinf(error):
        return "locks"
    return f"{error:.1e}" if error > ROUNDING else "0"


def _scales(
    scan: Scan, lengths: Floats, regular: Pattern, direction: float, tick: slopes.Tick
) -> Iterator[tuple[float, ...]]:
    """Sampling length, mean and rms slope, theta and flat share of the regular pattern of the same sides."""
    for length in lengths:
        found = slopes.facets(scan.sampled(length), direction)
        pattern = slopes.nearest_regular(found, None, regular.m or 2, direction)
        theta, flat = (pattern.theta, pattern.flat) if pattern.m else (0.0, 1.0)
        yield float(length), found.mean_slope, found.rms_slope, theta, flat
        tick()


def _remarks(scan: Scan, found: Facets, direction: float) -> Iterator[str]:
    """Doubts about units and scale."""
    rms, unit = found.rms_slope, scan.unit
    if rms > slopes.FLATNESS and not PLAUSIBLE[0] <= rms <= PLAUSIBLE[1]:
        yield f"an rms slope of {rms:.2g} is unusual: are x and z in the same unit?"
    low, high = scan.steps()
    if high > UNLIKE * low:
        yield f"points are {low:g} to {high:g} {unit} apart, not one scale: --sampling {high:g} makes it one"
    length = 2.0 * scan.spacing
    if rms > slopes.FLATNESS and length <= slopes.longest(scan):
        coarse = slopes.facets(scan.sampled(length), direction).rms_slope
        if rms > GROWTH * coarse:
            yield (
                f"the rms slope at {scan.spacing:g} {unit} is {rms / coarse - 1.0:.0%} above that at "
                f"{length:g}: no plateau, the planes are those of this scale; --sampling, --smooth choose it"
            )


def _report(
    original: Scan,
    scan: Scan,
    found: Facets,
    slips: Slips,
    options: argparse.Namespace,
) -> list[str]:
    """What the scan is like."""
    unit = scan.unit
    points = (
        f"{len(original.x)} points" if original.y is None else f"{len(original.x)} x {len(original.y)} points"
    )
    extent = f"{np.ptp(original.x):g} {unit}" if original.y is None else (
        f"{np.ptp(original.x):g} x {np.ptp(original.y):g} {unit}")  # fmt: skip
    order = np.argsort(found.slopes)
    below = np.cumsum(found.nominal[order])
    at = [
        found.slopes[order][min(np.searchsorted(below, p / 100 * below[-1]), len(order) - 1)] for p in PERCENT
    ]
    steep = ", ".join(f"{p} %: {np.degrees(np.arctan(t)):.2f}" for p, t in zip(PERCENT, at, strict=True))
    heights = scan.heights()
    tilt = found.tilt if found.tilt > ROUNDING else 0.0
    lean = lean if (lean := scan.lean()) > ROUNDING else 0.0
    low, high = slips.residual.min(), slips.residual.max()
    shown = ["locks" if np.isinf(value) else f"{value:.4f}" for value in (low, high)]
    filtered = "" if options.smooth is None else f", smoothed over {options.smooth:g}"
    return [
        f"scan        {'profile' if scan.is_profile else 'map'}, {points}, {extent}{filtered}",
        f"level       average plane tilted by {tilt:.4g} degrees, turned away; "
        f"{lean:.3g} degrees from that of least squares",
        f"facets      {len(found.gamma)} at {_apart(scan)} {unit}; true/nominal area {found.ratio:.4f}",
        f"heights     rms {heights.std():.4g} {unit}, range {np.ptp(heights):.4g} {unit}",
        f"slopes      mean {found.mean_slope:.4f}, rms {found.rms_slope:.4f} (tangent)",
        f"inclined    {steep} degrees (share of the nominal area)",
        f"residual    {shown[0]} to {shown[1]} |sigma_N| over {len(slips.angles)} directions, "
        f"mu = {slips.mu:g}: set by the steepest facet along the slip",
    ]


def _apart(scan: Scan) -> str:
    """Spacing of the points."""
    low, high = scan.steps()
    return f"{high:g}" if high <= low * (1.0 + 2.0 * EVEN) else f"{low:g} to {high:g}"


def _directions(options: argparse.Namespace, found: Facets) -> int:
    """Sectors of azimuth."""
    if found.profile:
        if options.directions not in (None, 2):
            raise ValueError(f"--directions {options.directions}: expected 2 for a profile")
        return 2
    if options.directions is not None and options.directions < 2:
        raise ValueError(f"--directions {options.directions}: expected 2 or more")
    return options.directions or 8


def _listed(options: argparse.Namespace, found: Facets, directions: int) -> tuple[Pattern, np.ndarray]:
    """Listed planes by the options."""
    for name in ("bins", "planes"):
        value = getattr(options, name)
        if value is not None and not 1 <= value <= contract.MAX_INCLINED:
            raise ValueError(f"--{name} {value}: expected 1 to {contract.MAX_INCLINED}")
    flat = 0.0 if options.flat_below is None else options.flat_below
    if not 0.0 <= flat < 90.0:
        raise ValueError(f"--flat-below {flat:g}: expected an angle from 0 to below 90 degrees")
    bins = options.bins or 3
    if options.planes is not None:
        if options.planes < directions + 1:
            raise ValueError(
                f"--planes {options.planes}: expected at least {directions + 1} for {directions} directions"
            )
        bins = (options.planes - 1) // directions
    if directions * bins + 1 > contract.MAX_INCLINED:
        raise ValueError(
            f"{directions} directions of {bins} bins and the flat plane are {directions * bins + 1} planes: "
            f"expected at most {contract.MAX_INCLINED}"
        )
    return slopes.bin_facets(found, directions, bins, options.direction, flat)


def _nearest(found: Facets, pattern: Pattern) -> np.ndarray:
    """Plane of a pattern that is nearest to each facet in slope, (n,)."""
    planes = Planes.of(pattern).gradients
    return np.array([np.hypot(*(found.gradients - g).T) for g in planes]).argmin(axis=0)


def _name(pattern: Pattern) -> str:
    """Short name of a pattern, with its angle."""
    if pattern.m < 0:
        return "listed"
    if pattern.m == 0:
        return "flat"
    return f"{'RT' if pattern.m == 2 else f'RP-{pattern.m}'}, {pattern.theta:.2f} deg"


def _write(path: Path, pattern: Pattern) -> None:
    """Planes of a pattern as CSV."""
    planes = Planes.of(pattern)
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(
            ["plane", "theta_deg", "azimuth_deg", "n_N", "n_Tx", "n_Ty", "gamma", "nominal_share"]
        )
        azimuth = np.arctan2(planes.gradients[:, 1], planes.gradients[:, 0])
        angles = np.degrees([np.arctan(planes.slopes), azimuth])
        rows = np.column_stack([*angles, planes.normals, planes.gamma, planes.nominal])
        for k, row in enumerate(_rounded(rows), start=1):
            writer.writerow([k, *(f"{value:.9f}" for value in row)])


def _cells(path: Path) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Header (empty without one) and the rows with their line numbers."""
    header: list[str] = []
    rows: list[tuple[int, list[str]]] = []
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}: expected a CSV with a profile or a height map") from None
    except UnicodeDecodeError as error:
        raise ValueError(
            f"{path}: byte {error.start} is no text in UTF-8: expected a CSV with a profile or a height map"
        ) from None
    shown = tqdm(lines, unit="line", desc="read", disable=None, delay=PATIENCE, leave=False)
    for line, text in enumerate(shown, start=1):
        text = text.split("#")[0].strip()
        if not text:
            continue
        mark = next((mark for mark in ";,\t" if mark in text), None)
        cells = [cell.strip().strip('"') for cell in text.split(mark)]
        if not rows and not header and not any(_is_number(cell) or _COMMA.match(cell) for cell in cells):
            header = cells if mark else re.findall(r"\w+\s*(?:[\[(][^\])]*[\])])?", text)
        else:
            rows.append((line, cells))
    return header, rows


def _columns(path: Path, header: list[str], count: int) -> tuple[list[str], list[str]]:
    """Names and units of the columns."""
    if not header:
        if count not in (2, 3):
            raise ValueError(f"{path}: {count} columns without names: {EXPECTED}")
        return ["x", "z"] if count == 2 else ["x", "y", "z"], [""] * count
    found = [_CELL.match(cell) for cell in header]
    names = ["" if m is None else m[1].lower() for m in found]
    if sorted(names) not in (["x", "z"], ["x", "y", "z"]):
        raise ValueError(f"{path}: columns {', '.join(header)}: {EXPECTED}")
    units = ["" if m is None else m[2] or "" for m in found]
    if any(units) and not all(units):
        raise ValueError(f"{path}: columns {', '.join(header)}: expected a unit for all or none, as x [mm]")
    return names, units


def _table(path: Path, rows: list[tuple[int, list[str]]]) -> Floats:
    """Numbers of the rows."""
    if not rows:
        raise ValueError(f"{path}: expected rows of numbers")
    width = len(rows[0][1])
    for line, cells in rows:
        if len(cells) != width:
            raise ValueError(f"{path}, line {line}: {len(cells)} values: expected {width}")
        for cell in cells:
            if not _is_number(cell) or not np.isfinite(float(cell)):
                point = " with a decimal point" if _COMMA.match(cell) else ""
                raise ValueError(f"{path}, line {line}: {cell or 'nothing'}: expected a finite number{point}")
    return np.array([cells for _, cells in rows], dtype=float)


def _profile(path: Path, data: dict[str, Floats], lines: list[int], unit: str) -> Scan:
    """Profile with x increasing; one that decreases throughout is turned round."""
    x, z = data["x"], data["z"]
    _enough(path, "points", len(x))
    steps = np.diff(x)
    if (steps < 0.0).all():
        x, z, lines, steps = x[::-1], z[::-1], lines[::-1], -steps[::-1]
    if not (steps > 0.0).all():
        i = int((steps <= 0.0).argmax())
        what = "vertical" if steps[i] == 0.0 else "overhang, or the points are not in order"
        raise ValueError(
            f"{path}, line {lines[i + 1]}: x = {x[i + 1]:g} after {x[i]:g}: expected x to increase ({what})"
        )
    return Scan(x.copy(), None, z[None, ::1].copy(), unit)


def _map(path: Path, data: dict[str, Floats], lines: list[int], unit: str) -> Scan:
    """Map on the grid of its points, which may come in any order."""
    axes, places = [], []
    for name in ("x", "y"):
        given = data[name]
        order = np.argsort(given, kind="stable")
        sizes = np.diff(given[order])
        # values of a grid line may differ by rounding
        new = sizes > EVEN * max(sizes.max(initial=0.0), 0.0)
        place = np.empty(len(given), dtype=int)
        place[order] = np.concatenate([[0], np.cumsum(new)])
        axis = np.bincount(place, given) / np.bincount(place)
        if len(axis) == 1:
            raise ValueError(f"{path}: {name} = {axis[0]:g} throughout: expected a map; a profile is x, z")
        _enough(path, f"different {name}", len(axis))
        steps = np.diff(axis)
        if np.abs(axis - slopes.even(axis)).max() > EVEN * steps.mean():
            i = int((np.abs(steps - np.median(steps)) > EVEN * np.median(steps)).argmax())
            raise ValueError(
                f"{path}: {name} = {axis[i]:g} and {axis[i + 1]:g}, {len(axis)} different {name}: expected a "
                f"regular grid along x and y, here of spacing {np.median(steps):g}; interpolate points that "
                "lie elsewhere onto one"
            )
        axes.append(slopes.even(axis))
        places.append(place)
    x, y = axes
    count = np.zeros((len(y), len(x)), dtype=int)
    np.add.at(count, (places[1], places[0]), 1)
    if (count > 1).any():
        j, i = np.argwhere(count > 1)[0]
        second = lines[np.flatnonzero((places[0] == i) & (places[1] == j))[1]]
        raise ValueError(
            f"{path}, line {second}: x = {x[i]:g}, y = {y[j]:g} again: expected one height a point"
        )
    if (count == 0).any():
        j, i = np.argwhere(count == 0)[0]
        raise ValueError(
            f"{path}: {np.count_nonzero(count == 0)} points of the grid are missing, the first at "
            f"x = {x[i]:g}, y = {y[j]:g}: expected a regular grid of {len(x)} x {len(y)} points"
        )
    z = np.empty((len(y), len(x)))
    z[places[1], places[0]] = data["z"]
    return Scan(x, y, z, unit)


def _enough(path: Path, what: str, count: int) -> None:
    if count < slopes.LEAST_POINTS:
        raise ValueError(f"{path}: {count} {what}: expected at least {slopes.LEAST_POINTS}")


def _metres(path: Path, unit: str) -> float:
    if unit not in UNITS:
        raise ValueError(f"{path}: unit {unit}: expected one of {', '.join(UNITS)}")
    return UNITS[unit]


def _rounded(values: Floats) -> Floats:
    """Values to the digits that are printed, without -0."""
    found: Floats = np.round(values, 9) + 0.0
    return found


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _lengths(text: str) -> tuple[float, ...]:
    """Spacings of the option."""
    try:
        found = tuple(float(part) for part in text.split(","))
    except ValueError:
        found = ()
    if len(found) not in (1, 2) or not all(np.isfinite(v) and v > 0.0 for v in found):
        raise argparse.ArgumentTypeError(f"{text}: expected DX or DX,DY, lengths > 0")
    return found


def _material(text: str) -> tuple[float, ...]:
    """Constants of the option, in the order of PROPS."""
    try:
        pairs = [part.partition("=") for part in text.split(",")]
        values = {name.strip(): contract.number(name, value) for name, _, value in pairs}  # type: ignore[arg-type]
        if set(values) != set(REQUIRED) or len(values) < len(pairs):
            raise ValueError("expected " + ",".join(f"{name}=VALUE" for name in REQUIRED))
        contract.check(contract.pack(values))
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text}: {error}") from None
    return tuple(values[name] for name in REQUIRED)

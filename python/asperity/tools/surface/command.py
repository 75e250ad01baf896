"""Command `asperity surface`: listed planes or the nearest regular pattern of a scanned surface."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ... import contract
from ...case_files import read_case
from ...case_writer import pattern_text
from ...interface import Interface
from ...material import Material
from ...model_checks import shown_warnings
from ...options import add_options, add_output, check_outputs, numbers, progress_bar, replace_file
from ...pattern import Pattern
from . import slopes
from .scan import EVEN, Scan
from .scan_files import read_scan
from .slopes import FLATNESS, Facets, Planes, Slips

MU = 0.5  # friction for the residual strength where no material is given (Table 2 of the paper)
HEADER = "plane,theta_deg,azimuth_deg,n_N,n_Tx,n_Ty,gamma,nominal_share"  # first line of the table
HEADING = "! Pattern of asperity surface.\n"  # first line of the case
REQUIRED = tuple(row.name for row in contract.props_table() if row.default is None)
"""Constants of a material that have no default."""

ROUNDING = 1.0e-9  # errors and angles (degrees) below this are shown as 0
GROWTH = 1.1  # a warning is printed if half the sampling length raises the rms slope by this factor
UNLIKE = 1.5
"""Ratio of the largest to the smallest spacing that gives a warning, because slopes depend on the spacing."""

PERCENT = (50, 90, 99, 100)  # percentiles of the inclination that are printed


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    add_options(
        parser,
        (
            "scan SCAN",
            "columns x, z (profile) or x, y, z (map) with units, a matrix (--spacing), a grid of ESRI, or "
            "triangles (.stl)",
            Path,
        ),
        ("--spacing DX[,DY]", "a CSV is a matrix, x along a row, y downwards; grid of triangles", _lengths),
        ("--unit UNIT", "unit of lengths whose header names none", "mm"),
        ("--nodata VALUE", "height that marks missing points, beside -9999 and other usual ones", list),
        ("--keep-spikes", "read a scan with heights far above or below all others, which are refused"),
    )
    scale = parser.add_argument_group("scale", "slopes depend on it; in the unit of x")
    add_options(
        scale,
        ("--smooth L", "cut-off length of a Gaussian filter", float),
        ("--sampling L", "length of the facets (default: that of the scan)", float),
    )
    constants = f"{', '.join(REQUIRED)}, for PROPS and residual strength (default: names, mu = {MU:g})"
    add_options(
        parser.add_argument_group("planes"),
        ("--regular", "the nearest regular pattern, not listed planes"),
        ("--sides M", "inclined planes of the regular pattern (default: best)", int),
        ("--directions D", "sectors of azimuth of the listed planes (default: 8)", int),
        ("--bins B", "classes of inclination in each (default: 3)", int),
        ("--planes N", "largest number of listed planes; it sets the bins", int),
        ("--flat-below DEG", "facets inclined by at most this form the flat plane (default: 0)", float),
        ("--direction DEG", "direction of the profile, or of the first sector, from Tx towards Ty", 0.0),
        ("--material NAME=VALUE,...", constants, str),
    )
    add_options(
        parser,
        ("--case CASE.nml", "case of the driver, of which a copy gets the pattern that is found", Path),
    )
    add_output(
        parser,
        "FILE.csv",
        "table of the planes; beside it the picture, .png, and with --case the case, .nml "
        "(default: the name of the scan with _planes.csv, here)",
    )
    parser.set_defaults(action=_run)


def props_line(pattern: Pattern, material: Material | None) -> str:
    """PROPS of a pattern; without a material the names of its constants stand for their values."""
    if material is not None:
        return ", ".join(f"{value:.9g}" for value in Interface(material, pattern).props())
    values = contract.pack(pattern.values(), pattern.constants())[len(REQUIRED) :]
    return ", ".join([*REQUIRED, *(f"{value:.9g}" for value in values)])


def _run(options: argparse.Namespace) -> int:
    """Read a scan, find the planes of its average and their classes, compare patterns, write the results."""
    _check(options)
    table, png, case = _outputs(options)
    template = None if options.case is None else read_case(options.case)
    if template is not None and any(run.material != template.runs[0].material for run in template.runs):
        raise ValueError(f"{template.path}: &material: expected numbers, not the name of a sweep")
    material = _material(options.material) if template is None else template.runs[0].material
    mu = MU if material is None else material.mu
    nodata = [contract.number("--nodata", text) for text in options.nodata]
    with shown_warnings():
        original = read_scan(options.scan, options.spacing, options.unit, nodata, options.keep_spikes)
    smooth = original if options.smooth is None else original.smoothed(options.smooth)
    scan = smooth if options.sampling is None else smooth.sampled(options.sampling)
    facets = slopes.facets(scan, options.direction)
    slopes.refuse_impossible(facets)
    if facets.profile and options.sides not in (None, 2):
        raise ValueError(f"--sides {options.sides}: expected 2 for a profile, which knows one direction")
    listed, label = _listed(options, facets)
    angles = slopes.directions_of(facets, options.direction)
    with progress_bar(len(angles) + len(smooth.lengths), "step") as bar:
        slips = facets.slips(angles, mu, bar.update)
        regular = slopes.nearest_regular(facets, slips, options.sides or 0, options.direction)
        rows = []
        for length in smooth.lengths:
            coarse = smooth.sampled(length) if length <= smooth.longest else smooth
            part = slopes.facets(coarse, options.direction)
            like = slopes.nearest_regular(part, None, regular.m or 2, options.direction)
            rows.append((length, part.mean_slope, part.rms_slope, like.theta, like.flat if like.m else 1.0))
            bar.update()
    points, extent = (" x ".join(f"{f(axis):g}" for axis in original.axes) for f in (len, np.ptp))
    filtered = "" if options.smooth is None else f", smoothed over {options.smooth:g}"
    kind = "profile" if scan.y is None else "map"
    print(f"scan        {kind}, {points} points, {extent} {scan.unit}{filtered}")
    print(report(scan, facets, slips))
    print(f"\n{'pattern':<22}planes  mean slope    fabric    uphill  residual    listed")
    of_listed = Planes.of(listed).slips(angles, mu).residual
    for pattern in (listed, regular):
        texts = [*map(_shown, slopes.compare(pattern, facets, slips, of_listed).values())]
        start = f"{_name(pattern):<22}{len(pattern.weights):>6}{texts[0]:>12}"
        print(start + "".join(f"{text:>10}" for text in texts[1:]))
    print(f"\n{f'sampling, {scan.unit}':>14}{'mean slope':>12}{'rms slope':>12}{'theta':>8}{'flat':>8}")
    for length, mean, rms, theta, flat in rows:
        print(f"{length:>14.4g}{mean:>12.4f}{rms:>12.4f}{theta:>8.2f}{flat:>8.3f}")
    told = [f"warning     {text}" for text in scale_warnings(scan, facets, options.direction)]
    print("\n".join(["", *told, ""]) if told else "")
    chosen = regular if options.regular else listed
    written = [table, png]
    if template is not None:
        lines = pattern_text(chosen).encode()
        replace_file(case, HEADING.encode() + template.before + lines + template.after)
        written.append(case)
    print(f"{pattern_text(chosen)}\n\nPROPS  {props_line(chosen, material)}\n")
    _write(table, chosen)
    from .picture import draw

    if chosen is regular:  # the plane that is nearest to each facet in slope
        away = [np.hypot(*(facets.gradients - gradient).T) for gradient in Planes.of(regular).gradients]
        label = np.argmin(away, axis=0)
    draw(scan, facets, (listed, regular), chosen, label, slips, np.array(rows), png, options.scan.name)
    print("\n".join(map(str, written)))
    return 0


def scale_warnings(scan: Scan, facets: Facets, direction: float) -> Iterator[str]:
    """Warnings about units and scale."""
    rms, unit, (low, high) = facets.rms_slope, scan.unit, scan.steps
    if facets.doubt:
        yield facets.doubt
    if high > UNLIKE * low:
        yield f"points are {low:g} to {high:g} {unit} apart; --sampling {high:g} gives them one scale"
    if rms > FLATNESS and 2.0 * high <= scan.longest:
        coarse = slopes.facets(scan.sampled(2.0 * high), direction).rms_slope
        if rms > GROWTH * coarse:
            yield (
                f"the rms slope at {high:g} {unit} is {rms / coarse - 1.0:.0%} above that at {2.0 * high:g}: "
                "there is no plateau, so the planes depend on the scale, which --sampling and --smooth set"
            )


def report(scan: Scan, facets: Facets, slips: Slips) -> str:
    """Lines that describe the facets of a scan."""
    unit, (low, high), heights = scan.unit, scan.steps, scan.heights
    apart = f"{high:g}" if high <= low * (1.0 + 2.0 * EVEN) else f"{low:g} to {high:g}"
    order = np.argsort(facets.slopes)
    below = np.cumsum(facets.nominal[order])
    at = np.searchsorted(below, np.array(PERCENT) / 100 * below[-1]).clip(max=len(order) - 1)
    angles = zip(PERCENT, facets.inclination[order][at], strict=True)
    steep = ", ".join(f"{p} %: {angle:.2f}" for p, angle in angles)
    tilt, lean = (angle if angle > ROUNDING else 0.0 for angle in (facets.tilt, scan.lean))
    ends = (slips.residual.min(), slips.residual.max())
    strengths = " to ".join("locks" if np.isinf(value) else f"{value:.4f}" for value in ends)
    return "\n".join([
        f"level       average plane inclined by {tilt:.4g} degrees, rotated to level; {lean:.3g} degrees "
        "from the least-squares plane",
        f"facets      {len(facets.gamma)} at {apart} {unit}; true/nominal area {facets.ratio:.4f}",
        f"heights     rms {heights.std():.4g} {unit}, range {np.ptp(heights):.4g} {unit}",
        f"slopes      mean {facets.mean_slope:.4f}, rms {facets.rms_slope:.4f} (tangent)",
        f"inclined    {steep} degrees (fraction of the nominal area)",
        f"residual    {strengths} |sigma_N| over {len(slips.angles)} directions, mu = {slips.mu:g}: set by "
        "the steepest facet along the slip",
    ])  # fmt: skip


def _check(options: argparse.Namespace) -> None:
    """Check the options that do not depend on the scan."""
    listing = (options.bins, options.planes, options.directions, options.flat_below)
    if options.regular and any(value is not None for value in listing):
        raise ValueError(
            "--regular: expected without --bins, --directions, --flat-below and --planes, which list planes"
        )
    if options.sides is not None and not options.regular:
        raise ValueError("--sides: expected with --regular, listed planes have no such number")
    if options.sides is not None and not 2 <= options.sides <= contract.MAX_INCLINED:
        raise ValueError(f"--sides {options.sides}: expected 2 to {contract.MAX_INCLINED}")
    for pair, why in (("bins planes", ""), ("case material", ", a case has its material")):
        if all(getattr(options, name) is not None for name in pair.split()):
            raise ValueError(f"--{pair.replace(' ', ', --')}: expected one of them{why}")


def _outputs(options: argparse.Namespace) -> tuple[Path, Path, Path]:
    """Names of table, picture and case."""
    stem = options.output or Path(f"{options.scan.stem}_planes")
    if stem.suffix in (".csv", ".png", ".nml"):
        stem = stem.with_suffix("")
    if not stem.name:
        raise ValueError(f"-o {stem}: expected a name")
    table, png, case = (stem.with_name(stem.name + suffix) for suffix in (".csv", ".png", ".nml"))
    written = ("-o", table, HEADER), ("-o", png), ("-o", None if options.case is None else case, HEADING)
    check_outputs(options.force, [options.scan, options.case], *written)
    return table, png, case


def _listed(options: argparse.Namespace, facets: Facets) -> tuple[Pattern, np.ndarray]:
    """Listed planes according to the options, and the plane of every facet."""
    directions = (2 if facets.profile else 8) if options.directions is None else options.directions
    bins = 3 if options.bins is None else options.bins
    if options.planes is not None:
        if not directions < options.planes <= contract.MAX_INCLINED:
            text = f"expected {directions + 1} to {contract.MAX_INCLINED} for {directions} directions"
            raise ValueError(f"--planes {options.planes}: {text}")
        bins = (options.planes - 1) // max(directions, 1)
    return slopes.bin_facets(facets, directions, bins, options.direction, options.flat_below or 0.0)


def _shown(error: float) -> str:
    if np.isinf(error):
        return "locks"
    return f"{error:.1e}" if error > ROUNDING else "0"


def _name(pattern: Pattern) -> str:
    if pattern.m <= 0:
        return "listed" if pattern.m else "flat"
    return f"{'RT' if pattern.m == 2 else f'RP-{pattern.m}'}, {pattern.theta:.2f} deg"


def _write(path: Path, pattern: Pattern) -> None:
    planes = Planes.of(pattern)
    columns = planes.inclination, np.degrees(planes.azimuth), planes.normals, planes.gamma, planes.nominal
    rows = np.column_stack([np.arange(len(planes.gamma)) + 1, np.round(np.column_stack(columns), 9) + 0.0])
    np.savetxt(path, rows, ["%d", *["%.9f"] * 7], ",", header=HEADER, comments="")


def _lengths(text: str) -> tuple[float, ...]:
    try:
        lengths = tuple(float(contract.plain(part)) for part in text.split(","))
    except ValueError:
        lengths = ()
    if len(lengths) not in (1, 2) or not all(np.isfinite(v) and v > 0.0 for v in lengths):
        raise argparse.ArgumentTypeError(f"{text}: expected DX or DX,DY, lengths > 0")
    return lengths


def _material(text: str | None) -> Material | None:
    if text is None:
        return None
    values = {name: value for name, (value,) in numbers("--material", text.split(","), 1).items()}
    if set(values) != set(REQUIRED):
        raise ValueError(f"--material {text}: expected {','.join(f'{name}=VALUE' for name in REQUIRED)}")
    return Material(**values)

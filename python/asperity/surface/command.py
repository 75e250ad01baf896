"""Command `asperity surface`: listed planes or the nearest regular pattern of a scanned surface."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from .. import contract
from ..case_files import read_case
from ..case_writer import pattern_text
from ..fit.units import size
from ..interface import Interface
from ..material import Material
from ..options import add_options, add_output, assigned, check_outputs, progress_bar, replace_file
from ..pattern import Pattern
from ..remarks import shown_warnings
from . import slopes
from .report import ROUNDING, remarks, report
from .scan import lengths_of
from .scan_files import read_scan
from .slopes import Facets, Planes

MU = 0.5
"""Friction for the residual strength where no material is given (Table 2 of the paper)."""

HEADER = "plane,theta_deg,azimuth_deg,n_N,n_Tx,n_Ty,gamma,nominal_share"
HEADING = "! Pattern of asperity surface.\n"
"""First lines of the table and of the case."""

REQUIRED = tuple(row.name for row in contract.props_table() if row.default is None)
"""Constants of a material that have no default."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    add_options(
        parser,
        (
            "scan SCAN",
            "columns x, z (profile) or x, y, z (map) with units, a matrix (--spacing), or triangles (.stl)",
            Path,
        ),
        ("--spacing DX[,DY]", "a CSV is a matrix, x along a row, y downwards; grid of triangles", _lengths),
        ("--unit UNIT", "unit of lengths whose header names none", "mm"),
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
        ("--material NAME=VALUE,...", constants, _material),
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
        values = Interface(material, pattern).props()
    else:
        values = contract.pack(pattern.values(), pattern.constants())[len(REQUIRED) :]
    return ", ".join([*(REQUIRED if material is None else ()), *(f"{value:.9g}" for value in values)])


def _run(options: argparse.Namespace) -> int:
    """Read a scan, find the planes of its average and their classes, compare patterns, write the results."""
    _check(options)
    table, png, case = _outputs(options)
    template = None if options.case is None else read_case(options.case)
    material = options.material if template is None else template.runs[0].material
    if template is not None and any(run.material != material for run in template.runs):
        raise ValueError(f"{template.path}: &material: expected numbers, not the name of a sweep")
    mu = MU if material is None else material.mu
    with shown_warnings():
        original = scan = read_scan(options.scan, options.spacing, options.unit)
    if options.smooth is not None:
        scan = scan.smoothed(options.smooth)
    smooth = scan
    if options.sampling is not None:
        scan = scan.sampled(options.sampling)
    found = slopes.facets(scan, options.direction)
    if found.profile and options.sides not in (None, 2):
        raise ValueError(f"--sides {options.sides}: expected 2 for a profile, which knows one direction")
    listed, label, fewer = _listed(options, found)
    angles = slopes.directions_of(found, options.direction)
    lengths = lengths_of(smooth)
    with progress_bar(len(angles) + len(lengths), "step") as bar:
        slips = found.slips(angles, mu, bar.update)
        regular = slopes.nearest_regular(found, slips, options.sides or 0, options.direction)
        rows = []
        for length in lengths:
            part = slopes.facets(smooth.sampled(length), options.direction)
            like = slopes.nearest_regular(part, None, regular.m or 2, options.direction)
            angle, flat = (like.theta, like.flat) if like.m else (0.0, 1.0)
            rows.append((length, part.mean_slope, part.rms_slope, angle, flat))
            bar.update()
        scales = np.array(rows)
    print("\n".join(report(original, scan, found, slips, options)))
    print(f"\n{'pattern':<22}planes  mean slope    fabric    uphill  residual    listed")
    of_listed = Planes.of(listed).slips(angles, mu).residual
    for pattern in (listed, regular):
        texts = [*map(_shown, slopes.compare(pattern, found, slips, of_listed).values())]
        start = f"{_name(pattern):<22}{len(pattern.weights):>6}{texts[0]:>12}"
        print(start + "".join(f"{text:>10}" for text in texts[1:]))
    print(f"\n{f'sampling, {scan.unit}':>14}{'mean slope':>12}{'rms slope':>12}{'theta':>8}{'flat':>8}")
    for length, mean, rms, theta, flat in scales:
        print(f"{length:>14.4g}{mean:>12.4f}{rms:>12.4f}{theta:>8.2f}{flat:>8.3f}")
    doubts = [f"remark      {text}" for text in (*remarks(scan, found, options.direction), *fewer)]
    print("\n".join(["", *doubts, ""]) if doubts else "")
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
        away = [np.hypot(*(found.gradients - one).T) for one in Planes.of(regular).gradients]
        label = np.argmin(away, axis=0)
    draw(scan, found, (listed, regular), chosen, label, slips, scales, png, options.scan.name)
    print("\n".join(map(str, written)))
    return 0


def _check(options: argparse.Namespace) -> None:
    """Check the options that do not depend on the scan."""
    listing = (options.bins, options.planes, options.directions, options.flat_below)
    if options.regular and any(value is not None for value in listing):
        raise ValueError(
            "--regular: expected without --bins, --directions, --flat-below and --planes, which list planes"
        )
    if options.sides is not None and not options.regular:
        raise ValueError("--sides: expected with --regular, listed planes have no such number")
    if options.bins is not None and options.planes is not None:
        raise ValueError("--bins, --planes: expected one of them")
    if options.sides is not None and not 2 <= options.sides <= contract.MAX_INCLINED:
        raise ValueError(f"--sides {options.sides}: expected 2 to {contract.MAX_INCLINED}")
    if not np.isfinite(options.direction):
        raise ValueError(f"--direction {options.direction}: expected a finite angle")
    if options.unit != "mm":
        try:
            size("length", options.unit)
        except ValueError as error:
            raise ValueError(f"--unit {error}") from None
    if options.case is not None and options.material is not None:
        raise ValueError("--case, --material: expected one of them, a case has its material")


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


def _shown(error: float) -> str:
    if np.isinf(error):
        return "locks"
    return f"{error:.1e}" if error > ROUNDING else "0"


def _listed(options: argparse.Namespace, found: Facets) -> tuple[Pattern, np.ndarray, list[str]]:
    """Listed planes according to the options, the plane of every facet, and a remark if planes are fewer."""
    directions = options.directions or (2 if found.profile else 8)
    if found.profile and directions != 2:
        raise ValueError(f"--directions {directions}: expected 2 for a profile")
    for name, least in (("directions", 2), ("bins", 1), ("planes", 1)):
        value = getattr(options, name)
        if value is not None and not least <= value <= contract.MAX_INCLINED:
            raise ValueError(f"--{name} {value}: expected {least} to {contract.MAX_INCLINED}")
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
    listed, label = slopes.bin_facets(found, directions, bins, options.direction, flat)
    fewer = (
        f"--planes {options.planes} gives {len(listed.weights)}: {bins} bins in each of {directions} "
        f"directions and a flat plane are {directions * bins + 1}, less those of bins with hardly any facets;"
        " --directions changes this"
    )
    return listed, label, [fewer] * (len(listed.weights) < (options.planes or 0))


def _name(pattern: Pattern) -> str:
    if pattern.m < 0:
        return "listed"
    if pattern.m == 0:
        return "flat"
    return f"{'RT' if pattern.m == 2 else f'RP-{pattern.m}'}, {pattern.theta:.2f} deg"


def _write(path: Path, pattern: Pattern) -> None:
    planes = Planes.of(pattern)
    columns = planes.inclination, np.degrees(planes.azimuth), planes.normals, planes.gamma, planes.nominal
    rows = np.column_stack([np.arange(len(planes.gamma)) + 1, np.round(np.column_stack(columns), 9) + 0.0])
    np.savetxt(path, rows, ["%d", *["%.9f"] * 7], ",", header=HEADER, comments="")


def _lengths(text: str) -> tuple[float, ...]:
    try:
        found = tuple(float(part) for part in text.split(","))
    except ValueError:
        found = ()
    if len(found) not in (1, 2) or not all(np.isfinite(v) and v > 0.0 for v in found):
        raise argparse.ArgumentTypeError(f"{text}: expected DX or DX,DY, lengths > 0")
    return found


def _material(text: str) -> Material:
    try:
        values = assigned(text.split(","))
        if set(values) != set(REQUIRED):
            raise ValueError("expected " + ",".join(f"{name}=VALUE" for name in REQUIRED))
        return Material(**{name: contract.number(name, value) for name, value in values.items()})  # type: ignore[arg-type]
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text}: {error}") from None

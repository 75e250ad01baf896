"""Command `asperity barton`: the RIE that comes closest to a joint of Barton, and both side by side."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from ... import contract
from ...case_writer import props_line, rounded, slip_case
from ...model_checks import model_warnings
from ...options import add_options, numbers, report_warning
from ...plausible import doubts
from .envelope import REACH, Envelope, curves, draw, envelope, table
from .joint import SAMPLE, Joint

FREE, FIXED = ("ks", "mu", "theta", "height"), {"flat": contract.default("flat"), "kc": 20.0}
SIDES = 8
"""Constants of one normal stress; values that are not identified, as the curves hardly depend on kc = kn/ks
because they begin under pressure; and inclined planes.
"""

BY_NATURE = """\
A joint of Barton has no bond: the RIE is damaged from the start, and ks is the stiffness below the peak.
The curves have no scatter: the intervals say which constants the curves determine, not how well the rock is
known. There is no covariance for asperity uncertainty."""
"""What the constants and their intervals mean."""

Result = tuple[Envelope, str, str, Callable[[Path], object]]
"""Both laws, lines of the report, text of a case and function that draws."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    from ..fit.command import add_results

    needed = {"required": True}
    stresses = "normal stress of the curves, or LOW,HIGH of an envelope; compression > 0"
    add_options(
        parser,
        ("--jrc JRC", "joint roughness coefficient, up to 20", float, needed),
        ("--jcs MPA", "compressive strength of the joint wall", float, needed),
        ("--phi-r DEGREES", "residual friction angle", float, needed),
        ("--length M", "length of the joint", float, needed),
        ("--sample M", "length of the samples on which JRC and JCS were measured", SAMPLE),
        ("--sigma-n MPA,...", stresses, str, needed),
    )
    known = ", ".join(f"{name}={value:.4g}" for name, value in FIXED.items())
    add_options(
        parser,
        ("--free NAMES", "constants to identify from the curves of one stress", ",".join(FREE)),
        ("--set NAME=VALUE", f"constants that are known (default: {known})", list),
        ("--sides SIDES", f"inclined planes of the pattern (default: {SIDES})", int),
        ("--direction DEGREES", "direction of the slip, from Tx", 0.0),
    )
    add_results(parser)
    parser.set_defaults(action=_run)


def _run(options: argparse.Namespace) -> int:
    """Print both laws under one stress or over a range, with warnings and PROPS, and write the files."""
    from ..fit.command import check_results, write
    from ..fit.thresholds import FAIR, UNSAFE

    check_results(options)
    stresses = [contract.number("--sigma-n", text) for text in options.sigma_n.split(",")]
    if len(stresses) > 2:
        raise ValueError(f"--sigma-n {options.sigma_n}: expected one normal stress, or LOW,HIGH")
    joint = Joint(options.jrc, options.jcs, options.phi_r, options.length, options.sample)
    inputs = {"JCS": joint.jcs, "phi_r": joint.phi_r, "length": joint.length, "sample": joint.sample}
    for text in doubts(**inputs):
        report_warning(text)
    laws, more, case, picture = (_curve if len(stresses) == 1 else _envelope)(options, joint, *stresses)
    interface, pressure, end = laws.interface, -float(laws.stresses[-1]), float(laws.slips[-1])
    print(
        f"joint       JRC {joint.jrc:g}, JCS {joint.jcs:g} MPa on samples of {joint.sample:g} m, "
        f"phi_r {joint.phi_r:g} degrees\n"
        f"length      {joint.length:g} m: JRC {joint.jrc_n:.4g}, JCS {joint.jcs_n:.4g} MPa, slip at "
        f"the peak {joint.peak_slip:.4g} mm\n"
        f"curves      to {REACH:g} slips at the peak, {end:.4g} mm, {laws.slips.size - 1} rows each\n\n"
        f"{table(laws)}\n\n{more}"
    )
    for text in model_warnings(interface.material, interface.pattern, pressure, slip=end):
        print(f"warning: {text}")
    print(f"\n{props_line(interface.props())}")
    # without scatter there is no covariance
    write(options, interface, picture, case)
    if laws.is_met:
        return 0
    worst = laws.parted[np.argmax(abs(laws.parted))]
    report_warning(
        f"the strength of the law differs by {worst:.0%}: expected at most "
        f"{UNSAFE:.0%} more and {FAIR:.0%} less than that of Barton: a smaller range of normal stresses"
    )
    return 3


def _curve(options: argparse.Namespace, joint: Joint, sigma_n: float) -> Result:
    """Law that comes closest to the curves under one normal stress."""
    from ..fit.columns import DEFAULT
    from ..fit.command import progress
    from ..fit.fitting import fit
    from ..fit.kinds import kind_of
    from ..fit.model import ROCK
    from ..fit.report import case_of, report

    test, free = curves(joint, sigma_n), tuple(name.strip() for name in options.free.split(","))
    known = FIXED | {name: value for name, (value,) in numbers("--set", options.set, 1).items()}
    fixed = {name: value for name, value in known.items() if name not in free}
    sides = SIDES if options.sides is None else options.sides
    with progress() as tick:
        result = fit([test], ROCK, fixed, free, sides, options.direction, tick)
    slips = np.append(0.0, test.slip)
    laws = Envelope(joint, result.interface, np.array([sigma_n]), slips, result.values)
    picture = partial(kind_of(result.tests).draw, result, DEFAULT, of_tests=f"Barton, JRC {joint.jrc:g}")
    return laws, f"{BY_NATURE}\n\n{report(result, DEFAULT)}", case_of(result), picture


def _envelope(options: argparse.Namespace, joint: Joint, low: float, high: float) -> Result:
    """Law that meets an envelope."""
    if options.set or options.sides is not None or options.free != ",".join(FREE):
        raise ValueError(
            "--free, --set, --sides: expected with one normal stress; LOW,HIGH needs none of them"
        )
    from ..fit.columns import DEFAULT
    from ..fit.report import unit_of

    laws = envelope(joint, low, high)
    shown = {name: value for name, value in laws.values.items() if name != "kn"}
    values = "\n".join(f"{name:<12}{value:>12.5g}  {unit_of(name, DEFAULT)}" for name, value in shown.items())
    material = {name: rounded(value, 6) for name, value in laws.values.items() if name != "theta"}
    slips, tractions = [float(laws.slips[-1])], [rounded(-stress, 4) for stress in laws.stresses]
    case = slip_case("Joint of Barton", material, laws.interface.pattern, tractions, slips)
    return laws, values, case, partial(draw, laws)

"""Command `asperity barton`: the RIE that comes closest to a joint of Barton, and both side by side."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .. import contract
from ..case_writer import rounded
from ..options import add_options, numbers
from ..remarks import doubts
from .envelope import Envelope, draw, envelope, table
from .joint import SAMPLE, Joint, check_reach

if TYPE_CHECKING:
    from ..fit.records import ShearTest

FREE, FIXED = ("ks", "mu", "theta", "height"), {"flat": contract.default("flat"), "kc": 20.0}
"""Constants of one normal stress, and values that are not identified: the curves hardly depend on kc = kn/ks,
as they begin under pressure.
"""

ROWS, REACH = 100, 10.0
"""Rows of a curve, equally spaced in the slip, and its default end, in slips at the peak."""

BY_NATURE = (
    "A joint of Barton has no bond: the RIE has damage0 = 1, and ks stands for the stiffness below the peak.",
    "The curves have no scatter: the intervals below say which constants the curves determine, not how well "
    "the rock is known. There is no covariance for asperity uncertainty.",
)
"""What the constants and their intervals mean."""

Found = tuple[Envelope, str, str, Callable[[Path], object]]
"""Both laws, lines of the report, text of a case and function that draws."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    from ..fit.command import add_search

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
        ("--reach RATIO", "end of the curves over the slip at the peak, up to 100", REACH),
    )
    add_search(parser, ",".join(FREE), FIXED)
    parser.set_defaults(action=_run)


def _run(options: argparse.Namespace) -> int:
    """Print both laws under one stress or over a range, with warnings and PROPS, and write the files."""
    from ..fit.command import check_search, write
    from ..fit.report import props_line

    check_search(options)
    stresses = [contract.number("--sigma-n", text) for text in options.sigma_n.split(",")]
    if len(stresses) > 2:
        raise ValueError(f"--sigma-n {options.sigma_n}: expected one normal stress, or LOW,HIGH")
    joint = Joint(options.jrc, options.jcs, options.phi_r, options.length, options.sample)
    found, more, case, picture = (_curve if len(stresses) == 1 else _envelope)(options, joint, *stresses)
    interface, pressure, end = found.interface, -float(found.stresses[-1]), float(found.slips[-1])
    print(
        f"joint       JRC {joint.jrc:g}, JCS {joint.jcs:g} MPa on samples of {joint.sample:g} m, "
        f"phi_r {joint.phi_r:g} degrees\n"
        f"length      {joint.length:g} m: JRC {joint.jrc_n:.4g}, JCS {joint.jcs_n:.4g} MPa, slip at "
        f"the peak {joint.peak_slip:.4g} mm\n"
        f"curves      to {options.reach:g} slips at the peak, {end:.4g} mm, {found.slips.size - 1} rows "
        f"each\n\n{table(found)}\n\n{more}"
    )
    for text in doubts(interface.material, interface.pattern, pressure, slip=end):
        print(f"warning: {text}")
    print(f"\n{props_line(interface)}")
    # without scatter there is no covariance
    write(options, interface, picture, case)
    return 0


def _curve(options: argparse.Namespace, joint: Joint, sigma_n: float) -> Found:
    """Law that comes closest to the curves under one normal stress."""
    from ..fit.command import arguments_of, searching
    from ..fit.model import BOND, KS
    from ..fit.records import DEFAULT
    from ..fit.report import case_of, lines_of, report
    from ..fit.report import draw as draw_fit

    names = {*options.free.split(","), *numbers("--set", options.set, 1)}
    wrong = ", ".join(name for name in BOND if name in names) or ("" if KS in names else f"{KS} is missing")
    if wrong:
        raise ValueError(f"--free {options.free}: {wrong}: expected {KS}, as a joint of Barton has no bond")
    tests = curves(joint, [sigma_n], options.reach)
    with searching(options, tests) as fitted:
        found = fitted(arguments_of(options, FIXED))
    slips = np.append(0.0, tests[0].slip)
    both = Envelope(joint, found.interface, np.array([sigma_n]), slips, found.values)
    picture = partial(draw_fit, found, DEFAULT, of_tests=f"Barton, JRC {joint.jrc:g}")
    return both, f"{lines_of(BY_NATURE)}\n\n{report(found, DEFAULT)}", case_of(found), picture


def _envelope(options: argparse.Namespace, joint: Joint, low: float, high: float) -> Found:
    """Law that meets an envelope."""
    from ..fit.report import slip_case

    given = {name: value for name, (value,) in numbers("--set", options.set, 1).items()}
    unused = ["--free"] * (options.free != ",".join(FREE))
    unused += [f"--{name}" for name in ("start", "bounds") if getattr(options, name)]
    unused += [f"--set {name}" for name in given if name not in ("kc", "flat")]
    if unused:
        raise ValueError(
            f"{unused[0]}: expected with one normal stress; LOW,HIGH finds theta, crush, height and ks; "
            "kc and flat are those of --set"
        )
    if options.sides is not None:
        given["sides"] = options.sides
    found = envelope(joint, low, high, reach=options.reach, **given)
    units = {"ks": "MPa/mm", "mu": "-", "theta": "degree", "height": "mm", "crush": "MPa"}
    values = [f"{name:<12}{found.values[name]:>12.5g}  {unit}" for name, unit in units.items()]
    names = [name for name in found.values if name not in ("theta", "flat")]
    material = {name: rounded(found.values[name], 6) for name in names}
    slips, tractions = [float(found.slips[-1])], [rounded(-one, 4) for one in found.stresses]
    case = slip_case("Joint of Barton", material, found.interface.pattern, tractions, slips)
    return found, "\n".join(values), case, partial(draw, found)


def curves(joint: Joint, stresses: Sequence[float], reach: float = REACH) -> list[ShearTest]:
    """Curves of a joint as tests of a fit, one for each normal stress; reach: their end in slips at the peak.

    Raises ValueError for stresses out of range and for a reach that does not pass the peak.
    """
    from ..fit.records import ShearTest

    check_reach(reach)
    joint.check_stresses(*stresses)
    slip = np.linspace(0.0, reach * joint.peak_slip, ROWS + 1)[1:]
    return [
        ShearTest(f"sigma_n {one:g}", slip, joint.shear(slip, one), joint.dilation(slip, one), -one)
        for one in stresses
    ]

"""Command `asperity barton`: the RIE that comes closest to a joint of Barton, and both side by side."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import contract
from ..contract import Floats
from ..fit.constants import BOND, KS
from ..fit.fitting import fit
from ..fit.outcome import Fit
from ..fit.search import HEADING, Search, add_search, check_search, write
from ..fit.shear_test import ShearTest
from ..fit.units import DEFAULT
from ..options import add_options, numbers
from ..remarks import doubts
from .envelope import case_of, draw, envelope
from .envelope import table as envelope_table
from .joint import SAMPLE, Joint, check_reach

FREE = ("ks", "mu", "theta", "height")

FIXED = {"flat": contract.default("flat"), "kc": 20.0}
"""Values that are not identified: the curves hardly depend on kc = kn/ks, as they begin under pressure."""


ROWS = 100
"""Rows of a curve, equally spaced in the slip."""

REACH = 10.0
"""Default end of the curves, in slips at the peak."""

BY_NATURE = (
    "A joint of Barton has no bond: its shear traction is zero at sigma_n = 0. The RIE, the planes "
    "of the law, has damage0 = 1: ks stands for the stiffness before the peak, mu, theta and height for "
    "strength and dilation.",
    "The strength over sigma_n and the dilation angle of Barton fall with sigma_n. Those of the RIE do not: "
    "--sigma-n LOW,HIGH finds crush, with which they do.",
    "The slip at the peak of Barton does not depend on sigma_n. That of the RIE grows with it, because its "
    "contact is elastic up to friction.",
    "The strength of Barton falls to sigma_n tan(phi_r) only at 100 slips at the peak, and his dilation ends "
    "there.",
    "The curves have no scatter: the intervals below say which constants the curves determine, and how "
    "sharply, not how well the rock is known. There is no covariance for asperity uncertainty.",
)
"""Where the two laws differ whatever the constants are, and what the intervals mean."""


@dataclass(frozen=True)
class Row:
    """Numbers of both laws under a normal stress sigma_n, MPa, mm and degrees.

    tau, slip: peak strength and the slip there; angle: largest dilation angle; s_N: opening at the end of the
    curves; each is the pair (Barton, RIE).  misfit: root mean square differences of tau and of s_N, over the
    range of the curve of Barton.
    """

    sigma_n: float
    tau: tuple[float, float]
    slip: tuple[float, float]
    angle: tuple[float, float]
    s_N: tuple[float, float]
    misfit: tuple[float, float]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    needed = {"required": True}
    add_options(
        parser,
        ("--jrc JRC", "joint roughness coefficient, up to 20", float, needed),
        ("--jcs MPA", "compressive strength of the joint wall", float, needed),
        ("--phi-r DEGREES", "residual friction angle", float, needed),
        ("--length M", "length of the joint", float, needed),
        ("--sample M", "length of the samples on which JRC and JCS were measured", SAMPLE),
        (
            "--sigma-n MPA,...",
            "normal stress of the curves, or LOW,HIGH of an envelope; compression > 0",
            str,
            needed,
        ),
        ("--reach RATIO", "end of the curves over the slip at the peak, up to 100", REACH),
    )
    add_search(parser, ",".join(FREE), FIXED)
    parser.set_defaults(action=_run)


def _run(options: argparse.Namespace) -> int:
    check_search(options)
    stresses = [contract.number("--sigma-n", text) for text in options.sigma_n.split(",")]
    if len(stresses) > 2:
        raise ValueError(f"--sigma-n {options.sigma_n}: expected one normal stress, or LOW,HIGH")
    joint = Joint(options.jrc, options.jcs, options.phi_r, options.length, options.sample)
    if len(stresses) == 2:
        return _meet(options, joint, *stresses)
    names = {*options.free.split(","), *numbers("--set", options.set, 1)}
    of_bond = [name for name in BOND if name in names]
    if of_bond or KS not in names:
        wrong = ", ".join(of_bond) or f"{KS} is missing"
        raise ValueError(f"--free {options.free}: {wrong}: expected {KS}, as a joint of Barton has no bond")
    tests = curves(joint, stresses, options.reach)
    searching = Search(options, FIXED)
    with searching.shown() as fitted:
        found = fitted(tests, searching.given)
    from ..fit.report import lines_of, props_line, report

    print(heading(joint, options.reach))
    print(f"\n{table(compare(joint, found))}\n\n{lines_of(BY_NATURE)}\n\n{report(found, DEFAULT)}")
    slip = max(test.slip.max() for test in tests)
    for text in doubts(found.interface.material, found.interface.pattern, -max(stresses), slip=slip):
        print(f"warning: {text}")
    print(f"\n{props_line(found)}")
    # without scatter there is no covariance
    write(options, found, DEFAULT, f"Barton, JRC {joint.jrc:g}")
    return 0


def _meet(options: argparse.Namespace, joint: Joint, low: float, high: float) -> int:
    """Print and write the law that meets an envelope."""
    given = {name: value for name, (value,) in numbers("--set", options.set, 1).items()}
    unused = ["--free"] if options.free != ",".join(FREE) else []
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
    from ..fit.report import props_line

    print(heading(joint, options.reach, found.slips.size - 1), envelope_table(found), sep="\n\n", end="\n\n")
    for name, unit in (
        ("ks", "MPa/mm"),
        ("mu", "-"),
        ("theta", "degree"),
        ("height", "mm"),
        ("crush", "MPa"),
    ):
        print(f"{name:<12}{found.values[name]:>12.5g}  {unit}")
    for text in doubts(found.interface.material, found.interface.pattern, -high, slip=found.slips[-1]):
        print(f"warning: {text}")
    print(f"\n{props_line(found)}")
    if options.card is not None:
        print("\n" + found.interface.card(options.card), end="")
    if options.plot is not None:
        draw(found, options.plot)
        print(options.plot)
    if options.output is not None:
        options.output.write_text(f"{HEADING}\n{case_of(found)}", encoding="utf-8")
        print(options.output)
    return 0


def barton(
    jrc: float,
    jcs: float,
    phi_r: float,
    length: float,
    sigma_n: Sequence[float],
    sample: float = SAMPLE,
    reach: float = REACH,
    **search: Any,
) -> Fit:
    """Constants of the law whose curves come closest to those of a joint of Barton.

    Parameters
    ----------
    jrc, jcs, phi_r
        Roughness, wall strength (MPa) and residual friction angle (degrees) of samples.
    length, sample
        Length of the joint and of the samples, m.
    sigma_n
        Normal stresses of the curves, MPa, compression positive.
    reach
        End of the curves over the slip at the peak.
    search
        Arguments of `asperity.fit.fit`, such as sides, free and fixed.

    Returns
    -------
    Fit
        Its `interface` is the joint in mm and MPa; the intervals say which constants the curves determine.

    Raises
    ------
    ValueError
        For values out of range.

    Examples
    --------
    >>> from asperity.barton import barton
    >>> found = barton(10.0, 100.0, 30.0, 0.1, [1.0], sides=2, starts=1)
    >>> 0.2 < found.values["mu"] < 0.7
    True
    """
    tests = curves(Joint(jrc, jcs, phi_r, length, sample), list(sigma_n), reach)
    free = search.pop("free", FREE)
    fixed = {name: value for name, value in FIXED.items() if name not in free}
    return fit(tests, free, fixed | dict(search.pop("fixed", {})), **search)


def curves(joint: Joint, stresses: Sequence[float], reach: float = REACH) -> list[ShearTest]:
    """Curves of a joint as tests of a fit, one for each normal stress; reach: their end in slips at the peak.

    Raises ValueError for stresses out of range and for a reach that does not pass the peak.
    """
    check_reach(reach)
    if not stresses:
        raise ValueError("sigma_n: expected at least one normal stress")
    for sigma_n in stresses:
        joint.check_stress(sigma_n)
    if len(set(stresses)) < len(stresses):
        raise ValueError(f"sigma_n = {', '.join(f'{one:g}' for one in stresses)}: expected each stress once")
    slip = np.linspace(0.0, reach * joint.peak_slip, ROWS + 1)[1:]
    return [
        ShearTest(f"sigma_n {one:g}", slip, joint.shear(slip, one), joint.dilation(slip, one), -one)
        for one in stresses
    ]


def compare(joint: Joint, found: Fit) -> list[Row]:
    """Both laws side by side for each normal stress of a fit."""
    rows = []
    problem = found.problem
    models = found.curves
    for test, path, (tau, s_N, _) in zip(problem.tests, problem.paths, models, strict=True):
        sigma_n = -test.sigma_N
        assert test.s_N is not None
        peak = int(np.argmax(tau))
        slope = np.diff(s_N) / np.diff(path.slips)
        rows.append(
            Row(
                sigma_n,
                (joint.peak_strength(sigma_n), float(tau[peak])),
                (joint.peak_slip, float(path.slips[peak])),
                (joint.peak_dilation_angle(sigma_n), float(np.degrees(np.arctan(slope.max())))),
                (float(test.s_N[-1]), float(s_N[-1])),
                (_misfit(tau[path.rows], test.tau), _misfit(s_N[path.rows], test.s_N)),
            )
        )
    return rows


def _misfit(model: Floats, wanted: Floats) -> float:
    return float(np.sqrt(np.mean((model - wanted) ** 2)) / np.ptp(wanted))


def heading(joint: Joint, reach: float, rows: int = ROWS) -> str:
    """Joint with its scaled values and its slip at the peak."""
    scaled = f"JRC {joint.jrc_n:.4g}, JCS {joint.jcs_n:.4g} MPa"
    lines = [
        f"joint       JRC {joint.jrc:g}, JCS {joint.jcs:g} MPa on samples of {joint.sample:g} m, "
        f"phi_r {joint.phi_r:g} degrees",
        f"length      {joint.length:g} m: {scaled}, slip at the peak {joint.peak_slip:.4g} mm",
        f"curves      to {reach:g} slips at the peak, {reach * joint.peak_slip:.4g} mm, {rows} rows each",
    ]
    return "\n".join(lines)


def table(rows: Sequence[Row]) -> str:
    """Both laws and the misfit for each normal stress."""
    names = ("sigma_n", "peak tau", "at slip", "dilation angle", "s_N at end", "misfit tau", "s_N")
    widths = (8, 18, 18, 18, 18, 12, 8)
    lines = ["".join(f"{name:>{width}}" for name, width in zip(names, widths, strict=True))]
    units = ("MPa", "MPa", "mm", "degrees", "mm", "", "")
    lines.append("".join(f"{unit:>{width}}" for unit, width in zip(units, widths, strict=True)).rstrip())
    pair = f"{'Barton':>10}{'RIE':>8}"
    lines.append(" " * widths[0] + 4 * pair)
    for row in rows:
        cells = [f"{row.sigma_n:>8.4g}"]
        cells += [f"{a:>10.4g}{b:>8.4g}" for a, b in (row.tau, row.slip, row.angle, row.s_N)]
        cells += [f"{row.misfit[0]:>12.1%}{row.misfit[1]:>8.1%}"]
        lines.append("".join(cells))
    return "\n".join(lines)

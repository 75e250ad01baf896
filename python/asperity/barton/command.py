"""Command `asperity barton`: constants of the law from JRC, JCS and phi_r."""

from __future__ import annotations

import argparse

from .. import contract
from ..fit.model import BOND, KS
from ..fit.search import Search, add_search, check_search, write
from ..fit.units import DEFAULT
from ..options import add_options, numbers
from ..remarks import doubts
from .comparison import BY_NATURE, REACH, compare, curves, heading, table
from .joint import SAMPLE, Joint

FREE = ("ks", "mu", "theta", "height")

FIXED = {"flat": contract.default("flat"), "kc": 20.0}
"""Values that are not identified: the curves hardly depend on kc = kn/ks, as they begin under pressure."""


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
            "normal stresses of the curves, compression > 0",
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
    names = {*options.free.split(","), *numbers("--set", options.set, 1)}
    of_bond = [name for name in BOND if name in names]
    if of_bond or KS not in names:
        wrong = ", ".join(of_bond) or f"{KS} is missing"
        raise ValueError(f"--free {options.free}: {wrong}: expected {KS}, as a joint of Barton has no bond")
    joint = Joint(options.jrc, options.jcs, options.phi_r, options.length, options.sample)
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

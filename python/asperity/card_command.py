"""Command `asperity card`: the material block of a host for the interface of a case file."""

from __future__ import annotations

import argparse
import re
from pathlib import Path

import numpy as np

from . import contract, hosts
from .case_files import Run, read_run
from .installed import case_file
from .model_checks import shown_warnings
from .options import add_options, add_output, check_outputs, replace_file, report_warning

HEAD = 5  # lines of a case in which its comments are
START = r".{,80}asperity \d|\{\s+\"elements\": \[\s+\"Geo_U"
"""Start of a block; JSON, for Kratos, has no comments."""


def add_arguments(card: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    add_options(
        card,
        ("host", None, str, {"choices": tuple(hosts.hosts("card"))}),
        ("case CASE.nml", "case file of rie_driver, or a name of `asperity cases`", case_file),
        ("--name NAME", "name of material and elements", "INTERFACE"),
        ("--value VALUE", "value of the sweep, for a case with a sweep", str),
    )
    add_output(card, "FILE", "write the block to this file")
    for row in contract.owned("host", "numerics"):
        text = f"{row.meaning} (default: that of &replay, or {row.default:g})"
        card.add_argument(f"--{row.name}", type=int if row.integral else float, help=text)
    add_options(
        card,
        ("--dimension", "default: %(default)s", 3, {"choices": (2, 3)}),
        ("--explicit", "for Abaqus/Explicit; needs --density, but not with --contact"),
        ("--contact", "for contact pairs of Abaqus, without joint elements"),
        ("--density RHO", "mass over area and thickness h", float),
    )
    add_options(
        card.add_argument_group("checks", "given values are checked; the findings go into the block"),
        ("--sigma-N SIGMA_N", "largest compression, < 0; checks the contact stiffness", float),
        ("--modulus E", "Young's modulus of the solid beside the joint", float),
        ("--size L", "length of the elements of this solid; checks snap-back and mesh", float),
        (
            "--direction DEG",
            "of the slip in 3D, from Tx towards Ty; checks for planes that face across",
            float,
        ),
    )
    card.set_defaults(action=_card)


def _of_fit(case: Path) -> list[str]:
    """Grade and intervals of a fit, and what it assumed, from the comments of its case."""
    lines = case.read_text(encoding="utf-8").splitlines()[:HEAD]
    return [line[2:] for line in lines if re.match(r"! (Grade (good|fair|poor)\b|.* assumed)", line)]


def _has_water(run: Run) -> bool:
    """Whether a step, or the start, has a water pressure."""
    pressures = [step.p for step in run.steps if step.p is not None] + [run.state.p if run.state else 0.0]
    return any(np.any(field) for field in pressures)


def _card(options: argparse.Namespace) -> int:
    """Print or write the block; each warning is a line on standard error."""
    check_outputs(options.force, [options.case], ("-o", options.output, START))
    with shown_warnings():
        run = read_run(options.case, options.value)
        of_host = run.of_host()
        choices = {name: getattr(options, name) for name in of_host}
        of_host |= {name: value for name, value in choices.items() if value is not None}
        takes, wet = hosts.of(options.host, "card"), _has_water(run)
        if takes.path and wet and choices["water"] == 0:
            raise ValueError(
                f"{options.case}: p, and --water 0: expected 1, as the path has the water pressure"
            )
        if takes.path and wet and choices["water"] is None:
            of_host["water"] = 1
        names = "name", "dimension", "explicit", "contact", "density", "modulus", "size", "direction"
        text = run.interface.card(
            options.host,
            stress=options.sigma_N,
            notes=_of_fit(options.case),
            **{name: getattr(options, name) for name in names},
            **of_host,
        )
    if wet and not of_host["water"]:
        field = "expected --water N, the number of the field that is the pressure"
        how = takes.water or (
            f"{options.host} passes no field to the law" if takes.only.get("water") == 0 else field
        )
        report_warning(f"{options.case}: p: the block has no water: {how}")
    writer = hosts.part(options.host, "card")
    if writer is not None and takes.path:
        if run.start != "virgin" or not run.steps:
            raise ValueError(f"{options.case}: expected &step groups from a virgin joint for {options.host}")
        text += writer.path_of(run.steps, bool(of_host["water"]))
    elif run.start != "virgin":
        report_warning(
            f"{options.case}: &{run.start}: not in the block, which is that of a virgin joint: expected "
            "initial conditions of the host beside it"
        )
    if options.output is None:
        print(text, end="")
    else:
        replace_file(options.output, text)
    return 0

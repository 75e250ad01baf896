"""Commands `asperity new` and `asperity cases`: a case file to start from."""

from __future__ import annotations

import argparse
from pathlib import Path

from .case_files import check_text, read_case
from .case_writer import Word, case_text
from .installed import all_cases, named_case
from .options import add_options, add_output, assigned, check_outputs, replace_file, report_warning
from .plausible import doubts

LOAD = {"sigma_N": "-1.0", "slip": "0.6", "direction": "0.0", "increments": "200"}
"""Entries of the load path, and their values in a new case."""

MATERIAL = {"sigma0": "3.0", "Gc": "0.3", "eta": "0.9", "mu": "0.5", "kc": "20.0"}
PATTERN = {"sides": "8", "theta": "30.0", "flat": "0.3333333333333333"}
"""Entries of the groups of a new case; constants that are not here may be added."""

TEXT = """! Slip under a constant normal traction; units here: mm, MPa. Run it by
!   asperity run {name} --plot
! Components are (N, Tx, Ty); tension and opening are positive, angles are in degrees.
{case}
! sigma0: strength of the bond, Gc: its rupture energy, eta: 1 - s0/sf, mu: friction,
! kc: normal stiffness of the closed joint over that of the bond: 1 for a lumped mortar joint, 10 and more
! for a crack or an unmated rock joint, or closure, the largest closure, instead
{material}
! sides: inclined planes (0: a flat joint), theta: their inclination, flat: share of the flat plane
{pattern}
! the pressure first, then the slip under it
{load}"""


def new_arguments(new: argparse.ArgumentParser) -> None:
    """Add the arguments of `asperity new`."""
    new.description = "Write a case file with comments, as a start. The driver checks its values."
    names = (
        f"constants and load path, with the names of case files: {', '.join([*MATERIAL, *PATTERN])}, "
        f"{', '.join(LOAD)}; a constant may also be another one of &material or &pattern"
    )
    add_options(new, ("values NAME=VALUE", names, str, {"nargs": "*"}))
    add_output(new, "CASE.nml", "a new file", Path("case.nml"))
    new.set_defaults(action=_new)


def cases_arguments(cases: argparse.ArgumentParser) -> None:
    """Add the arguments of `asperity cases`."""
    cases.description = (
        "List the case files that come with the package, or copy one; asperity run takes their names, too."
    )
    add_options(cases, ("name NAME", "copy this case (default: list all)", str, {"nargs": "?"}))
    add_output(cases, "CASE.nml", "a new file (default: the name of the case, here)")
    cases.set_defaults(action=_cases)


def _new(options: argparse.Namespace) -> int:
    file = next((text for text in options.values if "=" not in text and text.endswith(".nml")), "")
    if file:
        raise ValueError(f"{file}: expected NAME=VALUE, or -o {file} for the name of the file")
    values = assigned(options.values)
    check_outputs(options.force, [], ("-o", options.output))
    taken = {name: values.pop(name, value) for name, value in LOAD.items()}
    pattern = {name: values.pop(name, value) for name, value in (PATTERN | {"turn": ""}).items()}
    if pattern["sides"].strip() == "0":
        pattern = {"sides": "0"}
    # a joint without bond has none of the constants that kn and ks give
    material = ({"mu": MATERIAL["mu"]} if {"kn", "ks"} & set(values) else MATERIAL) | values
    load = {name: taken[name] for name in ("slip", "direction", "increments")}
    texts = {
        "case": _group("case", title="Slip under pressure"),
        "material": _group("material", **_words(material)),
        "pattern": _group("pattern", **_words(pattern)),
        "load": _group("step", t_N=Word(taken["sigma_N"]), increments=100) + _group("step", **_words(load)),
    }
    text = TEXT.format(name=options.output, **texts)
    check_text(text)
    for doubt in doubts(mu=float(material.get("mu", "0").lower().replace("d", "e"))):
        report_warning(doubt)
    replace_file(options.output, text)
    print(options.output)
    return 0


def _cases(options: argparse.Namespace) -> int:
    if options.name is None:
        if options.output is not None:
            raise ValueError(f"-o {options.output}: expected the name of a case to copy")
        for name, path in all_cases().items():
            print(f"{name:<34}{read_case(path, any_law=True).title}")
        return 0
    path = named_case(options.name)
    output = options.output or Path(path.name)
    check_outputs(options.force, [path], ("-o", output))
    replace_file(output, path.read_bytes())
    print(output)
    return 0


def _group(name: str, **entries: object) -> str:
    return case_text((name, entries))


def _words(values: dict[str, str]) -> dict[str, Word]:
    return {name: Word(value) for name, value in values.items() if value}

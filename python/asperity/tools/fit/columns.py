"""Columns of the files of laboratories: which ones there are, and the factors of their units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..tables import Table, size
from .checks import warn_if
from .headings import standard

REQUIRED, OPTIONAL = ("slip", "tau", "sigma_N"), ("dilation", "k_N", "test")
STRENGTHS, BESIDE = ("peak", "sigma_N"), ("residual", "peak_slip", "slip")
FORCES = {
    f"{name}_force": stress
    for name, stress in zip(
        ("shear", "normal", "peak", "residual"), ("tau", "sigma_N", "peak", "residual"), strict=True
    )
}
CLOSURES = ("closure", "sigma_N")
KNOWN = (*dict.fromkeys(REQUIRED + STRENGTHS + BESIDE + OPTIONAL + CLOSURES), *FORCES)
"""Columns of a file; STRENGTHS, BESIDE: those needed and others of a table with a row for each test; FORCES:
forces and the stresses that they are over an area.
"""

KINDS = dict.fromkeys(("slip", "peak_slip", "dilation", "closure"), "length") | {"k_N": "stiffness"}
KINDS |= dict.fromkeys(FORCES.values(), "stress") | dict.fromkeys(FORCES, "force")
DEFAULT, NONE = ("mm", "MPa"), ("length", "stress")
"""What each column measures; units to which numbers with units are converted, and labels without units."""


def columns_of(table: Table, renamed: Mapping[str, str], optional: bool, forces: bool) -> list[str]:
    """Columns of the file, "" for those that are not used.

    A name of the user comes before one of this program, and this before one of a laboratory.  forces: an area
    is given, so that forces come before stresses.
    """
    headers, lower = table.headings, [name.lower() for name in table.names]
    there = f"{table.path}: line {table.line}: columns {', '.join(headers)}: expected"
    places_of = {name: table.places(header) for name, header in renamed.items()}
    missing = [renamed[name] for name, places in places_of.items() if not places]
    if missing:
        raise ValueError(f"{there} {', '.join(missing)}, too (--columns)")
    exact = {name.lower(): name for name in KNOWN if name not in renamed}
    taken = {*renamed, *(exact[name] for name in lower if name in exact)}
    names = [
        exact.get(low, name if standard(name) in taken else standard(name))
        for name, low in zip(table.names, lower, strict=True)
    ]
    for name, places in places_of.items():
        for place in places:
            names[place] = name
    dropped = {FORCES[name] for name in names if name in FORCES} if forces else {*FORCES}
    names = ["" if name in dropped else name for name in names]
    shown = {FORCES.get(name, name) for name in names}
    if "strength" in shown and not {"tau", "slip", "peak"} & shown:
        # a strength without a slip is that of a test
        names, shown = ["peak" if name == "strength" else name for name in names], {*shown, "peak"}
    curved = bool({"tau", "slip"} & shown)
    closes = "closure" in shown and not curved
    table_of_strengths = {"peak", "residual"} & shown and "tau" not in shown
    required = STRENGTHS if table_of_strengths else CLOSURES if closes else REQUIRED
    missing = [name for name in required if name not in shown and not (optional and name == "sigma_N")]
    option = f"--columns {''.join(missing[:1])}=HEADER, in Python columns=, for a column with another name"
    if missing:
        more = "--sigma-N VALUE for files without sigma_N, 0 without a pressure; --area A for forces"
        if missing == ["peak"]:
            more = "residual strengths alone show the friction at large slips: --columns peak=HEADER for them"
        elif "dilation" in shown and not curved:
            more = "a closure test has no slip: --columns closure=HEADER"
        raise ValueError(f"{there} {', '.join(missing)}, too ({option}; {more})")
    twice = next((name for name in KNOWN if names.count(name) > 1), "")
    if twice:
        text = f"column {twice} is there twice: expected one, or --columns {twice}=HEADER"
        raise ValueError(f"{table.path}: line {table.line}: {text}")
    used = {*(STRENGTHS + BESIDE if table_of_strengths else REQUIRED + OPTIONAL)}
    used = {*CLOSURES, "test"} if closes else used
    used |= {name for name, stress in FORCES.items() if stress in used}
    unused = [header for header, name in zip(headers, names, strict=True) if header and name not in used]
    warn_if(unused, f"{table.path}: columns not used: {', '.join(unused)}")
    return [name if name in used else "" for name in names]


def with_names(table: Table, renamed: Mapping[str, str], decimal: str | None) -> Table:
    """Table without a header whose columns have names: their places, 1, 2, ..., as `renamed` has them.

    Without any of these, two or three columns are slip, tau, sigma_N in this order, of which the slip alone
    must grow from row to row; a ModelWarning says so.  Raises ValueError for any other table.
    """
    width = table.cells.shape[1]
    names = [str(i + 1) for i in range(width)]
    if not renamed:
        wanted = "expected a header, or --columns slip=1 --columns tau=2 and so on"
        text = f"{table.path}: {width} columns without a header: {wanted}"
        if not 1 < width <= len(REQUIRED):
            raise ValueError(text)
        numbers = table.numbers(range(width), names, names, decimal)
        grows = [bool((np.diff(column) > 0.0).all()) for column in numbers.T]
        if grows != [True, *[False] * (width - 1)]:
            raise ValueError(f"{text}; the first column alone of slip, tau, sigma_N grows from row to row")
        names = [*REQUIRED[:width]]
        warn_if(True, f"{table.path}: no header: the columns are read as {', '.join(names)}")
    return replace(table, names=names, headings=names, units=[""] * width)


def factors_of(where: str, units: Mapping[str, str], target: tuple[str, str]) -> list[float]:
    """Factor of every column from its unit to that of the target, 1 where no column has a unit."""
    length, stress = (size(kind, unit) for kind, unit in zip(NONE, target, strict=True))
    wanted = {"length": length, "stress": stress, "stiffness": stress / length, "force": stress * length**2}
    first = next((f"{name} [{unit}]" for name, unit in units.items() if unit), "")
    without = next((name for name, unit in units.items() if first and not unit), "")
    if without:
        text = f"column {without} has no unit: expected one for every column, as {first} has, or none at all"
        raise ValueError(f"{where}: {text}")
    kinds = ((KINDS[name], unit, f"{where}: {name} ") for name, unit in units.items() if first)
    return [size(*kind) / wanted[kind[0]] for kind in kinds] or [1.0] * len(units)

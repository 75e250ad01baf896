"""What comparison and picture need of a case file; harness/case_file.f90 owns the format and checks it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .contract import Floats
from .material import Material
from .pattern import Pattern

Group = dict[str, list[str]]
"""Values of a namelist group by lower-case name."""

_TOKEN = re.compile(
    r"""(?P<comment>![^\n]*)
    | (?P<string>'(?:[^']|'')*' | "(?:[^"]|"")*")
    | &(?P<group>\w+)
    | (?P<end>/)
    | (?P<entry>\w+)\s*=
    | (?P<value>[^\s,=/!'"&]+)""",
    re.VERBOSE,
)
"""Pieces of a namelist file, tried in this order; blanks and commas lie between them."""


DEFAULT_INCREMENTS = 100
"""Increments to a target where a step says none (harness/load_path.f90)."""


@dataclass(frozen=True, eq=False)
class SlipTest:
    """Slips (T,) along direction (degrees) under a held sigma_N, applied first in `preload` increments.

    A case that opens the interface in mode I has no slips.  value is that of the sweep, None without one.
    """

    value: float | None
    material: Material
    pattern: Pattern
    preload: int
    sigma_N: float
    direction: float
    slips: Floats


def groups(path: Path) -> list[tuple[str, Group]]:
    """Namelist groups of a file in their order."""
    found: list[tuple[str, Group]] = []
    values: list[str] = []
    inside = False
    try:
        content = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: byte {error.start} is no text in UTF-8: expected a case file") from None
    for token in _TOKEN.finditer(content):
        kind, text = token.lastgroup, token[0]
        if kind == "group":
            inside = True
            found.append((token["group"].lower(), {}))
        elif kind == "end":
            inside = False
        elif inside and kind == "entry":
            values = found[-1][1].setdefault(token["entry"].lower(), [])
        elif inside and kind == "string":
            values.append(text[1:-1].replace(2 * text[0], text[0]))
        elif inside and kind == "value":
            values.append(text)
    return found


def number(text: str) -> float:
    """Number as Fortran writes it, 1 or 0 for a truth value; raises ValueError for anything else."""
    truth = {"true": 1.0, "t": 1.0, "false": 0.0, "f": 0.0}
    word = text.lower()
    key = word.strip(".")
    return truth[key] if key in truth else float(word.replace("d", "e"))


def labels(path: Path) -> tuple[str, str]:
    """Title of a case and name of its sweep; the name of the file and nothing where there is none."""
    found = dict(groups(path))
    title = found.get("case", {}).get("title", [path.stem])
    return ", ".join(title), found.get("sweep", {}).get("name", [""])[0]


def slip_tests(path: Path) -> Iterator[SlipTest]:
    """Tests of a case, one for each value of its sweep.

    Raises ValueError for a case that is neither slip under a held normal traction nor opening in mode I, or
    that does not start virgin.
    """
    found = groups(path)
    for name, _ in found:
        if name in ("initial", "state"):
            raise ValueError(f"{path}: &{name}: expected a case that starts virgin and free of traction")
    sweep = next((group for name, group in found if name == "sweep"), None)
    for text in sweep["values"] if sweep else [None]:
        replaced = {sweep["name"][0].lower(): text} if sweep and text is not None else {}
        numbers = [
            (
                name,
                {
                    key: [number(replaced.get(value.lower(), value)) for value in values]
                    for key, values in group.items()
                },
            )
            for name, group in found
            if name in ("material", "pattern", "step")
        ]
        yield _test(path, None if text is None else float(text), numbers)


def _test(path: Path, value: float | None, found: list[tuple[str, dict[str, list[float]]]]) -> SlipTest:
    constants = ("sigma0", "Gc", "eta", "mu", "sigma02", "Gc2", "tau_v", "kc", "guard")
    names = {name.lower(): name for name in constants}
    material = Material(
        **{names[key]: v[0] for name, g in found if name == "material" for key, v in g.items()}
    )
    group = next(group for name, group in found if name == "pattern")
    preload, sigma_N, direction = 0, 0.0, 0.0
    opened = held = False
    slips = [np.zeros(1)]
    for step in (group for name, group in found if name == "step"):
        step.pop("tolerance", None)
        parts = [int(n) for n in step.get("increments", [DEFAULT_INCREMENTS])]
        if (
            step.keys() <= {"t_n", "increments"}
            and len(step.get("t_n", [])) == 1
            and not (preload or opened or len(slips) > 1)
        ):
            preload, sigma_N = parts[0], step["t_n"][0]
        elif (
            "slip" in step
            and step.keys() <= {"slip", "direction", "increments", "t_n", "cycles"}
            # held by an earlier step, or by this one: else the driver holds s_N
            and step.get("t_n", [sigma_N] if preload or held else []) == [sigma_N]
            and not opened
            and (len(slips) == 1 or step.get("direction", [direction]) == [direction])
        ):
            held = True
            direction = step.get("direction", [direction])[0]
            cycles = int(step.get("cycles", [1])[0])
            # the last number goes on
            parts += [parts[-1]] * (len(step["slip"]) - len(parts))
            for target, n in zip(cycles * step["slip"], cycles * parts, strict=True):
                slips.append(np.linspace(slips[-1][-1], target, n + 1)[1:])
        elif step.keys() <= {"s_n", "increments"} and not (preload or len(slips) > 1):
            opened = True
        else:
            raise ValueError(
                f"{path}: expected &step with t_N, then slip under it in one direction, or with s_N alone"
            )
    return SlipTest(value, material, _pattern(group), preload, sigma_N, direction, np.concatenate(slips)[1:])


def _pattern(group: dict[str, list[float]]) -> Pattern:
    """Regular or listed planes."""
    if "weights" in group:
        return Pattern.planes(np.reshape(group["normals"], (-1, 3)), group["weights"])
    values = {name: numbers[0] for name, numbers in group.items()}
    return Pattern.regular(int(values.pop("sides")), values.pop("theta", 0.0), **values)

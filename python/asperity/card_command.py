"""Command `asperity card`: the material block of a host for the interface of a case file."""

from __future__ import annotations

import argparse
import sys
import warnings
from pathlib import Path
from typing import Any

from . import contract
from .case_files import Group, groups, number
from .interface import Interface
from .material import Material
from .pattern import Pattern

_MATERIAL = ("sigma0", "Gc", "eta", "mu", "sigma02", "Gc2", "tau_v", "kc", "guard")
_REPLAY = ("h", "map", "r")
_GROUPS = ("material", "pattern", "replay")


def add_command(commands: Any) -> None:
    """Add the subcommand to the command's subparsers."""
    card = commands.add_parser("card", help="print the material block for the input of a host program")
    card.add_argument("case", type=Path, metavar="CASE.nml", help="namelist input of rie_driver")
    card.add_argument("--host", required=True, choices=("abaqus", "calculix", "kratos"))
    card.add_argument("--name", default="INTERFACE", help="of material and elements (default: %(default)s)")
    card.add_argument("--value", metavar="VALUE", help="the value of the sweep, for a case that has one")
    card.add_argument("-o", "--output", type=Path, metavar="FILE", help="write it there")
    for name, kind in (("h", float), ("map", int), ("dalpha", float), ("r", float)):
        row = contract.props_table()[contract.index(name)]
        card.add_argument(
            f"--{name}", type=kind, help=f"{row.meaning} (default: that of &replay, or {row.default:g})"
        )
    card.add_argument("--dimension", type=int, default=3, choices=(2, 3), help="default: %(default)s")
    card.add_argument("--explicit", action="store_true", help="for Abaqus/Explicit; needs --density")
    card.add_argument("--density", type=float, metavar="RHO", help="mass over area and thickness h")
    checks = card.add_argument_group("checks", "what is given is checked; remarks go into the block")
    checks.add_argument(
        "--stress",
        type=float,
        metavar="SIGMA_N",
        help="largest compression, < 0: is the contact stiff enough?",
    )
    checks.add_argument("--modulus", type=float, metavar="E", help="Young's modulus of the solid beside it")
    checks.add_argument("--size", type=float, metavar="L", help="length of its elements: snap-back, mesh")
    card.set_defaults(action=_card)


def _card(options: argparse.Namespace) -> int:
    """Print or write the block; warnings go to standard error, a line each."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        interface, keywords = read_interface(options.case, options.value)
        for name in ("h", "map", "dalpha", "r"):
            if getattr(options, name) is not None:
                keywords[name] = getattr(options, name)
        text = interface.card(
            options.host,
            name=options.name,
            dimension=options.dimension,
            explicit=options.explicit,
            density=options.density,
            stress=options.stress,
            modulus=options.modulus,
            size=options.size,
            **keywords,
        )
    messages = [str(warning.message) for warning in caught]
    messages += [
        f"{options.case}: &{group}: not in the block, which is that of a virgin joint: expected initial "
        "conditions of the host beside it"
        for group, _ in groups(options.case)
        if group in ("initial", "state")
    ]
    for message in messages:
        print(f"asperity: warning: {message}", file=sys.stderr)
    if options.output is None:
        print(text, end="")
    else:
        options.output.write_text(text, encoding="utf-8")
    return 0


def read_interface(path: Path, value: str | None = None) -> tuple[Interface, dict[str, Any]]:
    """Interface of a case file, and the keywords of `Interface.card` that its group &replay gives.

    value replaces the name of the sweep.  Raises ValueError for what is missing, unknown or no number.
    """
    found = groups(path)
    sweep = dict(found).get("sweep")
    replaced = {}
    if sweep is not None and _is_used(found, sweep["name"][0]):
        name, values = sweep["name"][0], ", ".join(sweep["values"])
        if value is None:
            raise ValueError(f"{path}: --value is missing: expected one for {name}, as {values}")
        replaced[name.lower()] = value
    elif value is not None:
        raise ValueError(f"{path}: --value {value}: expected where a constant is the name of a sweep only")
    material = _numbers(path, found, "material", _MATERIAL, replaced)
    pattern = _numbers(
        path, found, "pattern", ("sides", "theta", "flat", "turn", "normals", "weights"), replaced
    )
    replay = _numbers(path, found, "replay", _REPLAY, replaced, others=True)
    missing = [name for name in _MATERIAL[: contract.N_REQUIRED_PROPS] if name not in material]
    if missing:
        raise ValueError(f"{path}: &material: expected {', '.join(missing)}")
    keywords: dict[str, Any] = {name: values[0] for name, values in replay.items()}
    if "map" in keywords:
        keywords["map"] = int(keywords["map"])
    constants = {name: values[0] for name, values in material.items()}
    return Interface(Material(**constants), _pattern(path, pattern)), keywords


def _is_used(found: list[tuple[str, Group]], name: str) -> bool:
    """Whether a constant of the interface is the name of the sweep."""
    texts = [text for group in _GROUPS for values in dict(found).get(group, {}).values() for text in values]
    return name.lower() in map(str.lower, texts)


def _pattern(path: Path, values: dict[str, list[float]]) -> Pattern:
    """Regular or listed planes."""
    if "sides" in values:
        if values.keys() & {"normals", "weights"}:
            raise ValueError(f"{path}: &pattern: expected sides, or normals and weights")
        numbers = {name: value[0] for name, value in values.items()}
        sides = numbers.pop("sides")
        if sides != int(sides):
            raise ValueError(f"{path}: &pattern: sides = {sides:g}: expected a whole number")
        return Pattern.regular(int(sides), numbers.pop("theta", contract.default("theta")), **numbers)
    if values.keys() != {"normals", "weights"}:
        raise ValueError(f"{path}: &pattern: expected sides, or normals and weights")
    components = values["normals"]
    if len(components) % 3 != 0:
        raise ValueError(f"{path}: &pattern: {len(components)} values of normals: expected three a plane")
    return Pattern.planes([components[i : i + 3] for i in range(0, len(components), 3)], values["weights"])


def _numbers(
    path: Path,
    found: list[tuple[str, Group]],
    group: str,
    names: tuple[str, ...],
    replaced: dict[str, str],
    others: bool = False,
) -> dict[str, list[float]]:
    """Numbers of a group by the names of the contract; with `others`, other names are passed over."""
    by_lower = {name.lower(): name for name in names}
    numbers = {}
    for key, texts in dict(found).get(group, {}).items():
        if key not in by_lower:
            if others:
                continue
            raise ValueError(f"{path}: &{group}: {key}: unknown name, expected one of {', '.join(names)}")
        try:
            numbers[by_lower[key]] = [number(replaced.get(text.lower(), text)) for text in texts]
        except ValueError:
            raise ValueError(f"{path}: &{group}: {key} = {', '.join(texts)}: expected numbers") from None
        if not texts:
            raise ValueError(f"{path}: &{group}: {key}: expected a value")
    return numbers

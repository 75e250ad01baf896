"""Material blocks for the input of host programs."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from .. import contract, hosts

PER_LINE = 8  # largest number of constants on a line of an Abaqus or CalculiX input
FIELD = 20  # characters of a number that they read; CalculiX drops the others, which may be an exponent

WHY = {
    "h": ", whose joints pass separations", "map": ", whose order of components is fixed",
    "dalpha": ", which ignores a request for a smaller step", "r": ", whose joint has no other stress",
    "water": ", which passes no field to the law",
    "implex": ", where IMPL-EX is not offered or was not tried",
}  # fmt: skip


AT_FIRST = (
    "** Zero state variables are the initial state of the joint, so no initial conditions are needed.",
    "** The first call of a point reads an initial stress (TYPE=STRESS).",
)


@dataclass(frozen=True)
class Block:
    """Contents of a material block; props and statev are in the order of the library."""

    name: str
    props: contract.Floats
    statev: tuple[str, ...]
    notes: Sequence[str] = ()
    dimension: int = 3
    explicit: bool = False
    contact: bool = False
    density: float | None = None
    stiffness: tuple[float, float] = (0.0, 0.0)  # largest in shear and in opening, for Cast3M

    def prop(self, name: str) -> float:
        """Entry of PROPS by name."""
        return float(self.props[contract.index(name)])

    def thickness(self) -> float:
        """Thickness by which the host divides; 0 stands for 1."""
        return self.prop("h") or 1.0


def card(host: str, block: Block) -> str:
    """Text for the input of a host; raises ValueError for a value that the host cannot take."""
    takes: hosts.Card = hosts.of(host, "card")
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,39}", block.name):
        raise ValueError(
            f"name = {block.name!r}: expected a letter, then up to 39 letters, digits or underscores"
        )
    if block.dimension not in (2, 3):
        raise ValueError(f"dimension = {block.dimension}: expected 2 or 3")
    if not takes.explicit and (block.explicit or block.density is not None):
        able = ", ".join(
            name for name, known in hosts.hosts("card").items() if known.card and known.card.explicit
        )
        raise ValueError(f"explicit, density: expected for {able} only, not for {host}")
    if block.contact and not takes.contact:
        able = ", ".join(
            name for name, known in hosts.hosts("card").items() if known.card and known.card.contact
        )
        raise ValueError(f"contact: expected for {able} only, not for {host}")
    if block.density is not None and not 0.0 < block.density < float("inf"):
        raise ValueError(f"density = {block.density:g}: expected > 0")
    if not takes.listed and block.prop("m") < 0.0:
        raise ValueError(f"m = {block.prop('m'):g}: expected a regular pattern for {host}, not listed planes")
    known = {row.name for row in contract.props_table()}
    for name, expected in takes.only.items():
        of_host = {"dimension": block.dimension, "h": block.thickness()}
        if name not in of_host and name not in known:
            file = hosts.folder(host) / "host.toml"
            raise ValueError(f"{file}: card.only: {name}: expected dimension or a constant of PROPS")
        value = of_host[name] if name in of_host else block.prop(name)
        good = expected if isinstance(expected, list) else [expected]
        if value not in good:
            why = WHY.get(name, "") if len(good) == 1 else ""
            why = f": {takes.water}" if name == "water" and takes.water else why
            one_of = " or ".join(f"{value:g}" for value in good)
            raise ValueError(f"{name} = {value:g}: expected {one_of} for {host}{why}")
    writer = hosts.part(host, "card")
    if writer is None:
        raise FileNotFoundError(f"{hosts.folder(host)}: expected card.py, which writes the block")
    return str(writer.block_of(block))


def comments(block: Block, run: str, count: int = contract.N_USED_PROPS) -> str:
    """Head of a block: its origin, the first entries of PROPS, how to run it, and the notes."""
    names = ", ".join(row.name for row in contract.props_table()[:count])
    head, *lines = remarks(block, run, mark="** ")
    return "\n".join([f"{head}: {names}", *lines])


def remarks(block: Block, run: str, *more: str, mark: str = "") -> list[str]:
    """Lines at the head of a block, after a mark: its origin, how to run it, the notes, and more."""
    units = "units: one consistent set, such as mm, N, MPa, N/mm; theta and turn in degrees"
    texts = f"asperity {contract.library_version()}", units, run, *block.notes, *more
    return [f"{mark}{text}" for text in texts]


def text_of(*lines: str) -> str:
    """Text of these lines."""
    return "\n".join(lines) + "\n"


def numeral(value: float) -> str:
    """Number with all its digits, or as many as an input of Abaqus or CalculiX has room for."""
    texts = (repr(value), *(f"{value:.{digits}g}" for digits in (15, 14, 13)))
    return next(text for text in texts if len(text) <= FIELD)


def constants(props: contract.Floats) -> list[str]:
    """Lines of constants."""
    texts = [numeral(value) for value in props.tolist()]
    return [", ".join(texts[i : i + PER_LINE]) for i in range(0, len(texts), PER_LINE)]

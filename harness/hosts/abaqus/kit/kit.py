"""The kit for Abaqus: sources, decks, environment file, and a README with what a first run must show."""

from __future__ import annotations

from asperity import installed
from asperity.export.element import Element

from .decks import single_explicit, single_standard, wallette

EXPLICIT = """\
A `single_explicit.inp` is the same joint for Abaqus/Explicit. RF1 and U3 over U1 follow the rows, with
oscillations:

    abaqus job=single_explicit user=asperity_abaqus.f90 double=both

"""
"""What the README says of the deck for Abaqus/Explicit."""


def files(element: Element, examples: bool = True) -> dict[str, str | bytes]:
    """Contents of the kit by file name; examples: with the decks of an explicit element and a wall."""
    decks = {"single_standard.inp": single_standard(element)}
    if examples:
        decks |= {"single_explicit.inp": single_explicit(element), "wallette.inp": wallette()}
    listed = "\n".join(f"| `{name}` | {text.splitlines()[1]} |" for name, text in decks.items())
    environment = (installed.kit("abaqus") / "abaqus_v6.env").read_text(encoding="ascii")
    texts = {
        "README.md": element.readme("abaqus", decks=listed, explicit=EXPLICIT if examples else ""),
        "abaqus_v6.env": environment,
    }
    sources = {path.name: path.read_bytes() for path in sorted(installed.abaqus().glob("*.f90"))}
    return texts | {"joint.nml": element.text} | decks | sources

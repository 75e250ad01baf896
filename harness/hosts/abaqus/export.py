"""The kit of Abaqus: sources, decks, environment file and README."""

from __future__ import annotations

from typing import Any

from asperity import Interface, contract, hosts, installed
from asperity.export.element import Element

DENSITY = 1.0e-8
"""Mass per area of a joint in Abaqus/Explicit, t/mm2."""

EXPLICIT = """\
A `single_explicit.inp` is the same joint for Abaqus/Explicit. RF1 and U3 over U1 follow the rows, with
oscillations:

    abaqus job=single_explicit user=asperity_abaqus.f90 double=both

"""
"""What the README says of the deck for Abaqus/Explicit."""


def files(element: Element, examples: bool) -> dict[str, str | bytes]:
    """Sources, decks, environment file and README; examples: with an explicit element."""
    stress = element.sigma_N or None
    texts = {"traction": f"{element.sigma_N:g}", "stroke": f"{element.slip:g}"}
    cards = {"single_standard": _with_asperities(element.interface, stress=stress)}
    if examples:
        cards["single_explicit"] = _with_asperities(
            element.interface, stress=stress, explicit=True, density=DENSITY
        )
    decks = {f"{name}.inp": element.filled("abaqus", f"{name}.inp", card=card, **texts)
             for name, card in cards.items()}  # fmt: skip
    listed = "\n".join(f"| `{name}` | {text.splitlines()[1]} |" for name, text in decks.items())
    readme = element.readme("abaqus", decks=listed, explicit=EXPLICIT if examples else "")
    environment = (hosts.folder("abaqus") / "abaqus_v6.env").read_text(encoding="ascii")
    sources = {path.name: path.read_bytes() for path in sorted(installed.abaqus().glob("*.f90"))}
    texts = {"README.md": readme, "abaqus_v6.env": environment, "joint.nml": element.text}
    return texts | decks | sources


def _with_asperities(joint: Interface, **options: Any) -> str:
    """Material and section of a joint, with what the two constants of finite asperities would do."""
    height, wear = (contract.index(name) + 1 for name in ("height", "W0"))
    worn, states = (contract.n_statev(joint.n_planes, with_wear) for with_wear in (True, False))
    return (
        f"** Finite asperities: PROPS {height} (height, mm) is the rise at which the dilation ends, and\n"
        f"** PROPS {wear} (W0, N/mm) the work of friction per area that wears 63 % of them off. Both are 0\n"
        f"** here: no end and no wear. With W0 > 0\n** *Depvar needs {worn} variables instead of {states}.\n"
        + joint.card("abaqus", name="JOINT", **options)
    )

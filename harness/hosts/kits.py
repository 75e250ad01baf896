"""The files that `asperity export HOST` writes for one joint element, by host."""

from __future__ import annotations

from typing import Any

from asperity import Interface, Material, Pattern, contract, installed
from asperity.export.element import Element

JOINTED = " ".join(f"jointed{part}.py" for part in ("", "_follow", "_mesh", "_model", "_output", "_steps"))
"""Files of the solver for FEniCSx."""

KITS: dict[str, tuple[dict[str, Any], str, str, str]] = {
    "akantu": ({"name": "joint"}, "", "material.dat", "single.py asperity_akantu.py single.msh"),
    "calculix": ({"name": "JOINT", "h": 1.0e-3}, "", "single.inp", ""),
    "fenicsx": ({"name": "joint"}, "joint.py", "", f"single.py {JOINTED} paraview_files.py"),
    "kratos": ({}, "joint.json", "", "single.py kratos_model.py"),
    "ogs": ({"h": 1.0e-4}, "card.xml", "path.xml", "single.prj layer.vtu bottom.vtu top.vtu"),
    "oofem": ({"h": 1.0e-4}, "", "single.in", "oofem_run.py"),
}
"""Options of the card, its own file, the template that is filled (with the card without one), others."""

DENSITY = 1.0e-8
"""Mass per area of a joint in Abaqus/Explicit, t/mm2."""

EXPLICIT = """\
A `single_explicit.inp` is the same joint for Abaqus/Explicit. RF1 and U3 over U1 follow the rows, with
oscillations:

    abaqus job=single_explicit user=asperity_abaqus.f90 double=both

"""
"""What the README says of the deck for Abaqus/Explicit."""


def files(host: str, element: Element, examples: bool = True) -> dict[str, str | bytes]:
    """Contents of the kit of a host by file name; examples: whether it has other models, too."""
    if host == "abaqus":
        return _abaqus(element, examples)
    options, own, template, others = KITS[host]
    card = element.interface.card(host, stress=element.sigma_N or None, **options)
    texts = element.scripts(host, *others.split())
    if own:
        texts[own] = card
    return texts | ({template: filled(host, element, card)} if template else {})


def filled(host: str, element: Element, card: str) -> str:
    """Template of a host with the path of the element and a card; OOFEM's first step has the time 0."""
    options, _, template, _ = KITS[host]
    last = element.press + element.slide
    texts = {"card": card, "h": repr(options.get("h")), "steps": f"{last + 1}", "after": f"{last + 9}"}
    return element.filled(host, template, **texts)


def _abaqus(element: Element, examples: bool) -> dict[str, str | bytes]:
    """Sources, decks, environment file and README; examples: with an explicit element and a wallette."""
    stress = element.sigma_N or None
    texts = {"traction": f"{element.sigma_N:g}", "stroke": f"{element.slip:g}"}
    cards = {"single_standard": _with_asperities(element.interface, stress=stress)}
    if examples:
        cards["single_explicit"] = _with_asperities(
            element.interface, stress=stress, explicit=True, density=DENSITY
        )
        theta, pressure, length = 15.0, 0.5, 400.0  # of the wallette
        bond = Material(sigma0=1.0, Gc=0.02, eta=0.95, mu=0.6, kc=10.0)
        mortar = Interface(bond, Pattern.regular(2, theta))
        texts["strength"] = f"{mortar.material.residual_strength(theta) * pressure * length:.6g}"
        names = contract.statev_names(mortar.n_planes)
        row = ["BED_2", *("1." if name.startswith("alpha") else "0." for name in names)]
        texts["cracked"] = "".join(", ".join(row[i : i + 8]) + "\n" for i in range(0, len(row), 8))
        cards["wallette"] = _with_asperities(mortar, dimension=2, stress=-pressure, modulus=5000.0, size=20.0)
    decks = {f"{name}.inp": element.filled("abaqus", f"{name}.inp", card=card, **texts)
             for name, card in cards.items()}  # fmt: skip
    listed = "\n".join(f"| `{name}` | {text.splitlines()[1]} |" for name, text in decks.items())
    readme = element.readme("abaqus", decks=listed, explicit=EXPLICIT if examples else "")
    environment = (installed.kit("abaqus") / "abaqus_v6.env").read_text(encoding="ascii")
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

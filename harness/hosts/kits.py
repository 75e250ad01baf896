"""The files that `asperity export HOST` writes for one joint element, by host."""

from __future__ import annotations

from typing import Any

from asperity.export.element import Element

KITS: dict[str, tuple[dict[str, Any], str, str, str]] = {
    "akantu": ({"name": "joint"}, "", "material.dat", "single.py asperity_akantu.py single.msh"),
    "calculix": ({"name": "JOINT", "h": 1.0e-3}, "", "single.inp", ""),
    "kratos": ({}, "joint.json", "", "single.py kratos_model.py"),
    "ogs": ({"h": 1.0e-4}, "card.xml", "path.xml", "single.prj layer.vtu bottom.vtu top.vtu"),
    "oofem": ({"h": 1.0e-4}, "", "single.in", "oofem_run.py"),
}
"""Options of the card, its own file, the template that is filled (with the card without one), others."""


def files(host: str, element: Element, examples: bool = True) -> dict[str, str | bytes]:
    """Contents of the kit of a host by file name; examples: whether it has other models, too."""
    if host == "abaqus":
        from asperity.hosts.abaqus.kit import files as of_abaqus

        return of_abaqus(element, examples)
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

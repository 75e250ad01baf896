"""The kit for OOFEM: an input with one element of a thin layer, and a script that runs it."""

from __future__ import annotations

from asperity.export.element import Element

H = 1.0e-4
"""Thickness of the layer, whose edges are 1."""


def files(element: Element, examples: bool = True) -> dict[str, str]:
    """Contents of the kit by file name."""
    card = element.interface.card("oofem", h=H, stress=element.sigma_N or None)
    return element.scripts("oofem", "oofem_run.py") | {"single.in": text(element, card)}


def text(element: Element, card: str) -> str:
    """Input with this material; the first step has the time 0."""
    last = element.press + element.slide
    ends = {"steps": f"{last + 1}", "after": f"{last + 9}"}
    return element.filled("oofem", "single.in", card=card, h=repr(H), **ends)

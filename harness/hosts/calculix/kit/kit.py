"""The kit for CalculiX: an input with one element of a thin layer."""

from __future__ import annotations

from asperity.export.element import Element

H = 1.0e-3
"""Thickness of the layer, whose edges are 1."""


def files(element: Element, examples: bool = True) -> dict[str, str]:
    """Contents of the kit by file name."""
    card = element.interface.card("calculix", h=H, name="JOINT", stress=element.sigma_N or None)
    model = element.filled("calculix", "single.inp", card=card, h=repr(H))
    return element.scripts("calculix") | {"single.inp": model}

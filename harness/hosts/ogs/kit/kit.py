"""The kit for OpenGeoSys: a project with one element of a thin layer, its meshes and patches."""

from __future__ import annotations

from asperity.export.element import Element

H = 1.0e-4
"""Thickness of the layer in the meshes, whose edges are 1."""


def files(element: Element, examples: bool = True) -> dict[str, str]:
    """Contents of the kit by file name."""
    card = element.interface.card("ogs", h=H, stress=element.sigma_N or None)
    patches = {"card.xml": card, "path.xml": element.filled("ogs", "path.xml")}
    return element.scripts("ogs", "single.prj", "layer.vtu", "bottom.vtu", "top.vtu") | patches

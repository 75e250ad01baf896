"""The kit for Akantu: the material in Python, and a script with one cohesive element."""

from __future__ import annotations

from asperity.export.element import Element


def files(element: Element, examples: bool = True) -> dict[str, str]:
    """Contents of the kit by file name."""
    card = element.interface.card("akantu", name="joint", stress=element.sigma_N or None)
    model = element.filled("akantu", "material.dat", card=card)
    scripts = element.scripts("akantu", "single.py", "asperity_akantu.py", "single.msh")
    return scripts | {"material.dat": model}

"""The kit for Kratos: a script with one interface element."""

from __future__ import annotations

from asperity.export.element import Element


def files(element: Element, examples: bool = True) -> dict[str, str]:
    """Contents of the kit by file name."""
    card = element.interface.card("kratos", stress=element.sigma_N or None)
    return element.scripts("kratos", "single.py", "kratos_model.py") | {"joint.json": card}

"""The files that `asperity export HOST` writes for one joint element, by host."""

from __future__ import annotations

from .. import hosts
from .element import Element


def files(host: str, element: Element, examples: bool = True) -> dict[str, str | bytes]:
    """Contents of the kit of a host by file name; examples: whether it has other models, too."""
    kit: hosts.Kit = hosts.of(host, "kit")
    module = hosts.part(host, "export")
    if module is not None:
        return dict(module.files(element, examples))
    card = element.interface.card(host, stress=element.sigma_N or None, **kit.options)
    texts: dict[str, str | bytes] = dict(element.scripts(host, *kit.files))
    if kit.card:
        texts[kit.card] = card
    return texts | ({kit.template: filled(host, element, card)} if kit.template else {})


def filled(host: str, element: Element, card: str) -> str:
    """Template of a host with the path of the element and a card; OOFEM's first step has the time 0."""
    kit: hosts.Kit = hosts.of(host, "kit")
    last = element.press + element.slide
    texts = {"card": card, "h": repr(kit.options.get("h")), "steps": f"{last + 1}", "after": f"{last + 9}"}
    return element.filled(host, kit.template, **texts)

"""The kit of OpenRadioss: one connection element whose upper nodes go along the path of a material point."""

from __future__ import annotations

import numpy as np
from asperity import Step, installed
from asperity.export.element import Element

DURATION = 1.0e-3
"""Time of the path; inertia has no part in it, as all displacements are prescribed."""

EVERY = 20
"""Cycles of the engine between two increments of the path, or more."""


def files(element: Element, examples: bool) -> dict[str, str | bytes]:
    """Decks of starter and engine, README and case."""
    steps = (
        Step(t_N=element.sigma_N, increments=element.press),
        Step(slip=element.slip, direction=0.0, increments=element.slide),
    )
    history, _ = element.interface.rows(steps)
    times = DURATION * np.arange(len(history) + 1) / len(history)
    columns = {"opening": history.separation[:, 0], "sliding": history.separation[:, 1]}
    tables = {
        name: "".join(f"{t:>20.13g}{s:>20.13g}\n" for t, s in zip(times, [0.0, *column], strict=True))
        for name, column in columns.items()
    }
    card = element.interface.card("radioss", name="JOINT", stress=element.sigma_N or None)
    interval = DURATION / len(history)
    texts = {
        "card": card,
        "end": f"{DURATION:g}",
        "interval": f"{interval:.13g}",
        "step": f"{interval / EVERY:.13g}",
    }
    decks: dict[str, str | bytes] = {
        name: element.filled("radioss", name, **tables, **texts)
        for name in ("single_0000.rad", "single_0001.rad")
    }
    library = installed.named_library("raduser_linux64")
    places = {"library": library.name, "folder": str(library.parent), "time": f"{DURATION:g}"}
    return {"README.md": element.readme("radioss", **places), "joint.nml": element.text} | decks

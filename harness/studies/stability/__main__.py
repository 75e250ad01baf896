"""Failure modes of solution methods: the entries of docs/results/stability.md and its pictures."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from asperity.tools.style import save

from ..program import DIFFERS, program
from ..tables import refresh
from .branches import draw
from .entries import MODES, as_expected
from .symmetric import chart, sentences
from .symmetric import draw as draw_chart


def _run(options: argparse.Namespace) -> int:
    """Run the entries, draw the picture, and print the sections or fill them into a page."""
    sections, bad = [], 0
    for name in options.only or MODES:
        trials = MODES[name].run()
        sections.append(MODES[name].section(trials))
        if not as_expected(trials):
            bad += 1
            print(f"{name}: expected a failure and a success", file=sys.stderr)
    options.folder.mkdir(parents=True, exist_ok=True)
    picture = options.folder / "stability_snap.png"
    save(draw(), picture)
    factors = chart()
    regions = options.folder / "stability_symmetric.png"
    save(draw_chart(factors), regions)
    text = "\n\n".join(sections)
    if options.page is None:
        print(text, sentences(factors), sep="\n\n", end="\n\n")
    else:
        refresh(options.page, False, {"stability": text, "symmetric": sentences(factors)})
    print(picture, regions, sep="\n")
    return DIFFERS if bad else 0


main = program(
    _run,
    ("--folder DIR", "folder of the pictures", Path()),
    ("--page FILE.md", "fill the sections into a page, between the markers <!-- stability -->", Path),
    ("--only ENTRY", "which", str, {"nargs": "+", "choices": MODES}),
)

if __name__ == "__main__":
    sys.exit(main())

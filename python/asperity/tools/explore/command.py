"""Command `asperity explore`: a page in the browser whose sliders redraw a slip test."""

from __future__ import annotations

import argparse
import math
import sys
import webbrowser
from typing import TYPE_CHECKING

from ... import contract
from ...installed import needed
from ...options import add_options, assigned
from .model import CYCLES, LOGARITHMIC, OPTIONAL, VALUES, Choice

if TYPE_CHECKING:
    from bokeh.document import Document


def add_arguments(explore: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    explore.description = (
        "Open a page in the browser with sliders for constants, pattern and load path of a slip test. The "
        "command serves this page, to this machine only, until Ctrl-C ends it."
    )
    add_options(
        explore,
        ("values NAME=VALUE", f"values at the start, of {', '.join(VALUES)}", str, {"nargs": "*"}),
        ("--port PORT", "of the page, 0 for any that is free", 5006),
        ("--no-browser", "print the address only"),
    )
    explore.set_defaults(action=_run)


def _run(options: argparse.Namespace) -> int:
    values = _values(options.values)
    if not 0 <= options.port <= 65535:
        raise ValueError(f"--port {options.port}: expected 0 to 65535")
    needed("explore", "bokeh")
    from bokeh.server.server import Server

    from .page import Page

    def show(document: Document) -> None:
        Page(document, values)

    try:
        server = Server(
            {"/": show},
            port=options.port,
            address="127.0.0.1",
            num_procs=1,
        )
    except OSError as error:
        raise OSError(f"--port {options.port}: {error.strerror or error}: expected a free port") from None
    # Bokeh accepts connections of pages from this name
    address = f"http://localhost:{server.port}/"
    print(f"{address}  (Ctrl-C ends it)", flush=True)
    server.start()
    if not options.no_browser and not webbrowser.open(address):
        print("no browser was found: open the address in one", file=sys.stderr)
    try:
        server.io_loop.start()
    except KeyboardInterrupt:
        pass
    finally:
        server.stop()
    return 0


def _values(texts: list[str]) -> dict[str, float]:
    """Values at the start, those of the command instead of the defaults."""
    values = dict(VALUES)
    for name, text in assigned(texts).items():
        if name not in VALUES:
            raise ValueError(f"{name}={text}: expected one of {', '.join(VALUES)}")
        values[name] = value = contract.number(name, text)
        least = " >= 0" if name in OPTIONAL else " > 0" if name in LOGARITHMIC else ""
        if not math.isfinite(value) or (least and value < 0.0) or (least == " > 0" and value == 0.0):
            raise ValueError(f"{name}={text}: expected a finite number{least}")
        if name == "sides" and not value.is_integer():
            raise ValueError(f"{name}={text}: expected a whole number")
    _ = Choice(values, next(iter(CYCLES))).interface  # the library refuses other values
    return values

"""Frame of the programs of this folder, which `python -m harness.studies.NAME` starts from the top folder."""

from __future__ import annotations

import argparse
import inspect
import sys
from collections.abc import Callable, Sequence
from typing import Any

from asperity.cli import execute
from asperity.options import add_options

DIFFERS = 1
"""Exit code of a comparison that does not hold."""

Main = Callable[..., int]
"""Function that runs a program with arguments, or with those of the command line; returns its exit code."""


def program(action: Callable[[argparse.Namespace], int], *rows: tuple[Any, ...]) -> Main:
    """Program with an action and its options, rows of `add_options`; its module's docstring describes it."""

    def main(arguments: Sequence[str] | None = None) -> int:
        module = inspect.getmodule(action)
        spec = getattr(module, "__spec__", None)
        name = spec.name.removesuffix(".__main__") if spec else str(module)
        description = (inspect.getdoc(module) or "").split("\n\n")[0]
        parser = argparse.ArgumentParser(prog=f"python -m {name}", description=description)
        add_options(parser, *rows)
        parser.set_defaults(action=action)
        return execute(parser, sys.argv[1:] if arguments is None else arguments)

    return main

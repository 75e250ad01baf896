"""Frame of the programs of this folder, which `python -m harness.studies.NAME` starts from the top folder."""

from __future__ import annotations

import argparse
import inspect
import sys
from collections.abc import Callable, Sequence

from asperity.cli import execute

DIFFERS = 1
"""Exit code of a comparison that does not hold."""


def run(
    add_arguments: Callable[[argparse.ArgumentParser], None], arguments: Sequence[str] | None = None
) -> int:
    """Run a program with arguments, or with those of the command line; return its exit code.

    add_arguments adds the arguments and sets the action; the docstring of its module describes the program.
    """
    module = inspect.getmodule(add_arguments)
    spec = getattr(module, "__spec__", None)
    name = spec.name.removesuffix(".__main__") if spec else str(module)
    description = (inspect.getdoc(module) or "").split("\n\n")[0]
    parser = argparse.ArgumentParser(prog=f"python -m {name}", description=description)
    add_arguments(parser)
    return execute(parser, sys.argv[1:] if arguments is None else arguments)

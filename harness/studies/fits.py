"""The example of docs/how-to/fit.md: `python -m harness.studies.fits docs/how-to/fit.md`."""

from __future__ import annotations

import argparse
import os
import re
import sys
import tempfile
from pathlib import Path

from asperity.case_writer import props_line
from asperity.tools.fit.fitting import fit
from asperity.tools.fit.records import DEFAULT, read_tests
from asperity.tools.fit.report import draw, report

from .program import program
from .synthetic import DEFAULT_NOISE, synthetic, write_record
from .tables import refresh


def example(picture: Path) -> str:
    """Report of `asperity fit` on the default tests, without two peaks, and its picture."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "record.csv"
        write_record(path, synthetic(DEFAULT_NOISE, 0))
        found = fit(read_tests([path]))
        text = report(found, DEFAULT).replace(f"{folder}{os.sep}", "")
    draw(found, DEFAULT, picture)
    text = re.sub(r"\ntest 2, sigma_N.*?\n(?=\n)", "\n", text, count=1, flags=re.DOTALL)
    return f"```text\n{text}\n\n{props_line(found.interface.props())}\n```"


def _write(options: argparse.Namespace) -> int:
    """Fill the example into a page."""
    images = options.page.parents[1] / "images"
    images.mkdir(exist_ok=True)
    refresh(options.page, False, {"fit-example": lambda: example(images / "fit.png")})
    print(options.page)
    return 0


main = program(_write, ("page FILE.md", "fill its markers, draw its picture", Path))

if __name__ == "__main__":
    sys.exit(main())

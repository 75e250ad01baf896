"""Result files of a run of the driver."""

from __future__ import annotations

import glob
from pathlib import Path

NO_EQUILIBRIUM = 2  # exit code of the driver after a lost equilibrium


def results_of(output: Path) -> dict[float | None, Path]:
    """Result files of a run by the value of the sweep, in ascending order; None without a sweep."""
    found: dict[float | None, Path] = {None: output} if output.is_file() else {}
    values = {}
    # as in the driver, only the ending .csv is removed before the value is appended
    stem = output.name.removesuffix(".csv")
    for path in output.parent.glob(f"{glob.escape(stem)}_*.csv"):
        try:
            values[float(path.stem.removeprefix(stem + "_"))] = path
        except ValueError:
            continue
    return found | dict(sorted(values.items()))

"""Files of shear-box tests as laboratories write them, for tests of their readers."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from asperity.tools.fit import ShearTest, read_tests

HEADER, SHORT, ENVELOPE = "slip,tau,dilation,sigma_N\n", "slip,tau,sigma_N\n", "sigma_N,peak,residual,slip\n"
WITH_K = "slip,tau,dilation,k_N,sigma_N\n"
UNITS = "slip [mm],tau [MPa],dilation [mm],sigma_N [MPa]\n"
ROWS = "".join(f"{0.1 * i:.1f},{min(i, 4) * 0.2:.1f},{0.02 * i:.2f},-1\n" for i in range(1, 8))
LINE = SHORT + "".join(f"{0.1 * i:.1f},{min(i, 4) * 0.2:.1f},-1\n" for i in range(1, 8))
SLIP, TAU, DILATION = np.linspace(0.1, 0.7, 7), 0.2 * np.minimum(np.arange(1, 8), 4), 0.02 * np.arange(1, 8)


def write(folder: Path, text: str, name: str = "record.csv", encoding: str = "utf-8") -> Path:
    """A file."""
    path = folder / name
    path.write_text(text, encoding=encoding)
    return path


def seven(row: Callable[[int], str]) -> str:
    """Seven rows."""
    return "".join(row(i) + "\n" for i in range(1, 8))


def same(test: ShearTest, s_N: bool = True, digits: float = 1e-9) -> None:
    """Check that a test is that of ROWS, in mm and MPa."""
    assert test.slip == pytest.approx(SLIP, abs=digits) and test.tau == pytest.approx(TAU, abs=digits)
    assert test.sigma_N == pytest.approx(-1.0)
    assert (test.s_N == pytest.approx(DILATION, abs=digits)) if s_N else test.s_N is None


def warned(path: Path) -> tuple[list[ShearTest], list[str]]:
    """Tests of a file, and the warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        tests = read_tests(path)
    return tests, [str(warning.message) for warning in caught]

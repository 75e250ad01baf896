"""MTest (TFEL) with libasperity_generic; runs where `mtest` is on PATH."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from asperity import read_case
from asperity.cli import main
from asperity.installed import named_case


@pytest.mark.skipif(shutil.which("mtest") is None, reason="mtest is not on PATH")
@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
def test_figure05b(tmp_path: Path) -> None:
    """MTest ends where the driver ends, in every component, energy and state variable that it prints."""
    file = tmp_path / "figure05b.mtest"
    assert main(["card", "mtest", str(named_case("figure05b")), "-o", str(file)]) == 0
    subprocess.run(["mtest", file.name], cwd=tmp_path, check=True, timeout=300)
    last = np.loadtxt(tmp_path / "figure05b.res")[-1]
    history = read_case(named_case("figure05b")).runs[0].history()
    # columns: time, separation, traction, then the state variables; six digits are printed
    expected = [2.0, *history.separation[-1], *history.traction[-1], *history.state[-1]]
    assert last[: len(expected)] == pytest.approx(expected, rel=2e-5, abs=1e-9)


WATER = """&case title = 'Water in a rough joint' /
&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5, kc = 100.0 /
&pattern sides = 4, theta = 30.0 /
&step t_N = -10.0, slip = 0.0, increments = 20 /
&step slip = 0.4, p = 4.0, increments = 100 /
&step slip = 0.3, p = 2.5, 8.0, increments = 50 /
"""


@pytest.mark.skipif(shutil.which("mtest") is None, reason="mtest is not on PATH")
def test_water(tmp_path: Path) -> None:
    """FluidPressure is the water of the driver in every row, tractions are total; it must be given, >= 0."""
    case, file = tmp_path / "wet.nml", tmp_path / "wet.mtest"
    case.write_text(WATER, encoding="utf-8")
    assert main(["card", "mtest", str(case), "-o", str(file)]) == 0
    subprocess.run(["mtest", file.name], cwd=tmp_path, check=True, timeout=300)
    results = np.loadtxt(tmp_path / "wet.res")[1:]
    history = read_case(case).runs[0].history()
    assert len(results) == len(history) == 220 and np.ptp(history.p[120:]) == pytest.approx(5.5)
    n = 7 + history.state.shape[1]
    expected = np.hstack([history.separation, history.traction, history.state])
    # six digits are printed
    assert results[:, 1:n] == pytest.approx(expected, rel=2e-5, abs=1e-8)
    text = file.read_text(encoding="utf-8")
    negative = text.replace(": 8.0}", ": -8.0}")
    missing = re.sub("@ExternalStateVariable.*\n", "", text)
    for changed, words in ((negative, "FluidPressure = -"), (missing, "FluidPressure")):
        file.write_text(changed, encoding="utf-8")
        done = subprocess.run(
            ["mtest", file.name], cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False
        )
        assert done.returncode != 0 and words in done.stdout + done.stderr

"""MTest (TFEL) with the joints of Cast3M in libasperity_generic; runs where `mtest` is on PATH."""

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

pytestmark = [
    pytest.mark.skipif(shutil.which("mtest") is None, reason="mtest is not on PATH"),
    pytest.mark.filterwarnings("ignore::asperity.ModelWarning"),
]

ITERATIONS = """@MaterialProperty<constant> 'TangentialStiffness' {ks};
@MaterialProperty<constant> 'NormalStiffness' {kn};
@ExternalStateVariable 'Temperature' 293.15;
@AccelerationAlgorithm 'Cast3M';
@MaximumNumberOfIterations 1000;
"""
"""Cast3M iterates with an elastic operator, and passes a temperature."""


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("wet", [False, True])
def test_path_of_the_driver(tmp_path: Path, dimension: int, wet: bool) -> None:
    """Called as Cast3M calls it, the joint ends where the driver ends, in two and three dimensions.

    The water is the first parameter after the temperature.
    """
    case, file = named_case("figure05b"), tmp_path / "castem.mtest"
    if wet:
        dry = case.read_text(encoding="utf-8")
        case = tmp_path / "wet.nml"
        case.write_text(dry.replace("&step slip =", "&step p = 4.0, 6.0, 2.5, slip ="), encoding="utf-8")
    assert main(["card", "mtest", str(case), "-o", str(file)]) == 0
    text = file.read_text(encoding="utf-8").replace("<generic>", "<castem>")
    text = re.sub(r"(Asperity(?:Wet)?)Joint", r"\1Castem", text)
    assert ("AsperityWetCastem" in text) == wet
    k = read_case(case).runs[0].interface.update(np.zeros((1, 3))).tangent[0]
    text = text.replace("@Imposed", ITERATIONS.format(ks=k[1, 1], kn=k[0, 0]) + "@Imposed", 1)
    if dimension == 2:
        text = re.sub(r"@Imposed\w+ 'Ut2'.*\n", "", text).replace("'Ut1'", "'Ut'")
        text = text.replace("Tridimensional", "PlaneStrain")
    file.write_text(text, encoding="utf-8")
    subprocess.run(["mtest", file.name], cwd=tmp_path, check=True, timeout=300)
    last = np.loadtxt(tmp_path / "castem.res")[-1]
    history = read_case(case).runs[0].history()
    assert history.p[-1] == (2.5 if wet else 0.0)
    # columns: time, separation, traction, then the state variables; six digits are printed
    end = history.separation[-1][:dimension], history.traction[-1][:dimension], history.state[-1]
    expected = np.concatenate([[2.0], *end])
    assert last[: len(expected)] == pytest.approx(expected, rel=2e-5, abs=1e-9)

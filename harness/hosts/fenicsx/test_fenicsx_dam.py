"""Dams on FEniCSx: the scripts of docs/how-to/dam.md, and the section that other codes have computed."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from on_ranks import RANKS, SEVERAL_RANKS, WITH_FENICSX, done_by

from harness.studies.validation import dam
from harness.studies.validation.wall_runs import PROGRAM, launch

pytestmark = WITH_FENICSX

PAGE = (PROGRAM.parents[3] / "docs/how-to/dam.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("ranks", RANKS)
def test_the_scripts_of_the_page(ranks: int, tmp_path: Path) -> None:
    """The page has the output of both scripts; the dam slides at (W - U) tan phi within 0.2 %."""
    names = "gravity_dam_mesh.py", "gravity_dam.py"
    for name in names:
        shutil.copy(PROGRAM.with_name(name), tmp_path)
    command, environment = launch("", Path(names[1]), ranks)
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    shown = re.search(r"^```text\n(.*?)^```$", PAGE, re.M | re.S)[1]
    number = r"(?<![\w.])\d+\.\d+"
    assert re.sub(number, "", done.stdout) == re.sub(number, "", shown)
    computed, told = ([float(x) for x in re.findall(number, text)] for text in (done.stdout, shown))
    assert computed == pytest.approx(told, abs=2e-3)
    for line in done.stdout.splitlines():
        slides, hand, *_ = (float(x) for x in re.findall(number, line))
        assert slides == pytest.approx(hand, rel=2e-3)


@pytest.mark.parametrize(
    ("kind", "ranks"),
    [("none", 1), *(pytest.param(kind, 2, marks=SEVERAL_RANKS) for kind in ("linear", "flow"))],
)
def test_profiles_of_other_codes(kind: str, ranks: int, tmp_path: Path) -> None:
    """Separations along the joint are those of Code_Aster's coarser mesh."""
    out = tmp_path / "rows.csv"
    done = done_by(f"profile {dam.PROFILES[kind]} --out {out}", "dam", ranks)
    assert done.returncode == 0, done.stderr
    x, s_N = np.loadtxt(out, delimiter=",", skiprows=1, usecols=(0, 1)).T
    expected = np.array(dam.OTHERS[kind]["Code_Aster"])
    assert np.interp(dam.PLACES, x, s_N) == pytest.approx(expected, abs=dam.BESIDE * np.abs(expected).max())


def test_level_at_which_flow_overturns_the_dam() -> None:
    """The water that runs into the crack overturns the dam at the level of a rigid one."""
    done = done_by("overload flow --parts 20 --least 0.02", "dam", 1)
    assert done.returncode == 0, done.stderr
    word, level, end = done.stdout.split()
    assert (word, end) == ("level", "limit")
    assert float(level) == pytest.approx(dam.overturned("flow"), rel=2e-3)

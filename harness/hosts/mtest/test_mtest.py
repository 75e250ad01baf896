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

HERE = Path(__file__).parent


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


def test_input_file_is_that_of_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    """The file for readers is what `asperity card` prints, but for comments and the folder of the library."""
    main(["card", "mtest", str(named_case("figure05b"))])
    printed = capsys.readouterr().out

    def plain(text: str) -> list[str]:
        return [re.sub(r"'/.*/", "'", line) for line in text.splitlines() if not line.startswith("//")]

    assert plain((HERE / "figure05b.mtest").read_text(encoding="utf-8")) == plain(printed)

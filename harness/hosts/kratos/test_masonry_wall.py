"""Wrong options of masonry_wall.py."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

pytest.importorskip("KratosMultiphysics.GeoMechanicsApplication", reason="kratos is not installed")

sys.path.insert(0, str(Path(__file__).parent))
import masonry_wall

TOLD = [
    ("--to -1", "--to -1.0: expected finite, above 0"),
    ("--to nan", "--to nan: expected finite, above 0"),
    ("--step 0", "--step 0.0: expected between 1e-05 and --most"),
    ("--step nan", "--step nan: expected between 1e-05 and --most"),
    ("--step 0.1 --most 0.05", "--step 0.1: expected between 1e-05 and --most"),
    ("--most inf", "--step 0.02: expected between 1e-05 and --most"),
    ("--elements 0 2", "--elements [0, 2]: expected 2 numbers of at least 1"),
    ("--size -1 6", "--size [-1, 6]: expected 2 numbers of at least 0"),
    ("--implex -0.1", "--implex -0.1: expected at least 0 and below 1"),
    ("--implex 1", "--implex 1.0: expected at least 0 and below 1"),
    (f"--out {__file__}", "expected a new file in a folder that exists"),
    (f"--out {Path(__file__).parent}/none/rows.csv", "expected a new file in a folder that exists"),
    ("--theta 95", "theta = 95"),
    ("--height -1", "height = -1"),
    ("--tau nan", "tau_v = NaN"),
    ("--wall WS40 --tau 0.1", "tau = 0.1: expected 0 for dry joints"),
]


@pytest.mark.parametrize(("words", "expected"), TOLD)
def test_bad_options(
    words: str, expected: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A value out of range is named with what was expected, and nothing is computed."""
    monkeypatch.setattr(sys, "argv", ["masonry_wall.py", *words.split()])
    monkeypatch.setattr(masonry_wall.Run, "follow", lambda run: pytest.fail("a run began"))
    try:
        status = masonry_wall.main()
    except SystemExit as end:
        status = end.code
    told = capsys.readouterr()
    assert status == 2
    assert expected in told.err
    assert "{" not in told.out

"""Every entry of the catalogue of failure modes has the expected results, and its numbers are checked."""

from __future__ import annotations

import csv
import functools
import re
from collections.abc import Sequence
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Pattern

from harness.studies.stability import MODES, Trial, find, shown, table
from harness.studies.stability.__main__ import main
from harness.studies.stability.branches import steep_snap
from harness.studies.stability.catalogue import agree
from harness.studies.stability.explicit import Vumat
from harness.studies.stability.law_modes import clamped_reversal, facing_angle
from harness.studies.stability.modes import TABLE_2, drive

pytestmark = pytest.mark.long

ROOT = Path(__file__).parents[2]
NAMES = [mode.name for mode in MODES]


@functools.cache
def trials_of(name: str) -> Sequence[Trial]:
    """Trials of an entry, run once."""
    return find([name])[0].run()


def measured(name: str, method: str) -> str:
    """Measured text of the only method whose label contains a text."""
    (trial,) = (trial for trial in trials_of(name) if method in trial.method)
    return trial.measured


def numbers(text: str) -> list[float]:
    """Numbers of a text."""
    return [float(number) for number in re.findall(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?", text)]


def table_of_the_page() -> str:
    """Return the table that docs/results/stability.md shows."""
    page = (ROOT / "docs" / "results" / "stability.md").read_text(encoding="utf-8")
    found = re.search(r"<!-- stability -->\n(.*?)\n<!-- /stability -->", page, re.DOTALL)
    assert found
    return found[1]


@pytest.mark.parametrize("name", NAMES)
def test_failure_and_survival(name: str) -> None:
    """Trials fail or succeed as expected, each entry has both kinds, and the page has its section.

    Numbers may differ as between compilers.
    """
    trials = trials_of(name)
    assert [trial for trial in trials if not trial.holds] == []
    assert any(trial.survives for trial in trials)
    assert not all(trial.survives for trial in trials)
    assert shown(trials)
    entry = table([(find([name])[0], trials)])
    section_of_it = rf"^### {name}\n[\s\S]*?(?=\n\n### |\Z)"
    (section,) = re.findall(section_of_it, table_of_the_page(), re.MULTILINE)
    assert agree(section, entry)


def test_a_snap_is_drawn(tmp_path, capsys) -> None:
    """Jump and whole branch are drawn; without friction the area between both is the released energy."""
    assert main(["run", "snap", "--folder", str(tmp_path)]) == 0
    assert f"{tmp_path / 'stability_snap.png'}" in capsys.readouterr().out
    assert (tmp_path / "stability_snap.png").stat().st_size > 20_000
    snap = steep_snap(0.0)
    # the motion of the jump is accurate to 3e-4 K s_0^2
    assert snap.area == pytest.approx(snap.released, abs=3e-4 * TABLE_2.K * TABLE_2.s_0**2)
    assert len(snap.turns) == 2


def test_an_entry_that_does_not_show_is_found() -> None:
    """An entry with an unexpected trial, or with one kind of trial only, is not confirmed."""
    good, bad = Trial("a", True, True, ""), Trial("b", False, False, "")
    assert shown([good, bad])
    assert not shown([good, good])
    assert not shown([good, Trial("b", False, True, "")])
    assert not shown([good, bad, Trial("c", True, False, "")])


# --- numbers that come from elsewhere ----------------------------------------------------------------


def test_snap_is_where_the_fold_is() -> None:
    """RP-16 snaps from s_N = .0926 to .1002 at s_L = .1736, as the independent reference does, for all steps.
    """
    slip, before, after, energy = numbers(measured("snap", "solver"))
    assert slip == pytest.approx(0.1736, abs=2e-4)
    assert before == pytest.approx(0.0926, abs=2e-4)
    assert after == pytest.approx(slip * np.tan(np.radians(30.0)), abs=1e-4)
    assert energy > 0.0


def test_full_damage_after_the_snap() -> None:
    """Beyond the fold s_N = s_L tan(theta), the smallest fully damaged opening, without traction."""
    run = drive("snap")
    row = run.rows_with("snap")[-1]
    for later in (row, -1):
        slip, opening = (run.columns[name][later] for name in ("s_Tx", "s_N"))
        assert opening == pytest.approx(slip * np.tan(np.radians(30.0)), rel=1e-9)
        assert run.columns["t_N"][later] == pytest.approx(0.0, abs=1e-9)


def test_limit_of_the_step_back() -> None:
    """The limit is p/(kc K)/sin(theta) with p = |sigma_N|/(gamma (cos - mu sin)) on the facing plane."""
    gamma, c, s, mu, stiffness = 1.0 / 6.0, np.cos(np.radians(30.0)), 0.5, 0.5, 100.0 * 150.0
    pressure = 1.0 / (gamma * (c - mu * s))
    limit = numbers(measured("unloading", "back in steps of 0.004 mm"))[-1]
    assert limit == pytest.approx(pressure / stiffness / s, abs=5e-5)


def test_second_law_numbers() -> None:
    """The rupture energy falls from .0167 to -.0544 N/mm, and does not fall without the closure."""
    assert numbers(measured("second-law", "as published")) == pytest.approx([0.0167, -0.0544], abs=5e-5)
    assert numbers(measured("second-law", "guard = True")) == pytest.approx([0.0167, 0.0167], abs=5e-5)
    flat = Interface(TABLE_2, Pattern.regular(0, 0.0))
    assert clamped_reversal(flat, [0.0, 0.05], [0.1, 0.1], 0.03).max() < 1e-12
    assert clamped_reversal(flat, [0.2], [0.05], 0.03) == pytest.approx([0.0711], abs=5e-4)


def test_facing_angle() -> None:
    """The angle to the nearest facing plane is correct for patterns and directions."""
    assert facing_angle(4, np.array([0.0, 45.0, 100.0, 350.0])) == pytest.approx([0, 45, 10, 10])


def test_energies_of_one_step() -> None:
    """In one step of 10 s_f the rupture energy is half of Y at the end, at least K s_L^2/4 = 150 N/mm."""
    _, rupture = numbers(
        measured("steps", "in 1 step: energies").replace("work - stored - rupture - friction", "")
    )
    assert rupture > 150.0


def test_energy_bound_of_central_differences() -> None:
    """The energy is 1/(1 - 0.99^2) of the initial one for both springs, to 1 %."""
    for method in ("bond, dt = 0.99 ", "of the VUMAT's probe"):
        assert numbers(measured("explicit", method))[0] == pytest.approx(1.0 / (1.0 - 0.99**2), rel=0.01)


@pytest.mark.parametrize("single", [False, True])
def test_vumat_is_the_law(single: bool) -> None:
    """The point in the VUMAT has the traction of `replay`."""
    rough = Interface(TABLE_2, Pattern.regular(4, 30.0))
    steps = np.random.default_rng(5).normal(scale=0.01, size=(50, 3))
    point = Vumat(rough, single)
    expected = rough.replay(np.cumsum(steps, axis=0))
    for ds, traction in zip(steps, expected.traction, strict=True):
        tolerance = 1e-4 if single else 1e-12
        assert point.step(ds) == pytest.approx(traction, abs=tolerance * TABLE_2.sigma0)
    assert point.value("damage") == pytest.approx(expected.damage[-1], rel=1e-5)


# --- maps --------------------------------------------------------------------------------------------


def test_map(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Pictures and CSV are written; the consistent tangent converges wherever the symmetrised one does."""
    assert main(["map", "--folder", str(tmp_path), "--size", "2", "--pdf"]) == 0
    written = [Path(line) for line in capsys.readouterr().out.split()]
    assert [path.suffix for path in written] == [".csv", ".png", ".pdf"]
    assert [path.read_bytes()[:4] for path in written[1:]] == [b"\x89PNG", b"%PDF"]
    with written[0].open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    places = {(float(row["mu"]), float(row["theta"])) for row in rows}
    assert places == set(product((0.0, 1.6), (0.0, 60.0)))
    assert all(row["consistent"] != "nan" for row in rows if row["symmetrised"] != "nan")
    assert float(rows[0]["determinant"]) < 0.0  # the bond softens
    assert main(["map", "--folder", str(tmp_path), "--size", "1"]) == 1


# --- command -----------------------------------------------------------------------------------------


def test_list(capsys: pytest.CaptureFixture[str]) -> None:
    """The list has every entry with its advice."""
    assert main(["list"]) == 0
    out = capsys.readouterr().out
    assert re.findall(r"^(\S+): ", out, re.MULTILINE) == NAMES
    assert out.count("\n  -> ") == len(NAMES)


def test_run(capsys: pytest.CaptureFixture[str]) -> None:
    """One entry is shown with its measured numbers; the error for an unknown name has the known ones."""
    assert main(["run", "single-precision"]) == 0
    out = capsys.readouterr().out
    assert "fails    single precision, slip of 100 mm" in out
    assert main(["run", "unheard-of"]) == 1
    assert "unheard-of: expected all or names of snap, " in capsys.readouterr().err
    assert main(["run", "single-precision", "--check"]) == 1


def test_entries_of_the_page() -> None:
    """The page has the entries of the catalogue, in its order."""
    assert re.findall(r"^### (\S+)$", table_of_the_page(), re.MULTILINE) == NAMES


def test_tables_that_differ() -> None:
    """Tables differ by words and numbers, not by rounding errors."""
    assert agree("| a | 3e-14 | 2.1 |", "| a | 8e-13 | 2.0 |")
    assert not agree("| a | 3e-14 |", "| b | 3e-14 |")
    assert not agree("| a | 3e-4 |", "| a | 3e-3 |")
    assert not agree("| a | 0 |", "| a | 1 |")
    assert not agree("| a | -1 |", "| a | 1 |")


def test_fill(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Markers are filled; a filled page is up to date; a stale page is reported."""
    page = tmp_path / "page.md"
    page.write_text("<!-- stability -->\nold\n<!-- /stability -->\n", encoding="utf-8")
    command = ["run", "single-precision", "--fill", str(page)]
    assert main([*command, "--check"]) == 1
    assert main(command) == 0
    assert "- *Fails:* single precision, slip of 100 mm" in page.read_text(encoding="utf-8")
    assert main([*command, "--check"]) == 0
    assert "the table is not up to date" in capsys.readouterr().out

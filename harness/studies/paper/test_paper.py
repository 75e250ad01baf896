"""Tests of the gallery of the paper: Table 5, converged energies, and reproduction of the committed files."""

from __future__ import annotations

import re
from concurrent.futures import Executor, ThreadPoolExecutor
from pathlib import Path

import matplotlib.image
import numpy as np
import pandas
import pytest
from asperity import Interface, ModelWarning, Pattern
from asperity.tools.slip_curves import slip_curves
from refresh import words_and_numbers

from harness.studies import gallery
from harness.studies.paper import command
from harness.studies.paper.fracture_energy import (
    DIRECTIONS,
    MATERIAL,
    TABLE_5,
    distinct,
    fracture_energy,
    pattern,
    sampled,
)

GALLERY = Path(__file__).parents[3] / "docs" / "gallery"

LAW_MD = {
    "RT": (0.352453, 0.300000),
    "RP-3": (0.344260, 0.327335),
    "RP-4": (0.338649, 0.335964),
    "RP-6": (0.337899, 0.336878),
    "RP-32": (0.33742, 0.33742),
}
"""Converged energies of an independent implementation, with all digits that it printed."""

CONVERGED = 2.0e-6
"""Tolerance: steps here are halved until the error is 3e-7, and the references are rounded to 5e-7."""

FIVE_DIGITS = 5.0e-6
"""Additional tolerance for the rounding of the references of RP-32."""

RELATIVE = 2.0e-5
"""Tolerance relative to the largest value of a column.

It covers twice the rounding of a number written with six digits (5e-6) and differences between compilers.
"""


@pytest.mark.parametrize("name", TABLE_5)
def test_converged_energies(name: str) -> None:
    """The largest and smallest energy over 64 directions are those of an independent implementation.

    The estimated error is below 1e-6 Gc.
    """
    energy = fracture_energy(MATERIAL, pattern(name))
    tolerance = CONVERGED + (FIVE_DIGITS if name == "RP-32" else 0.0)
    assert [energy.values.max(), energy.values.min()] == pytest.approx(LAW_MD[name], rel=0.0, abs=tolerance)
    assert 0.0 < energy.error.max() < 1e-6 * MATERIAL.Gc


@pytest.mark.parametrize("name", TABLE_5)
def test_table_5(name: str) -> None:
    """The three printed numbers of a pattern are reproduced to the last digit."""
    assert sampled(name) == TABLE_5[name][1:]


@pytest.mark.parametrize("sides", [2, 3, 4, 6, 32])
def test_symmetric_directions_are_the_same(sides: int) -> None:
    """The curves that symmetry replaces equal the curves that are computed."""
    planes = Pattern.regular(sides, 30.0, turn=10.0)
    angles, place = distinct(planes, DIRECTIONS)
    assert sides == 3 or len(angles) < 40  # symmetry of RP-3 does not map these directions onto each other
    slips = np.linspace(0.0, 0.15, 31)[1:]
    interface = Interface(MATERIAL, planes)
    every = slip_curves(interface, DIRECTIONS, slips, -1.0).tau_L
    folded = slip_curves(interface, angles, slips, -1.0).tau_L[place]
    np.testing.assert_allclose(folded, every, rtol=0.0, atol=1e-10)


def test_energy_of_a_path_that_is_too_short(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is an error if a traction remains at the end, or if the number of steps becomes too large."""
    monkeypatch.setattr("harness.studies.paper.fracture_energy.SPAN", 0.5)
    with pytest.raises(ValueError, match="expected a fully damaged, open interface"):
        fracture_energy(MATERIAL, pattern("RP-4"))
    monkeypatch.undo()
    with pytest.raises(ValueError, match=r"G_T changes by .* expected less than 1e-17"):
        monkeypatch.setattr("harness.studies.paper.fracture_energy.FINEST", 840)
        fracture_energy(MATERIAL, pattern("RP-4"), np.array([3.0]), 1e-17)


@pytest.mark.parametrize("executor", [None, ThreadPoolExecutor(1)], ids=["threads", "one"])
def test_slip_curves_are_the_single_tests(executor: Executor | None) -> None:
    """Many tests in one call equal single calls of `confined_slip`.

    The rows after a loss of equilibrium are NaN.
    """
    interface = Interface(MATERIAL, Pattern.regular(4, 30.0))
    slips = np.concatenate([np.linspace(0.0, 0.1, 21)[1:], np.linspace(0.1, -0.1, 41)[1:]])
    angles = np.arange(0.0, 90.0, 7.0)
    curves = slip_curves(interface, angles, slips, -1.0, executor=executor)
    for i, angle in enumerate(angles):
        with pytest.warns(ModelWarning, match="contact is soft"):
            single = interface.confined_slip(angle, slips, -1.0)
        e = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
        np.testing.assert_array_equal(curves.s_N[i], single.separation[:, 0])
        np.testing.assert_array_equal(curves.damage[i], single.damage)
        np.testing.assert_array_equal(curves.work[i], single.work)
        np.testing.assert_allclose(curves.tau_L[i], single.traction[:, 1:] @ e, rtol=0.0, atol=1e-14)
        across = single.traction[:, 1:] @ np.array([-e[1], e[0]])
        np.testing.assert_allclose(curves.tau_across[i], across, rtol=0.0, atol=1e-14)
    flat = Interface(MATERIAL, Pattern.regular(0, 0.0))
    lost = slip_curves(flat, 0.0, slips, [2.0, 0.0], executor=executor)
    assert lost.rows.tolist() == [6, 60]  # equilibrium ends at .031, row 6 is .030
    assert np.isfinite(lost.tau_L[0, :6]).all() and np.isnan(lost.tau_L[0, 6:]).all()


# --- the committed gallery --------------------------------------------------------------------------


def sections(page: Path) -> dict[str, str]:
    """Return what stands between the markers of a page, by figure."""
    tables = re.findall(r"<!-- (\w+) -->\n(.*?)<!-- /", page.read_text(encoding="utf-8"), re.DOTALL)
    return {name: text for name, text in tables if text.strip()}


FEW = ["2", "4a", "5b", "10", "13b"]
"""Figures that are drawn again in every check: modes, friction, a cycle, directions and energies."""


@pytest.fixture(scope="module", params=[FEW, pytest.param([], marks=pytest.mark.long)], ids=["few", "all"])
def again(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Draw the gallery, or some of its figures, again; return the folder of the output."""
    folder = tmp_path_factory.mktemp("gallery")
    page = folder / "README.md"
    text = (GALLERY / page.name).read_text(encoding="utf-8")
    page.write_text(re.sub(r"(<!-- \w+ -->).*?(<!-- /)", r"\1\n\2", text, flags=re.DOTALL), encoding="utf-8")
    gallery.refresh(page, command.select(request.param) if request.param else command.ENTRIES)
    return folder


@pytest.mark.slow
def test_gallery_is_the_committed_one(again: Path) -> None:
    """Every entry has its picture, its numbers and its text, and there are no other files.

    Cells agree relative to the largest value of their column; rounding errors and errors stay small.
    """
    names = {f"{entry.stem}.{kind}" for entry in command.ENTRIES for kind in ("png", "csv")} | {"README.md"}
    names.remove("table5.png")
    assert {path.name for path in GALLERY.iterdir()} == names
    drawn = {path.name for path in again.iterdir()}
    assert drawn <= names and len(drawn) in (2 * len(FEW) + 1, len(names))
    assert sum(path.stat().st_size for path in GALLERY.iterdir()) < 3_000_000
    for picture in again.glob("*.png"):
        image = matplotlib.image.imread(picture)
        assert image.shape == matplotlib.image.imread(GALLERY / picture.name).shape
        assert image[..., :3].min() < 0.3 and image[..., :3].max() == 1.0
    for path in sorted(again.glob("*.csv")):
        ours, committed = pandas.read_csv(path), pandas.read_csv(GALLERY / path.name)
        assert [*ours] == [*committed] and len(ours) == len(committed) > 0, path.name
        for name, column in committed.items():
            if not pandas.api.types.is_numeric_dtype(column):
                assert [*ours[name]] == [*column], f"{path.name}, {name}"
                continue
            tolerance = RELATIVE * (1.0 if name == "error" else column.abs().max())
            np.testing.assert_allclose(ours[name], column, rtol=0.0, atol=tolerance, err_msg=path.name + name)
    filled, committed = (sections(folder / "README.md") for folder in (again, GALLERY))
    assert len(filled) in (len(FEW), len(command.ENTRIES)) and len(committed) == len(command.ENTRIES)
    for name, text in filled.items():
        (words, values), (committed_words, expected) = map(words_and_numbers, (text, committed[name]))
        assert words == committed_words and values == pytest.approx(expected, rel=1e-3, abs=1e-6)

"""Tests of the pictures of `python -m harness.studies.concepts`, and of the statements they illustrate."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Pattern

from harness.studies import concepts

DOCS = Path(__file__).parents[2] / "docs"


@pytest.mark.long
def test_pictures_are_drawn_and_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The command draws every picture; each is committed and shown on a page."""
    assert concepts.main(["--folder", str(tmp_path)]) == 0
    drawn = [Path(line) for line in capsys.readouterr().out.splitlines()]
    assert [path.stem for path in drawn] == list(concepts.PICTURES)
    names = ("concepts.md", "solver.md", "extensions.md")
    pages = "".join((DOCS / name).read_text(encoding="utf-8") for name in names)
    for path in drawn:
        assert path.stat().st_size > 10000
        assert (DOCS / "images" / path.name).is_file()
        assert f"(images/{path.name})" in pages


def test_bond_and_contact_add_up() -> None:
    """The two contributions add up to the traction of the library, before and after a reversal."""
    flat = Interface(concepts.MATERIAL, Pattern.regular(0, 0.0))
    slips = concepts.ramp(0.0, 0.26, 0.12)
    history = flat.confined_slip(0.0, slips, concepts.PRESSURE)
    bond, contact = concepts.parts(history, flat)
    assert bond + contact == pytest.approx(history.traction[:, 1], abs=1e-12)
    assert min(bond) >= 0.0 and min(contact) == pytest.approx(concepts.MATERIAL.mu * concepts.PRESSURE)


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
@pytest.mark.parametrize(("name", "values"), [(name, values) for name, _, values in concepts.CONSTANTS])
def test_constants_that_are_compared_matter(name: str, values: tuple[float, ...]) -> None:
    """The curves of a panel differ, and the value in the middle of sigma0 is that of the base material."""
    curves = [concepts.slip_test(name, value).traction[:, 1] for value in values]
    for one, other in pairwise(curves):
        assert np.abs(one - other).max() > 0.05
    if name == "sigma0":
        assert values[1] == concepts.MATERIAL.sigma0

"""Joints that crush on FEniCSx: walls on a toe that yields, by Newton's method and passes, and their fall."""

from __future__ import annotations

import itertools

import pytest
from on_ranks import WITH_FENICSX, of_all_ranks

from harness.studies.validation.wall_runs import printed_by

pytestmark = WITH_FENICSX


@pytest.mark.parametrize(("Css", "within"), [(0.0, 2e-3), (9.0, 8e-3)])
def test_a_toe_that_yields(Css: float, within: float) -> None:
    """The largest force is N (L - N/(fc t))/(2 H) at three of N; with Css by the mean shear of the toe."""
    rows = printed_by(f"--Css {Css}", "toe")
    assert [name for name, _ in rows] == ["0.1", "0.2", "0.3"]
    for _, (found, expected) in rows:
        assert found == pytest.approx(expected, rel=within)


def test_a_toe_that_softens() -> None:
    """With a Gfc of 30 N/mm the largest force is up to 3 % lower, also in a wall of 4 m, and then it falls.

    Passes find it, too.  The energies of the fall balance better than those of the few steps before it.
    """
    results = of_all_ranks(
        """
from harness.hosts.fenicsx.toe import Toe, expected
for height in (2500.0, 4000.0):
    toe = Toe(0.2, 30.0, height=height)
    results[str(height)] = toe.limit().at / expected(0.2, height=height)
toe = Toe(0.2, 30.0)
follow = toe.limit()
results["passes"] = toe.limit(always=True).at / follow.at
branch, rows = toe.beyond(follow, 0.97)
results["fall"] = rows.tolist()
results["kappa"] = [float(state.joints[0][:, -2].max()) for state in (follow.state, branch.state)]
results["unbalanced"] = follow.unbalanced, branch.unbalanced
results["crushing"] = branch.ledger.spent > follow.ledger.spent > 0.0
""",
        1,
    )
    assert 0.97 < results["2500.0"] < 1.0 and 0.97 < results["4000.0"] < 1.0
    assert results["passes"] == pytest.approx(1.0, rel=2e-3)
    rotations, forces = zip(*results["fall"], strict=True)
    assert all(after > before for before, after in itertools.pairwise(rotations))
    assert all(after < before for before, after in itertools.pairwise(forces))
    before, after = results["kappa"]
    assert after > 2.0 * before > 0.0 and results["crushing"]
    coarse, fine = results["unbalanced"]
    assert abs(fine) < abs(coarse) < 0.03

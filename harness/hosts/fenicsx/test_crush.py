"""Joints that crush on FEniCSx: walls on a toe, by Newton's method, passes and IMPL-EX, and their fall."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from on_ranks import RANKS, WITH_FENICSX, done_by, of_all_ranks
from scipy.optimize import brentq

from harness.studies.validation.toe import CSS, MU, most, plain, sheared
from harness.studies.validation.wall_runs import printed_by

pytestmark = WITH_FENICSX


def test_a_toe_that_yields() -> None:
    """The largest force at three of N is N (L - N/(fc t))/(2 H), with Css that of an even shear in the toe.

    No distribution of the shear carries more than the linear programme; its cells and sides err by 1e-3.
    """
    rows = printed_by("yields", "toe", run=done_by)
    assert len(rows) == 6
    for name, [found] in rows:
        length, height, share, Css, _ = map(float, name.split()[1:])
        slenderness = height / length
        if Css:
            assert found == pytest.approx(sheared(share, slenderness, Css), rel=8e-3)
            assert found <= (1.0 + 1e-3) * most(share, slenderness, Css, MU)
        else:
            assert found == pytest.approx(plain(share, slenderness), rel=2e-3)


def test_bounds_of_a_toe() -> None:
    """Without Css all formulas are one; with it an even shear carries less than the best distribution."""
    for share, slenderness in itertools.product((0.05, 0.3, 0.6), (1.0, 3.0)):
        closed = plain(share, slenderness)
        assert sheared(share, slenderness, 0.0) == pytest.approx(closed, rel=1e-9)
        # the programme has 400 cells
        assert most(share, slenderness, 0.0, 10.0) == pytest.approx(closed, rel=2e-3)
        assert sheared(share, slenderness, CSS) < most(share, slenderness, CSS, 10.0) < closed


def test_a_toe_that_softens() -> None:
    """With a Gfc of 30 N/mm the largest force is up to 3 % lower, also in a wall of 4 m, and then it falls.

    Passes find it, too.  The energies of the fall balance better than those of the few steps before it.
    """
    results = of_all_ranks(
        """
from harness.hosts.fenicsx.toe import Toe
for height in (2500.0, 4000.0):
    toe = Toe(0.2, 30.0, height=height)
    results[str(height)] = toe.limit().at
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
    for height in (2500.0, 4000.0):
        assert 0.97 < results[str(height)] / plain(0.2, height / 1000.0) < 1.0
    assert results["passes"] == pytest.approx(1.0, rel=2e-3)
    rotations, forces = zip(*results["fall"], strict=True)
    assert all(after > before for before, after in itertools.pairwise(rotations))
    assert all(after < before for before, after in itertools.pairwise(forces))
    before, after = results["kappa"]
    assert after > 2.0 * before > 0.0 and results["crushing"]
    coarse, fine = results["unbalanced"]
    assert abs(fine) < abs(coarse) < 0.03


def test_implex_goes_on_past_the_peak() -> None:
    """One pass a step carries what Newton's method does, within the moment of the error of forces.

    Tractions that are wrong by e_t of the forces, which are less than 2 N here, turn the wall by e_t 2 N L/2
    at most.  Smaller errors need more steps.
    """
    results = of_all_ranks(
        f"""
from harness.hosts.fenicsx.toe import Toe
toe = Toe(0.2, 30.0, {CSS})
for method in ("Newton", "IMPL-EX 0.02", "IMPL-EX 0.005"):
    rows, follow, _ = toe.along(method, 15.0)
    results[method] = rows[:, 1].max(), rows[-1, 1], rows[:, 2].max(), follow.count
    assert follow.report.size < 2.0 * toe.N and (follow.report.passes == 1 or method == "Newton")
""",
        1,
    )
    peak, end, _, _ = results.pop("Newton")
    assert end < 0.97 * peak
    for largest, last, e_t, _ in results.values():
        assert largest == pytest.approx(peak, abs=0.4 * e_t) and last == pytest.approx(end, abs=0.4 * e_t)
    (_, _, coarse, few), (_, _, fine, many) = results.values()
    assert fine <= 0.005 < coarse <= 0.02 and few < many


@pytest.mark.parametrize("ranks", RANKS)
def test_error_of_a_pass_counts_crushing(ranks: int) -> None:
    """A pass that aims at a whole joint has its strength fc; the law softens: the difference is e_t.

    Stiff blocks are pressed together by 12/200 mm: f(kappa) = 200 (0.06 - kappa).  Forces are those of both
    ends.  A pass that aims at the crushed joint has no error.
    """
    results = of_all_ranks(
        """
crushing = Interface(Material.from_joint(kn=200.0, ks=80.0, mu=0.5, fc=6.0, Gfc=1.0), Pattern.regular(0, 0.0))
m = model(2e9, 0.0, laws={"joint": crushing})
fixed = np.r_[bottom(m), m.dofs(m.group("top")[0], 1)]
down = Conditions(fixed, -0.06 * np.isin(fixed, m.dofs(m.group("top")[0], 1)))
start = State.virgin(m)
at = np.tile([-0.06, 0.0, 0.0], (len(m.pairs), 1))
for name, aim in (("whole", None), ("crushed", at)):
    report = solve(m, start, down, Terms(passes=1, aim=aim, finish=False))
    results[name] = report.errors[1], total(m.area @ -report.state.t[:, 0]) / 3.0
""",
        ranks,
    )
    r, fc, Gfc = 0.1, 6.0, 1.0

    def strength(kappa: float) -> float:
        return fc * (r + (1.0 - r) * np.exp(-(1.0 - r) * fc * kappa / Gfc))

    kappa = brentq(lambda kappa: 200.0 * (0.06 - kappa) - strength(kappa), 0.0, 0.06)
    # blocks and joint in series differ by 2e-7
    assert results["whole"] == pytest.approx([0.5 * (1.0 - strength(kappa) / fc), fc], rel=1e-4)
    assert results["crushed"] == pytest.approx([0.0, strength(kappa)], rel=1e-4, abs=1e-6)

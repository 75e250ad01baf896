"""Tests of the comparisons with measurements: pages, closed forms, fits that are minima."""

from __future__ import annotations

import re
from itertools import product
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
import test_crush

from harness.studies.validation import (
    closure,
    common,
    dam,
    delamination,
    dynamics,
    granite,
    oriented,
    push_off,
    ribbed,
    sandstone,
    scan,
    toe,
    wall_costs,
    wall_runs,
    wall_scale,
    walls,
)
from harness.studies.validation.shaken_points import ALPHA, RADIUS, G, rock

MEASURED = [push_off.STUDY, sandstone.STUDY, granite.STUDY, closure.STUDY, scan.STUDY, walls.STUDY]
STUDIES = [*MEASURED, oriented.STUDY, dynamics.STUDY, ribbed.STUDY, delamination.STUDY, dam.STUDY, toe.STUDY]


@pytest.mark.parametrize("study", STUDIES, ids=lambda study: study.name)
def test_page_is_up_to_date(study: common.Study) -> None:
    """The tables of the page are those of the constants that were found, and its picture is there."""
    assert study.main(["--check"]) == 0
    assert f"(../images/{study.picture.name})" in study.page.read_text(encoding="utf-8")
    assert matplotlib.image.imread(study.picture).shape[1] > 300


def test_rocking_on_two_edges() -> None:
    """Housner's period and ratio of angular velocities, if only the edges touch, and do not bounce."""
    share, p = 0.5, np.sqrt(0.75 * G / RADIUS)
    period, ratio = rock(2, 1.0, share)
    assert period == pytest.approx(4.0 * np.arccosh(1.0 / (1.0 - share)) / p, rel=2e-3)
    assert ratio == pytest.approx(1.0 - 1.5 * np.sin(ALPHA) ** 2, abs=1e-3)


def test_rocking_on_a_full_base() -> None:
    """A base of many points loses less: between the plastic limit, .9640, and 1."""
    assert rock(21, 1.0, 0.3)[1] == pytest.approx(0.974, abs=0.003)


def test_levels_of_the_dam() -> None:
    """The dam fails at the levels of a rigid one, and with E x 1000 opens and closes as that does."""
    levels = common.rows("dam_levels").set_index(["water", "joint"]).level
    for kind, exact in {"none": 11.462, "linear": 10.017, "flow": 9.312}.items():
        assert dam.overturned(kind) == pytest.approx(exact, abs=5e-4)
        assert levels[kind, "held"] == pytest.approx(exact, rel=1e-3)
    # the uplift U = p b/2 gives a quadratic equation of the level
    slid = np.roots([0.5 * 9.81, 0.75 * 9.81 * 2.5, -0.75 * 765.18]).max()
    assert dam.slid("linear") == pytest.approx(slid, rel=1e-9)
    assert levels["linear", "plain"] == pytest.approx(slid, rel=1e-3)
    assert dam.opened("linear") == pytest.approx((2.577e-7, -3.696e-7), rel=1e-3)
    assert dam.opened("flow") == pytest.approx((1.1338e-6, -5.072e-7), rel=1e-3)


def test_toes_that_crush() -> None:
    """Walls of all sizes carry what a rigid one does, between an even shear of the toe and the bound.

    IMPL-EX ends where Newton's method does, within the moment of its error of forces: at most 2 N L/2.
    """
    constants = toe.STUDY.constants()
    found = toe.limits(constants)
    assert len(found) == 48
    for length, height, share in toe.walls_of(found):
        slenderness, both = height / length, found[length, height, share, toe.CSS, toe.YIELDING]
        assert found[length, height, share, 0.0, toe.YIELDING] == pytest.approx(
            toe.plain(share, slenderness), rel=2e-3
        )
        assert both == pytest.approx(toe.sheared(share, slenderness, toe.CSS), rel=8e-3)
        assert both <= (1.0 + 1e-3) * toe.most(share, slenderness, toe.CSS, toe.MU)
    for name, values in constants.items():
        if name.startswith("IMPL-EX"):
            for kind in ("force", "end"):
                assert values[kind] == pytest.approx(constants["Newton"][kind], abs=0.4 * values["e_t"])
    page = toe.STUDY.page.read_text(encoding="utf-8")
    factors = [toe.plain(share, 2.5) / toe.sheared(share, 2.5, toe.CSS) - 1.0 for share in (0.1, 0.2, 0.3)]
    assert "{:.1f}, {:.1f} and {:.1f} %".format(*(100.0 * factor for factor in factors)) in page
    ends = [toe.plain(share, H) / toe.sheared(share, H, toe.CSS) for share, H in ((0.24, 2.5), (0.3, 4.0))]
    assert ends[0] == pytest.approx(1.03, abs=1e-3) and ends[1] < 1.03


def test_runs_of_the_walls_are_stored() -> None:
    """All runs are stored, and the pictures that a run draws are there."""
    runs = set(wall_runs.RUNS)
    assert set(wall_runs.summaries().index) == runs
    assert set(wall_runs.curves()) == runs
    assert set(wall_scale.stored().index) == set(wall_scale.RUNS)
    text = walls.STUDY.page.read_text(encoding="utf-8")
    for picture in (walls.CRACKS, walls.OWN, wall_costs.COSTS, wall_costs.PLANES):
        assert f"(../images/{picture.name})" in text and matplotlib.image.imread(picture).shape[1] > 300


def test_walls_within_ten_percent() -> None:
    """Most walls have the measured strength within a tenth, as the overview says."""
    curves = wall_runs.curves()
    away = walls.errors(curves)
    assert sum(abs(value) <= 0.1 for value in away.values()) == len(away) - 2
    assert "9 of 11 walls within 10 %" in (walls.STUDY.page.parent / "README.md").read_text(encoding="utf-8")


def test_walls_pass_to_their_ends() -> None:
    """Each tested wall moves as far as it was asked to; what passes leave is small but in snaps of bricks."""
    summaries = wall_runs.summaries()
    dry = summaries.loc[list(walls.FORCES)]
    assert (dry.end == [12.0 if name.startswith("SW") else 20.0 for name in dry.index]).all()
    assert (dry.e_t <= 0.01).all()
    mortar = summaries.loc[[f"{name}{planes}" for name in walls.MORTAR for planes in ("", " 10 0.1")]]
    assert (mortar.end == 4.0).all() and (mortar.e_t <= 0.05).all()


def test_overview_has_the_numbers_of_the_pages() -> None:
    """The errors in the overview are those of the bold cells of the pages."""
    text = (common.DOCS / "validation" / "README.md").read_text(encoding="utf-8").replace("−", "-")
    constants, errors = push_off.STUDY.constants(), []
    for fit, name in product(("friction", "crush"), (push_off.WEAK, push_off.STRONG)):
        fit += " 6.8" if name == push_off.WEAK else " 3.6"
        errors.append([common.rms(part) for part in push_off.differences(constants[fit], name)])
    low, high = np.min(errors, axis=0), np.max(errors, axis=0)
    assert f"opening {low[0]:.3f} to {high[0]:.3f} mm" in text
    assert f"shear stress {low[1]:.2f} to {high[1]:.2f} MPa" in text
    joints = sandstone.STUDY.constants()
    away = np.array(
        [100.0 * sandstone.errors(joints[f"crush 1+5 {name}"], name)[[1, 2, 3]] for name in sandstone.JOINTS]
    )
    for i, what in enumerate(("peak", "slip at the peak", "stress at 10 mm")):
        assert f"{what} {away[..., i].min():.0f} to {away[..., i].max():.0f} %" in text
    away = closure.differences(closure.contact(closure.STUDY.constants()[closure.FITTED]))
    for part, value in away.items():
        assert f"{part} {100.0 * common.rms(value) / closure.SIZE[1]:.0f} %" in text
    stages = granite.STUDY.constants()
    last = [granite.differences(stages[f"{name}: 1 to 7"], name)[:, 7:] for name in granite.SPECIMENS]
    rms = 100.0 * np.sqrt(np.mean(np.square(last), axis=2))
    for i, what in enumerate(("shear stress", "opening", "slip")):
        assert f"{what} {rms[0, i]:.1f} and {rms[1, i]:.1f} %" in text


def test_fit_is_a_minimum() -> None:
    """A search from the constants that were found moves none of the free ones by a thousandth."""
    constants = push_off.STUDY.constants()["friction 6.8"]
    start = {name: constants[name] for name in push_off.START}
    size = (push_off.RANGE[1], push_off.SLIPS[-1])
    again = common.fitted(lambda x: push_off.residuals(x, (push_off.STRONG,)), [start], size, push_off.RIGID)
    assert again == pytest.approx(constants, rel=1e-3)


@pytest.mark.parametrize("name", granite.SPECIMENS)
def test_closed_form_of_the_slip(name: str) -> None:
    """The rigid joint of the closed form slips from strength to strength and rises by the opening."""
    measured, closed = granite.measured(name), granite.closed_form(name)
    slope = np.tan(np.radians(closed["theta"]))
    slip = measured["ds"][granite.ARREST] - measured["ds"][granite.ONSET]
    for row, climbed in ((granite.ONSET, 0.0), (granite.ARREST, slip)):
        phi = slope * np.exp(-climbed * slope / closed["height"])
        strength = (closed["mu"] + phi) / (1.0 - closed["mu"] * phi)
        assert strength == pytest.approx(measured["tau"][row] / measured["sn"][row], rel=1e-3)
    rise = closed["height"] * (1.0 - np.exp(-slip * slope / closed["height"]))
    assert rise == pytest.approx(measured["dn"][granite.ARREST] - measured["dn"][granite.ONSET], rel=2e-3)


COMPUTED = (
    "arches",
    "dam_",
    "fit_times",
    "fits",
    "ribbed_",
    "toe_",
    "walls_runs",
    "walls_scale",
    "walls_summaries",
)
"""Starts of the names of files that hold results of the project."""


def test_data_have_source_and_licence() -> None:
    """Every file of measurements says where its numbers come from and under which licence."""
    files = [path for path in common.DATA.glob("*.csv") if not path.stem.endswith("_constants")]
    files = [path for path in files if not path.stem.startswith(COMPUTED)]
    assert {path.stem for path in files} >= {"walls", "walls_mortar"} and len(files) == len(MEASURED) + 1
    for path in files:
        assert re.match(r"# Source: .*\n# Licence: .*\n", path.read_text(encoding="utf-8"))


def test_measure_of_grasselli() -> None:
    """A distribution (1 - angle/largest)^C of the facing length gives back its C."""
    largest, power = 40.0, 2.5
    shares = np.full(400000, 1.0 / 400000)  # at the largest of LIMITS 23 of them are left
    angles = largest * (1.0 - (np.arange(400000) / 400000) ** (1.0 / power))
    roughness = scan.grasselli(angles, shares)
    assert roughness[0] == pytest.approx(largest) and roughness[1] == pytest.approx(power, rel=0.01)


def test_stale_page_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A page with another number fails the check, and the program fills it."""
    text = push_off.STUDY.page.read_text(encoding="utf-8")
    (tmp_path / "validation").mkdir()
    (tmp_path / "images").mkdir()
    page = tmp_path / "validation" / "push-off.md"
    page.write_text(text.replace("0.011", "0.012"), encoding="utf-8")
    monkeypatch.setattr(common, "DOCS", tmp_path)
    assert push_off.STUDY.main(["--check"]) == 1
    assert push_off.STUDY.main([]) == 0
    assert page.read_text(encoding="utf-8") == text


def test_ridges_in_any_direction() -> None:
    """Held and free slips over ridges of drawn frictions and slopes are those of the closed forms."""
    rng = np.random.default_rng(58)
    for mu, theta, a in rng.uniform([0.1, 5.0, 1.0], [0.8, 40.0, 89.0], (20, 3)):
        for side_free, closed in ((False, oriented.confined), (True, oriented.free)):
            assert oriented.law(a, side_free, mu, theta) == pytest.approx(closed(a, mu, theta), abs=1e-6)
    mu, theta = oriented.ridges_of(oriented.STRENGTHS)
    for a, wanted in oriented.STRENGTHS.items():
        assert oriented.law(a, False, mu, theta)[0] == pytest.approx(wanted, abs=1e-6)


def test_anchored_bar() -> None:
    """The bar of solids has the closed forms, and a cover that splits takes the strength away."""
    constants = ribbed.STUDY.constants()
    slip, beta = 1e-3, np.sqrt(4.0 * 100.0 / (19.05 * 2e5))
    force = 0.25 * np.pi * 19.05**2 * 2e5 * beta * slip * np.tanh(beta * 95.25)
    for name in ("bar linear", "bar linear, fine"):
        assert constants[name]["value"] == pytest.approx(force, rel=5e-3) and constants[name]["away"] < 5e-3
    assert constants["bar friction"]["value"] == pytest.approx(np.pi * 19.05 * 95.25 * 0.4 * 2.0, rel=1e-3)
    # the error of the stiffness of the cover falls with the mesh
    stiff = 3e4 / (9.525 * ((38.1**2 + 9.525**2) / (38.1**2 - 9.525**2) + 0.2))
    away = [constants[name]["value"] / stiff - 1.0 for name in ("bar ring", "bar ring, fine")]
    assert 0.0 < away[1] < 0.4 * away[0] < 0.01
    strong = {case: ribbed.anchored(case) for case in ribbed.CASES}
    point = ribbed.curve(constants["bond and crush"], 10.3)[1].max()
    first, _, splits, finer = (path.force.max() for path in strong.values())
    assert first == pytest.approx(np.pi * 19.05 * 95.25 * point, rel=0.03)
    assert splits == pytest.approx(finer, rel=0.01) and splits < 0.6 * first
    brittle, plastic = ribbed.tepfers()
    assert brittle < strong["cover, splits"].pressure.max() < plastic


def test_delamination_balances() -> None:
    """J of the moments is what the joint spends, within 5 %; without friction it is Gc in every mix."""
    constants = delamination.STUDY.constants()
    rough, smooth = (delamination.rows_of(constants, mu) for mu in ("0.8", "0"))
    for rows in (rough, smooth):
        assert rows[:, 2] == pytest.approx(rows[:, 3], rel=0.05)
    assert smooth[:, 2] == pytest.approx(delamination.GC, rel=0.06)
    assert rough[-1, 2] > 1.5 * delamination.GC


@pytest.mark.parametrize("pressure", [0.1, 1.0, 10.0])
def test_strength_of_crushed_planes(pressure: float) -> None:
    """The strength of sandstone.py is that of a joint that climbs one of two planes, in closed form."""
    known = 2.0 * test_crush.closed_form(pressure)
    slope = np.tan(np.radians(test_crush.THETA))
    computed = sandstone.strength(2.0 * pressure, slope, test_crush.MU, test_crush.CRUSH)
    assert computed == pytest.approx(known, rel=1e-9)

"""Decks: every load path of tests/decks through driver, Python and UMAT, against the NumPy reference.

The driver compares the last row with `&expect`, whose numbers are formulas or those of independent programs.
Here the rows of a path are those of every other entry to the library.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from asperity import EquilibriumLost, History, read_case
from support_driver import ROOT, call

from tests.oracle import cap, reference

DECKS = sorted((ROOT / "tests" / "decks").glob("*.nml"))
HOSTS = "h = 0.5", "ntens = 6, h = 0.5", "ntens = 6, map = 1, r = 0.1"
"""Entries of &replay; a deck has one of them, and ntens = 2 if nothing happens across the plane."""
ENERGIES = "stored", "rupture", "friction"
ROUNDING = 1e-11
"""Relative to the largest traction and to K |s|; sums over planes and increments in another order."""

pytestmark = pytest.mark.filterwarnings("ignore::asperity.ModelWarning")


def assert_rows(rows: History, expected: History, tolerance: float) -> None:
    """Assert that two histories have the same tractions, damage and energies."""
    size = np.abs(expected.traction).max() + 1.0
    for name in ("traction", "damage", *ENERGIES):
        ours, theirs = getattr(rows, name), getattr(expected, name)
        np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=tolerance * size, err_msg=name)


def events_of(rows: History) -> list[tuple[int, set[str]]]:
    """Events of the law; in equilibrium rounding decides whether a plane slips or touches."""
    ignored = {"", "slip", "open", "close"} if np.abs(rows.traction[-1, 0]) < 1e-9 else {"", "slip"}
    return [(row, names) for row, text in rows.events if (names := {*text.split("+")} - ignored)]


def assert_reference(run, rows: History) -> None:
    """Assert that every increment that was not divided has the results of the reference."""
    p = run.interface.pattern
    law = reference.Parameters(**run.interface.material.values())
    pattern = reference.regular_pattern(p.m, p.theta, p.flat, p.turn)
    divided = [row for row, text in rows.events if {"substeps", "snap"} & set(text.split("+"))]
    # what an initial state is at its start is not in the rows
    left_out = divided if run.state is None else [*divided, 0]
    if law.W0:
        # work of friction wears a facet that touches at the start: where none presses, rounding decides
        left_out = [*left_out, *(1 + np.flatnonzero(np.abs(rows.traction[:-1]).max(-1) < 1e-12))]
    whole = np.delete(np.arange(len(rows)), left_out)
    s, state = (np.vstack([np.zeros_like(a[:1]), a]) for a in (rows.separation, rows.state))
    steps = np.diff(rows.time, prepend=0.0).round(12) if law.tau_v else np.zeros(len(rows))
    for dt in np.unique(steps[whole]):
        here = whole[steps[whole] == dt]
        given = s[here + 1], state[here], s[here], dt
        if law.fc > 0.0:
            strength = cap.Cap(law.fc, law.Gfc, law.Css, law.kp, law.fcr)
            traction, new = cap.update(law, strength, pattern, *given)
            size = np.abs(rows.traction).max() + law.Kn * np.abs(s).max()
            np.testing.assert_allclose(rows.traction[here], traction, rtol=0.0, atol=ROUNDING * size)
            np.testing.assert_allclose(rows.state[here], new, rtol=0.0, atol=ROUNDING * size)
            continue
        theirs = reference.update(law, pattern, *given, tangent=False)
        size = np.abs(rows.traction).max() + law.Kn * np.abs(s).max()
        np.testing.assert_allclose(rows.traction[here], theirs.traction, rtol=0.0, atol=ROUNDING * size)
        # without pressure, rounding decides which planes are in contact, and with it their slips
        some = slice(None) if np.abs(rows.traction[-1, 0]) > 1e-9 else slice(4)
        # rupture and friction of long increments are judged by the tests of the reference
        known = theirs.long[:, None] & np.isin(np.arange(state.shape[1]), [2, 3])
        ours, theirs = state[here + 1, some], np.where(known, state[here + 1], theirs.state)[:, some]
        np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=ROUNDING * (1.0 + size))


@pytest.mark.slow
@pytest.mark.parametrize("deck", DECKS, ids=lambda path: path.stem)
def test_deck(driver: Path, deck: Path, tmp_path: Path) -> None:
    """Every entry to the library has the rows of the driver, and the last one is as the deck says."""
    done = call(driver, deck, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    case, text = read_case(deck), deck.read_text(encoding="utf-8")
    for run in case.runs:
        name = deck.stem + (f"_{run.value:g}" if case.sweep else "")
        (path,) = (file for file in tmp_path.glob("*.csv") if file.stem in (name, f"{name}.0"))
        rows = History.from_csv(path)
        try:
            history = run.history()
            assert_rows(history, rows, 0.0)
            assert history.events == rows.events
        except EquilibriumLost as lost:
            history = lost.history
        assert_reference(run, history)
        # a host does not divide increments; the driver compares its energies relative to their sum
        divided = any("substeps" in text or "snap" in text for _, text in rows.events)
        if divided or history.lost or rows.rupture.min() < 0.0:
            continue
        # the same case with the record in place of its steps and of what is expected
        head = re.sub(r"&(step|expect|sweep)[^/]*/", "", re.sub(r"(?<== )x\b", f"{run.value}", text))
        plane = not rows.separation[:, 2].any() and not rows.traction[:, 2].any()
        host = HOSTS[DECKS.index(deck) % len(HOSTS)]
        for entry in (host, "ntens = 2") if plane else (host,):
            replay = head + f"&replay file = '{path}', {entry} /\n"
            (tmp_path / "replay.nml").write_text(replay, encoding="utf-8")
            done = call(driver, "replay.nml", "--force", folder=tmp_path)
            assert done.returncode == 0, done.stderr
            replayed = History.from_csv(tmp_path / "replay.csv")
            assert_rows(replayed, rows, 10 * ROUNDING)
            # viscous damage is full where rounding makes it 1
            assert run.interface.material.tau_v or events_of(replayed) == events_of(rows)

"""Doors of host programs: the path decks by the calls of a host, imitated as its documents describe them.

A host with a door has `calls.py` in its folder, whose Points take separations and return tractions.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from asperity import EquilibriumLost, read_case

ROOT = Path(__file__).parents[2]
DOORS = {
    path.parent.name: import_module(f"harness.hosts.{path.parent.name}.calls")
    for path in sorted((ROOT / "harness" / "hosts").glob("*/calls.py"))
}
SENSITIVE = "wear_coarse"
"""A deck of long increments with wear: separations that change by 1e-15 change its tractions by 100 MPa."""

DECKS = [deck for deck in sorted((ROOT / "tests" / "decks").glob("*.nml")) if deck.stem != SENSITIVE]
ROUNDING = 1e-10
"""Relative to the largest traction and to K |s|: separations are sums of increments."""
SHARES = 0.0, 1.0, 0.5
"""Points of a block: each takes this share of the separations of a deck."""

pytestmark = pytest.mark.filterwarnings("ignore::asperity.ModelWarning")


def paths(deck: Path):
    """Interface, separations and ends of the increments of each case of a deck that begins virgin and dry."""
    for run in read_case(deck).runs:
        try:
            history = run.history()
        except EquilibriumLost as lost:
            history = lost.history
        if run.state is None and len(history) > 1 and not np.any(getattr(history, "water", 0.0)):
            yield run.interface, history


@pytest.mark.slow
@pytest.mark.parametrize("deck", DECKS, ids=lambda path: path.stem)
def test_doors(deck: Path) -> None:
    """Each point of a block has the tractions, damage and energies of the driver on its own separations."""
    for interface, history in paths(deck):
        material, steps = interface.material, np.diff(history.time, prepend=0.0)
        times = history.time if material.tau_v > 0.0 or material.c > 0.0 else None
        separations = [share * history.separation for share in SHARES]
        expected = [interface.replay(s, times) for s in separations]
        divided = [{"substeps", "snap"} & {*text.split("+")} for rows in expected for _, text in rows.events]
        if any(divided):
            continue  # hosts do not divide increments
        s = np.stack(separations, axis=1)
        traction, state = np.stack([e.traction for e in expected], 1), [e.state[-1, :4] for e in expected]
        size = np.abs(traction).max() + material.K * np.abs(s).max()
        for door in DOORS:
            points = DOORS[door].Points(interface.props(), len(SHARES))
            start = np.zeros((len(SHARES), 3))
            for k, end in enumerate(s):
                new = points.step(start, end, float(steps[k]))
                np.testing.assert_allclose(new, traction[k], 0.0, ROUNDING * size, err_msg=f"{door}, row {k}")
                start = end
            np.testing.assert_allclose(points.state[:, :4], state, 0.0, ROUNDING * (1.0 + size), err_msg=door)

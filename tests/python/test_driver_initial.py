"""Initial states in the driver, group &initial. Decks have sheared, far slipped and partly damaged joints."""

from __future__ import annotations

import numpy as np
import pytest
from support_driver import GC, MATERIAL, PARTS, RP_4, S_F

LISTED = "&pattern normals = 1, 0, 0, 0.9, 0.3, 0.1, 0.8, -0.2, 0.3, weights = 0.4, 0.3, 0.3 /\n"
VISCOUS, GUARDED = ", tau_v = 0.5 /", ", guard = .true. /"


@pytest.mark.parametrize(
    ("extra", "pattern", "damage", "steps"),
    [
        ("", RP_4, "0.3", "&step t_N = -4, increments = 1 /\n&step {s_Tx}, {s_Ty}, increments = 60 /\n"),
        ("", RP_4, "0.9", "&step k_N = 20.0, t_N = -4, {s_Tx}, {s_Ty}, increments = 60 /\n"),
        ("", LISTED, "0", "&step t_N = -4, {s_Tx}, t_Ty = 0.0, increments = 60 /\n"),
        ("", LISTED, "1", "&step t_N = -1, t_Tx = 0, t_Ty = 0, increments = 60 /\n"),
        ("", RP_4, "1", "&step t_N = 0.0, {s_Tx}, {s_Ty}, increments = 40 /\n"),
        (VISCOUS, RP_4, "0.3", "&step t_N = -4, {s_Tx}, {s_Ty}, increments = 60, time = 2.0 /\n"),
        (GUARDED, RP_4, "0.3", "&step t_N = -4, {s_Tx}, {s_Ty}, increments = 60 /\n"),
    ],
)
def test_initial_state_is_a_preload(run, extra: str, pattern: str, damage: str, steps: str) -> None:
    """A path from an initial state is that of a run that applied the traction first, less its separation."""
    head = MATERIAL.replace(" /", extra or " /") + pattern
    planes = 5 if pattern == RP_4 else 3
    traction = {"t_N": -4.0, "t_Tx": 0.8, "t_Ty": -0.4}

    def path(s: list[float]) -> str:
        targets = [f"s_Tx = {s[1] + 0.05!r}, {s[1] - 0.1!r}", f"s_Ty = {s[2] + 0.1!r}, {s[2] + 0.02!r}"]
        return steps.format(s_Tx=targets[0], s_Ty=targets[1])

    state = f"&state separation = 3*0, statev = 8*0{f', {damage}, 0, 0' * planes} /\n"
    # The preload is so slow that viscous damage is in equilibrium, to 1e-9 of its growth.
    preload = f"{', '.join(f'{name} = {value}' for name, value in traction.items())}, time = 1e9"
    before = head + state + f"&step {preload}, increments = {PARTS} /\n"
    offset = run(before, "--planes").vector("s")[-1]
    loaded = run(before + path(offset.tolist()), "--planes")
    values = ", ".join(str(value) for value in traction.values())
    initial = run(
        head + f"&initial traction = {values}, damage = {damage} /\n" + path([0.0, 0.0, 0.0]), "--planes"
    )
    assert len(initial.rows) == len(loaded.rows) - PARTS
    # The state does not record that a plane slides. Sliding may be due to rounding, as may the contact of
    # fully damaged planes.
    ignored = {"slip", "open", "close"} if damage == "1" else {"slip"}
    events = [[event - ignored for event in result.events] for result in (initial, loaded)]
    assert events[0] == events[1][PARTS:]
    tolerance, first = 1e-9, slice(PARTS, None)
    size = np.abs(loaded.vector("t")).max()
    np.testing.assert_allclose(initial.vector("t"), loaded.vector("t")[first], rtol=0, atol=tolerance * size)
    np.testing.assert_allclose(
        initial.vector("s"), loaded.vector("s")[first] - offset, rtol=0, atol=tolerance * S_F
    )
    # rupture and friction count from the initial state on, and the work from its stored energy on
    before = {name: loaded[name][PARTS - 1] for name in ("rupture", "friction")}
    before["work"] = loaded["work"][PARTS - 1] - loaded["stored"][PARTS - 1]
    for name in ("damage", "stored", "rupture", "friction", "work", "alpha_1", "s_dit_2", "s_dih_3"):
        scale = max(np.abs(loaded[name]).max(), GC)
        expected = loaded[name][first] - before.get(name, 0.0)
        np.testing.assert_allclose(initial[name], expected, rtol=0, atol=tolerance * scale, err_msg=name)

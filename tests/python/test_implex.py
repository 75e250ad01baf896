"""IMPL-EX of the UMAT (PROPS 25) beside a reference that shares no code, and where it is refused."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, ModelWarning, Pattern, contract
from support_calls import LIBRARY, address, errors, umat, vumat
from test_oracle import OPTIONS, assert_within

from tests.oracle import implex, reference

TOLERANCE = 0.1
SEED, STEPS, POINTS = 56, 10, 2
MATERIAL = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5}
PLAIN = Interface(Material(**MATERIAL), Pattern.regular(4, 30.0))


def props_of(joint: Interface) -> np.ndarray:
    """PROPS with IMPL-EX."""
    return np.ascontiguousarray(joint.props(implex=TOLERANCE))


def names_of(joint: Interface) -> list[str]:
    """Names of STATEV."""
    return list(contract.umat_names(*contract.check(joint.props()), TOLERANCE))


@pytest.mark.parametrize("option", OPTIONS)
def test_reference(option: str) -> None:
    """Traction, state, and errors of random walks are those of the reference."""
    constants = MATERIAL | OPTIONS[option]
    parameters, rng = reference.Parameters(**constants), np.random.default_rng(SEED)
    for sides, flat in ((0, 1.0), (2, 0.0), (5, 0.3)):
        joint = Interface(Material(**constants), Pattern.regular(sides, 30.0, flat, 20.0))
        planes, names = reference.regular_pattern(sides, 30.0, flat, 20.0), names_of(joint)
        props = props_of(joint)
        size, stress = joint.material.s_0, joint.material.K * max(1.0, joint.material.kc)
        s, state = np.zeros((POINTS, 3)), np.zeros((POINTS, len(names)))
        own, reached, way = (
            implex.Own.virgin(joint.n_planes, POINTS),
            np.zeros(POINTS),
            rng.standard_normal((POINTS, 3)),
        )
        for step in range(STEPS):
            dt, way = float(10 ** rng.uniform(-1.0, 0.5)), way + rng.standard_normal((POINTS, 3))
            end, first = s + 0.3 * dt * size * way, step in (0, 7)
            law = state[:, : joint.nstatv]
            expected, own = implex.step(parameters, planes, s, end, law, own, first, dt)
            reached = np.maximum(reached, np.abs([s, end, own.aim]).max(axis=(0, 2)))
            scale = stress * (reached + size)
            # the reference finds what is crushed by bisection
            rounding = (1e-9 if parameters.crush else 1e-11) * (scale + np.abs(expected).max(axis=1))
            kinc = 1 if first else step + 1
            for k in range(POINTS):
                change = end[k] - s[k]
                out = umat(LIBRARY, props, np.zeros(3), state[k], s[k], change, dt, kinc=kinc)
                assert_within("traction", out.stress, expected[k], rounding[k])
                assert np.array_equal(out.tangent, out.tangent.T)
                state[k] = out.state
                values = dict(zip(names, out.state.tolist(), strict=True))
                assert values["e_a"] == pytest.approx(own.e_a[k], abs=1e-9)
                assert values["e_t"] == pytest.approx(own.e_t[k], abs=1e-9 * scale[k] / constants["sigma0"])
                assert values["longest"] == own.longest and values["duration"] == dt
            s = end


def test_card() -> None:
    """Cards have PROPS 25 and its state variables; other hosts say that they have no IMPL-EX."""
    card = PLAIN.card("abaqus", implex=0.05)
    names = names_of(PLAIN)
    assert f"*Depvar\n{len(names)},\n" in card and "35, e_t, e_t" in card and "unsymm" not in card
    assert "unsymm" in PLAIN.card("abaqus")
    assert len(names) == PLAIN.nstatv + 7 + PLAIN.n_planes
    with pytest.warns(ModelWarning, match="room for 21 constants"):
        assert "SDV35: e_t" in PLAIN.card("calculix", implex=0.1, h=0.1)
    for host in ("ogs", "oofem", "fenicsx", "mtest"):
        thin = {"h": 0.1} if host in ("ogs", "oofem") else {}
        with pytest.raises(ValueError, match=r"implex = 0\.1: expected 0"):
            PLAIN.card(host, implex=0.1, **thin)
    with pytest.raises(ValueError, match=r"implex = 0\.1: expected 0 for Abaqus/Explicit"):
        PLAIN.card("abaqus", explicit=True, density=1.0, implex=0.1)
    with pytest.raises(ValueError, match="implex = 1: expected 0 <= implex < 1"):
        PLAIN.card("abaqus", implex=1.0)


def test_card_of_a_joint_that_wears() -> None:
    """The state of the planes and of their facets comes first, then that of IMPL-EX; all of it has room."""
    joint = Interface(Material(**MATERIAL, height=0.1, W0=0.5), Pattern.regular(4, 30.0))
    for host in ("abaqus", "kratos"):
        card = joint.card(host, implex=TOLERANCE)
        places = [card.index(name) for name in ("alpha_5", "worn_5", "wear_work_5", "growth_5")]
        assert places == sorted(places), host
    sizes = contract.check(joint.props(implex=TOLERANCE))
    assert sizes == contract.check(joint.props()) == (5, True)
    assert f"*Depvar\n{contract.n_statev(*sizes) + len(contract.implex_table()) - 1 + 5}," in joint.card(
        "abaqus", implex=TOLERANCE
    )


def test_refused_by_explicit_hosts_and_c() -> None:
    """VUMAT and C API name PROPS 25; nothing is written."""
    words = "PROPS(25) implex = 0.1: expected 0, as IMPL-EX belongs to the UMAT alone"
    props, state = props_of(PLAIN), np.zeros((1, PLAIN.nstatv + 20))
    with errors() as said:
        out = vumat(LIBRARY, props, np.ones(1), (1.0, 0.1), np.full((1, 3), 1e-3), np.zeros((1, 3)), state)
        assert words in said()
    assert np.isnan(out.stress).all() and not out.state.any()
    message = ctypes.create_string_buffer(400)
    assert LIBRARY.asperity_nstatv(address(props), len(props), message, 400) == 0
    assert message.value.decode() == words


def test_replay(run, tmp_path: Path) -> None:
    """&replay with implex has the tractions of the UMAT, and its implicit state."""
    text = "&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5 /\n&pattern sides = 4, theta = 30.0 /\n"
    run(text + "&step t_N = -5.0, increments = 20 /\n&step slip = 0.3, -0.2, increments = 40 /\n")
    (tmp_path / "case.csv").rename(tmp_path / "record.csv")
    law = run(text + "&replay file = 'record.csv' /\n", "--planes")
    rows = run(text + f"&replay file = 'record.csv', implex = {TOLERANCE} /\n", "--planes")
    assert np.array_equal(rows["damage"], law["damage"])
    s, tractions = rows.vector("s"), rows.vector("t")
    state, at, stress = np.zeros(len(names_of(PLAIN))), np.zeros(3), np.zeros(3)
    for k, (end, time) in enumerate(zip(s, np.diff(rows["time"], prepend=0.0), strict=True)):
        out = umat(LIBRARY, props_of(PLAIN), stress, state, at, end - at, float(time), kinc=k + 1)
        state, at, stress = out.state, end, out.stress
        assert out.stress == pytest.approx(tractions[k], abs=1e-8)
    off = np.abs(rows["t_Tx"] - law["t_Tx"]).max()
    assert 0.0 < off < 0.2 * np.abs(law["t_Tx"]).max()

"""Joints of Cast3M: the functions of libasperity_generic, called with its arguments, and the card."""

from __future__ import annotations

import ctypes
import re
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, Pattern, contract
from asperity.cli import main
from asperity.installed import generic_library

JOINT = Interface(Material(3.0, 0.3, 0.9, 0.5, kc=20.0, height=0.2), Pattern.regular(4, theta=30.0))
LEADING = [1500.0, 3000.0, 0.0, 0.0]
"""KS, KN, RHO and ALPN of Cast3M, which the law does not read."""
ORDER = {2: [1, 0], 3: [1, 2, 0]}
"""The components of Cast3M as components (N, Tx, Ty)."""


def constants() -> list[float]:
    """The constants of the joint that the library names, behind those of Cast3M."""
    names = [row for row in contract.owned("law", "pattern", "numerics") if row.name not in ("map", "h", "r")]
    return [*LEADING, *(JOINT.props()[row.index - 1] for row in names)]


def call(n: int, stress, statev, stran, dstran, props, planes: int = 5, dt: float = 1.0):
    """Call a joint: KINC, traction, state, DDSDDE in Fortran's order and PNEWDT; inputs are copied."""
    stress, statev, props = (np.array(values, dtype=float) for values in (stress, statev, props))
    ddsdde, pnewdt = np.full((n, n), 7.0), ctypes.c_double(1e300)
    kinc, sizes = ctypes.c_long(5), [ctypes.c_long(size) for size in (n, len(statev), len(props))]
    arrays = [np.array(values, dtype=float) for values in (stran, dstran)]
    arguments = [None] * 37
    for place, value in {0: stress, 1: statev, 2: ddsdde, 10: arrays[0], 11: arrays[1], 23: props}.items():
        arguments[place] = value.ctypes.data_as(ctypes.c_void_p)
    time = ctypes.c_double(dt)
    for place, value in {13: time, 21: sizes[0], 22: sizes[1], 24: sizes[2], 27: pnewdt, 36: kinc}.items():
        arguments[place] = ctypes.byref(value)
    getattr(ctypes.CDLL(str(generic_library())), f"AsperityCastem{planes}")(*arguments, 0)
    return kinc.value, stress, statev, ddsdde.T, pnewdt.value


@pytest.mark.parametrize("n", [2, 3])
def test_walk_is_that_of_the_interface(n: int) -> None:
    """Along a random walk tractions, states and tangents are those of Python in the order of Cast3M."""
    draw = np.random.default_rng(2015)
    order = ORDER[n]
    s, state, theirs = np.zeros((1, 3)), np.zeros((1, JOINT.nstatv)), np.zeros(8 + 5 * 5 + 2)
    traction = np.zeros(n)
    for _ in range(50):
        move = draw.normal(size=3) * [0.02, 0.03, 0.03]
        if n == 2:
            move[2] = 0.0
        end = JOINT.update(s + move, state, s)
        done, traction, theirs, tangent, factor = call(
            n, traction, theirs, s[0, order], move[order], constants()
        )
        assert done == 1 and factor == 1e300
        scale = np.abs(end.traction).max()
        np.testing.assert_allclose(traction, end.traction[0, order], rtol=0.0, atol=1e-12 * scale)
        np.testing.assert_allclose(tangent, end.tangent[0][np.ix_(order, order)], rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(theirs[: JOINT.nstatv], end.state[0], rtol=1e-12, atol=1e-12)
        s, state = s + move, end.state


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"n": 6}, "NTENS = 6: expected a joint element, 2 or 3"),
        ({"statev": 30}, "NSTATV = 30: expected "),
        ({"props": [*LEADING, 3.0]}, "NPROPS = 5, NSTATV = 35: expected "),
        ({"planes": 4}, "NSTATV = 35: expected "),
        ({"stran": np.nan}, "AsperityJoint5: "),
        ({"sigma0": -3.0}, "sigma0 = -3: expected > 0"),
    ],
)
def test_refused(capfd: pytest.CaptureFixture[str], changes: dict, said: str) -> None:
    """What is not admissible returns KINC = -1 with a message, and changes nothing but PNEWDT."""
    n = changes.get("n", 3)
    props = list(changes.get("props", constants()))
    props[4] = changes.get("sigma0", props[4])
    state, stran = np.zeros(changes.get("statev", 35)), np.full(n, changes.get("stran", 0.0))
    done, stress, statev, ddsdde, _ = call(
        n, np.ones(n), state, stran, np.zeros(n), props, changes.get("planes", 5)
    )
    assert done == -1 and said in capfd.readouterr().err
    assert (stress == 1.0).all() and not statev.any() and (ddsdde == 7.0).all()


def test_card(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """The card has all constants in the order of the library, in lines that Gibiane reads whole."""
    monkeypatch.chdir(tmp_path)
    case = "&material sigma0 = 3, Gc = 0.3, eta = 0.9, mu = 0.5, kc = 20, height = 0.2 /\n"
    case += "&pattern sides = 4, theta = 30 /\n&step s_N = 0.1 /\n"
    Path("case.nml").write_text(case, encoding="utf-8")
    assert main(["card", "cast3m", "case.nml", "--name", "JOINTS"]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if not line.startswith("*")]
    assert max(map(len, lines)) <= 72
    coel, stat, model, material = " ".join(lines).rstrip(" ;").split(" ; ")
    names = re.findall(r"'(\w+)'", coel)[1:]
    assert names[:4] == ["KS", "KN", "RHO", "ALPN"] and len(re.findall("'V", stat)) == 35
    values = dict(re.findall(r"'(\w+)' ([-\d.e]+)", material))
    assert list(values) == names and max(map(len, names)) <= 4
    assert [float(values[name]) for name in names[4:]] == constants()[4:]
    # the contact is 20 times stiffer than the bond
    k = JOINT.update(np.zeros((1, 3))).tangent[0]
    assert [float(values["KS"]), float(values["KN"])] == pytest.approx([20 * k[1, 1], 20 * k[0, 0]])
    assert "'JOI4'" in model
    assert main(["card", "cast3m", "case.nml", "--dimension", "2"]) == 0
    assert "'JOI2'" in capsys.readouterr().out
    assert "'MODELISER' JOINTS " in model and "'FCT_LOI' 'AsperityCastem5'" in model

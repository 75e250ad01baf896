"""Numbers of the reference for the Fortran suites: every build is compared with the same numbers.

`python tests/python/test_reference_numbers.py` writes tests/law/reference_numbers.f90.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from tests.oracle import reference

FILE = Path(__file__).parents[1] / "law" / "reference_numbers.f90"
STEPS = 16
TABLE_2 = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5}
TABLE_2_PROPS = (3.0, 0.3, 0.9, 0.5, 30.0)
THIRD = 1.0 / 3.0
# Each case has its name, the inclined planes, further parameters, and these as PROPS 11, 12, 16.
CASES = (
    ("RT", 2, {}, (0.0, 0.0, 1.0)),
    ("RP-3", 3, {}, (0.0, 0.0, 1.0)),
    ("RP-4", 4, {}, (0.0, 0.0, 1.0)),
    ("RP-6", 6, {}, (0.0, 0.0, 1.0)),
    ("RP-32", 32, {}, (0.0, 0.0, 1.0)),
    ("RP-4, own mode II, stiff contact", 4, {"sigma02": 6.0, "Gc2": 0.45, "kc": 10.0}, (6.0, 0.45, 10.0)),
)
TURN = 10.0
"""Rotation of the pattern, degrees, away from the axes: no component vanishes by symmetry."""


def history() -> np.ndarray:
    """Return random separations (STEPS, 3) in a growing range, rounded to single precision.

    The last separation is closed.
    """
    rng = np.random.default_rng(2015)
    sf = 2.0 * TABLE_2["Gc"] / TABLE_2["sigma0"]
    reach = sf * (0.05 + 1.5 * np.arange(1, STEPS + 1) / STEPS)
    s = rng.uniform(-1.0, 1.0, (STEPS, 3)) * reach[:, None]
    s[STEPS // 2] = s[STEPS // 2 - 1]
    s[-1] = [-0.05 * sf, 0.9 * sf, -0.7 * sf]
    return s.astype(np.float32).astype(float)


def numbers() -> dict[str, list[float]]:
    """Return every array of the Fortran module, in the order of its elements."""
    s = history()
    out: dict[str, list[float]] = {n: [] for n in ("s", "props", "traction", "state", "tangent")}
    out["s"] = s.ravel().tolist()
    for _, sides, more, (sigma02, gc2, kc) in CASES:
        props = [*TABLE_2_PROPS, float(sides), THIRD, TURN, 1.0, 0.0, sigma02, gc2, 0.0, 0.0, 0.0, kc]
        pattern = reference.regular_pattern(sides, 30.0, THIRD, TURN)
        path = reference.replay(reference.Parameters(**TABLE_2, **more), pattern, s)
        out["props"] += props
        out["traction"] += path.traction.ravel().tolist()
        out["state"] += path.state[-1].tolist()
        out["tangent"] += path.tangent[-1].T.ravel().tolist()  # Fortran: columns first
    return out


def array(name: str, values: list[float], shape: tuple[int, ...]) -> str:
    """Return the declaration of a constant array with four numbers per line."""
    texts = [f"{v!r}_wp" for v in values]
    lines = ", &\n".join("    " + ", ".join(texts[i : i + 4]) for i in range(0, len(texts), 4))
    bounds = ", ".join(str(n) for n in shape)
    if len(shape) == 1:
        return f"  real(wp), parameter, public :: {name}({bounds}) = [ &\n{lines}]\n"
    return f"  real(wp), parameter, public :: {name}({bounds}) = reshape([ &\n{lines}], [{bounds}])\n"


def module() -> str:
    """Return the text of the Fortran module."""
    values = numbers()
    shapes = {
        "s": (3, STEPS),
        "props": (16, len(CASES)),
        "traction": (3, STEPS, len(CASES)),
        "state": (len(values["state"]),),
        "tangent": (3, 3, len(CASES)),
    }
    names = ", &\n".join(f'    "{name:40}"' for name, *_ in CASES)
    return (
        "!> What the independent reference gives for one history and several interfaces: separations, then\n"
        "!> by case PROPS, tractions, the last STATEV one after the other, the last tangent. Written by\n"
        "!> tests/python/test_reference_numbers.py.\n"
        "module reference_numbers\n"
        "  use asperity_kinds, only: wp\n"
        "  implicit none\n"
        "  private\n"
        f"  integer, parameter, public :: n_steps = {STEPS}, n_cases = {len(CASES)}\n"
        f"  character(len=40), parameter, public :: names(n_cases) = [ &\n{names}]\n"
        + "".join(array(name, values[name], shape) for name, shape in shapes.items())
        + "end module reference_numbers\n"
    )


def test_the_fortran_module_holds_the_numbers_of_the_reference() -> None:
    """The module has the numbers of the reference to a few rounding errors.

    NumPy's functions differ in the last bit between machines.
    """
    pattern = re.compile(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?(?=_wp)")
    written = [float(x) for x in pattern.findall(FILE.read_text(encoding="utf-8"))]
    now = [v for values in numbers().values() for v in values]
    assert len(written) == len(now)
    np.testing.assert_allclose(written, now, rtol=1e-12, atol=1e-14)


if __name__ == "__main__":
    FILE.write_text(module(), encoding="utf-8")

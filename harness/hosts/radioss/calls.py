"""The calls that OpenRadioss makes at connection elements, /PROP/TYPE43, of the user library.

They were read in its public sources (release of August 2026). Blocks are arrays by columns; components that
these elements do not have share one array.
"""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np
from asperity import installed
from asperity.contract import Floats

LIBRARY = ctypes.CDLL(str(installed.named_library("raduser_linux64")))
MOST_UPARAM = 1000
DENSITY = 1.0e-9


def read_card(root: str, lines: str) -> tuple[Floats, int]:
    """Starter: UPARAM and the number of UVAR of a card, whose lines behind the density are a file."""
    Path(f"SI{root}_0099.scr").write_text(lines, encoding="ascii")
    uparam, parmat, functions = np.zeros(MOST_UPARAM), np.zeros(100), np.zeros(100, np.int32)
    nuparam, nuvar, nfunc = (ctypes.c_int() for _ in range(3))
    LIBRARY.st_lecm99_(
        ctypes.byref(ctypes.c_int(99)), root.encode().ljust(80), ctypes.byref(ctypes.c_int(len(root))),
        ctypes.byref(ctypes.c_int(1)), _at(uparam), ctypes.byref(ctypes.c_int(MOST_UPARAM)),
        ctypes.byref(nuparam), ctypes.byref(nuvar), _at(functions),
        ctypes.byref(ctypes.c_int(100)), ctypes.byref(nfunc), _at(parmat),
    )  # fmt: skip
    # it copies this file into its listing and stops without it
    assert Path(f"SO{root}_0099.scr").read_text(encoding="ascii").strip()
    assert nfunc.value == 0 and parmat[0] > 0.0
    return uparam[: nuparam.value], nuvar.value


class Points:
    """One integration point of a block of elements, on the calls of the engine."""

    def __init__(self, props: Floats, n: int, density: float = DENSITY) -> None:
        """Begin with n virgin elements; props: PROPS."""
        self.uparam = np.array(props)
        self.nuvar = LIBRARY.asperity_nstatv(_at(self.uparam), len(props), None, 0)
        self.uvar = np.zeros((n, self.nuvar), order="F")
        self.stress = np.zeros((3, n))  # ZZ, YZ, ZX at the end of the cycle before
        self.rho, self.off = np.full(n, density), np.ones(n)
        self.soundsp, self.pla = np.zeros(n), np.zeros(n)
        self.time = 0.0

    def step(self, start: Floats, end: Floats, dt: float = 0.0) -> Floats:
        """Tractions (n, 3) N, Tx, Ty at the end of an increment from separation to separation (n, 3)."""
        n = len(self.rho)
        zz, zx, yz = (np.ascontiguousarray(row) for row in (end - start).T)
        new, of_all = np.zeros((3, n)), np.zeros((3, n))
        shared, viscosity, strength = of_all
        none = _at(shared)
        single, axes, dummies = ctypes.byref(ctypes.c_int(1)), [none] * 9, [none] * 6
        old, increment, ends = (
            [none, none, _at(normal), none, _at(of_y), _at(of_x)]
            for normal, of_y, of_x in (self.stress, (zz, yz, zx), new)
        )
        LIBRARY.eng_get_law_user_var_(
            single,
            single,
            single,
            single,
            single,
            *axes,
            *old,
            *dummies,
            *dummies,
            *increment,
            _at(self.rho),
            *ends,
            *dummies,
        )
        size, nuparam, nuvar = (ctypes.byref(ctypes.c_int(k)) for k in (n, len(self.uparam), self.nuvar))
        numbers = np.arange(1, n + 1, dtype=np.int32)
        scalar = [ctypes.byref(ctypes.c_double(value)) for value in (self.time, dt)]
        LIBRARY.eng_sigeps99_(
            size, nuparam, nuvar, single, ctypes.byref(ctypes.c_int(0)), None, None, None, *scalar,
            _at(self.uparam), _at(self.rho), none, none, _at(numbers),
            _at(self.soundsp), _at(viscosity), _at(self.uvar), _at(self.off), _at(strength), _at(self.pla),
        )  # fmt: skip
        assert not shared.any(), "the array of components that the element does not have was written"
        LIBRARY.eng_set_law_user_var_()
        self.stress, self.time = new, self.time + dt
        return np.stack([new[0], new[2], new[1]], axis=1)

    @property
    def state(self) -> Floats:
        """STATEV (n, :)."""
        return self.uvar


def _at(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)

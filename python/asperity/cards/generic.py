"""Behaviours of libasperity_generic, which hosts with MGIS or TFEL's interfaces load."""

from __future__ import annotations

import ctypes

from ..installed import generic_library


def behaviour(n_planes: int, host: str, kind: str = "Layer", wet: bool = False) -> str:
    """Name of the layer or joint with these planes; raises ValueError if the library has none.

    wet: whether its external state variable is the water pressure.
    """
    name = f"Asperity{'Wet' if wet else ''}{kind}{n_planes}"
    try:
        _number(f"{name}_nInternalStateVariables")
    except ValueError:
        raise ValueError(
            f"{n_planes} planes: expected fewer for {host}, whose library has no {name}"
        ) from None
    return name


def property_names(name: str, kind: str = "MaterialProperties") -> list[str]:
    """Names of the material properties of a behaviour, read from the library as MGIS reads them.

    kind: "InternalStateVariables" for those of its state.
    """
    n = _number(f"{name}_n{kind}")
    texts = (ctypes.c_char_p * n).in_dll(_library(), f"{name}_{kind}")
    return [(text or b"").decode("ascii") for text in texts]


def _library() -> ctypes.CDLL:
    return ctypes.CDLL(str(generic_library()))


def _number(symbol: str) -> int:
    return int(ctypes.c_ushort.in_dll(_library(), symbol).value)

"""Material block for OpenGeoSys: a patch of its project file with a "generic" behaviour of MGIS."""

from __future__ import annotations

import ctypes
from xml.sax.saxutils import escape

from .. import contract
from ..installed import generic_library

AXES = {2: ("0 1", "-1 0"), 3: ("0 0 1", "1 0 0", "0 1 0")}
"""N, Tx, Ty of a horizontal layer, by dimension.  In two dimensions they are right-handed, too."""


def behaviour(n_planes: int, host: str = "ogs", kind: str = "Layer") -> str:
    """Name of the layer or joint with these planes; raises ValueError if the library has none."""
    name = f"Asperity{kind}{n_planes}"
    try:
        _number(f"{name}_nInternalStateVariables")
    except ValueError:
        raise ValueError(
            f"{n_planes} planes: expected fewer for {host}, whose library has no {name}"
        ) from None
    return name


def property_names(name: str) -> list[str]:
    """Names of the material properties of a behaviour, read from the library as MGIS reads them."""
    n = _number(f"{name}_nMaterialProperties")
    texts = (ctypes.c_char_p * n).in_dll(_library(), f"{name}_MaterialProperties")
    return [(text or b"").decode("ascii") for text in texts]


def _library() -> ctypes.CDLL:
    return ctypes.CDLL(str(generic_library()))


def _number(symbol: str) -> int:
    return int(ctypes.c_ushort.in_dll(_library(), symbol).value)


def patch(name: str, law: str, props: contract.Floats, dimension: int, comments: list[str]) -> str:
    """Patch that adds a layer of the material 1, with a behaviour of the library, to a project."""
    names = property_names(law)
    values = {one: float(props[contract.index(one)]) for one in names}
    axes = [f"{name}_axis_{i}" for i in range(dimension)]
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        *(f"<!-- {escape(text).replace('--', '- -')} -->" for text in comments),
        "<OpenGeoSysProjectDiff>",
        '  <add sel="/*/processes/process[1]">',
        '    <constitutive_relation id="1">',
        "      <type>MFront</type>",
        f"      <library>{escape(str(generic_library()))}</library>",
        f"      <behaviour>{law}</behaviour>",
        "      <material_properties>",
        *(f'        <material_property name="{one}" parameter="{name}_{one}"/>' for one in names),
        "      </material_properties>",
        "    </constitutive_relation>",
        "  </add>",
        '  <add sel="/*">',
        "    <local_coordinate_system>",
        *(f"      <basis_vector_{i}>{axis}</basis_vector_{i}>" for i, axis in enumerate(axes)),
        "    </local_coordinate_system>",
        "  </add>",
        '  <add sel="/*/parameters">',
        *(_parameter(f"{name}_{one}", repr(value)) for one, value in values.items()),
        *(_parameter(axis, value) for axis, value in zip(axes, AXES[dimension], strict=True)),
        "  </add>",
        "</OpenGeoSysProjectDiff>",
    ]
    return "\n".join(lines) + "\n"


def _parameter(name: str, values: str) -> str:
    return f"    <parameter><name>{name}</name><type>Constant</type><values>{values}</values></parameter>"

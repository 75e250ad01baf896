"""Material blocks for the input of host programs."""

from __future__ import annotations

import json
import re

from . import contract
from .installed import library

PER_LINE = 8
"""Constants on a line of an Abaqus or CalculiX input."""

CALCULIX_MAX_CONSTANTS = 21
"""CalculiX takes no more constants, and does not check."""


def card(host: str, name: str, props: contract.Floats, statev: tuple[str, ...]) -> str:
    """Material block of a host for a PROPS vector and the names of its state variables."""
    writers = {"abaqus": _abaqus, "calculix": _calculix, "kratos": _kratos}
    if host not in writers:
        raise ValueError(f"host = {host!r}: expected one of {', '.join(writers)}")
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,39}", name):
        raise ValueError(f"name = {name!r}: expected a letter, then up to 39 letters, digits or underscores")
    return writers[host](name, props, statev)


def _abaqus(name: str, props: contract.Floats, statev: tuple[str, ...]) -> str:
    """Abaqus: friction needs the unsymmetric solver; the names of the state variables show in the output."""
    return "\n".join(
        [
            *_comments(),
            f"*Material, name={name}",
            f"*User Material, constants={len(props)}, unsymm",
            *_constants(props),
            "*Depvar",
            f"{len(statev)},",
            *(f"{i}, {text}, {text}" for i, text in enumerate(statev, 1)),
            "",
        ]
    )


def _calculix(name: str, props: contract.Floats, statev: tuple[str, ...]) -> str:
    """CalculiX: a material whose name begins with ABAQUS goes to the UMAT; SDV names are comments."""
    if len(props) > CALCULIX_MAX_CONSTANTS:
        raise ValueError(
            f"{len(props)} constants: expected at most {CALCULIX_MAX_CONSTANTS} for calculix, which takes "
            "regular patterns only"
        )
    if name.upper().startswith("NL"):
        raise ValueError(
            f"name = {name!r}: expected none that begins with NL, which selects calculix' log strains"
        )
    position = contract.index("map")
    if props[position] != 0.0:
        raise ValueError(f"map = {props[position]:g}: expected 0 for calculix")
    return "\n".join(
        [
            *_comments(),
            *(f"** SDV{i}: {text}" for i, text in enumerate(statev, 1)),
            f"*MATERIAL, NAME=ABAQUS{name.upper()}",
            f"*USER MATERIAL, CONSTANTS={len(props)}",
            *_constants(props),
            "*DEPVAR",
            f"{len(statev)}",
            "",
        ]
    )


def _kratos(name: str, props: contract.Floats, statev: tuple[str, ...]) -> str:
    """Kratos GeoMechanicsApplication: properties of the 3D surface interface element."""
    block = {
        "model_part_name": name,
        "properties_id": 1,
        "Material": {
            "constitutive_law": {"name": "SmallStrainUMAT3DSurfaceInterfaceLaw"},
            "Variables": {
                "UDSM_NAME": str(library()),
                "IS_FORTRAN_UDSM": True,
                "UMAT_PARAMETERS": props.tolist(),
                "STATE_VARIABLES": [0.0] * len(statev),
            },
        },
    }
    names = {f"STATE_VARIABLE_{i}": text for i, text in enumerate(statev, 1)}
    return json.dumps({"state_variables": names, "properties": [block]}, indent=2) + "\n"


def _comments() -> list[str]:
    """Head of a block: who wrote it and the entries of PROPS."""
    names = ", ".join(row.name for row in contract.props_table() if row.name != "reserved")
    return [f"** asperity {contract.library_version()}: {names}"]


def _constants(props: contract.Floats) -> list[str]:
    """Constants in full precision, eight a line."""
    texts = [repr(value) for value in props.tolist()]
    return [", ".join(texts[i : i + PER_LINE]) for i in range(0, len(texts), PER_LINE)]

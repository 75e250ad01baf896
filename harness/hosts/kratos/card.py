"""The material block of Kratos GeoMechanicsApplication."""

from __future__ import annotations

import json
from pathlib import Path

from asperity.cards.blocks import Block
from asperity.installed import named_library

ELEMENTS = {
    2: ("SmallStrainUMAT2DLineInterfaceLaw", "Geo_ULineInterfacePlaneStrainElement", (2, 3)),
    3: ("SmallStrainUMAT3DSurfaceInterfaceLaw", "Geo_USurfaceInterfaceElement", (4, 3, 8, 6)),
}
"""Law and interface element of Kratos by dimension, and the numbers of nodes of its faces."""


def commit_adapter() -> Path:
    """Path of the commit adapter, a UMAT that stores states for Kratos' interface elements (Linux only)."""
    return named_library("asperity_kratos")


def block_of(block: Block) -> str:
    """Block for Kratos GeoMechanicsApplication: properties of the zero-thickness interface elements."""
    law, element, nodes = ELEMENTS[block.dimension]
    material = {
        "model_part_name": block.name,
        "properties_id": 1,
        "Material": {
            "constitutive_law": {"name": law},
            "Variables": {
                "UDSM_NAME": str(commit_adapter()),
                "IS_FORTRAN_UDSM": True,
                "GEO_DRAINAGE_TYPE": "constant_pw_field",  # else the rows of the water pressure are 0/0
                "BIOT_COEFFICIENT": 0.0,  # the water pressure is not coupled with the displacements
                "UMAT_PARAMETERS": block.props.tolist(),
                "STATE_VARIABLES": [0.0] * len(block.statev),
            },
        },
    }
    names = {f"STATE_VARIABLE_{i}": text for i, text in enumerate(block.statev, 1)}
    history = (
        "UDSM_NAME is the commit adapter, because these elements commit no step. An analysis with "
        "libasperity.so in its place runs, but damage heals on unloading"
    )
    initial = (
        "Zero STATE_VARIABLES are the initial state of the joint. Kratos passes no initial stress to a UMAT; "
        "a state of Interface.initial in place of the zeros has an initial stress"
    )
    elements = [f"{element}{k}Plus{k}N" for k in nodes]
    notes = {"elements": elements, "notes": [*block.notes, history, initial], "state_variables": names}
    return json.dumps(notes | {"properties": [material]}, indent=2) + "\n"

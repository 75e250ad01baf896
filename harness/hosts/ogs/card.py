"""The material block of OpenGeoSys: a patch of the project."""

from __future__ import annotations

from xml.sax.saxutils import escape

from asperity import contract
from asperity.cards.blocks import Block, remarks
from asperity.cards.generic import behaviour, property_names
from asperity.installed import generic_library

AXES = {2: ("0 1", "-1 0"), 3: ("0 0 1", "1 0 0", "0 1 0")}
"""N, Tx, Ty of a horizontal layer, by dimension.  In two dimensions they are right-handed, too."""


def block_of(block: Block) -> str:
    """OpenGeoSys: a patch of the project, `ogs -p CARD PROJECT`."""
    law = behaviour(contract.check(block.props)[0], "ogs")
    comments = remarks(
        block,
        "ogs -p THIS_FILE PROJECT.prj",
        f"the layer has the material id 1 and the thickness h = {block.thickness()!r}: adapt both",
        "axes: N, Tx, Ty of the layer, here of a horizontal one; a project has one local_coordinate_system, "
        "whose parameters may be of the type MeshElement",
        "zero state variables are the initial state of the joint; initial_values gives another one",
    )
    return _patch(block.name, law, block.props, block.dimension, comments)


def _patch(name: str, law: str, props: contract.Floats, dimension: int, comments: list[str]) -> str:
    """Patch that adds a layer of the material 1, with a behaviour of the library, to a project."""
    names = property_names(law)
    values = {constant: float(props[contract.index(constant)]) for constant in names}
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
        *(
            f'        <material_property name="{constant}" parameter="{name}_{constant}"/>'
            for constant in names
        ),
        "      </material_properties>",
        "    </constitutive_relation>",
        "  </add>",
        '  <add sel="/*">',
        "    <local_coordinate_system>",
        *(f"      <basis_vector_{i}>{axis}</basis_vector_{i}>" for i, axis in enumerate(axes)),
        "    </local_coordinate_system>",
        "  </add>",
        '  <add sel="/*/parameters">',
        *(_parameter(f"{name}_{constant}", repr(value)) for constant, value in values.items()),
        *(_parameter(axis, value) for axis, value in zip(axes, AXES[dimension], strict=True)),
        "  </add>",
        "</OpenGeoSysProjectDiff>",
    ]
    return "\n".join(lines) + "\n"


def _parameter(name: str, values: str) -> str:
    return f"    <parameter><name>{name}</name><type>Constant</type><values>{values}</values></parameter>"

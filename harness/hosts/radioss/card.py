"""The material block of OpenRadioss."""

from __future__ import annotations

from asperity.cards.blocks import Block, remarks, text_of

SMALL = 1.0e-9
"""Density where none is given: elements without thickness have no mass, and their time step is free of it."""

NUMBERS = 4
"""Numbers on a line of 100 characters."""


def block_of(block: Block) -> str:
    """Material and property of connection elements; the door reads the lines after that of the density."""
    values = block.props.tolist()
    rows = [values[i : i + NUMBERS] for i in range(0, len(values), NUMBERS)]
    names = [f"UVAR {i}: {text.replace('offset', 'separation')}" for i, text in enumerate(block.statev, 1)]
    return text_of(
        *remarks(
            block,
            "RAD_USERLIB_LIBPATH: folder of libraduser_linux64.so, which `asperity export radioss` names",
            "/MAT/USER01 has two digits: USER1 would carry no traction. Nodes 1 to 4 are one side,",
            "in right-hand order about N, which points to nodes 5 to 8; Tx is along edge 1-2.",
            *names,
            "No deletion of elements: contact survives rupture.",
            mark="# ",
        ),
        "/MAT/USER01/1",
        block.name,
        "#              RHO_I",
        f"{SMALL if block.density is None else block.density!r:>20}",
        *("".join(f"{value!r:>25}" for value in row) for row in rows),
        "/PROP/TYPE43/1",
        block.name,
        "#   Ismstr",
        f"{1:>10}",
    )

"""The material block of Cast3M, in Gibiane."""

from __future__ import annotations

from collections.abc import Sequence

from asperity import contract
from asperity.cards.blocks import Block, remarks, text_of
from asperity.cards.generic import behaviour, property_names
from asperity.installed import generic_library


def block_of(block: Block) -> str:
    """Cast3M: model and material of joint elements, in Gibiane."""
    wet = block.prop("water") > 0.0
    law = behaviour(contract.check(block.props)[0], "cast3m", "Castem", wet)
    comments = remarks(
        block,
        "LD_LIBRARY_PATH=FOLDER_OF_THE_LIBRARY castem THIS_FILE.dgibi",
        f"{block.name}: the mesh of joint elements; triangles are JOT3 instead of JOI4",
        "KS and KN are those of the operator with which Cast3M iterates, not constants of the law",
        *(["PF: the water pressure in the joint, >= 0, a parameter beside the temperature"] if wet else []),
        "MTest calls this function as Cast3M does; Cast3M itself was not run",
        mark="* ",
    )
    lines = _castem(block, law, wet)
    return text_of(*comments, *lines, *(f"* {line}" for line in RUN))


RUN = (
    "A run: MODS, MATS are model and material of the solids, BLOC is what is",
    "held, CHAR loads and displacements over time, LTPS the times.",
    "MODT = MODS 'ET' MODL ;",
    "MATT = MATS 'ET' MATL ;",
    "TAB1 = 'TABLE' ;",
    "TAB1 . 'MODELE' = MODT ;",
    "TAB1 . 'CARACTERISTIQUES' = MATT ;",
    "TAB1 . 'BLOCAGES_MECANIQUES' = BLOC ;",
    "TAB1 . 'CHARGEMENT' = CHAR ;",
    "TAB1 . 'TEMPS_CALCULES' = LTPS ;",
    "'PASAPAS' TAB1 ;",
    "It leaves tractions in TAB1 . 'CONTRAINTES' and the state variables above",
    "in TAB1 . 'VARIABLES_INTERNES', by time.",
)
"""A run with model and material, as comments because it needs the solids."""


def _castem(block: Block, law: str, wet: bool) -> list[str]:
    """Lines of Gibiane that define model and material of a joint of Cast3M, whose names have four letters.

    KS and KN are those of the operator with which Cast3M iterates.
    """
    props, element = block.props, "JOI4" if block.dimension == 3 else "JOI2"
    constants, variables = property_names(law), property_names(law, "InternalStateVariables")
    leading = {"KS": block.stiffness[0], "KN": block.stiffness[1], "RHO": 0.0, "ALPN": 0.0}
    constants_of_law = {
        f"A{i:02}": float(props[contract.index(constant)]) for i, constant in enumerate(constants, 1)
    }
    values = leading | constants_of_law
    states = [f"V{i:03}" for i in range(1, len(variables) + 1)]
    return [
        *(f"* {short}: {name}" for short, name in zip(constants_of_law, constants, strict=True)),
        *(f"* {short}: {name}" for short, name in zip(states, variables, strict=True)),
        "COEL = 'MOTS'",
        *_in_lines([f"'{short}'" for short in values]),
        "STAT = 'MOTS'",
        *_in_lines([f"'{short}'" for short in states]),
        *(["PARA = 'MOTS' 'T' 'PF' ;"] if wet else []),
        f"MODL = 'MODELISER' {block.name} 'MECANIQUE' 'ELASTIQUE' 'ISOTROPE'",
        "  'NON_LINEAIRE' 'UTILISATEUR'",
        f"  'LIB_LOI' '{generic_library().name}'",
        f"  'FCT_LOI' '{law}'",
        "  'C_MATERIAU' COEL 'C_VARINTER' STAT" + (" 'PARA_LOI' PARA" if wet else ""),
        f"  'CONS' 'JOINT' '{element}' ;",
        "MATL = 'MATERIAU' MODL",
        *_in_lines([f"'{short}' {value!r}" for short, value in values.items()], 2),
    ]


def _in_lines(words: Sequence[str], per_line: int = 6) -> list[str]:
    """Words in lines of at most 72 columns, as Gibiane reads no more; the last one ends the instruction."""
    lines = ["  " + " ".join(words[i : i + per_line]) for i in range(0, len(words), per_line)]
    return [*lines[:-1], f"{lines[-1]} ;"]

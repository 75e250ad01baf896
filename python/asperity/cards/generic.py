"""Blocks with a behaviour of libasperity_generic: of OpenGeoSys, MTest (TFEL) and Cast3M."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from xml.sax.saxutils import escape

import numpy as np

from .. import contract
from ..installed import generic_library
from ..pattern import direction_vector
from ..steps import Step, prescribed

AXES = {2: ("0 1", "-1 0"), 3: ("0 0 1", "1 0 0", "0 1 0")}
"""N, Tx, Ty of a horizontal layer, by dimension.  In two dimensions they are right-handed, too."""

FORCES, OPENINGS = ("Tn", "Tt1", "Tt2"), ("Un", "Ut1", "Ut2")  # names of N, Tx, Ty in MTest


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


def mtest_head(law: str, props: contract.Floats, comments: Sequence[str]) -> str:
    """Behaviour and all its material properties, after comments; it has no external state variable."""
    values = {name: float(props[contract.index(name)]) for name in property_names(law)}
    head = "@ModellingHypothesis 'Tridimensional';", f"@Behaviour<generic> '{generic_library()}' '{law}';"
    given = (f"@MaterialProperty<constant> '{name}' {value!r};" for name, value in values.items())
    return "\n".join([*comments, *head, *given]) + "\n"


def castem(name: str, law: str, props: contract.Floats, stiffness: Sequence[float]) -> list[str]:
    """Lines of Gibiane that define model and material of a joint of Cast3M, whose names have four letters.

    stiffness: in shear and in opening, of the operator with which Cast3M iterates.
    """
    constants, variables = property_names(law), property_names(law, "InternalStateVariables")
    leading = {"KS": stiffness[0], "KN": stiffness[1], "RHO": 0.0, "ALPN": 0.0}
    own = {f"A{i:02}": float(props[contract.index(one)]) for i, one in enumerate(constants, 1)}
    values = leading | own
    states = [f"V{i:03}" for i in range(1, len(variables) + 1)]
    return [
        *(f"* {short}: {one}" for short, one in zip(own, constants, strict=True)),
        *(f"* {short}: {one}" for short, one in zip(states, variables, strict=True)),
        "COEL = 'MOTS'",
        *_in_lines([f"'{one}'" for one in values]),
        "STAT = 'MOTS'",
        *_in_lines([f"'{one}'" for one in states]),
        f"MODL = 'MODELISER' {name} 'MECANIQUE' 'ELASTIQUE' 'ISOTROPE'",
        "  'NON_LINEAIRE' 'UTILISATEUR'",
        f"  'LIB_LOI' '{generic_library().name}'",
        f"  'FCT_LOI' '{law}'",
        "  'C_MATERIAU' COEL 'C_VARINTER' STAT",
        "  'CONS' 'JOINT' 'JOI4' ;",
        "MATL = 'MATERIAU' MODL",
        *_in_lines([f"'{one}' {value!r}" for one, value in values.items()], 2),
    ]


def _in_lines(words: Sequence[str], per_line: int = 6) -> list[str]:
    """Words in lines of at most 72 columns, as Gibiane reads no more; the last one ends the instruction."""
    lines = ["  " + " ".join(words[i : i + per_line]) for i in range(0, len(words), per_line)]
    return [*lines[:-1], f"{lines[-1]} ;"]


def mtest_path(steps: Sequence[Step]) -> str:
    """Evolutions of the prescribed components, and times.

    steps: of a case that was read, with lists of all targets, increments and times. Raises ValueError for
    what MTest cannot take.
    """
    kinds = set(prescribed(steps))
    if len(kinds) != 1:
        raise ValueError(
            f"steps with {len(kinds)} sets of prescribed components: expected one for mtest, the same "
            "tractions and separations in all steps"
        )
    [tractions] = kinds
    times, values, numbers = [0.0], [np.zeros(3)], []
    for number, step in enumerate(steps, 1):
        if step.follow == "branch":
            raise ValueError(f"step {number}: follow = 'branch': expected 'stable' for mtest")
        for name in ("k_N", "k_Tx", "k_Ty"):
            if getattr(step, name):
                raise ValueError(f"step {number}: {name} = {getattr(step, name):g}: expected 0 for mtest")
        if step.p is not None and any(step.p):
            raise ValueError(f"step {number}: p = {max(step.p):g}: expected no water for mtest")
        targets = {
            i: given
            for i, axis in enumerate(("N", "Tx", "Ty"))
            if (given := getattr(step, f"{'t' if tractions[i] else 's'}_{axis}")) is not None
        }
        if step.slip is not None:
            targets[1], targets[2] = np.outer(direction_vector(step.direction), step.slip)
        for k, duration in enumerate(step.time):
            values.append(values[-1].copy())
            for i, one in targets.items():
                values[-1][i] = one[k]
            times.append(times[-1] + duration)
            numbers.append(round(step.increments[k]))
    lines = []
    for i, column in enumerate(np.array(values).T):
        keyword, name = (
            ("@ImposedCohesiveForce", FORCES[i])
            if tractions[i]
            else ("@ImposedOpeningDisplacement", OPENINGS[i])
        )
        pairs = ", ".join(
            f"{time!r} : {float(value) + 0.0!r}" for time, value in zip(times, column, strict=True)
        )
        lines.append(f"{keyword} '{name}' {{{pairs}}};")
    parts = ", ".join(f"{time!r} in {n}" for time, n in zip(times[1:], numbers, strict=True))
    return "\n".join([*lines, f"@Times {{0.0, {parts}}};"]) + "\n"

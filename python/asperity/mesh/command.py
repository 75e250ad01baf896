"""Command `asperity mesh`: joints in a mesh of gmsh, Abaqus or VTK, written for a host."""

from __future__ import annotations

import argparse
import re
from pathlib import Path

import numpy as np

from ..hosts import hosts
from ..options import add_options, add_output, check_outputs

START = r".{,250}mesh with joints of asperity"
"""Start of a file that this command writes."""


ENDINGS = tuple(dict.fromkeys(host.mesh.ending for host in hosts("mesh").values() if host.mesh))
"""Endings of the output."""


def add_arguments(mesh: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    mesh.description = (
        "Double the nodes of a mesh along joints. The joints are the faces between blocks (physical groups, "
        "cell sets), or the named faces of --joint."
    )
    choices = {"choices": tuple(hosts("mesh"))}
    rules = (
        "NAME: a group of faces; NAME=A:B: faces between blocks that match A and B (default: joint=*:*); "
        "NAME=A~B: faces of the group A and, a period away, of B"
    )
    add_options(
        mesh,
        ("mesh MESH", "mesh: .msh of gmsh, .inp of Abaqus, .vtu or another one that meshio reads", Path),
        ("--joint RULE", rules, list),
        ("--law NAME=CASE.nml", "constants of a joint, whose material is written, too", list),
        (
            "--blocks A,B,...",
            "groups that are blocks, or cell data with their numbers (default: all groups)",
            str,
        ),
        ("--join TOL", "distance of nodes that become one; 0: blocks without common nodes stay apart", float),
        ("--direction X", "of a vector: Tx is its projection onto the joint", float, {"nargs": "+"}),
        (
            "--host",
            "default: by the ending of the output",
            str,
            choices,
        ),
        (
            "--axisymmetric",
            "the mesh is the section (r, z) of a body of revolution, for hosts with joints of it",
        ),
        ("--layer H", "thickness of the solids that are joints in CalculiX and OpenGeoSys", 0.0),
    )
    add_output(mesh, "FILE", "mesh with joints, whose ending chooses the host", Path)
    mesh.set_defaults(action=_mesh)


def _mesh(options: argparse.Namespace) -> int:
    """Split the mesh, write it and print its counts."""
    from ..case_files import read_run
    from ..model_checks import shown_warnings
    from .hosts import beside, endings, of_ending, write
    from .split import split

    if options.output is None:
        raise ValueError(f"-o: expected the name of the mesh to write, {', '.join(endings(options.host))}")
    ending = options.output.suffix
    able = of_ending(ending)
    if not able:
        raise ValueError(f"-o {options.output}: expected a name that ends in {', '.join(ENDINGS)}")
    host = options.host or able[0]
    if host not in able:
        raise ValueError(f"-o {options.output}: expected another ending for --host {host}")
    kind = hosts("mesh")[host].mesh
    materials = (
        [("-o", options.output.with_suffix(kind.materials), kind.start)]
        if kind and kind.materials and options.law
        else []
    )
    check_outputs(options.force, [options.mesh], ("-o", options.output, START), *materials)
    if options.join is not None and not 0.0 <= options.join < np.inf:
        raise ValueError(f"--join {options.join:g}: expected a distance >= 0")
    rules: dict[str, list[str] | dict[str, str] | None] = {}
    for text in options.joint:
        match = re.fullmatch(r"([^:~=]+)(?:=([^:~]+)([:~])([^:~]+))?", text)
        if not match:
            raise ValueError(f"--joint {text}: expected NAME, NAME=A:B or NAME=A~B")
        name, first, sign, second = match.groups()
        if name in rules:
            raise ValueError(f"--joint {text}: {name} is given twice: expected one rule for each name")
        rules[name] = {first: second} if sign == "~" else [first, second] if first else None
    if options.direction is not None and not (
        len(options.direction) in (2, 3) and np.linalg.norm(options.direction) > 0.0
    ):
        raise ValueError(f"--direction {options.direction}: expected two or three components, not all zero")
    laws = {}
    for text in options.law:
        name, equals, case = text.partition("=")
        if not equals:
            raise ValueError(f"--law {text}: expected NAME=CASE.nml")
        if name in laws:
            raise ValueError(f"--law {text}: {name} is given twice: expected one case for each joint")
        laws[name] = read_run(Path(case), None).interface
    with shown_warnings():
        mesh = split(
            options.mesh, rules or None, options.blocks, options.direction, options.join, options.axisymmetric
        )
        groups = [("-o", file, START) for file in beside(options.output, mesh, host)]
        check_outputs(options.force, [options.mesh], *groups)
        files = write(options.output, mesh, options.host, laws, options.layer)
    print(mesh.summary())
    print(*files, sep="\n")
    return 0

"""Meshes with joints as input of host programs."""

from __future__ import annotations

import re
import warnings
from collections.abc import Mapping
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from .. import hosts
from ..contract import Floats
from ..material import ModelWarning
from .jointed import Jointed
from .shapes import corner_sizes, corners, place
from .writing import layer_points

if TYPE_CHECKING:
    from ..interface import Interface

LABEL = r"[A-Za-z_][\w-]*"
"""Names that most hosts can read: those of Abaqus/CAE, too."""

UNEVEN = 0.02
"""Relative error of the thickness of a layer, as at corners of a curved joint, above which one is told."""


def write(
    path: Path | str,
    mesh: Jointed,
    host: str | None = None,
    laws: Mapping[str, Interface] | None = None,
    layer: float = 0.0,
) -> list[Path]:
    """Write a mesh for a host and return the files.

    host: one of `asperity.hosts`, vtu for ParaView; by default the first of the ending of the file.
    laws: of joints by name, whose material blocks are written, too.  layer: thickness of the solids by which
    CalculiX and OpenGeoSys represent joints.

    Raises ValueError for a law without a joint, for elements that the host does not have, and for layers that
    are too thick.
    """
    path, laws = Path(path), dict(laws or {})
    known = hosts.hosts("mesh")
    host = host or next(iter(of_ending(path.suffix)), None)
    if host not in known:
        raise ValueError(f"{path}: host {host}: expected one of {', '.join(known)}")
    kind: hosts.Mesh = hosts.of(host, "mesh")
    if unknown := sorted(set(laws) - set(mesh.joints)):
        raise ValueError(f"law of {unknown[0]}: expected a joint of the mesh: {', '.join(mesh.joints)}")
    if kind.layer != (layer > 0.0):
        wanted = "the thickness of its layers, > 0" if not layer else "none: its joints have no thickness"
        raise ValueError(f"layer = {layer:g}: expected {wanted}, for {host}")
    if kind.labels:
        mesh, laws = _as_labels(mesh, laws)
    for label in (*mesh.names, *mesh.joints, *mesh.groups, *mesh.sets, *mesh.surfaces):
        if kind.labels and not re.fullmatch(LABEL, label, re.ASCII):
            raise ValueError(
                f"name {label!r}: expected a letter, then letters, digits, underscores, hyphens, for {host}"
            )
    if mesh.axisymmetric and not kind.axisymmetric:
        able = ", ".join(name for name, entry in known.items() if entry.mesh and entry.mesh.axisymmetric)
        raise ValueError(f"axisymmetric mesh: {host} would read a plane one: expected {able}")
    if kind.linear:
        _check_faces(mesh, host, kind.layer)
    if layer:
        _check_layer(mesh, layer)
    return list(_writer(host).write(path, mesh, laws, layer, host))


def beside(path: Path, mesh: Jointed, host: str) -> list[Path]:
    """Files of groups that `write` writes beside that of a mesh."""
    module = _writer(host)
    return list(module.beside(path, mesh)) if hasattr(module, "beside") else []


def _writer(host: str) -> ModuleType:
    """Module that writes meshes of a host: its own, or that of the ending."""
    kind: hosts.Mesh = hosts.of(host, "mesh")
    return hosts.part(host, "mesh") or import_module(f"{__package__}.{kind.ending[1:]}")


def _as_labels(mesh: Jointed, laws: dict[str, Interface]) -> tuple[Jointed, dict[str, Interface]]:
    """Mesh and laws with _ for what names of hosts cannot have; ValueError where two names become one."""
    groups = mesh.joints, mesh.groups, mesh.sets, mesh.surfaces
    labels = list(dict.fromkeys(name for names in (mesh.names, *groups) for name in names))
    new = {name: re.sub(r"[^\w-]+", "_", name, flags=re.ASCII).strip("_") or name for name in labels}
    changed = [name for name in labels if not re.fullmatch(r"[\w-]+", name, re.ASCII)]
    if not changed:
        return mesh, laws
    new |= {name: name for name in labels if name not in changed}
    for name in changed:
        if alike := [other for other in labels if other != name and new[other] == new[name]]:
            raise ValueError(f"names {name!r} and {alike[0]!r} both become {new[name]}: expected other names")
    text = ", ".join(f"{name!r} is {new[name]}" for name in changed)
    warnings.warn(f"names in the file: {text}", ModelWarning, stacklevel=3)
    joints = {new[name]: parts for name, parts in mesh.joints.items()}
    faces = {new[name]: parts for name, parts in mesh.groups.items()}
    sets, surfaces = ({new[name]: rows for name, rows in table.items()} for table in groups[2:])
    names = [new[name] for name in mesh.names]
    renamed = replace(mesh, names=names, joints=joints, groups=faces, sets=sets, surfaces=surfaces)
    return renamed, {new[name]: law for name, law in laws.items()}


def of_ending(ending: str) -> list[str]:
    """Hosts whose meshes have this ending, the default one first."""
    meshes = {name: entry.mesh for name, entry in hosts.hosts("mesh").items() if entry.mesh}
    return sorted(
        (name for name in meshes if meshes[name].ending == ending), key=lambda k: not meshes[k].default
    )


def endings(host: str | None = None) -> list[str]:
    """Endings of meshes of all hosts, or of one."""
    kinds = [hosts.of(host, "mesh")] if host else [entry.mesh for entry in hosts.hosts("mesh").values()]
    return sorted({kind.ending for kind in kinds if kind})


def _check_faces(mesh: Jointed, host: str, layer: bool) -> None:
    """Raise ValueError for joints between faces that are not linear, or a period apart.

    Joints that a file has itself may have a thickness, which a host without layers keeps.
    """
    for name, joint in ((name, part) for name, parts in mesh.joints.items() for part in parts):
        count, k = joint.minus.shape
        if corners(mesh.dimension, k) != k:
            raise ValueError(f"joint {name}: {count} faces of {k} nodes: expected linear ones for {host}")
        x = mesh.points[joint.minus]
        apart = float(np.linalg.norm(mesh.points[joint.plus] - x, axis=2).max(initial=0.0))
        edge = float(np.linalg.norm(np.roll(x, 1, axis=1) - x, axis=2).min(initial=np.inf))
        if apart > 0.0 and (layer or apart >= edge):
            raise ValueError(f"joint {name}: its sides are {apart:g} apart: expected one place for {host}")


def _check_layer(mesh: Jointed, h: float) -> None:
    """Raise ValueError for a layer that does not fit into the cells; warn of tips and other thicknesses."""
    points = layer_points(mesh, h)
    centres = np.concatenate([mesh.points[cells].mean(1) for cells in mesh.cells.values()])
    for name, joint in ((name, part) for name, parts in mesh.joints.items() for part in parts):
        away = centres[joint.cells] - mesh.points[joint.minus].mean(1)[:, None]
        most = 2.0 * float(np.abs(np.einsum("fsd,fd->fs", away, joint.axes[:, 0])).min())
        if h >= most:
            raise ValueError(f"layer = {h:g}: expected less than {most:.3g}, for the cells at joint {name}")
        across = np.einsum("fkd,fd->fk", points[joint.plus] - points[joint.minus], joint.axes[:, 0])
        error: Floats = np.where(joint.minus == joint.plus, 0.0, np.abs(across - h))
        bad = np.flatnonzero((error > UNEVEN * h).any(1))
        if len(bad):
            face, node = np.unravel_index(error.argmax(), error.shape)
            where = f"as at {place(mesh.points[joint.minus[face, node]])} {across[face, node]:.3g}"
            text = f"layer = {h:g}: {len(bad)} of {len(error)} faces of joint {name} have other thicknesses"
            text = f"{text}, {where}, as faces meet at sharp angles"
            if (across[joint.minus != joint.plus] <= 0.0).any():
                raise ValueError(f"{text}: expected joints that cross at larger angles")
            text = f"{text}: their separations are wrong by that factor"
            warnings.warn(text, ModelWarning, stacklevel=3)
        if joint.tips:
            text = f"joint {name} ends inside the mesh, where its layer has no thickness: its last elements"
            warnings.warn(f"{text} are too stiff, and break too early", ModelWarning, stacklevel=3)
    for kind, cells in mesh.cells.items():
        turned = (corner_sizes(kind, points[cells]) <= 0.0) & (corner_sizes(kind, mesh.points[cells]) > 0.0)
        if len(bad := np.flatnonzero(turned.any(1))):
            where = place(mesh.points[cells[bad[0]]].mean(0))
            text = f"layer = {h:g}: {len(bad)} cells, as at {where}, would be inside out"
            raise ValueError(f"{text}: expected a thinner layer, or larger cells there")

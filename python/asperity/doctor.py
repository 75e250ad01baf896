"""Command `asperity doctor`: whether what is installed works together, hosts of this machine, decks."""

from __future__ import annotations

import argparse
import ctypes
import importlib.metadata
import os
import platform
import shutil
import subprocess
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import numpy as np

from . import contract, installed
from .hosts import Host, hosts
from .interface import Interface
from .material import Material
from .mesh.deck_joints import judged
from .pattern import Pattern

TOOLS = ("scipy", "matplotlib", "tqdm", "pandas", "pint", "openpyxl")
"""Packages of the toolbox, which `pip install 'asperity[tools]'` brings."""

LONGEST_VERSION = 32  # characters of the version, with the final null
KERNELS = {0: "the platform of the build", 1: "any x86-64", 3: "x86-64-v3 (AVX2)"}  # meaning of asperity_isa
ROUNDING = 1.0e-9  # largest relative difference between the library and closed forms


class Finding(NamedTuple):
    """Line of the report; good is None where nothing is required."""

    name: str
    text: str
    good: bool | None = None


def add_arguments(doctor: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    doctor.description = (
        "Check the installation and look for host programs, or check the joints of a deck: constants, state "
        "variables, sections and water; exit code 1: something is wrong."
    )
    doctor.add_argument("deck", metavar="DECK.inp", nargs="?", type=Path, help="input of Abaqus or CalculiX")
    doctor.set_defaults(action=_run)


def _run(options: argparse.Namespace) -> int:
    results = list(of_deck(options.deck) if options.deck else findings())
    for result in results:
        mark = {True: "ok", False: "WRONG", None: ""}[result.good]
        print(f"{result.name:<12}{mark:<6} {result.text}")
    return int(any(result.good is False for result in results))


def of_deck(path: Path) -> Iterator[Finding]:
    """Findings of a deck; raises ValueError for one that is not read or has no joint."""
    judgement = judged(path)
    yield from (Finding("deck", text) for text in judgement.lines)
    yield from (Finding("deck", text, False) for text in judgement.wrong)
    yield from (Finding("doubt", text, False) for text in judgement.doubtful)
    yield from (Finding("warning", text) for text in judgement.notes)
    if not (judgement.wrong or judgement.doubtful):
        yield Finding("deck", f"{path}: constants, state variables, sections and water agree", True)


def findings() -> Iterator[Finding]:
    """Findings in the order of the report."""
    version = contract.library_version()
    yield Finding("asperity", f"{version} in {installed.library().parent}", True)
    yield _library(version)
    yield _driver(version)
    yield Finding("sources", f"for Abaqus: {installed.abaqus()}")
    yield _law()
    yield Finding("python", f"{platform.python_version()}, {platform.platform()}")
    yield Finding("numpy", np.__version__, True)
    for name in TOOLS:
        try:
            yield Finding(name, importlib.metadata.version(name), True)
        except importlib.metadata.PackageNotFoundError:
            yield Finding(name, "not installed: the toolbox needs it (pip install 'asperity[tools]')")
    yield _threads()
    for host in sorted(hosts().values(), key=lambda host: bool(host.programs)):
        if host.module or host.programs:
            yield Finding(host.title, _of_host(host))
    yield Finding(
        "gfortran", shutil.which("gfortran") or "not found on PATH: user materials of hosts need it"
    )


def _library(version: str) -> Finding:
    """Whether the shared library loads and is of the version of the extension module."""
    try:
        path = installed.library()
        text = ctypes.create_string_buffer(LONGEST_VERSION)
        library = ctypes.CDLL(str(path))
        library.asperity_version(text, LONGEST_VERSION)
        compiled = text.value.decode()
        kernels = KERNELS.get(library.asperity_isa(), "unknown")
    except (OSError, AttributeError) as error:
        return Finding("library", f"{error}", False)
    return Finding("library", f"{compiled}, kernels for {kernels}, {path}", compiled == version)


def _driver(version: str) -> Finding:
    try:
        path = installed.driver()
        told = subprocess.run([path, "--version"], capture_output=True, text=True, check=True).stdout
        compiled = told.split()[-1]
    except (OSError, subprocess.CalledProcessError, IndexError) as error:
        return Finding("driver", f"{error}", False)
    return Finding("driver", f"{compiled}, {path}", compiled == version)


def _of_host(host: Host) -> str:
    """Whether a host is here, and how its Python packages are installed."""
    if not host.module:
        paths = [path for path in map(shutil.which, host.programs) if path]
        return paths[0] if paths else f"{host.programs[0]} not found on PATH"
    if find_spec(host.module):
        return f"module {host.module} found"
    packages = " ".join(f"'{name}'" for name in host.packages)
    return f"module {host.module} not found" + (f" (pip install {packages})" if packages else "")


def _law() -> Finding:
    """Whether the library agrees with closed forms: opening, the residual strength and its dilation."""
    material, theta, pressure = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=1.0e4), 30.0, 0.5
    opening = np.linspace(0.0, 1.5 * material.s_f, 61)
    pulled = Interface(material, Pattern.regular(0, 0.0)).replay(opening[:, None] * [1.0, 0.0, 0.0])
    triangle = np.interp(opening, [0.0, material.s_0, material.s_f], [0.0, material.sigma0, 0.0])
    joint = Interface(material, Pattern.regular(2, theta, flat=0.0))
    sheared = joint.confined_slip(0.0, np.linspace(0.0, 5.0 * material.s_f, 201), -pressure)
    strength = pressure * float(material.residual_strength(theta))
    slope = (sheared.dilation[-1] - sheared.dilation[-2]) / (5.0 * material.s_f / 200)
    difference = max(
        float(np.abs(pulled.traction[:, 0] - triangle).max()) / material.sigma0,
        abs(float(sheared.traction[-1, 1]) / strength - 1.0),
        abs(float(slope) / np.tan(np.radians(theta)) - 1.0),
    )
    return Finding("law", f"differs from closed forms by {difference:.0e}", difference < ROUNDING)


def _threads() -> Finding:
    """Processors, and the variables that set the number of threads."""
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    variables = [f"{name}={os.environ[name]}" for name in ("OMP_NUM_THREADS",) if name in os.environ]
    return Finding("threads", ", ".join([f"{usable} of {os.cpu_count()} processors usable", *variables]))

"""Files that are installed with the package."""

from __future__ import annotations

import argparse
import os
import sys
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

DRIVER_VARIABLE = "ASPERITY_DRIVER"  # environment variable with the path of another driver


def needed(extra: str, *modules: str) -> None:
    """Raise ModuleNotFoundError that names an extra if one of its modules is not installed."""
    missing = [name for name in modules if find_spec(name) is None]
    if missing:
        text = f"{', '.join(missing)} not installed: pip install 'asperity[{extra}]' brings what is needed"
        raise ModuleNotFoundError(text, name=missing[0])


def library() -> Path:
    """Path of the shared library: symbols umat_ and those of asperity.h."""
    return named_library("asperity")


def generic_library() -> Path:
    """Path of the library of "generic" behaviours, which programs with MGIS load."""
    return named_library("asperity_generic")


def abaqus() -> Path:
    """Folder of the single source files for Abaqus."""
    return _installed("abaqus/asperity_abaqus.f90").parent


def run_driver() -> None:
    """Program `rie_driver` on the search path: the driver of the package, with the same arguments."""
    path = str(driver())
    os.execv(path, [path, *sys.argv[1:]])


def driver() -> Path:
    """Path of the driver rie_driver: the value of the variable ASPERITY_DRIVER, or the installed driver."""
    chosen = os.environ.get(DRIVER_VARIABLE)
    if chosen is None:
        return _installed("rie_driver.exe" if sys.platform == "win32" else "rie_driver")
    if not Path(chosen).is_file():
        raise FileNotFoundError(f"{DRIVER_VARIABLE} = {chosen}: expected the path of rie_driver")
    return Path(chosen)


def all_cases() -> dict[str, Path]:
    """Case files by name: the file name without suffix, with its folder where it has one."""
    folder = _installed("cases/figure05b.nml").parent
    return {
        path.relative_to(folder).with_suffix("").as_posix(): path for path in sorted(folder.rglob("*.nml"))
    }


def named_case(name: str) -> Path:
    """Case file of a name, with or without folder; raises ValueError for an unknown one."""
    for known, path in all_cases().items():
        if name in (known, path.stem):
            return path
    raise ValueError(f"{name}: expected a case file, or a name that `asperity cases` lists")


def case_file(text: str) -> Path:
    """Case file that an argument of a command names, by its path or as `asperity cases` lists it."""
    path = Path(text)
    if path.is_file() or path.suffix:
        return path
    try:
        return named_case(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(error) from None


def named_library(name: str) -> Path:
    """Path of a shared library of the package."""
    suffix = {"darwin": ".dylib", "win32": ".dll"}.get(sys.platform, ".so")
    return _installed(f"lib{name}{suffix}")


def _installed(name: str) -> Path:
    path = Path(str(files(__package__) / name))
    if not path.is_file():
        raise FileNotFoundError(f"{path}: expected to be installed with the package")
    return path

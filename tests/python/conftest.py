"""What all Python tests share: their order, threads of linear algebra, fixtures of driver, command, UMATs."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

# The workers of pytest share the cores already. NumPy reads this when it is imported, which comes later;
# commands start as many processes as there are processors.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from asperity import installed
from asperity.cli import main
from support_driver import Result, call
from support_umat import ATTACKER

os.cpu_count = lambda: 1


ROOT = Path(__file__).parents[2]


def pytest_configure() -> None:
    """The tests try the installed package: they end where it is older than the sources."""
    stamp, package = ROOT / ".venv" / "installed", Path(installed.__file__).parent
    if not stamp.exists() or ROOT / ".venv" not in package.parents:
        return
    built = (*ROOT.glob("src/**/*.[fch]*"), *ROOT.glob("harness/driver/*"), *ROOT.glob("python/*.pyf"))
    stale = [file for file in built if file.is_file() and file.stat().st_mtime > stamp.stat().st_mtime]
    for file in ROOT.glob("python/asperity/**/*.py"):
        copy = package / file.relative_to(ROOT / "python" / "asperity")
        if not copy.exists() or copy.read_bytes() != file.read_bytes():
            stale.append(file)
    if stale:
        name = stale[0].relative_to(ROOT)
        pytest.exit(f"the installed package is older than {name}: make .venv/installed", 4)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The files with slow tests come first, so that no worker is left alone with one at the end.

    Before them come those that wait, as the builds beside them have work for every core.  A file stays in one
    piece, as what its tests share is made again otherwise.
    """
    waits, slow = (
        {item.path for item in items if item.get_closest_marker(mark)} for mark in ("waits", "slow")
    )
    items.sort(key=lambda item: (item.path not in waits, item.path not in slow))


@pytest.fixture(scope="session")
def driver() -> Path:
    """Return the path of the driver."""
    return installed.driver().resolve()


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty current folder, and the driver of the package."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("ASPERITY_DRIVER", raising=False)
    return tmp_path


@pytest.fixture
def said(capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[str, str]]:
    """Return a function that runs a command, asserts its exit code and returns what it wrote: out and err."""

    def run_command(command: str, code: int = 0) -> tuple[str, str]:
        capsys.readouterr()
        assert main(shlex.split(command)) == code
        return capsys.readouterr()

    return run_command


@pytest.fixture
def run(driver: Path, tmp_path: Path):
    """Return a function that runs a case given by its text and asserts the exit code."""

    def run_text(text: str | bytes, *options: str, code: int = 0) -> Result:
        case = tmp_path / "case.nml"
        case.write_bytes(text if isinstance(text, bytes) else text.encode())
        output = tmp_path / "case.csv"
        output.unlink(missing_ok=True)
        process = call(driver, "case.nml", *options, folder=tmp_path)
        assert process.returncode == code, process.stderr
        return Result(process, output)

    return run_text


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the path of the library of the planted UMAT."""
    path = tmp_path_factory.mktemp("umat") / "libplanted.so"
    source = ROOT / "harness/examples/planted_umat.f"
    command = ["gfortran", "-ffree-form", "-shared", "-fPIC", "-O1", source, "-o", path]
    subprocess.run(command, check=True, capture_output=True)
    return path


@pytest.fixture(scope="session")
def attackers(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Return a function that compiles an elastic UMAT with a statement, once for all tests that have it."""
    folder, made = tmp_path_factory.mktemp("attackers"), {}

    def compiled(statement: str) -> Path:
        if statement not in made:
            source = folder / f"{len(made)}.c"
            source.write_text(ATTACKER.replace("ATTACK", statement), encoding="utf-8")
            made[statement] = source.with_suffix(".so")
            command = ["gcc", "-shared", "-fPIC", "-w", source, "-o", made[statement], "-lm"]
            subprocess.run(command, check=True)
        return made[statement]

    return compiled


@pytest.fixture
def attacker(tmp_path: Path, attackers: Callable[[str], Path]):
    """Return a function that makes a case of an elastic UMAT with a statement for increments from 4 on."""

    def case(statement: str, limit: float = 0.5) -> str:
        path = tmp_path / "attacker.so"
        # a new file, as a process may still have the old one in its memory
        path.unlink(missing_ok=True)
        shutil.copy(attackers(statement), path)
        return (
            f"&umat library = '{path}', length = 0.01, stiffness = 100, nstatv = 1, limit = {limit} /\n"
            "&step s_N = 0.008, increments = 8 /\n"
        )

    return case

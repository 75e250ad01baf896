"""What all Python tests share: their order, threads of linear algebra, fixtures of driver and command."""

from __future__ import annotations

import os
import shlex
from collections.abc import Callable
from pathlib import Path

import pytest

# The workers of pytest share the cores already. NumPy reads this when it is imported, which comes later;
# commands start as many processes as there are processors.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from asperity import installed
from asperity.cli import main
from support_driver import Result, call

os.cpu_count = lambda: 1


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The slow tests come first, so that no worker is left alone with one at the end."""
    items.sort(key=lambda item: item.get_closest_marker("slow") is None)


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

"""CalculiX for the tests of this folder, which `make hosts` builds first."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from asperity import library

HERE = Path(__file__).parent


@pytest.fixture(scope="session")
def ccx(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Path of a ccx linked with libasperity."""
    folder = HERE.parents[2] / "build" / "calculix"
    if not (folder / "ready").exists():
        pytest.skip("no build/calculix: harness/hosts/calculix/install.sh build/calculix")
    program = tmp_path_factory.mktemp("ccx") / "ccx"
    subprocess.run([HERE / "link.sh", folder, library(), program], check=True)
    return program

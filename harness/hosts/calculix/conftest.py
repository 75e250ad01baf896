"""CalculiX for the tests of this folder.

ASPERITY_LIBRARY names libasperity.so, ASPERITY_CALCULIX the folder for CalculiX, built once from Debian's
source package.  If the source is not available all tests are skipped, with the reason.
"""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).parent

CANNOT = 77
"""Exit code of build.sh if the source is not available or cannot be compiled."""


@pytest.fixture(scope="session")
def ccx(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Path of a ccx linked with libasperity."""
    library, folder = (Path(os.environ[f"ASPERITY_{name}"]).resolve() for name in ("LIBRARY", "CALCULIX"))
    built = subprocess.run([HERE / "build.sh", folder], capture_output=True, text=True, check=False)
    if built.returncode == CANNOT:
        pytest.skip(built.stdout.strip().splitlines()[-1])
    assert built.returncode == 0, built.stdout + built.stderr
    program = tmp_path_factory.mktemp("ccx") / "ccx"
    subprocess.run([HERE / "link.sh", folder, library, program], check=True)
    return program

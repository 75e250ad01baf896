"""The targets that CONTRIBUTING.md names, in a short form where no suite has one."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not (ROOT / ".git").exists() or not shutil.which("make"), reason="sdist, or no make"),
]


def run(*command: str | Path) -> str:
    """Output of a command in the top folder, which must not fail."""
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.long
def test_mutants() -> None:
    """A changed line of the law is compiled, and a suite notices it."""
    arguments = ["--samples", "1", "--jobs", "1", "--suite", "test_kinds", "src/law/asperity_law.inc"]
    table = run(sys.executable, "tools/mutants.py", *arguments).splitlines()
    assert re.fullmatch(r"\| `src/law` \| \d+ \| 1 \| 0 \| 1 \| 0 \|", table[-1])


def test_release() -> None:
    """The sdist is made from a clone; it has what builds the package, its tests and the files for Abaqus."""
    listed = Path(run("tools/release.sh", "--dry").splitlines()[-1]).read_text(encoding="utf-8").splitlines()
    files = {name.partition("/")[2] for name in listed}
    needed = [
        "CMakeLists.txt",
        "pyproject.toml",
        "LICENSE",
        "src",
        "harness",
        "python",
        "tests",
        "docs/how-to",
    ]
    committed = run("git", "ls-tree", "-r", "--name-only", "HEAD", *needed).splitlines()
    assert len(committed) > 100 and set(committed) <= files

"""The notebooks of the how-to pages run, and print what they show."""

from __future__ import annotations

import contextlib
import io
import json
from pathlib import Path
from typing import Any

import pytest

HOW_TO = Path(__file__).parents[2] / "docs" / "how-to"


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
@pytest.mark.parametrize("name", sorted(path.name for path in HOW_TO.glob("*.ipynb")))
def test_notebook(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each cell prints as many lines as it shows, with the same words."""
    monkeypatch.chdir(tmp_path)
    cells = json.loads((HOW_TO / name).read_text(encoding="utf-8"))["cells"]
    space: dict[str, Any] = {}
    for cell in cells:
        if cell["cell_type"] != "code":
            continue
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile("".join(cell["source"]), name, "exec"), space)
        shown = "".join("".join(one["text"]) for one in cell["outputs"])
        # digits of a fit differ between machines
        assert _words(printed.getvalue()) == _words(shown)


def _words(text: str) -> list[list[str]]:
    """Words without digits of each line."""
    return [[word for word in line.split() if not any(map(str.isdigit, word))] for line in text.splitlines()]

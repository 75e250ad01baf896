"""Run the examples of pages of docs in an empty folder and fill in their output.

    .venv/bin/python tests/python/refresh.py docs/how-to/surface.md docs/how-to/tutorial.md

A fenced block that is followed by a text block is run: python, py and commands of asperity by this Python,
other lines by the shell, where ASPERITY is the folder of the project.  A text block directly after the fenced
block is replaced by the output.  A text block with prose in between is an excerpt: each of its lines is
replaced by the line of the output (or of the file after -o) that differs from it in numbers only.  Files of
docs/images that the page names are copied.  Numbers in prose do not change: the tests of the pages report
those that are out of date.
Notebooks, such as docs/how-to/rock-joint.ipynb, have what their cells print now.
"""

from __future__ import annotations

import contextlib
import difflib
import io
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

from asperity.cli import main as main_of_asperity

ROOT = Path(__file__).parents[2]
FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")


def printed_by_cells(cells: list[dict[str, Any]]) -> Iterator[tuple[dict[str, Any], str]]:
    """Cells with code of a notebook, which run here one after the other, and what each prints."""
    space: dict[str, Any] = {}
    for cell in cells:
        if cell["cell_type"] == "code":
            printed = io.StringIO()
            with contextlib.redirect_stdout(printed):
                exec(compile("".join(cell["source"]), cell["id"], "exec"), space)
            yield cell, printed.getvalue()


def notebook(page: Path, folder: Path) -> str:
    """Text of the notebook with what its cells print in the given folder."""
    content = json.loads(page.read_text(encoding="utf-8"))
    with _inside(folder):
        for cell, printed in printed_by_cells(content["cells"]):
            stream = {"name": "stdout", "output_type": "stream", "text": printed.splitlines(True)}
            cell["outputs"] = [stream] if printed else []
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


@contextlib.contextmanager
def _inside(folder: Path) -> Iterator[None]:
    """Make a folder the current one in a block."""
    here = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(here)


def follow(page: Path, folder: Path, hosts: bool = True) -> str:
    """Text of the page with the output of its commands, which run in the given folder; hosts need not run."""
    text = page.read_text(encoding="utf-8")
    blocks = list(FENCE.finditer(text))
    pieces, done = [], 0
    for block, after in pairwise(blocks):
        if block[1] == "text" or after[1] != "text" or (not hosts and "harness/hosts" in block[2]):
            continue
        print(f"{page.name}:{text.count(chr(10), 0, block.start()) + 1}", file=sys.stderr, flush=True)
        printed = _run(block[1], block[2], folder)
        if text[block.end() : after.start()].strip():
            output = re.search(r" -o (\S+\.(?:json|xml|csv|txt))", block[2])
            written = printed + ((folder / output[1]).read_text(encoding="utf-8") if output else "")
            printed = _excerpt(after[2], written)
        pieces += [text[done : after.start(2)], printed]
        done = after.end(2)
    return "".join([*pieces, text[done:]])


def _run(language: str, code: str, folder: Path) -> str:
    """Output of a block, which must end with exit code 0.

    Python and commands of asperity alone run here, as each process would import all again.
    """
    commands, printed = code.replace("\\\n", " ").splitlines(), io.StringIO()
    python = language in ("python", "py")
    if python or all(re.fullmatch(r"asperity [-\w ./=,]+", command) for command in commands):
        status: object = 0
        with _inside(folder), contextlib.redirect_stdout(printed):
            try:
                if python:
                    exec(compile(code, "block", "exec"), {"__name__": "__main__"})
                else:
                    status = next(filter(None, (main_of_asperity(shlex.split(c)[1:]) for c in commands)), 0)
            except SystemExit as end:
                status = f"ended by itself with {end.code}"
        if status != 0:
            raise SystemExit(f"{code}\n{printed.getvalue()}{status}")
        return printed.getvalue()
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    env = os.environ | {"PATH": path, "ASPERITY": str(ROOT), "PYTHONPATH": str(ROOT), "MPLBACKEND": "Agg"}
    ended = subprocess.run(
        ["sh", "-ec", code], capture_output=True, text=True, cwd=folder, env=env, check=False
    )
    if ended.returncode != 0:
        raise SystemExit(f"{code}\n{ended.stdout}{ended.stderr}")
    return ended.stdout


def _excerpt(shown: str, printed: str) -> str:
    """Replace the lines of an excerpt by those of the output, in their order; of JSON the strings."""
    lines = [
        text for line in printed.splitlines() for text in dict.fromkeys((line.rstrip(), line.strip('", ')))
    ]
    renewed, at = [], 0
    for line in shown.splitlines():
        same = [i for i in range(at, len(lines)) if _key(lines[i]) == _key(line)]
        if not same:
            raise SystemExit(f"not printed any more: {line}")
        renewed.append(lines[same[0]])
        at = same[0] + 1
    return "\n".join(renewed) + "\n"


def words_and_numbers(text: str) -> tuple[str, list[float]]:
    """Text with # in place of its numbers, and the numbers."""
    return NUMBER.sub("#", text), [float(number) for number in NUMBER.findall(text)]


def _key(line: str) -> str:
    """Line without its numbers and blanks."""
    return "".join(NUMBER.sub("#", line).split())


def main(names: list[str]) -> None:
    """Refresh pages and their files."""
    for page in map(Path, names):
        with tempfile.TemporaryDirectory() as name:
            made_anew = notebook if page.suffix == ".ipynb" else follow
            old, new = page.read_text(encoding="utf-8"), made_anew(page, Path(name))
            page.write_text(new, encoding="utf-8")
            sys.stdout.writelines(difflib.unified_diff(old.splitlines(True), new.splitlines(True), n=0))
            for file in sorted(set(re.findall(r"\(\.\./(images/[\w.]+)\)", new))):
                made = Path(name) / Path(file).name
                if made.exists():
                    shutil.copy(made, ROOT / "docs" / file)
                    print(ROOT / "docs" / file)


if __name__ == "__main__":
    main(sys.argv[1:])

"""Codes and programs that tests run on ranks of MPI, and what each rank stores in the dictionary `results`.

The ranks stay for the next code, as `waiting_ranks` says.
"""

from __future__ import annotations

import atexit
import json
import os
import shlex
import subprocess
import tempfile
from dataclasses import dataclass
from functools import cache
from typing import IO

import pytest

from harness.studies.validation.wall_runs import PYTHON, ROOT, launch

ANSWER = "answer: "
"""What stands before an answer of ranks that wait."""

WITH_FENICSX = pytest.mark.skipif(
    not PYTHON.exists(), reason="no build/fenicsx: harness/hosts/fenicsx/install.sh"
)

SEVERAL_RANKS = pytest.mark.ranks
"""Mark of a test that needs more than one rank, for which it is run alone."""
RANKS = [1, pytest.param(2, marks=SEVERAL_RANKS)]
"""Numbers of ranks of a test that runs on one and on two."""

MODEL = """
from dataclasses import replace
import numpy as np
from asperity import Interface, Material, Pattern
from asperity.fenicsx import *
from asperity.mesh import split
from harness.hosts.structured import grid

law = Interface(Material.from_joint(kn=200.0, ks=80.0, mu=0.5), Pattern.regular(0, 0.0))
mesh = split(grid(range(4), range(3), block=[0, 1])) if COMM.rank == 0 else None

def model(E=2e4, nu=0.2, laws=None, **settings):
    return Model(mesh, laws or {"joint": law}, E, nu, **settings)

def bottom(m):
    return m.dofs(m.x[:, 1] < 1e-6, 0, 1)

def found(terms=None, m=None, **conditions):
    m = m or model()
    return solve(m, State.virgin(m), Conditions(**{"fixed": bottom(m)} | conditions), terms)
"""
"""A model of two blocks."""

WRONG_INPUT = """
for expression in EXPRESSIONS:
    try:
        eval(expression)
        results[expression] = "accepted"
    except ValueError as error:
        results[expression] = str(error)
"""


@cache
def assert_installed() -> None:
    """The solver of this tree is what build/fenicsx has."""
    [installed] = (PYTHON.parents[1] / "lib").glob("python3.*/site-packages/asperity/fenicsx")
    here, there = (
        {file.name: file.read_bytes() for file in folder.glob("*.py")}
        for folder in (ROOT / "python" / "asperity" / "fenicsx", installed)
    )
    assert here == there, "build/fenicsx has another solver: harness/hosts/fenicsx/install.sh build/fenicsx"


@dataclass
class Ranks:
    """Ranks that wait for codes, the file of their messages and the folder of their temporary files."""

    process: subprocess.Popen[str]
    messages: IO[str]
    folder: tempfile.TemporaryDirectory[str]
    count: int = 0

    @classmethod
    def begin(cls, ranks: int) -> Ranks:
        """Start so many ranks."""
        command, environment = launch(shlex.quote(ANSWER), "waiting_ranks", ranks)
        messages = tempfile.TemporaryFile("w+", encoding="utf-8")
        folder, pipe = tempfile.TemporaryDirectory(), subprocess.PIPE
        environment |= {"TMPDIR": folder.name}
        process = subprocess.Popen(
            command, cwd=ROOT, env=environment, stdin=pipe, stdout=pipe, stderr=messages, text=True
        )
        return cls(process, messages, folder)

    def answers(self, code: str, words: str) -> list[dict] | None:
        """What a code does on each rank; None where it ends them."""
        assert self.process.stdin and self.process.stdout
        self.count += 1
        print(json.dumps([code, shlex.split(words)]), file=self.process.stdin, flush=True)
        for line in self.process.stdout:
            # a library may have begun the line
            _, mark, text = line.partition(ANSWER)
            if mark:
                answers: list[dict] = json.loads(text)
                return answers
        return None

    def end(self) -> tuple[int, str]:
        """Wait for the end of the ranks; their exit status and messages."""
        self.process.communicate()
        self.folder.cleanup()
        self.messages.seek(0)
        return self.process.returncode, self.messages.read()


MOST = 8
"""Codes of several ranks before others replace them, at whose end alone PETSc releases what a code leaves."""

WAITING: dict[int, Ranks] = {}
"""Ranks of this process of pytest, by their number."""


@atexit.register
def end_all() -> None:
    """End all ranks."""
    while WAITING:
        WAITING.popitem()[1].end()


def answers_of(code: str, words: str, ranks: int) -> list[dict]:
    """What a code does on each rank; fails with the messages of ranks that it ends."""
    assert_installed()
    beside = ranks > 1 and "PYTEST_XDIST_WORKER" in os.environ
    assert not beside, "several ranks beside other tests: expected SEVERAL_RANKS at the test, and one process"
    if ranks > 1 and ranks in WAITING and WAITING[ranks].count == MOST:
        WAITING.pop(ranks).end()
    if ranks not in WAITING:
        WAITING[ranks] = Ranks.begin(ranks)
    answers = WAITING[ranks].answers(code, words)
    if answers is None:
        status, messages = WAITING.pop(ranks).end()
        raise AssertionError(f"exit {status}: {messages}")
    assert len(answers) == ranks
    return answers


def done_by(
    words: str, name: str = "walls", ranks: int = 1, code: str = ""
) -> subprocess.CompletedProcess[str]:
    """Run a program of this host, or a code, with options, as `start` does, on ranks that wait."""
    program = f"import runpy; runpy.run_module('harness.hosts.fenicsx.{name}', run_name='__main__')"
    answers = answers_of(code or program, words, ranks)
    out, err = ("".join(answer[key] for answer in answers) for key in ("out", "err"))
    return subprocess.CompletedProcess(words, max(answer["status"] for answer in answers), out, err)


def of_each_rank(code: str, ranks: int) -> list[dict]:
    """Results of a code that goes on from the model of two blocks, by rank."""
    answers = answers_of(MODEL + code, "", ranks)
    assert [answer["status"] for answer in answers] == [0] * ranks
    return [answer["results"] for answer in answers]


def of_all_ranks(code: str, ranks: int) -> dict:
    """Results that are the same on all ranks."""
    first, *others = of_each_rank(code, ranks)
    assert others == [first] * len(others)
    return first


def assert_refused(expected: dict[str, str], code: str, ranks: int) -> None:
    """Every rank refuses each expression by one line, which contains what is expected."""
    for texts in of_each_rank(code + WRONG_INPUT.replace("EXPRESSIONS", repr([*expected])), ranks):
        assert texts.keys() == expected.keys()
        assert {name: text for name, text in texts.items() if expected[name] not in text} == {}
        assert not any("\n" in text for text in texts.values())

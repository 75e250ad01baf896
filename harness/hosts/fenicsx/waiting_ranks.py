"""Ranks of MPI that run the codes of tests one after another: most take less time than the import of dolfinx.

Rank 0 reads a line of JSON for each code: the code, and its words, `sys.argv`.  It prints a line with the
mark that the program was given, and what each rank has stored in `results`, printed and returned.  What a
code changes in the modules of the solver, the filters of warnings and the options of PETSc is as before when
the next one begins.  An error that a code does not handle ends all ranks.
"""

from __future__ import annotations

import contextlib
import gc
import io
import json
import sys
import time
import warnings

from asperity.fenicsx import COMM
from petsc4py import PETSc

PAUSE = 0.005
"""Seconds between looks for the next code: a rank that waits in MPI would keep its core from others."""


def order() -> str:
    """Next line, on all ranks; empty at the end."""
    line = sys.stdin.readline() if COMM.rank == 0 else ""
    there = COMM.Ibarrier()
    while not there.Test():
        time.sleep(PAUSE)
    text: str = COMM.bcast(line)
    return text


def answer(code: str, words: list[str]) -> dict[str, object]:
    """Run a code on this rank; what it stores and prints, and its exit status."""
    options, given = PETSc.Options(), PETSc.Options().getAll()
    rooms = [vars(module) for name, module in sys.modules.items() if name.startswith("asperity.fenicsx")]
    before = [dict(room) for room in rooms]
    results: dict[str, object] = {}
    out, err, status = io.StringIO(), io.StringIO(), 0
    sys.argv = ["-c", *words]
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), warnings.catch_warnings():
        try:
            exec(compile(code, "<code>", "exec"), {"__name__": "__main__", "results": results})
        except SystemExit as end:
            status = end.code if isinstance(end.code, int) else int(end.code is not None)
            if isinstance(end.code, str):
                print(end.code, file=err)
        finally:
            for room, names in zip(rooms, before, strict=True):
                room.update(names)
            for name in options.getAll().keys() - given.keys():
                options.delValue(name)
    return {"results": results, "out": out.getvalue(), "err": err.getvalue(), "status": status}


def main() -> None:
    """Run codes until there are no more."""
    mark = sys.argv[1]
    while line := order():
        answers = COMM.gather(answer(*json.loads(line)))
        if COMM.rank == 0:
            print(mark + json.dumps(answers), flush=True)
        gc.collect()


if __name__ == "__main__":
    main()

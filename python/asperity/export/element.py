"""One element of a joint as a model of a host: its load path, and the rows that the host must show."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from string import Template

import numpy as np

from .. import contract, hosts, installed
from ..cards.blocks import numeral
from ..case_files import read_run, slip_test
from ..history import History
from ..interface import Interface
from ..steps import Step, turns_of

ROWS = 5  # rows that are printed: so many equal parts of the slip
EARLY, SHORTENED = 0.15, 2.5
"""Place of a peak over the whole slip that no row shows, and slip of the element over that at such a peak."""

SAME = 1.0e-6  # largest difference of a host from the material point, over s_f and sigma0


@dataclass(frozen=True, eq=False)
class Element:
    """Square element of area 1: a normal traction sigma_N in `press` increments, then a slip along Tx.

    text, value: of the case and its sweep.  slide: increments of the slip.  history: rows of the slip of
    the material point.
    """

    text: str
    interface: Interface
    sigma_N: float
    slip: float
    press: int
    slide: int
    history: History
    value: str | None

    @property
    def every(self) -> int:
        """Increments of the slip between two rows."""
        return self.slide // ROWS

    @classmethod
    def of_case(cls, path: Path | None = None, value: str | None = None) -> Element:
        """Element with the joint of a case (that of the package), up to the first reversal of its slip.

        Raises ValueError for a case without a slip along Tx under a constant t_N, with viscous damage, or
        whose path ends or jumps, which no static model can follow.
        """
        path = installed.named_case("one_element") if path is None else path
        run = read_run(path, value, with_path=True)
        test = slip_test(path, run)
        if not len(test.slips) or test.sigma_N > 0.0:
            raise ValueError(f"{path}: expected &step with t_N <= 0, then slip under it, for one element")
        if test.direction != 0.0:
            raise ValueError(f"{path}: direction = {test.direction:g}: expected 0; turn the pattern instead")
        for name in ("tau_v", "c"):
            if (constant := getattr(run.material, name)) > 0.0:
                raise ValueError(f"{path}: {name} = {constant:g}: expected 0, an element has no rate")
        stroke = int(turns_of(np.array([0.0, *test.slips]))[1])
        slip, press, slide = float(test.slips[stroke - 1]), max(test.preload, 1), -(-stroke // ROWS) * ROWS
        if slip == 0.0:
            raise ValueError(f"{path}: slip = 0: expected a slip that is not zero, for one element")
        for _ in range(2):
            steps = Step(t_N=test.sigma_N, increments=press), Step(slip=slip, direction=0.0, increments=slide)
            history, lost = run.interface.rows(steps)
            # rows after rupture test nothing: those of a shorter slip lie on both sides of the peak
            tau = np.abs(history.after_step(1).traction[:, 1])
            at = abs(float(history.after_step(1).separation[np.argmax(tau), 1])) if tau.size else abs(slip)
            if lost or history.snaps or at > EARLY * abs(slip):
                break
            slip = float(np.copysign(SHORTENED * at, slip))
        if lost or history.snaps:
            slips = history.separation[:, 1]
            at = history.snaps[0].before[1] if history.snaps else max(slips, key=abs, default=0.0)
            what = "jumps" if history.snaps else "has no equilibrium"
            raise ValueError(
                f"{path}: the joint {what} beyond s_Tx = {at:.6g}: expected a stable path, which a static "
                "model can follow"
            )
        text = path.read_text(encoding="utf-8", errors="replace")
        return cls(text, run.interface, test.sigma_N, slip, press, slide, history.after_step(1), value)

    @classmethod
    def of_kit(cls, folder: Path) -> Element:
        """Element of the case in the folder of a kit."""
        value = json.loads((folder / "model.json").read_text(encoding="utf-8"))["value"]
        return cls.of_case(folder / "joint.nml", value)

    @property
    def rows(self) -> list[list[float]]:
        """Slip, opening, shear traction and damage at equal parts of the slip."""
        h, places = self.history, [k * self.every - 1 for k in range(1, ROWS + 1)]
        columns = h.separation[:, 1], h.dilation, h.traction[:, 1], h.damage
        return [[float(column[i]) for column in columns] for i in places]

    def table(self) -> str:
        """Rows in Markdown."""
        lines = [
            f"| {u:.6g} | {self._length(w)} | {self._stress(force)} | {d:.7f} |"
            for u, w, force, d in self.rows
        ]
        return "\n".join(["| U1 | U3 | RF1 | SDV1 |", "|---|---|---|---|", *lines])

    def _length(self, value: float) -> str:
        return _digits(value, self.interface.material.s_f)

    def _stress(self, value: float) -> str:
        return _digits(value, self.interface.material.sigma0)

    def numbers(self) -> dict[str, str]:
        """Numbers of the load path by name, for templates of all hosts."""
        names = ("sigma_N", "slip", "press", "slide")
        more = {"every": self.every, "last": self.press + self.slide, "quarter": 0.25 * self.sigma_N}
        steps = {"press_step": 1.0 / self.press, "slide_step": 1.0 / self.slide}
        values: dict[str, float] = {name: getattr(self, name) for name in names} | more | steps
        return {name: numeral(value) for name, value in values.items()}

    def filled(self, host: str, name: str, **texts: str) -> str:
        """Text of a template of a host."""
        text = (hosts.folder(host) / name).read_text(encoding="utf-8")
        return Template(text).substitute(self.numbers(), **texts)

    def readme(self, host: str, **texts: str) -> str:
        """README of a kit."""
        version = contract.library_version()
        packages = " ".join(f"'{package}'" for package in hosts.hosts()[host].packages)
        texts = {"table": self.table(), "version": version, "packages": packages, **texts}
        return self.filled(host, "README.md", **texts)

    def scripts(self, host: str, *names: str) -> dict[str, str]:
        """README, case and these files of a kit, which read the case."""
        texts = {name: (hosts.folder(host) / name).read_text(encoding="utf-8") for name in names}
        value = {"model.json": json.dumps({"value": self.value}) + "\n"} if "single.py" in names else {}
        return {"README.md": self.readme(host), "joint.nml": self.text} | value | texts

    def follow(self, step: Callable[[float, float], Sequence[float]]) -> None:
        """Take a host along the path and print its rows and the expected ones; SystemExit if they differ.

        step: solves for a slip and a normal traction, returns slip, opening and shear force.
        """
        for k in range(1, self.press + 1):
            step(0.0, self.sigma_N * k / self.press)
        taken = [step(self.slip * k / self.slide, self.sigma_N) for k in range(1, self.slide + 1)]
        seen = taken[self.every - 1 :: self.every]
        print(f"{'U1':>12}{'U3':>14}{'expected':>14}{'RF1':>14}{'expected':>14}")
        for row, (u, w, force, _) in zip(seen, self.rows, strict=True):
            lengths, stresses = map(self._length, (row[1], w)), map(self._stress, (row[2], force))
            print(f"{u:>12.6g}", *(f"{text:>14}" for text in (*lengths, *stresses)), sep="")
        material = self.interface.material
        sizes = np.array([material.s_f, material.s_f, material.sigma0])
        worst = np.abs((np.array(seen) - np.array(self.rows)[:, :3]) / sizes).max()
        if not worst <= SAME:
            sys.exit(f"the rows differ by {worst:.1e} of s_f or sigma0: expected at most {SAME:g}")


def _digits(value: float, size: float) -> str:
    """Digits of a value in any units; what is a rounding error beside a size is 0."""
    return f"{value if abs(value) > 1.0e-9 * size else 0.0:.9g}"

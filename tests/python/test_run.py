"""Load paths in Python: examples of the docstrings, the table of steps, runs that go on, and many at once."""

from __future__ import annotations

import doctest
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields
from importlib import import_module

import asperity
import numpy as np
import pytest
from asperity import EquilibriumLost, Interface, Material, Pattern, Point, Step, steps

JOINT = Interface(Material(3.0, 0.3, 0.9, 0.5, kc=20.0), Pattern.regular(4, 30.0))


WITH_EXAMPLES = ("interface", "steps", "case_files", "history", "material", "fit.fitting", "barton.command",
                 "surface.scan_files", "uncertainty.spread")  # fmt: skip


@pytest.mark.parametrize("name", WITH_EXAMPLES)
def test_examples(name: str) -> None:
    """Examples of docstrings run."""
    failed, tried = doctest.testmod(import_module(f"asperity.{name}"))
    assert failed == 0 < tried


def test_functions_of_the_tools() -> None:
    """What the commands do is there as functions, and dir() has the public names only."""
    for tool, function in (
        ("fit", "fit"), ("barton", "barton"), ("surface", "planes_from_scan"), ("uncertainty", "uncertainty")
    ):  # fmt: skip
        assert tool in dir(asperity) and callable(getattr(getattr(asperity, tool), function))
    assert not {"Any", "re", "Path", "import_module"} & {*dir(asperity)}


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Interface(JOINT.material, 8), "pattern = 8: expected a Pattern, as Pattern.regular"),
        (lambda: Interface(0.3, JOINT.pattern), "material = 0.3: expected a Material, as Material"),
        (lambda: Pattern([(1.0, 0.0, 0.0)]), "expected a number of planes; Pattern.planes.normals, weights"),
    ],
)
def test_arguments_of_another_type(make: Callable[[], object], message: str) -> None:
    """What looks like a pattern and is none is named, with the call that makes one."""
    with pytest.raises(ValueError, match=message):
        make()


def test_step_has_the_names_of_the_table() -> None:
    """Step, &step and the library have one list of names."""
    assert [part.name for part in fields(Step)] == [entry.name for entry in steps.entries()]


def test_length_is_the_number_of_rows() -> None:
    """Lists, cycles and a shorter list of increments."""
    for step in (
        Step(),
        Step(s_N=0.1, increments=7),
        Step(slip=[0.1, 0.2, 0.3], increments=[2, 5], cycles=3),
    ):
        assert len(JOINT.run(step)) == len(step)


def test_a_run_goes_on() -> None:
    """The rows after a point of a run are those of a run from there."""
    press = Step(t_N=-0.4, increments=10)
    slip = Step(slip=[0.1, 0.2], direction=20.0, increments=20)
    whole = JOINT.run([press, slip])
    first = JOINT.run([press, Step(slip=0.1, direction=20.0, increments=20)])
    rest = JOINT.run(Step(t_N=-0.4, slip=0.2, direction=20.0, increments=20), first.end)
    for name in ("separation", "traction", "state", "work"):
        np.testing.assert_allclose(getattr(rest, name), getattr(whole, name)[30:], rtol=0, atol=1e-9)


def test_traction_control_with_a_loss() -> None:
    """A shear traction beyond what the joint carries: the rows before, and the reason."""
    with pytest.raises(EquilibriumLost, match=r"step 1 increment \d+, s = .*: no equilibrium exists") as lost:
        JOINT.run(Step(t_N=3.5, increments=70))
    assert 50 < len(lost.value.history) == lost.value.row < 70
    history, text = JOINT.rows(Step(t_N=3.5, increments=70))
    assert text == str(lost.value) and len(history) == lost.value.row


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: JOINT.run([]), "steps: expected one asperity.Step or more"),
        (lambda: JOINT.run([{"t_N": 1.0}]), "steps: expected one asperity.Step or more"),
        (lambda: JOINT.run(Step(), np.zeros(3)), r"state has shape \(3,\): expected \(23,\)"),
        (lambda: JOINT.run(Step(), Point(np.full(23, 2.0))), r"STATEV\(9\) alpha = 2"),
        (lambda: Step(slip="x"), "slip.* = 'x': expected a finite number"),
        (lambda: Step(follow="x"), "follow = 'x': expected 'stable' or 'branch'"),
        (lambda: JOINT.run([Step(), Step(time=-1.0)]), r"steps\[1\]: time = -1: expected >= 0"),
        (lambda: JOINT.run(Step(), tolerance=0.5), r"tolerance = 0\.5: expected 1e-8 to 0\.1"),
    ],
)
def test_bad_arguments(call, message: str) -> None:
    """Errors name argument, value and what is expected."""
    with pytest.raises(ValueError, match=message):
        call()


def test_runs_in_threads() -> None:
    """Many runs at once give the bits of single runs."""
    paths = [[Step(t_N=-p, increments=10), Step(slip=0.3, increments=60)] for p in (0.1, 0.2, 0.3, 0.4)]
    with ThreadPoolExecutor(4) as threads:
        found = list(threads.map(JOINT.rows, paths))
    for path, (history, lost) in zip(paths, found, strict=True):
        assert lost == "" and np.array_equal(history.state, JOINT.run(path).state)

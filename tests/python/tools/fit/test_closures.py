"""Fits of closure tests: stiffness and largest closure of contacts, blind predictions, refusals."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, Pattern, read_case
from asperity.cli import main
from asperity.tools.fit.closure_test import ClosureTest
from asperity.tools.fit.closures import closure_of, fit_closures
from asperity.tools.fit.predict import predict
from asperity.tools.fit.strength import Strength

pytestmark = pytest.mark.usefixtures("folder")

KN, CLOSURE = 25.0, 0.2
"""Constants of the contact of Bandis et al. (1983): p = kn c / (1 - c/V)."""


def bandis(pressure: np.ndarray) -> np.ndarray:
    """Closure of this contact."""
    return pressure / (KN + pressure / CLOSURE)


def drawn(seed: int, rows: int = 25, noise: float = 0.01) -> ClosureTest:
    """Loading of the contact with noise, a fraction of the largest closure."""
    pressure = np.linspace(0.2, 10.0, rows)
    closure = bandis(pressure) - bandis(pressure[:1])
    noisy = closure + np.random.default_rng(seed).normal(0.0, noise * closure[-1], rows)
    return ClosureTest(f"test {seed}", pressure, noisy - noisy[0])


@pytest.mark.parametrize("count", [1, 3])
def test_constants_of_a_hyperbola(count: int) -> None:
    """Constants lie within their intervals, and further tests are predicted by the others."""
    result = fit_closures([drawn(seed) for seed in range(count)])
    assert result.is_result and result.grade == "good" and result.free == ("kn", "closure")
    for name, truth in (("kn", KN), ("closure", CLOSURE)):
        estimate = result.estimates[name]
        # a 0.95 interval, widened by half of itself for the twentieth that misses
        margin = 0.5 * (estimate.high - estimate.low)
        assert estimate.low - margin <= truth <= estimate.high + margin
    assert len(result.blind) == (count if count > 1 else 0)


def test_closed_form_is_the_joint() -> None:
    """The joint that is written closes as the fit says."""
    test = drawn(1, noise=0.0)
    result = fit_closures([test])
    # the solver meets the pressure to 1e-10 of it
    assert closure_of(result.interface, test) == pytest.approx(test.closure, abs=1e-6 * test.size)


def test_a_straight_line_has_one_stiffness() -> None:
    """Without a curvature the largest closure is not a constant of the fit."""
    pressure = np.linspace(0.0, 5.0, 12)
    result = fit_closures([ClosureTest("line", pressure, pressure / 40.0)])
    assert result.free == ("kn",) and result.values["kn"] == pytest.approx(40.0, rel=1e-4)


@pytest.mark.parametrize("kind", ["noise", "power"])
def test_nonsense_is_no_result(kind: str) -> None:
    """Noise, and a contact that softens with the pressure, are refused or are no result."""
    pressure = np.linspace(0.1, 5.0, 20)
    noise = np.abs(np.random.default_rng(0).normal(0.5, 0.2, 20))
    closure = {"noise": np.append(0.0, noise[1:]), "power": pressure**4}[kind]
    try:
        result = fit_closures([ClosureTest(kind, pressure, closure)])
    except ValueError as error:
        assert "does not close" in str(error)
    else:
        assert not result.is_result


def test_tests_that_cannot_be() -> None:
    """Wrong tests are named, with what is wrong."""
    pressure = np.linspace(0.1, 5.0, 10)
    for values, message in (
        ((pressure, -pressure), "the joint does not close as the pressure grows"),
        ((pressure, 0.0 * pressure), "column closure is the same in all rows"),
        ((pressure[::-1].copy(), pressure), "1 rows of loading: expected at least 3"),
        ((-pressure, pressure), "pressure = -5: expected >= 0"),
    ):
        with pytest.raises(ValueError, match=message):
            ClosureTest("a", *values)
    with pytest.raises(ValueError, match=r"again: the rows are those of test 0"):
        fit_closures([drawn(0), ClosureTest("again", drawn(0).pressure, drawn(0).closure)])
    with pytest.raises(ValueError, match="4 rows of loading: expected at least 6"):
        fit_closures([drawn(0, rows=4)])


def test_tests_of_several_kinds() -> None:
    """A joint predicts tests of one kind at a time; both kinds are named."""
    joint = Interface(Material.from_joint(KN, KN, 0.6, closure=CLOSURE), Pattern.regular(0, 0.0))
    strength = Strength("strength", sigma_N=-1.0, peak=0.6)
    assert predict(joint, [drawn(0)]).rms["loading"] < 0.05
    for tests in ([drawn(0), strength], [strength, drawn(0)]):
        with pytest.raises(ValueError, match="beside") as error:
            predict(joint, tests, slip=1.0)
        assert {"ClosureTest", "Strength"} <= set(str(error.value).replace(":", "").split())


def test_command_from_file_to_card(said: Callable) -> None:
    """The command reads loading and unloading, writes a case that runs, and predicts another test."""
    for number in (1, 2):
        test = drawn(number)
        back = [(p, c + 0.02) for p, c in zip(test.pressure[::-3], test.closure[::-3], strict=True)][1:]
        rows = [*zip(test.pressure, test.closure, strict=True), *back]
        text = "".join(f"{p:.6g},{c:.6g}\n" for p, c in rows)
        Path(f"{number}.csv").write_text("sigma_N [MPa],closure [mm]\n" + text)
    out, _ = said("fit 1.csv -o joint.nml --report joint.html --residuals rows.csv --plot joint.png")
    assert "hyperbolic contact" in out and "the unloading is missed by" in out
    content = json.loads(Path("joint.fit.json").read_text())
    kn = content["values"][content["parameters"].index("kn")]
    assert f"{kn:.4g}" in Path("joint.html").read_text()
    # three digits of kn stand in the comment of the case, six in its constants
    assert read_case("joint.nml").runs[0].material.closure == pytest.approx(CLOSURE, rel=0.1)
    assert len(Path("rows.csv").read_text().splitlines()) == 1 + 25 + 8
    assert main(["run", "joint.nml", "--quiet", "-o", "run.csv"]) == 0
    assert main(["card", "abaqus", "joint.nml"]) == 0
    out, _ = said("predict joint.nml 2.csv --plot predict.png")
    assert "grade       good" in out and "unloading" in out
    assert "a fit of closure tests: expected one of shear" in said("uncertainty joint.nml --jobs 1", 1)[1]
    assert "--set: expected curves of the slip, not closures" in said("fit 1.csv --set mu=0.5", 1)[1]
    rows = [f"{i},{i},1" for i in range(1, 8)]
    Path("shear.csv").write_text("\n".join(["slip [mm],tau [MPa],sigma_N [MPa]", *rows, ""]))
    message = "1.csv has closures, shear.csv has curves of the slip: expected one kind at a time"
    assert message in said("fit 1.csv shear.csv", 1)[1]
    # kn, which the fit knows, is no constant of shear tests: no intervals
    rows = [f"{0.1 * i:.1f},{min(0.3 * i, 0.6):.1f},-1" for i in range(1, 12)]
    Path("sheared.csv").write_text("\n".join(["slip [mm],tau [MPa],sigma_N [MPa]", *rows, ""]))
    assert "0.6 / 0.6" in said("predict joint.nml sheared.csv", 3)[0]

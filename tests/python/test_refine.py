"""Load paths to a tolerance in driver and Python: errors against fine increments, and number of rows."""

from __future__ import annotations

from pathlib import Path

import asperity
import numpy as np
import pytest
from support_driver import ETA, GC, MATERIAL, MU, RP_4, S_F, SIGMA0

pytestmark = pytest.mark.filterwarnings("ignore::asperity.ModelWarning")


def random_slip_test(seed: int) -> tuple[asperity.Interface, float, list[float], float]:
    """Random interface, direction, reversals and normal traction."""
    rng = np.random.default_rng(seed)
    eta, mu, kc = rng.uniform(0.5, 0.95), rng.uniform(0.0, 0.8), float(rng.choice([1, 10]))
    material = asperity.Material(SIGMA0, GC, eta, mu, kc=kc)
    sides = int(rng.choice([2, 3, 4, 5, 8]))
    pattern = asperity.Pattern.regular(sides, rng.uniform(5, 40), rng.uniform(0, 0.6), rng.uniform(0, 90))
    turns = [0.3] if seed % 2 else [0.25, -0.2, 0.3]
    interface = asperity.Interface(material, pattern)
    return interface, rng.uniform(0, 360), turns, -float(rng.choice([0.0, 0.5, 2.0, 8.0]))


def travelled(history: asperity.History, direction: float) -> np.ndarray:
    """Slip path length at every row."""
    e = [np.cos(np.radians(direction)), np.sin(np.radians(direction))]
    return np.cumsum(np.abs(np.diff(history.separation[:, 1:] @ e, prepend=0.0)))


def dense(
    interface: asperity.Interface,
    direction: float,
    turns: list[float],
    sigma_N: float,
    times: np.ndarray | None = None,
) -> asperity.History:
    """The same path in 4000 increments (viscous: 16,000) between reversals and 1000 in the preload."""

    def divided(ends) -> np.ndarray:
        n = 4000 if times is None else 16000
        return np.concatenate(
            [np.linspace(a, b, n + 1)[1:] for a, b in zip([0.0, *ends], ends, strict=False)]
        )

    every = None if times is None else divided(times)
    return interface.confined_slip(
        direction, divided(turns), sigma_N, preload=1000, times=every, preload_time=1.0
    )


def curve_error(
    rows: asperity.History, reference: asperity.History, direction: float, every: int = 1
) -> float:
    """Largest distance of the reference from straight lines between rows, in the scales of the tolerance."""
    x, x_reference = travelled(rows, direction)[every - 1 :: every], travelled(reference, direction)
    inside = x_reference >= x[0]
    largest = np.repeat(
        [max(S_F, np.abs(reference.separation).max()), max(SIGMA0, np.abs(reference.traction).max())], 3
    )
    lines = np.hstack([rows.separation, rows.traction])[every - 1 :: every] / largest
    exact = np.hstack([reference.separation, reference.traction])[inside] / largest
    place = np.searchsorted(x, x_reference[inside], side="left").clip(1, len(x) - 1)
    nearest = np.full(len(exact), np.inf)
    for shift in (-1, 0, 1):
        k = (place + shift).clip(1, len(x) - 1)
        way = lines[k] - lines[k - 1]
        length = np.einsum("ij,ij->i", way, way)
        share = np.einsum("ij,ij->i", exact - lines[k - 1], way) / np.where(length > 0.0, length, 1.0)
        away = np.abs(lines[k - 1] + share.clip(0.0, 1.0)[:, None] * way - exact).max(axis=1)
        nearest = np.minimum(nearest, away)
    return float(nearest.max())


@pytest.mark.parametrize("seed", range(12))
def test_error_is_within_the_tolerance_and_rows_are_few(seed: int):
    """Lines between the rows and energies are within the tolerance; with every fourth row they are not."""
    interface, direction, turns, sigma_N = random_slip_test(seed)
    reference = dense(interface, direction, turns, sigma_N)
    for tolerance in (1e-2, 1e-3):
        rows = interface.confined_slip(direction, turns, sigma_N, tolerance=tolerance)
        assert curve_error(rows, reference, direction) < tolerance
        work = reference.work[-1]
        assert abs(rows.work[-1] - work) < tolerance * work
        for name in ("stored", "rupture", "friction"):
            place = asperity.contract.statev_index(name)
            assert abs(rows.state[-1, place] - reference.state[-1, place]) < tolerance * work, name
    assert curve_error(rows, reference, direction, every=4) > tolerance
    # along the axes every reversal is a row, exactly
    axis = interface.confined_slip(0.0, turns, sigma_N, tolerance=1e-2)
    assert all(turn in axis.separation[:, 1] for turn in turns)
    assert interface.confined_slip(0.0, [], sigma_N, tolerance=1e-2).damage.size == 0


FACETS = {"height": 0.0853, "kc": 1000.0}


@pytest.mark.parametrize(
    ("material", "pattern", "path", "tolerance"),
    [
        # transients where a reversed slip passes zero
        ((0.98, 0.93, FACETS), (6, 5.76, 0.329), (44.07, [0.164, -0.383], -0.134), 5e-3),
        ((0.9, 0.9, {"kc": 1000.0}), (6, 6.0, 0.33), (44.0, [0.16, -0.38], -0.13), 5e-3),
        # viscous damage that stops growing; the time between two reversals is 1
        ((0.9, 0.5, {"tau_v": 0.05}), (0, 0.0), (0.0, [0.1, -0.3, 0.2], -3.0), 1e-3),
        (
            (0.7194, 0.8608, {"kc": 1e3, "tau_v": 0.0673}),
            (0, 0.0),
            (-57.0, [0.0817, -0.4012, 0.0565], -0.8137),
            1e-3,
        ),
        # planes that slide in a direction that turns slowly, up to the peak of a traction
        ((0.97, 1.2, {"kc": 5.0}), (2, 50.0), (60.0, [0.3], -1.0), 1e-3),
        # facets that wear: the difference of two runs is the error of the finer one, of first order
        ((ETA, MU, {"kc": 100.0, "height": 0.5, "W0": 1.0}), (2, 30.0), (0.0, [0.4, -0.1], -1.0), 2e-3),
    ],
)
def test_what_happens_within_an_increment(material, pattern, path, tolerance: float):
    """The curve is within the tolerance whatever happens within an increment."""
    eta, mu, others = material
    interface = asperity.Interface(
        asperity.Material(SIGMA0, GC, eta, mu, **others), asperity.Pattern.regular(*pattern)
    )
    direction, turns, _ = path
    times = np.arange(1.0, len(turns) + 1.0) if "tau_v" in others else None
    rows = interface.confined_slip(*path, tolerance=tolerance, times=times, preload_time=1.0)
    assert curve_error(rows, dense(interface, *path, times), direction) < tolerance
    assert "W0" not in others or max(rows.worn(k)[-1] for k in (1, 2, 3)) > 0.1


@pytest.mark.parametrize(
    "tolerance", [pytest.param(1e-8, marks=pytest.mark.slow), 0.0, -1e-3, 0.2, 1e-9, float("nan")]
)
def test_bad_tolerance(run, tolerance: float):
    """A tolerance out of range, or below what the limit of increments allows, is an error with its reason."""
    # of a flat joint the increments up to their limit take least
    interface = asperity.Interface(asperity.Material(SIGMA0, GC, ETA, MU), asperity.Pattern.regular(0, 0.0))
    said = (
        "the rows of .* increments still differ by .*: expected a tolerance of at least"
        if tolerance == 1e-8
        else r"expected 1e-8 to 0\.1"
    )
    with pytest.raises(ValueError, match=rf"tolerance = .*: {said}"):
        interface.confined_slip(0.0, [0.3], -1.0, tolerance=tolerance)
    if abs(tolerance) > 1e-8 or tolerance == 0.0:
        case = f"&case tolerance = {tolerance} /\n" + MATERIAL + RP_4 + "&step slip = 0.4 /\n"
        said = run(case, code=1).messages
        assert f"case.nml:1: &case: tolerance = {tolerance:g}: expected 1e-8 to 0.1" in said
        assert not Path("case.csv").exists()


def test_driver_takes_a_tolerance(run):
    """Targets and switches have rows, and the history is that of Python."""
    steps = "&step t_N = -5.0 /\n&step slip = 0.4, -0.2, time = 2.0 /\n"
    result = run("&case tolerance = 1e-3 /\n" + MATERIAL + RP_4 + steps)
    slip = result["step"] == 2
    assert 0.4 in result["s_Tx"] and result["s_Tx"][-1] == -0.2
    assert result["time"][-1] == 3.0 and np.all(np.diff(result["time"]) > 0.0)
    assert np.all(np.diff(result["increment"][slip]) == 1)
    assert {"onset", "slip", "open", "close", "damaged"} <= set().union(*result.events)
    interface = asperity.Interface(asperity.Material(SIGMA0, GC, ETA, MU), asperity.Pattern.regular(4, 30.0))
    history = interface.confined_slip(0.0, [0.4, -0.2], -5.0, tolerance=1e-3)
    assert result["t_Tx"][-1] == pytest.approx(history.traction[-1, 1], rel=1e-3)
    assert len(history.damage) == pytest.approx(np.sum(slip), rel=0.2)

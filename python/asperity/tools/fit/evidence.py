"""What the rows of a test show without a law: strokes, noise, peak and end, and guesses of the constants."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...contract import Floats
from .shear_test import ShearTest
from .thresholds import AT_END, BACK, LEAST_DATA, MOST_ALIKE, SMOOTHED


def smooth(values: Floats, rows: int) -> Floats:
    """Moving average over a number of rows."""
    rows = min(rows, values.size)
    return np.convolve(values, np.ones(rows) / rows, "valid")


def first_stroke(test: ShearTest) -> slice:
    """Rows of a test up to the first reversal."""
    slip = np.sign(test.slip[np.argmax(np.abs(test.slip))]) * test.slip
    # the rows beyond the highest slip so far by a reversal are not of the first stroke
    back = np.flatnonzero(np.maximum.accumulate(slip) - slip > BACK * np.ptp(slip))
    if not back.size:
        return slice(0, slip.size)
    return slice(0, int(np.argmax(slip[: back[0]])) + 1)


def cycles(tests: Sequence[ShearTest]) -> bool:
    """Whether the slip of a test is reversed."""
    return any(first_stroke(test).stop < test.slip.size for test in tests)


def noise(values: Floats) -> float:
    """Standard deviation of the noise of a curve, from its second differences."""
    second = np.diff(values, 2)
    return float(1.4826 * np.median(np.abs(second)) / np.sqrt(6.0)) if second.size else 0.0


def independent_rows(residuals: Floats) -> float:
    """Number of independent rows of a curve: n (1 - rho)/(1 + rho).

    rho is the correlation of neighbouring residuals, as no law meets a joint within its noise.
    """
    size, square = residuals.size, max(float(residuals @ residuals), 1e-300)
    rho = float(residuals[:-1] @ residuals[1:]) / square if size > 2 else 0.0
    rho = min(max(rho, 0.0), MOST_ALIKE)
    return min(size, max(LEAST_DATA, size * (1.0 - rho) / (1.0 + rho)))


def pressures(test: ShearTest) -> Floats:
    """Pressure in each row of a test, (T,)."""
    if test.path_N is not None:
        return -test.path_N
    opening = np.zeros(test.slip.size) if test.s_N is None else test.s_N
    return np.asarray(test.k_N * opening - test.sigma_N)


def numbers(test: ShearTest, tau: Floats, s_N: Floats | None) -> dict[str, float]:
    """Peak, slip at the peak, residual and dilation at the end of rows, measured or of the law.

    The rows are averaged, as the largest of noisy rows is above the peak.  The residual is missing where the
    test ends within a cycle.
    """
    rows = first_stroke(test)
    size = np.abs(tau[rows])
    width = min(max(3, round(SMOOTHED * tau.size)), max(1, size.size // 2))
    averaged, slips = smooth(size, width), smooth(np.abs(test.slip[rows]), width)
    shown = {"peak": float(averaged.max()), "slip at peak": float(slips[int(averaged.argmax())])}
    end = slice(-max(min(width, tau.size), round(AT_END * tau.size)), None)
    if test.ends_far:
        shown["residual"] = float(np.mean(np.abs(tau[end])))
    if s_N is not None:
        shown["dilation"] = float(np.mean(s_N[end]))
    return shown


def noises(test: ShearTest) -> dict[str, float]:
    """Standard deviations, by noise, of the averages from which `numbers` reads a measured test."""
    size, strokes = test.tau.size, first_stroke(test)
    averaged = min(max(3, round(SMOOTHED * size)), max(1, test.tau[strokes].size // 2))
    at_end = max(min(averaged, size), round(AT_END * size))
    of_tau = noise(test.tau)
    deviations = {"peak": of_tau / averaged**0.5, "residual": of_tau / at_end**0.5}
    return deviations | ({} if test.s_N is None else {"dilation": noise(test.s_N) / at_end**0.5})


def first_slope(test: ShearTest) -> float:
    """Largest slope of the dilation over the slip in the first stroke; 0 where it was not measured."""
    slopes = _slopes(test)
    return max(slopes) if slopes else 0.0


def last_slope(test: ShearTest) -> float:
    """Slope of the dilation at the end of the first stroke; 0 where it was not measured."""
    slopes = _slopes(test)
    return max(0.0, slopes[-1]) if slopes else 0.0


def _slopes(test: ShearTest) -> list[float]:
    if test.s_N is None:
        return []
    rows = first_stroke(test)
    slip, dilation = np.abs(test.slip[rows]), test.s_N[rows]
    width = max(4, slip.size // 6)
    parts = [slice(i, i + width) for i in range(0, slip.size - width + 1, max(1, width // 2))]
    return [float(np.polyfit(slip[part], dilation[part], 1)[0]) for part in parts if np.ptp(slip[part]) > 0.0]


def guesses(tests: Sequence[ShearTest]) -> dict[str, float]:
    """Rough values of the constants: the strength at the end less the slope there, the largest slope, its
    end.

    Any of them is only where a search begins.
    """
    mus, slopes, heights, stiffnesses, drops, ratios = [], [], [], [], [], []
    stress = max(float(np.abs(test.tau).max()) for test in tests)
    length = max(float(np.abs(test.slip).max()) for test in tests)
    for test in tests:
        rows = first_stroke(test)
        slip, tau, pressure = np.abs(test.slip[rows]), np.abs(test.tau[rows]), pressures(test)[rows]
        end = slice(-max(2, round(0.15 * slip.size)), None)
        least = 1e-9 * stress
        ratio = float(np.median(tau[end]) / max(np.median(pressure[end]), least))
        at_end = last_slope(test)
        if test.s_N is not None:
            slopes.append(max(first_slope(test), 0.02))
            heights.append(max(1.1 * float(np.mean(test.s_N[rows][end])), 0.02 * float(slip.max())))
        mus.append((ratio - at_end) / (1.0 + ratio * at_end))
        top = int(np.argmax(smooth(tau, min(3, tau.size))))
        stiffnesses.append(float(np.max(tau[: top + 2] / np.maximum(slip[: top + 2], 1e-9 * length))))
        drops.append(float(tau.max() - np.median(tau[end])))
        ratios.append(float(tau.max() / max(pressure[top], least)))
    mu, peak = float(np.clip(np.median(mus), 0.05, 1.5)), float(np.median(ratios))
    slope = float(np.median(slopes)) if slopes else max(0.05, (peak - mu) / (1.0 + peak * mu))
    bond = float(max(np.median(drops), 0.05 * stress))
    return {
        "kT": float(np.median(stiffnesses)),
        "ks": 2.0 * float(np.median(stiffnesses)),
        "mu": mu,
        "theta": float(np.clip(np.degrees(np.arctan(slope)), 1.0, 60.0)),
        "height": float(np.median(heights)) if heights else 0.25 * length * slope,
        "sigma0": bond,
        "Gc": 0.1 * bond * length,
        "crush": 3.0 * max(-test.pressed for test in tests) + 1e-3 * stress,
        "W0": stress * length,
        "eta": 0.9,
    }

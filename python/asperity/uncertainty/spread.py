"""Samples of uncertain constants through a load path: quantiles of the curves, and of peak, end and work."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial

import numpy as np

from .. import contract
from ..contract import Floats
from ..parallel import map_in_order
from ..steps import thinned
from .distribution import bad_constant
from .paths import CURVES, LoadPath

BATCH = 250
"""Samples of a task, whatever the number of workers."""

MOST_POINTS = 121
"""Largest number of points of a curve for which quantiles are computed; ends and reversals are among them."""

RESULTS = ("peak traction", "at slip", "traction at the end", "s_N at the end", "work")
"""Numbers of a sample; the peak is the largest size, and the work that of the traction on the whole path."""


@dataclass(frozen=True, eq=False)
class Spread:
    """Quantiles of a load path over the samples that have all of it.

    points (R,): rows of the path.  levels (L,).  curves (L, R, 3): in the order of CURVES.  results (k, 5):
    of each sample, in the order of RESULTS.  refused: samples out of the range of a constant, by its name.
    lost: samples without equilibrium.  case: curves (n, 3) and results (5,) of the case itself.
    """

    path: LoadPath
    points: np.ndarray
    levels: Floats
    curves: Floats
    results: Floats
    refused: Counter[str]
    lost: int
    case: tuple[Floats, Floats]

    @property
    def left_out(self) -> float:
        """Fraction of the samples that the quantiles do not contain."""
        out = self.lost + sum(self.refused.values())
        return out / (out + len(self.results))


def spread(
    path: LoadPath,
    names: Sequence[str],
    samples: Floats,
    levels: Sequence[float],
    executor: Executor | None = None,
    tick: Callable[[], object] = lambda: None,
) -> Spread:
    """Quantiles over samples (N, p) of the constants with these names; tick: called after each batch.

    Raises ValueError where no sample has the whole path.
    """
    case = path.curve(path.props)
    points = thinned(path.x, MOST_POINTS)
    batches = [samples[i : i + BATCH] for i in range(0, len(samples), BATCH)]
    done = map_in_order(partial(_batch, path, tuple(names), points), batches, executor, tick)
    parts = list(zip(*done, strict=True))
    curves, results = (np.concatenate(part) for part in parts[:2])
    refused: Counter[str] = sum(parts[2], Counter())
    lost = sum(parts[3])
    if not len(results):
        raise ValueError(
            f"none of {len(samples)} samples has the whole path: {sum(refused.values())} are out of range "
            f"({', '.join(refused) or 'no constant'}), {lost} lose equilibrium"
        )
    quantiles = np.stack([np.quantile(curves[:, i], levels, axis=0) for i in range(len(points))], axis=1)
    own = (case[0], _results(path.x, *case))
    return Spread(path, points, np.array(levels), quantiles, results, refused, lost, own)


def _batch(
    path: LoadPath, names: tuple[str, ...], points: np.ndarray, samples: Floats
) -> tuple[np.ndarray, Floats, Counter[str], int]:
    """Curves (k, R, 3) and results (k, 5) of a batch of samples, those refused, and the number of those lost.

    The curves are in single precision, to save memory.
    """
    places = [contract.index(name) for name in names]
    curves = np.zeros((len(samples), len(points), len(CURVES)), dtype=np.float32)
    results, refused, lost = [], Counter[str](), 0
    for sample in samples:
        props = path.props.copy()
        props[places] = sample
        bad = bad_constant(props, names)
        if bad is not None:
            refused[bad] += 1
            continue
        values, work = path.curve(props)
        if len(work) < path.x.size:
            lost += 1
            continue
        curves[len(results)] = values[points]
        results.append(_results(path.x, values, work))
    return curves[: len(results)], np.array(results).reshape(-1, len(RESULTS)), refused, lost


def _results(x: Floats, values: Floats, work: Floats) -> Floats:
    """Numbers of a curve in the order of RESULTS."""
    traction, s_N, _ = values.T
    peak = int(np.argmax(np.abs(traction)))
    return np.array([abs(traction[peak]), x[peak], traction[-1], s_N[-1], work[-1]])

"""Equilibria of a step that are not stable, as where two joints in series soften at once, and ways from them.

Where damage grows Arnoldi's method with the inverse of the tangent finds its eigenvalue nearest to 0.  Along
the eigenvector of a negative one, to both sides, the model moves by itself until its forces resist.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..contract import Floats
from .equilibrium import Report, Terms
from .newton import SOFT
from .ranks import largest, total
from .response import LawError, Response, damages, respond
from .tangent import Equations, equations_of

SOLUTIONS = 8
"""Solutions with one tangent by which its eigenvalues are found: enough for 2 to 10 joints in series."""

SETTLED = 0.05
"""Error of the inverse of an eigenvalue, over it, below which its sign counts: far from 1."""

FIRST, DOUBLES = 1e-3, 30
"""First length along an eigenvector, over the change of the separations, and how often it is doubled."""

HALVES, PARTS = 20, 16
"""How often the bracket of the root is halved, and parts of the way whose forces give its work."""


def beside(report: Report, terms: Terms) -> list[Floats] | None:
    """Displacements (n d,) beside an equilibrium that is not stable, those of more work first; else None."""
    assert report.between
    (m, old), new = report.between, report.taken()
    if largest(np.maximum(damages(m, new.joints) - damages(m, old.joints), 0.0)) == 0.0:
        return None
    now = respond(m, old, new.s, terms.dt, new.p, iterate=True)
    q = equations_of(m, report.fixed, terms.options)
    drag = np.broadcast_to(terms.drag, new.u.shape) / terms.dt
    q.assemble(now.D, drag, terms.damping, SOFT, False)  # a block that floats is not driven
    way = _unstable(q)
    if way is None:
        return None
    lines = (1.0 + terms.damping) * m.stiff(way) + drag * way
    found = [(work, new.u + a * way) for work, a in _roots(report, terms.dt, now, way, total(way @ lines))]
    return [x for _, x in sorted(found, key=lambda pair: pair[0])]


def _roots(
    report: Report, dt: float, now: Response, way: Floats, slope: float
) -> Iterator[tuple[float, float]]:
    """Works and lengths along a way, to each side, up to where forces no longer drive the model on."""
    assert report.between
    (m, old), new = report.between, report.taken()
    ds = m.separations(way)
    weights = (m.area[:, None] * ds).ravel()

    def resisting(a: float) -> float:
        t = respond(m, old, new.s + a * ds, dt, new.p, iterate=True).t
        return a * slope + total(weights @ (t - now.t).ravel())

    first = FIRST * largest(new.s - old.s) / (largest(ds) or 1.0)
    for side in (first, -first):
        try:
            high = next((a for a in side * 2.0 ** np.arange(DOUBLES) if a * resisting(a) >= 0.0), 0.0)
            low = 0.5 * high
            for _ in range(HALVES):
                middle = 0.5 * (low + high)
                low, high = (low, middle) if middle * resisting(middle) >= 0.0 else (middle, high)
            work = high * sum(map(resisting, np.linspace(0.0, high, PARTS, endpoint=False))) / PARTS
        except LawError:
            continue
        if work < 0.0:
            yield work, high


def _unstable(q: Equations) -> Floats | None:
    """Eigenvector of the negative eigenvalue of the assembled tangent nearest to 0, if there is one."""
    w = np.random.default_rng(0).standard_normal(len(q.free)) * q.free
    basis: list[Floats] = [w / np.sqrt(total(w @ w))]
    H = np.zeros((SOLUTIONS + 1, SOLUTIONS))
    for k in range(SOLUTIONS):
        solved = q.step(-basis[k], False, False)[0]
        if solved is None or not np.isfinite(total(np.abs(solved).sum())):
            return None
        w = solved
        for i, v in enumerate([*basis, *basis]):  # twice, as rounding errors leave a part
            share = total(v @ w)
            H[i % len(basis), k] += share
            w = w - share * v
        H[k + 1, k] = np.sqrt(total(w @ w))
        basis.append(w / (H[k + 1, k] or 1.0))
    inverse, vectors = np.linalg.eig(H[:-1])
    settled = H[-1, -1] * np.abs(vectors[-1]) < SETTLED * np.abs(inverse)
    lowest = np.where(settled & (inverse.imag == 0.0), inverse.real, 0.0)
    if lowest.min() >= 0.0:
        return None
    mixed = np.tensordot(vectors[:, lowest.argmin()].real, np.array(basis[:-1]), 1)
    return q.step(-mixed, False, False)[0]  # without its stiff motions

"""Equilibria of a step that are not stable, as where two joints in series soften at once, and ways from them.

Points whose damage grows lose the stiffness M, the negative part of their tangent.  With K that of the model
K + s M is regular for s = 1, where nothing softens.  For each s below, down to 0, at which it is singular,
the inverse of K times M has the eigenvalue -1 / s.  Arnoldi's method looks for these, -1 at most, in the
separations of the points, so that soft parts of the model hide none.  Along the motion that belongs to
one, to both sides, the model moves by itself until its forces resist.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..contract import Floats
from .equilibrium import Report, Terms
from .model import Model
from .newton import SOFT
from .ranks import largest, total
from .response import LawError, Response, damages, respond
from .tangent import Equations, equations_of

LEAST, MOST = 8, 40
"""Fewest solutions with the tangent by which eigenvalues are found, and most where one is not settled."""

SETTLED = 0.05
"""Error of an eigenvalue, over it, below which it counts: far from 1."""

BELOW = -0.5
"""Bound of eigenvalues: those of equilibria that are stable are not negative, others are -1 at most."""

EXHAUSTED = 1e-10
"""Share of a solution that is new, below which it is rounding errors and there are no other eigenvalues."""

FIRST, DOUBLES = 1e-3, 30
"""First length along an eigenvector, over the change of the separations, and how often it is doubled."""

HALVES, PARTS = 20, 16
"""How often the bracket of the root is halved, and parts of the way whose forces give its work."""


def beside(report: Report, terms: Terms) -> list[Floats] | None:
    """Displacements (n d,) beside an equilibrium that is not stable, those of more work first; else None.

    There are none where no eigenvalue is found, or no equilibrium along the motion.
    """
    assert report.between
    (m, old), new = report.between, report.taken()
    growth = np.maximum(damages(m, new.joints) - damages(m, old.joints), 0.0)
    if largest(growth) == 0.0:
        return None
    planes = np.concatenate(
        [np.full(len(joints), law.n_planes) for law, joints in zip(m.laws, new.joints, strict=True)]
    )
    grows = np.bincount(np.repeat(np.arange(len(planes)), planes), growth, len(planes)) > 0.0
    now = respond(m, old, new.s, terms.dt, new.p, iterate=True)
    q = equations_of(m, report.fixed, terms.options)
    drag = np.broadcast_to(terms.drag, new.u.shape) / terms.dt
    q.assemble(now.D, drag, terms.damping, SOFT, False)  # a block that floats is not driven
    way = _unstable(m, q, _lost(now.D) * grows[:, None, None])
    if way is None:
        return None
    if not way.size:
        return []
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


def _lost(D: Floats) -> Floats:
    """Square roots (p, 3, 3) of the stiffness that points lose: the negative part of their tangents."""
    values, axes = np.linalg.eigh(0.5 * (D + D.transpose(0, 2, 1)))
    roots: Floats = axes * np.sqrt(np.maximum(-values, 0.0))[:, None] @ axes.transpose(0, 2, 1)
    return roots


def _unstable(m: Model, q: Equations, lost: Floats) -> Floats | None:
    """Motion (n d,) against which the assembled tangent does not resist; None: all are resisted.

    lost (p, 3, 3): square roots of the stiffness that the points lose.  The motion is empty where the
    equations have no solution, or an eigenvalue is not settled.
    """
    if largest(np.abs(lost)) == 0.0:
        return None

    def product(a: Floats, b: Floats) -> float:
        return total(m.area @ (a * b).sum(1))

    def moved(v: Floats) -> Floats | None:
        x = q.step(-q.free * m.pulled((lost @ v[:, :, None])[:, :, 0]), False, False)[0]
        return x if x is not None and np.isfinite(total(np.abs(x).sum())) else None

    basis: list[Floats] = []
    w = (lost @ np.random.default_rng(0).standard_normal((len(lost), 3, 1)))[:, :, 0]
    H, beyond = np.zeros((MOST + 1, MOST)), np.sqrt(product(w, w))
    for k in range(MOST):
        basis.append(w / beyond)
        x = moved(basis[k])
        if x is None:
            break
        w = (lost @ m.separations(x)[:, :, None])[:, :, 0]
        for i, v in enumerate([*basis, *basis]):  # twice, as rounding errors leave a part
            share = product(v, w)
            H[i % len(basis), k] += share
            w = w - share * v
        H[k + 1, k] = beyond = np.sqrt(product(w, w))
        values, vectors = np.linalg.eig(H[: k + 1, : k + 1])
        exhausted = beyond <= EXHAUSTED * np.abs(H[: k + 1, : k + 1]).max()
        settled = exhausted | (beyond * np.abs(vectors[-1]) < SETTLED * np.abs(values))
        below = (values.imag == 0.0) & (values.real < BELOW)
        if (below & settled).any():
            chosen = np.where(below & settled, values.real, 0.0).argmin()
            x = moved(np.tensordot(vectors[:, chosen].real, np.array(basis), 1))
            break
        if exhausted or (k + 1 >= LEAST and not below.any()):
            return None
    else:
        x = None
    return np.zeros(0) if x is None else x

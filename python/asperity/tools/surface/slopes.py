"""Slopes of a scanned surface: facets, listed planes, nearest regular pattern, and their differences.

A facet is a piece of the scan with a vector, area times unit normal, components (N, Tx, Ty).  The average
plane is normal to the sum of these vectors.  The law sums tractions on planes with the weights gamma (3), so
gamma is a fraction of the true area: then a uniform pressure on all planes adds up to a pressure along N.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ... import contract
from ...contract import Floats
from ...pattern import Pattern, direction_vector, unit_vector
from .scan import Scan

LEAST_SHARE = 0.005
"""Smallest fraction of the nominal area of a bin; a smaller one joins the nearest bin, as planes carry load.
"""

FLATNESS = 1.0e-6  # slope (tangent) that counts as a rounding error of the heights
SAME = 1.0e-3  # bins whose slopes (tangents) differ by less than this form one plane
TIE = 1.0e-9  # planes whose slopes along a slip differ by less than this share the load
PLAUSIBLE = (3.0e-3, 3.0)  # rms slopes beyond these are doubted, because z may be in another unit than x
IMPOSSIBLE = 30.0  # rms slope that no surface has, 88 degrees: x and y are in another unit than z, as degrees
STEEP, MOST_STEEP = 85.0, 0.01  # angle, degrees, and the fraction of the area above it that is doubted, too
AS_GOOD = 0.01  # error, above the smallest one, up to which the smallest number of sides is chosen
Tick = Callable[[], object]  # function that is called after every direction


@dataclass(frozen=True, eq=False)
class Planes:
    """Facets or planes: unit normals (n, 3) with n_N > 0 and fractions (n,) of the true area, with sum 1."""

    normals: Floats
    gamma: Floats

    @classmethod
    def of(cls, pattern: Pattern) -> Planes:
        """Planes of a pattern."""
        return cls(pattern.normals, pattern.weights)

    @cached_property
    def gradients(self) -> Floats:
        """Slope vectors (n, 2): direction up the slope, length equal to the tangent."""
        return -self.normals[:, 1:] / self.normals[:, :1]

    @cached_property
    def slopes(self) -> Floats:
        """Tangent of the inclination, (n,)."""
        slopes: Floats = np.hypot(*self.gradients.T)
        return slopes

    @property
    def azimuth(self) -> Floats:
        """Direction up the slope, (n,), radians from Tx towards Ty."""
        azimuth: Floats = np.arctan2(self.gradients[:, 1], self.gradients[:, 0])
        return azimuth

    @property
    def inclination(self) -> Floats:
        """Angle between plane and average plane, (n,), degrees."""
        inclination: Floats = np.degrees(np.arctan(self.slopes))
        return inclination

    @cached_property
    def nominal(self) -> Floats:
        """Fractions of the area projected on the average plane, (n,), with sum 1."""
        projected = self.gamma * self.normals[:, 0]
        nominal: Floats = projected / projected.sum()
        return nominal

    @cached_property
    def mean_slope(self) -> float:
        """Mean of tan(inclination) over the nominal area."""
        return float(self.nominal @ self.slopes)

    @cached_property
    def rms_slope(self) -> float:
        """Root mean square of tan(inclination) over the nominal area: Z2 of a profile, Sdq of a map."""
        return float(np.sqrt(self.nominal @ self.slopes**2))

    @property
    def fabric(self) -> Floats:
        """Second moment of the slope vectors over the nominal area, (2, 2)."""
        return self.gradients.T @ (self.nominal[:, None] * self.gradients)

    def slips(self, angles: Floats, mu: float, tick: Tick = lambda: None) -> Slips:
        """Slips along angles (n,), radians, with friction mu; tick is called after each of them.

        Only the planes that are steepest along a slip are in contact at large slips.  Each closes by
        n_N times a common value, so they share the load in proportion to gamma n_N; a single plane gives the
        closed form of docs/theory.md, section 8.
        """
        rows = np.empty((3, len(angles)))
        for i, angle in enumerate(angles):  # one angle at a time saves memory: a map has millions of facets
            along = self.gradients @ unit_vector(angle)
            top = along.max()
            touching = along >= top - TIE * (1.0 + abs(top))
            n_N = self.normals[touching, 0]
            load, w = self.gamma[touching] * n_N, np.hypot(1.0, top)
            pressed = load @ (n_N - mu * top / w)
            residual = load @ (n_N * along[touching] + mu / w) / pressed if pressed > 0.0 else np.inf
            up = np.maximum(along, 0.0)
            rows[:, i] = self.nominal @ up, np.sqrt(self.nominal @ (up * up)), residual
            tick()
        return Slips(angles, mu, rows[:2], rows[2])


@dataclass(frozen=True, eq=False)
class Facets(Planes):
    """Facets of a scan in the frame of its average plane.

    ratio: true area over nominal area.  tilt: inclination of the average plane in the scan, degrees.
    profile: whether they lie along one direction.
    """

    ratio: float = 1.0
    tilt: float = 0.0
    profile: bool = False

    @property
    def doubt(self) -> str:
        """Warning about slopes that no joint has, empty if there is none."""
        steep = float(self.nominal[self.inclination > STEEP].sum())
        if self.rms_slope > FLATNESS and not PLAUSIBLE[0] <= self.rms_slope <= PLAUSIBLE[1]:
            return f"an rms slope of {self.rms_slope:.2g} is unusual: is z in the unit of x?"
        if steep > MOST_STEEP:
            text = f"{steep:.1%} of the area is inclined by more than {STEEP:g} degrees"
            return f"{text}: is z in the unit of x?"
        return ""


@dataclass(frozen=True, eq=False)
class Slips:
    """Properties of facets or planes for slips along angles (n,), radians, with friction mu.

    uphill (2, n): mean and root mean square, over the nominal area, of the slope that faces a slip.
    residual (n,): residual strength over |sigma_N|; inf: the joint locks.
    """

    angles: Floats
    mu: float
    uphill: Floats
    residual: Floats


def facets(scan: Scan, direction: float = 0.0) -> Facets:
    """Facets of a scan: segments of a profile, or four triangles for each cell of a map.

    direction: of the x axis of a profile in the Tx-Ty plane, degrees.  Both diagonals of a cell divide the
    cell into triangles, so that the result does not depend on a choice.  Raises ValueError where a facet
    overhangs.
    """
    if not np.isfinite(direction):
        raise ValueError(f"direction = {direction!r}: expected a finite angle in degrees")
    if scan.y is None:
        vectors = np.column_stack([np.diff(scan.x), -np.diff(scan.z[0]), np.zeros(len(scan.x) - 1)])
    else:
        rise = np.diff(scan.z) / np.diff(scan.x)
        climb = np.diff(scan.z, axis=0) / np.diff(scan.y)[:, None]
        cells = np.outer(np.diff(scan.y), np.diff(scan.x))
        pairs = [(gx, gy) for gx in (rise[:-1], rise[1:]) for gy in (climb[:, :-1], climb[:, 1:])]
        corners = [np.stack([cells, -gx * cells, -gy * cells], axis=-1) / 4 for gx, gy in pairs]
        vectors = np.stack(corners, axis=-2).reshape(-1, 3)
    total = vectors.sum(axis=0)
    tilt = float(np.degrees(np.arctan2(np.hypot(*total[1:]), total[0])))
    # the smallest rotation that takes the normal of the average plane to N
    vectors = Rotation.align_vectors([[1.0, 0.0, 0.0]], [total])[0].apply(vectors)
    if scan.y is None:
        vectors[:, 1:] = np.outer(vectors[:, 1], direction_vector(direction))
    area = np.linalg.norm(vectors, axis=1)
    over = np.flatnonzero(vectors[:, 0] <= FLATNESS * area)
    if len(over):
        j, i = (0, over[0]) if scan.y is None else divmod(over[0] // 4, len(scan.x) - 1)
        place = f"x = {scan.x[i]:g}" + ("" if scan.y is None else f", y = {scan.y[j]:g}")
        raise ValueError(
            f"{len(over)} facets, the first at {place}, overhang the average plane, which is tilted by "
            f"{tilt:.3g} degrees: expected n_N > 0; is z in the unit of x, is there a step that a longer "
            "sampling would bridge?"
        )
    ratio = float(area.sum() / np.linalg.norm(total))
    return Facets(_levelled(vectors / area[:, None]), area / area.sum(), ratio, tilt, scan.y is None)


def refuse_impossible(facets: Facets) -> None:
    """Raise ValueError for slopes that show that x and y are in another unit than z."""
    if facets.rms_slope > IMPOSSIBLE:
        text = f"an rms slope of {facets.rms_slope:.2g}: expected at most {IMPOSSIBLE:g}"
        raise ValueError(f"{text}: is z in the unit of x, are x and y degrees of longitude and latitude?")


def _levelled(normals: Floats) -> Floats:
    """Unit normals (n, 3), those within FLATNESS of N equal to it."""
    flat = np.hypot(*normals[:, 1:].T) <= FLATNESS * normals[:, 0]
    return np.where(flat[:, None], (1.0, 0.0, 0.0), normals)


def bin_facets(
    facets: Facets, directions: int | None = None, bins: int = 3, start: float = 0.0, flat: float = 0.0
) -> tuple[Pattern, np.ndarray]:
    """Listed planes of facets, a flat plane first, and the plane of every facet (n,).

    Facets inclined by at most `flat` (degrees) are the first bin; the others fall into `directions` sectors
    of azimuth (None: 8, of a profile 2), the first one centred at `start` (degrees), and in each into up to
    `bins` classes of inclination of equal nominal area.  A bin below LEAST_SHARE joins the nearest one.  The
    vector area of a plane is that of its facets.  Raises ValueError for numbers out of range.
    """
    usual, most = 2 if facets.profile else 8, contract.MAX_INCLINED
    directions = usual if directions is None else directions
    for name, count, least in (("directions", directions, 2), ("bins", bins, 1)):
        if not least <= contract.number(name, count) <= most or count != int(count):
            raise ValueError(f"{name} = {count!r}: expected a whole number, {least} to {most}")
    directions, bins = int(directions), int(bins)
    if facets.profile and directions != usual:
        raise ValueError(f"directions = {directions}: expected 2 for a profile")
    if (count := directions * bins + 1) > most:
        planes = f"{directions} directions of {bins} bins and the flat plane are {count} planes"
        raise ValueError(f"{planes}: expected at most {most}")
    if not 0.0 <= contract.number("flat_below", flat) < 90.0:
        raise ValueError(f"flat_below = {flat!r}: expected degrees, 0 to below 90")
    sector = 2.0 * np.pi / directions
    part = np.floor((facets.azimuth - np.radians(start)) / sector + 0.5 + FLATNESS).astype(int) % directions
    part[facets.slopes <= max(np.tan(np.radians(flat)), FLATNESS)] = -1
    label = np.full(len(part), -1)
    for k in range(directions):
        inside = np.flatnonzero(part == k)
        share = facets.nominal[inside].sum()
        if share > 0.0:
            classes = min(bins, int(np.ceil(bins * directions * share)))
            ranks = _ranks(facets.slopes[inside], facets.nominal[inside])
            label[inside] = k * bins + np.floor(ranks * classes).astype(int)
    label = np.unique(label, return_inverse=True)[1].ravel()
    vectors, label = _merged(facets, label)
    area = np.linalg.norm(vectors, axis=1)
    normals = _levelled(vectors / area[:, None])
    azimuth = np.arctan2(-normals[:, 2], -normals[:, 1]) - np.radians(start) + FLATNESS
    place = np.floor(azimuth / sector + 0.5) % directions
    place[normals[:, 0] == 1.0] = -1
    order = np.lexsort((-normals[:, 0], place))
    return Pattern.planes(normals[order], (area / area.sum())[order]), np.argsort(order)[label]


def nearest_regular(
    facets: Facets, slips: Slips | None = None, sides: int = 0, start: float = 0.0
) -> Pattern:
    """Regular pattern with the mean and the mean square slope of the facets over the nominal area.

    tan(theta) = mean square / mean, and the inclined planes have mean^2 / mean square of the nominal area.
    The rotation (turn) agrees best with the azimuths: arg(sum of slope^2 exp(i sides azimuth)) / sides.
    sides: 0 for the smallest number whose mean and rms uphill slopes for the slips are within AS_GOOD of the
    best.  Two sides have the moments of the slopes along their own direction only.  A profile has two sides,
    along `start` (degrees).
    """
    if facets.rms_slope <= FLATNESS:
        return Pattern.regular(0, 0.0)
    if facets.profile:
        return _of_moments(facets, 2, start)
    turns = _turns(facets, sides or contract.MAX_INCLINED)
    if sides:
        return _of_moments(facets, sides, turns[sides])
    if slips is None:
        raise ValueError("sides = 0: expected the slips under which sides are compared")
    tried = [_of_moments(facets, m, turn) for m, turn in turns.items()]
    angles, mu, uphill = slips.angles, slips.mu, slips.uphill
    errors = [_difference(Planes.of(pattern).slips(angles, mu).uphill, uphill) for pattern in tried]
    return next(p for p, error in zip(tried, errors, strict=True) if error <= min(errors) + AS_GOOD)


def compare(pattern: Pattern, facets: Facets, slips: Slips, of_listed: Floats) -> dict[str, float]:
    """Differences between a pattern and the facets; slips: properties of the facets.

    mean slope, fabric: relative (of tensors, Frobenius norm).  uphill: largest difference over directions of
    the mean or rms slope that faces a slip, over its largest value.  residual: largest relative difference of
    the residual strength, inf if only one of the two locks.  listed: the same, from that of the listed planes
    for the same slips, of_listed.
    """
    planes = Planes.of(pattern)
    of_pattern = planes.slips(slips.angles, slips.mu)
    return {
        "mean slope": _relative(planes.mean_slope, facets.mean_slope),
        "fabric": _relative(planes.fabric, facets.fabric),
        "uphill": _difference(of_pattern.uphill, slips.uphill),
        "residual": _of_strength(of_pattern.residual, slips.residual),
        "listed": _of_strength(of_pattern.residual, of_listed),
    }


def directions_of(facets: Facets, start: float = 0.0, count: int = 72) -> Floats:
    """Angles (radians) of the compared slips: both directions of a profile, `count` directions of a map."""
    turn = 2 if facets.profile else count
    angles: Floats = np.radians(start) + 2.0 * np.pi * np.arange(turn) / turn
    return angles


def _turns(facets: Facets, most: int) -> dict[int, float]:
    """Rotation (degrees) that agrees best with the azimuths, for each number of sides from 2 to `most`."""
    share = facets.nominal * facets.slopes**2
    wave = share.astype(complex)
    once = facets.gradients @ (1.0, 1j) / np.maximum(facets.slopes, FLATNESS)
    turns = {}
    for sides in range(1, most + 1):
        wave = wave * once
        total = wave.sum()
        # without a preferred azimuth rounding errors must not choose one
        turn = np.degrees(np.angle(total)) / sides if abs(total) > TIE * share.sum() else 0.0
        turns[sides] = 0.0 if abs(turn) < TIE else float(turn)
    del turns[1]
    return turns


def _of_moments(facets: Facets, sides: int, turn: float) -> Pattern:
    """Regular pattern with the mean and mean square slope of the facets (2 sides: along their direction)."""
    slopes = np.abs(facets.gradients @ direction_vector(turn)) if sides == 2 else facets.slopes
    mean, square = float(facets.nominal @ slopes), float(facets.nominal @ slopes**2)
    if mean <= FLATNESS:
        return Pattern.regular(0, 0.0)
    tangent, inclined = square / mean, min(1.0, mean**2 / square)
    flat = (1.0 - inclined) / (1.0 - inclined + inclined * np.hypot(1.0, tangent))
    theta = float(np.degrees(np.arctan(tangent)))
    return Pattern.regular(sides, theta, float(flat) if flat >= TIE else 0.0, turn)


def _merged(facets: Facets, label: NDArray[np.int_]) -> tuple[Floats, NDArray[np.int_]]:
    """Vector areas and labels of bins; bins below LEAST_SHARE join the nearest, bins of equal slope merge."""
    facet = facets.gamma[:, None] * facets.normals
    vectors = np.column_stack([np.bincount(label, facet[:, i]).astype(float) for i in range(3)])
    target = np.arange(len(vectors))
    total = vectors[:, 0].sum()
    while len(alive := np.unique(target)) > 1:
        slope = vectors[alive, 1:] / vectors[alive, :1]
        apart = np.hypot(*(slope[:, None] - slope[None, :]).transpose(2, 0, 1))
        np.fill_diagonal(apart, np.inf)
        least = vectors[alive, 0].argmin()
        if vectors[alive[least], 0] >= LEAST_SHARE * total:
            least = apart.min(axis=0).argmin()
            if apart[least].min() >= SAME:
                break
        nearest = alive[apart[least].argmin()]
        vectors[nearest] += vectors[alive[least]]
        target[target == alive[least]] = nearest
    alive, target = np.unique(target, return_inverse=True)
    return vectors[alive], target.ravel()[label]


def _ranks(values: Floats, weights: Floats) -> Floats:
    """Fraction of the weight below each value plus half of its own weight; equal values have the same."""
    _, group = np.unique(np.round(values / FLATNESS), return_inverse=True)
    group = group.ravel()
    of_group = np.bincount(group, weights)
    ranks: Floats = ((np.cumsum(of_group) - 0.5 * of_group) / of_group.sum())[group]
    return ranks


def _difference(values: Floats, expected: Floats) -> float:
    """Largest difference of the means or of the rms (2, n), over the largest value of the expected ones."""
    away, size = np.abs(values - expected).max(axis=1), expected.max(axis=1)
    return float(np.divide(away, size, out=(values.max(axis=1) > 0.0).astype(float), where=size > 0.0).max())


def _of_strength(values: Floats, expected: Floats) -> float:
    """Largest relative difference: 0 where both are infinite, inf where only one is."""
    if (np.isfinite(values) != np.isfinite(expected)).any():
        return np.inf
    finite = np.isfinite(expected) & (expected > 0.0)
    return float(np.max(np.abs(values[finite] / expected[finite] - 1.0), initial=0.0))


def _relative(value: Floats | float, expected: Floats | float) -> float:
    """Norm of the difference over the norm of the expected value; 0 if both are 0."""
    size = np.linalg.norm(expected)
    difference = np.linalg.norm(np.subtract(value, expected))
    return float(difference / size) if size > 0.0 else float(difference > 0.0)

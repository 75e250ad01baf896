"""The law that comes closest to a joint of Barton, as a function."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..fit.fitting import fit
from ..fit.outcome import Fit
from .command import FIXED, FREE, REACH, curves
from .joint import SAMPLE, Joint


def barton(
    jrc: float,
    jcs: float,
    phi_r: float,
    length: float,
    sigma_n: Sequence[float],
    sample: float = SAMPLE,
    reach: float = REACH,
    **search: Any,
) -> Fit:
    """Constants of the law whose curves come closest to those of a joint of Barton.

    Parameters
    ----------
    jrc, jcs, phi_r
        Roughness, wall strength (MPa) and residual friction angle (degrees) of samples.
    length, sample
        Length of the joint and of the samples, m.
    sigma_n
        Normal stresses of the curves, MPa, compression positive.
    reach
        End of the curves over the slip at the peak.
    search
        Arguments of `asperity.fit.fit`, such as sides, free and fixed.

    Returns
    -------
    Fit
        Its `interface` is the joint in mm and MPa; the intervals say which constants the curves determine.

    Raises
    ------
    ValueError
        For values out of range.

    Examples
    --------
    >>> from asperity.barton import barton
    >>> found = barton(10.0, 100.0, 30.0, 0.1, [1.0], sides=2, starts=1)
    >>> 0.2 < found.values["mu"] < 0.7
    True
    """
    tests = curves(Joint(jrc, jcs, phi_r, length, sample), list(sigma_n), reach)
    free = search.pop("free", FREE)
    fixed = {name: value for name, value in FIXED.items() if name not in free}
    return fit(tests, free, fixed | dict(search.pop("fixed", {})), **search)

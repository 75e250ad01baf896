"""Values, covariance and model error of a fit in a file, from which `asperity uncertainty` draws samples."""

from __future__ import annotations

import json
from pathlib import Path

from .constants import SCALES
from .outcome import Fit


def file_of(case: Path) -> Path:
    """File beside a case, where `asperity fit` writes the covariance."""
    return case.parent / f"{case.stem}.fit.json"


def covariance_text(found: Fit, accepted: str = "") -> str:
    """Content of the file; the covariance is widened as the intervals of the fit are.

    accepted: what the user has accepted.
    """
    names = found.problem.free
    content = {
        "parameters": names,
        "values": [found.values[name] for name in names],
        "scales": [SCALES[name] for name in names],
        "covariance on the scales": (found.covariance * found.widening**2).tolist(),
        "accepted": accepted,
        "model error of tau and s_N": found.deviation if accepted else (0.0, 0.0),
    }
    return json.dumps(content, indent=1) + "\n"

"""Functions that tests give to other processes."""

from __future__ import annotations

import os
import signal
import time
from functools import partial
from pathlib import Path

import numpy as np
from asperity import Interface, Material, Pattern
from asperity.parallel import map_in_order


def slowly_squared(value: float) -> float:
    """Square; odd numbers take longer, so that the results come in another order."""
    time.sleep(0.02 * (value % 2))
    return value**2


def refused(value: float) -> float:
    """Square of a value below 2; raises ValueError for others, the larger the sooner."""
    if value >= 2:
        time.sleep(max(0.0, 0.2 - 0.05 * value))
        raise ValueError(f"value {value:g}: expected less than 2")
    return value**2


def end_once(mark: Path, value: float) -> float:
    """Square; the process that comes first to value 3 is lost."""
    if value == 3:
        try:
            mark.touch(exist_ok=False)
        except FileExistsError:
            pass
        else:
            os.kill(os.getpid(), signal.SIGKILL)
    return value**2


def end_always(value: float) -> float:
    """Never return: the process is lost."""
    os.kill(os.getpid(), signal.SIGKILL)
    return value


def nested(value: float) -> list[float]:
    """Values of an inner loop."""
    return map_in_order(partial(pow, value), range(3))


def residual(mu: float) -> float:
    """Shear traction of a joint that slides."""
    joint = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=mu, kc=100.0), Pattern.regular(4, theta=20.0))
    time.sleep(0.02)
    return float(joint.confined_slip(10.0, np.linspace(0.0, 0.4, 41), sigma_N=-1.0).traction[-1, 1])

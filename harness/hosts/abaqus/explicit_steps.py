"""Explicit steps of the stand-in: central differences with a lumped mass, and the packager's probe."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from records import Row
from scipy import sparse
from user_routines import Vumat

if TYPE_CHECKING:
    from deck_model import Step
    from stand_in import StandIn


def explicit_step(host: StandIn, step: Step, vumat: Vumat, total: float, keep: int) -> float:
    """Central differences with a lumped mass; returns the total time at the end."""
    duration = step.keywords[1].number(step.keywords[1].data[0][1])
    prescribed, forces = host.targets(step)
    start, force, beginning = dict(host.prescribed), host.force, host.u
    points = host.points
    if not host.velocity.size:
        host.velocity = np.zeros(host.size)
        host.dt = 0.8 * stable(host, vumat)
    count = int(np.ceil(duration / host.dt))
    dt = duration / count
    internal = host.stiffness @ host.u + host.initial + points.forces(ordered(points.stress))
    load = force
    for i in range(1, count + 1):
        velocity = host.velocity + dt * (load - internal) / host.mass
        u = host.u + dt * velocity
        time = i * dt
        for freedom, value in start.items():
            u[freedom] = value
        for target, amplitude in prescribed:
            share = 1.0 if amplitude is None else host.factor(amplitude, time, duration)
            for freedom, value in target.items():
                u[freedom] = beginning[freedom] + share * (value - beginning[freedom])
        host.velocity = (u - host.u) / dt
        strain = points.separation(u)
        increment = ordered(strain - points.strain) * ([1.0] + [0.5] * (strain.shape[1] - 1))
        stress, statev = vumat.call(total + time, dt, increment, points.stress, points.statev)
        if not np.isfinite(stress).all():
            raise RuntimeError(f"step {step.name}, time {time:g}: the VUMAT has rejected a call")
        points.strain, points.stress, points.statev = strain, stress, statev
        host.u = u
        load = force + sum((host.factor(a, time, duration) * f for f, a in forces), np.zeros(host.size))
        internal = host.stiffness @ u + host.initial + points.forces(ordered(stress))
        if i % keep == 0 or i == count:
            host.rows.append(Row(step.name, time, u, internal - load, 0, statev, ordered(stress), 0.0))
    host.force = load
    freedoms = set(start).union(*(target for target, _ in prescribed))
    host.prescribed = {freedom: float(u[freedom]) for freedom in freedoms}
    return total + duration


def ordered(values: np.ndarray) -> np.ndarray:
    """The other order of the shears, which Abaqus/Explicit has in three dimensions."""
    return values if values.shape[1] == 2 else values[:, [0, 2, 1]]


def stable(host: StandIn, vumat: Vumat) -> float:
    """Stable increment, from the packager's probe and the largest frequency of the model."""
    points = host.points
    stiffness = np.empty(points.stress.shape)
    for i in range(stiffness.shape[1]):
        probe = np.zeros(points.stress.shape)
        probe[:, i] = 1.0e-6 if i == 0 else 0.5e-6
        stress, statev = vumat.call(0.0, 1.0, probe, np.zeros(probe.shape), points.statev)
        if not (statev == points.statev.astype(vumat.kind)).all():
            raise RuntimeError("the packager's probe changed the state")
        stiffness[:, i] = stress[:, i] / 1.0e-6
    diagonal = sparse.diags((ordered(stiffness) * points.area[:, None]).ravel())
    matrix = host.stiffness + points.matrix.T @ diagonal @ points.matrix
    free = np.ones(host.size, dtype=bool)
    free[list(host.prescribed)] = False
    vector = np.random.default_rng(0).random(host.size) * free
    largest = 0.0
    for _ in range(200):
        vector = (matrix @ vector) / host.mass * free
        largest = float(np.linalg.norm(vector))
        vector /= largest
    return 2.0 / np.sqrt(largest)

"""Water in the joints and on the faces of a model: given pressures, and steady flow along joints.

All of it are functions of a model, of what the conditions give, and of separations.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import basix
import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from ..contract import Floats
from ..mesh.shapes import Integers, place
from .model import Model
from .ranks import COMM, agree, doubles, largest, real

Pressure = float | Callable[..., Floats]
"""A number, or a function of places (n, d), or of places and openings (n,), with n values or one."""

FACES = {2: ("interval", [0, 1]), 3: ("triangle", [0, 1, 2]), 4: ("quadrilateral", [0, 1, 3, 2])}
"""Face in basix by its number of nodes, and these in its order."""

ROUNDING = 1e-9
"""Share of the largest pressure below 0 that counts as 0, such as at the level of the water."""

APART = 1e-6
"""Share of an opening by which another one differs that gives the slope of a pressure."""

WIDEST = 3e7
"""Most that a face lets through over the narrowest one on the widest path between two given pressures by it.

No gradient is left in what lets more through, such as an open part of a closed joint.  Rounding errors of the
matrix, which adds what wide and narrow faces let through, are some 1e-7 of pressures and inflows then.
"""

DEGREE, DEGREE_FLOW = 8, 5
"""Of the quadrature: a pressure on faces may have a kink, as at the level of the water; a^3 of the flow."""


def quadrature(x: Floats, degree: int) -> tuple[Floats, Floats, Floats]:
    """Of faces x (f, k, d): functions of the nodes (q, k), tangents (f, q, r, d), weights (q,)."""
    name, order = FACES[x.shape[1]]
    cell = basix.CellType[name]
    points, weights = basix.make_quadrature(cell, degree)
    table = basix.create_element(basix.ElementFamily.P, cell, 1).tabulate(1, points)[:, :, :, 0]
    table[:, :, order] = table.copy()
    return table, np.einsum("rqk,fkd->fqrd", table[1:], x), weights


def metric_of(tangents: Floats, weights: Floats) -> tuple[Floats, Floats]:
    """Metric (f, q, r, r) of the tangents, and areas (f, q) of the points of a quadrature."""
    metric = np.einsum("fqrd,fqsd->fqrs", tangents, tangents)
    return metric, weights * np.sqrt(np.linalg.det(metric))


def of_opening(p: Pressure) -> bool:
    """Whether a pressure is a function of the opening, too."""
    words = inspect.signature(p).parameters.values() if callable(p) else ()
    return sum(word.default is word.empty and word.kind <= word.POSITIONAL_OR_KEYWORD for word in words) > 1


WATER = "the water"
"""First words of the reason of a report whose pressures were refused."""


class WaterError(ValueError):
    """A pressure that is negative or not finite at some openings, or that its function refuses there."""


def values_of(name: str, p: Pressure, x: Floats, *opening: Floats) -> tuple[Floats, str, str]:
    """Pressures (n,) at places (n, d), what is wrong with the function, and with its values."""
    none = np.zeros(len(x))
    if of_opening(p) and not opening:
        return none, f"{name}: p is a function of the opening: expected one of places alone", ""
    try:
        given = p(x, *opening) if callable(p) else p
    except ValueError as error:  # perhaps at the places of one rank alone
        given, refused = none, f"{name}: p: {error}"
    else:
        refused = ""
    pressures = doubles(f"{name}: p", given)
    if pressures.shape not in ({(), (len(x),)} if callable(p) else {()}):
        expected = f"one number or {len(x)}" if callable(p) else "a number or a function of places"
        return none, f"{name}: p of the shape {pressures.shape}: expected {expected}", ""
    pressures = np.broadcast_to(pressures, len(x)).copy()
    pressures[(pressures < 0.0) & (pressures >= -ROUNDING * pressures.max(initial=0.0))] = 0.0
    bad = np.flatnonzero(~(np.isfinite(pressures) & (pressures >= 0.0)))
    for k in bad[:1]:
        refused = f"{name}: p = {pressures[k]:g} at {place(x[k])}: expected a finite water pressure >= 0"
    return pressures, "", refused


@dataclass(frozen=True)
class Flow:
    """Steady flow of water along joints, q = -a^3/(12 viscosity) (grad p - weight) per width.

    a = max(a_min, a_0 + s_N) is the aperture; a_0 may be given by joint.  given: pressures by group, where
    its nodes are those of the joints.  weight: of the water, force per volume (d,).  The flow goes through
    where the joints meet.  An equilibrium raises ValueError where nodes of a joint are cut off from every
    given pressure.
    """

    joints: str | Sequence[str]
    given: Mapping[str, Pressure]
    viscosity: float
    a_0: float | Mapping[str, float] = 0.0
    a_min: float = 0.0
    weight: Sequence[float] | None = None

    @property
    def names(self) -> list[str]:
        """Names of the joints."""
        return [self.joints] if isinstance(self.joints, str) else list(self.joints)


class Network:
    """Equations of a flow: linear in the pressures at the places of its joints.

    All ranks have the whole.
    """

    def __init__(
        self,
        names: list[str],
        joint: Integers,
        places: Integers,
        corners: Floats,
        given: dict[str, tuple[Integers, Floats]],
        law: tuple[float, Floats, float, Floats],
    ) -> None:
        """Refuse places that are cut off; joint (f,), places (f, k) and corners (f, k, d) of the faces.

        given: places and pressures by group.  law: viscosity over the width, a_0 by joint, a_min, weight.
        """
        self.names, self.corners = names, corners
        self.viscosity, a_0, self.a_min, weight = law
        self.a_0 = a_0[joint][:, None]
        known, nodes = np.unique(places, return_inverse=True)
        self.nodes: Integers = nodes.reshape(places.shape)
        n = len(known)
        self.p = np.full(n, np.nan)
        self.at = {name: np.searchsorted(known, at_places) for name, (at_places, _) in given.items()}
        x = np.empty((n, corners.shape[2]))
        x[self.nodes] = corners
        for name, (_, values) in given.items():
            old = self.p[self.at[name]]
            for k in np.flatnonzero(np.abs(old - values) > 1e-9 * values.max())[:1]:
                where = place(x[self.at[name][k]])
                raise ValueError(f"{name}: p = {values[k]:g} at {where}, but {old[k]:g} by another group")
            self.p[self.at[name]] = values
        self.free = np.isnan(self.p)
        # water flows between given nodes whose potentials p - weight . x differ, numbered from 1
        heads = np.where(self.free, 0.0, self.p), x @ weight
        scale = max(float(np.abs(head).max()) for head in heads) or 1.0
        driven = np.round((heads[0] - heads[1]) / (1e-9 * scale))
        self.driven: Integers = np.where(self.free, 0, 1 + np.unique(driven, return_inverse=True)[1])
        pairs = np.stack([self.nodes, np.roll(self.nodes, 1, axis=1)]).reshape(2, -1)
        links = coo_array((np.ones(pairs.shape[1], np.int8), tuple(pairs)), shape=(n, n))
        count, part = connected_components(links, directed=False)
        dry = np.bincount(part, ~self.free, count) == 0.0
        for f in np.flatnonzero(dry[part[self.nodes[:, 0]]])[:1]:
            text = f"{names[joint[f]]}: {dry[part].sum()} nodes are cut off from every given p, as at "
            raise ValueError(f"{text}{place(x[self.nodes[f, 0]])}: expected one of {', '.join(given)} there")
        table, tangents, weights = quadrature(corners, DEGREE_FLOW)
        metric, self.weights = metric_of(tangents, weights)
        inverse = np.linalg.inv(metric)
        self.gradients = np.einsum("rqk,fqrs,fqsd->fqkd", table[1:], inverse, tangents, optimize=True)
        self.shape = table[0]
        self.pull = self.gradients @ weight

    def aperture(self, opening: Floats) -> Floats:
        """Aperture (f, k) of faces by their openings."""
        return np.maximum(self.a_min, self.a_0 + opening)

    def _system(self, cubed: Floats) -> tuple[csr_array, Floats]:
        """Matrix and right-hand side of a^3/(12 viscosity) times the weights, (f, q)."""
        matrix = np.einsum("fqkd,fqld,fq->fkl", self.gradients, self.gradients, cubed, optimize=True)
        pulled = np.einsum("fqk,fq->fk", self.pull, cubed)
        k, n = self.nodes.shape[1], len(self.p)
        rows, columns = np.repeat(self.nodes, k, 1).ravel(), np.tile(self.nodes, k).ravel()
        A: csr_array = coo_array((matrix.ravel(), (rows, columns)), shape=(n, n)).tocsr()
        b = np.asarray(np.bincount(self.nodes.ravel(), pulled.ravel(), n), float)
        return A, b

    def _shares(self, cubed: Floats) -> Floats:
        """Shares (f, 1) of what faces let through, (f, q), that count: 1, or less as of WIDEST."""
        through = np.maximum(cubed.sum(1) / self.weights.sum(1), np.finfo(float).tiny)
        high, low = (int(np.floor(np.log10(end))) for end in (through.max(), through.min()))
        if high - low <= np.log10(WIDEST):
            return np.ones((len(through), 1))
        n, widest = len(self.p), np.zeros(len(self.p))
        known = np.flatnonzero(self.driven)
        for level in 10.0 ** np.arange(high, low - 1.0, -1.0):
            nodes = self.nodes[through >= level]
            pairs = np.stack([nodes, np.roll(nodes, 1, axis=1)]).reshape(2, -1)
            links = coo_array((np.ones(pairs.shape[1], np.int8), tuple(pairs)), shape=(n, n))
            count, part = connected_components(links, directed=False)
            ends = np.unique(np.stack([part[known], self.driven[known]]), axis=1)
            between = np.bincount(ends[0], minlength=count) > 1
            widest[(widest == 0.0) & between[part]] = level
        widest[widest == 0.0] = level
        shares: Floats = np.minimum(1.0, WIDEST * widest[self.nodes].max(1) / through)[:, None]
        return shares

    def _balanced(
        self, opening: Floats
    ) -> tuple[csr_array, Floats, Floats, Floats, Callable[[Floats], Floats]]:
        """Matrix, right-hand side, pressures (n,), shares of faces, change of the pressures by that side."""
        cubed = (self.aperture(opening) @ self.shape.T) ** 3 / (12.0 * self.viscosity) * self.weights
        shares = self._shares(cubed)
        A, b = self._system(cubed * shares)
        p, free = self.p.copy(), self.free
        factor = splu(A[free][:, free].tocsc()) if free.any() else None

        def change(more: Floats) -> Floats:
            dp = np.zeros(len(p))
            if factor:
                dp[free] = factor.solve(more[free])
            return dp

        p[free] = 0.0
        return A, b, p + change(b - A @ p), shares, change

    def solve(self, opening: Floats) -> tuple[Floats, dict[str, float]]:
        """Pressures (f, k) at the openings (f, k), and inflows at the given ones by group, volume per time.

        Pressures below 0, as a weight may give, count as 0.
        """
        A, b, p, *_ = self._balanced(opening)
        inflow = A @ p - b
        rates = {name: float(inflow[at].sum()) for name, at in self.at.items()}
        return np.maximum(p, 0.0)[self.nodes], rates

    def following(self, opening: Floats) -> Callable[[Floats], Floats]:
        """Changes (f, k) of the pressures by small changes of the openings (f, k)."""
        _, _, p, shares, change = self._balanced(opening)
        squared = (self.aperture(opening) @ self.shape.T) ** 2 / (4.0 * self.viscosity) * self.weights
        squared *= shares == 1.0
        wide, wet = self.a_0 + opening > self.a_min, p > 0.0

        def followed(more: Floats) -> Floats:
            dA, db = self._system(squared * ((more * wide) @ self.shape.T))
            return (change(db - dA @ p) * wet)[self.nodes]

        return followed


def in_joint(m: Model, name: str, p: Pressure, s: Floats) -> Floats:
    """Pressures at the points of a joint, at separations of all points.

    Raises WaterError for values that cannot be, ValueError for another shape.
    """
    part = m.parts[m.joints.index(name)]
    opening = [s[part, 0]] if of_opening(p) else []
    values, wrong, refused = values_of(name, p, m.places[part], *opening)
    agree(wrong)
    agree(refused, error=WaterError if opening else ValueError)
    return values


def on_faces(m: Model, name: str, p: Pressure) -> Floats:
    """Nodal forces (n d,) of a pressure on the faces of a group, which all ranks compute."""
    group = m.groups[name]
    agree(f"{name}: {group.message}" if group.message else "")
    table, along, weights = quadrature(group.corners, DEGREE)
    at = np.einsum("qk,fkd->fqd", table[0], group.corners)
    values, *wrong = values_of(name, p, at.reshape(-1, m.d))
    agree(*wrong)
    if m.d == 2:  # out of the cells, which are on the left
        normal = np.stack([along[:, :, 0, 1], -along[:, :, 0, 0]], axis=2)
    else:
        normal = np.cross(along[:, :, 0], along[:, :, 1])
    values = m.around(np.moveaxis(at, -1, 0)) * values.reshape(at.shape[:2]) * weights
    forces = -np.einsum("fq,qk,fqd->fkd", values, table[0], normal, optimize=True)
    local, here = m.owned(group.faces.ravel())
    nodal_forces = np.zeros((m.n, m.d))
    np.add.at(nodal_forces, local, forces.reshape(-1, m.d)[here])
    return nodal_forces.ravel()


def weights_of_faces(m: Model) -> tuple[Floats, Floats]:
    """Places (f, q, d) in the faces of joints here, and their shares (f, q, k) in the nodes."""
    *_, corners, mine = m.faces
    table, tangents, weights = quadrature(corners[mine], DEGREE_FLOW)
    _, sizes = metric_of(tangents, weights)
    return np.einsum("qk,fkd->fqd", table[0], corners[mine]), sizes[:, :, None] * table[0]


def _network(m: Model, flow: Flow) -> tuple[Network, Integers]:
    """Equations of a flow, and its faces among those of all ranks; ValueError for wrong constants."""
    if m.axisymmetric:
        raise ValueError("flow in a body of revolution: expected a plane mesh, or one in space")
    names, given, a_0 = flow.names, flow.given, flow.a_0
    first = dict(a_0) if isinstance(a_0, Mapping) else dict.fromkeys(names, a_0)
    pull = np.zeros(m.d) if flow.weight is None else doubles("weight", flow.weight)
    viscosity, a_min = flow.viscosity, flow.a_min
    numbers = {"viscosity": viscosity, "a_min": a_min, **{f"a_0 of {name}": a for name, a in first.items()}}
    agree(*(f"{name} = {a!r}: expected a finite number" for name, a in numbers.items() if not real(a)))
    if not isinstance(given, Mapping):
        raise ValueError(f"given {given!r}: expected pressures by group")
    unknown = [name for name in names if name not in m.joints]
    lost = [name for name in given if name not in m.groups]
    checks = {
        f"{''.join(unknown[:1])}: no such joint: expected one of {', '.join(m.joints)}": not unknown,
        f"joints {names}: expected at least one, each once": 0 < len(names) == len(set(names)),
        f"given {dict(given)}: expected the pressure at one group at least": len(given) > 0,
        f"{''.join(lost[:1])}: no such group: expected one of {', '.join(m.groups)}": not lost,
        f"viscosity = {viscosity}: expected above 0": viscosity > 0.0,
        f"a_min = {a_min}: expected above 0": a_min > 0.0,
        f"a_0 of {', '.join(first)}: expected one for each of {', '.join(names)}": {*first} == {*names},
        f"weight = {pull.tolist()}: expected {m.d} finite numbers":
            pull.shape == (m.d,) and bool(np.isfinite(pull).all()),
    }  # fmt: skip
    agree(next((text for text, good in checks.items() if not good), ""))
    joint, all_places, all_corners, _ = m.faces
    number = np.array([names.index(name) if name in names else -1 for name in m.joints])[joint]
    rows = np.flatnonzero(number >= 0)
    places, corners, ends = all_places[rows], all_corners[rows], {}
    known, first_at = np.unique(places, return_index=True)
    for name, p in given.items():
        inside = np.isin(known, m.groups[name].places)
        message = "" if inside.any() else f"{name}: no node of {', '.join(names)} is in it"
        values, *wrong = values_of(name, p, corners.reshape(-1, m.d)[first_at[inside]])
        agree(message, *wrong)
        ends[name] = known[inside], values
    law = viscosity / m.thickness, np.array([first[name] for name in names], float), a_min, pull
    return Network(names, number[rows], places, corners, ends, law), rows


class Water:
    """Water that conditions give to a model.

    outer (n d,): nodal forces of the pressures on faces.  moves: whether pressures in joints depend on
    separations.
    """

    def __init__(self, model: Model, pressures: Mapping[str, Pressure], flows: Sequence[Flow] = ()) -> None:
        """Check what is given; raises ValueError that names what is wrong."""
        self.model = m = model
        self.networks = [_network(m, flow) for flow in flows]
        names = [name for network, _ in self.networks for name in network.names]
        agree(*(f"{name}: it is in two flows" for name in names if names.count(name) > 1))
        self.outer, self.fixed = np.zeros(m.n * m.d), np.zeros(len(m.pairs))
        self.by_opening: dict[str, Pressure] = {}
        known = ", ".join(dict.fromkeys([*m.joints, *m.groups]))
        for name, p in pressures.items():
            agree(f"{name}: its pressure is that of a flow" if name in names else "")
            if name in m.joints:
                if of_opening(p):
                    self.by_opening[name] = p
                else:
                    self.fixed[m.parts[m.joints.index(name)]] = in_joint(m, name, p, self.fixed[:, None])
            elif name in m.groups:
                self.outer = self.outer + on_faces(m, name, p)
            else:
                agree(f"{name}: no such joint or group: expected one of {known}")
        self.moves = bool(self.by_opening or self.networks)

    def _opening(self, rows: Integers, s: Floats) -> tuple[Floats, Integers, Integers]:
        """Openings (f, k) of faces of all ranks; which of them are here, and their numbers here."""
        m = self.model
        _, places, _, all_mine = m.faces
        mine = all_mine[rows]
        here = np.cumsum(all_mine)[rows[mine]] - 1
        openings = np.zeros((len(rows), places.shape[1]))
        openings[mine] = s[m.face_points[here], 0]
        return COMM.allreduce(openings), mine, here

    def at(self, s: Floats) -> tuple[Floats, tuple[dict[str, float], ...]]:
        """Pressures (p,) at the points that belong to separations (p, 3), and the inflows of each flow."""
        if not self.moves:
            return self.fixed, ()
        new, m, rates = self.fixed.copy(), self.model, []
        for name, p in self.by_opening.items():
            new[m.parts[m.joints.index(name)]] = in_joint(m, name, p, s)
        for network, rows in self.networks:
            opening, mine, here = self._opening(rows, s)
            pressures, inflows = network.solve(opening)
            new[m.face_points[here]] = pressures[mine]
            rates.append(inflows)
        return new, tuple(rates)

    def following(self, s: Floats) -> Callable[[Floats], Floats]:
        """Changes (p,) of the pressures at the points by small changes (p, 3) of the separations."""
        m, flows = self.model, []
        slopes = np.zeros(len(s))
        apart = APART * np.maximum(np.abs(s[:, 0]), APART * largest(s))
        for name, p in self.by_opening.items():
            part, wider = m.parts[m.joints.index(name)], s.copy()
            wider[:, 0] += apart
            slopes[part] = (in_joint(m, name, p, wider) - in_joint(m, name, p, s)) / np.where(
                apart[part] > 0.0, apart[part], 1.0
            )
        for network, rows in self.networks:
            flows.append((network.following(self._opening(rows, s)[0]), rows))

        def followed(ds: Floats) -> Floats:
            dp = slopes * ds[:, 0]
            for change, rows in flows:
                opening, mine, here = self._opening(rows, ds)
                dp[m.face_points[here]] = change(opening)[mine]
            return dp

        return followed

    def aperture(self, s: Floats) -> Floats:
        """Apertures at the nodes of the faces here, (f, k); a_0 and a_min are 0 where nothing flows."""
        apertures: Floats = np.maximum(0.0, s[self.model.face_points, 0])
        for network, rows in self.networks:
            opening, mine, here = self._opening(rows, s)
            apertures[here] = network.aperture(opening)[mine]
        return apertures

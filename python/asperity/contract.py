"""PROPS and STATEV as the library defines them: index, name, unit, range and default of each entry."""

from __future__ import annotations

import reprlib
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, calls

Floats = NDArray[np.float64]


@cache
def tables() -> dict[str, Any]:
    """Tables of the library by names (tables_json of asperity_json)."""
    by_name: dict[str, Any] = calls.document(_core.asperity_tables)
    return by_name


_SIZES = tables()["sizes"]
N_FIXED_PROPS: int = _SIZES["fixed_props"]
N_REQUIRED_PROPS: int = _SIZES["required_props"]
N_LISTED_VALUES: int = _SIZES["listed_values"]
N_POINT_STATEV: int = _SIZES["point_statev"]
N_PLANE_STATEV: int = _SIZES["plane_statev"]
N_FACET_STATEV: int = _SIZES["facet_statev"]
N_CAP_STATEV: int = _SIZES["cap_statev"]
MAX_INCLINED: int = _SIZES["max_inclined"]
"""Numbers of PROPS before the listed planes, without a default, and of a listed plane; numbers of state
variables of a point, of a plane, with wear, of its facet and, with fc, of the joint; largest number of
inclined planes.
"""


@dataclass(frozen=True)
class Prop:
    """One entry of PROPS; index counts from 1, and default is None where a value is required.

    owner: law, pattern, host, numerics or reserved. lower, upper: smallest and largest admissible value.
    scale: linear, log, logit or whole. plausible: smallest and largest value that joints have, in multiples
    of the sizes of the unit, which are the largest stress and length of a test.  inclined: whether it is one
    of inclined planes only.  shown_by: what in a test determines it; may be empty.
    """

    index: int
    name: str
    owner: str
    meaning: str
    unit: str
    admissible: str
    scale: str
    shown_by: str
    lower: float
    upper: float
    default: float | None
    plausible: tuple[float, float]
    inclined: bool

    @property
    def integral(self) -> bool:
        """Whether the value must be a whole number."""
        return self.scale == "whole"


@dataclass(frozen=True)
class Statev:
    """One state variable; index counts from 1 and is, for a variable of a plane, that of the first plane."""

    index: int
    name: str
    meaning: str
    unit: str


@cache
def props_table() -> tuple[Prop, ...]:
    """Entries of PROPS before the listed planes, in their order."""
    rows = []
    for index, row in enumerate(tables()["props"], 1):
        required = {"default": None} if index <= N_REQUIRED_PROPS else {}
        rows.append(Prop(index, **row | {"plausible": tuple(row["plausible"])} | required))
    return tuple(rows)


N_USED_PROPS = max(row.index for row in props_table() if row.owner != "reserved")
"""Number of PROPS up to the last one before the listed planes that is not reserved."""


def owned(*owners: str) -> tuple[Prop, ...]:
    """Entries of PROPS that belong to the law, the pattern, the host or the numerics, in their order."""
    return tuple(row for row in props_table() if row.owner in owners)


def of_asperities(*units: str) -> tuple[str, ...]:
    """Names of the constants by which asperities end, wear or yield; units: only those of these units."""
    rows = (row for row in owned("law") if row.inclined)
    return tuple(row.name for row in rows if not units or row.unit in units)


@cache
def statev_table() -> tuple[Statev, ...]:
    """State variables of a point, of the first plane, of its facet (with wear) and of the joint (with fc)."""
    return tuple(Statev(index, **row) for index, row in enumerate(tables()["statev"], 1))


@cache
def statev_names(n_planes: int, wears: bool = False, yields: bool = False) -> tuple[str, ...]:
    """Names of the columns of a state of n_planes planes: damage, ..., alpha_1, s_dit_1, s_dih_1, ...

    With wear the names of the facets follow: worn_1, wear_work_1, ...; with fc kappa and crushing.
    """
    names = [row.name for row in statev_table()]
    n_plane = N_POINT_STATEV + N_PLANE_STATEV
    columns = names[:N_POINT_STATEV]
    for names_of_plane in (names[N_POINT_STATEV:n_plane], names[n_plane:-N_CAP_STATEV] if wears else []):
        columns += [f"{name}_{k}" for k in range(1, n_planes + 1) for name in names_of_plane]
    return (*columns, *(names[-N_CAP_STATEV:] if yields else ()))


@cache
def implex_table() -> tuple[Statev, ...]:
    """State variables of IMPL-EX (PROPS 25) in a UMAT, which follow the others; index counts among them."""
    return tuple(Statev(index, **row) for index, row in enumerate(tables()["implex"], 1))


def umat_names(
    n_planes: int, wears: bool = False, implex: float = 0.0, yields: bool = False
) -> tuple[str, ...]:
    """Names of STATEV in a UMAT: those of the state, and of IMPL-EX jump_N, ..., growth_1, ..., e_a, e_t.

    Those of the joint with fc, kappa and crushing, are the last.
    """
    *point, plane, e_a, e_t = (row.name for row in implex_table())
    of_aim = (*point, *(f"{plane}_{k}" for k in range(1, n_planes + 1)), e_a, e_t)
    of_law = statev_names(n_planes, wears)
    last = statev_names(n_planes, wears, yields)[len(of_law) :]
    return of_law + (of_aim if implex > 0.0 else ()) + last


def n_statev(n_planes: int, wears: bool = False, yields: bool = False) -> int:
    """Number of state variables of a pattern of n_planes planes.

    wears: whether the facets wear; yields: whether the joint has a compressive strength.
    """
    return N_POINT_STATEV + (N_PLANE_STATEV + wears * N_FACET_STATEV) * n_planes + yields * N_CAP_STATEV


def statev_index(name: str) -> int:
    """Position in STATEV, from 0, of a state variable of a point or of the first plane; raises KeyError."""
    return _STATEV[name].index - 1


_STATEV = {row.name: row for row in statev_table()}
_PROPS = {row.name: row for row in props_table()}


def index(name: str) -> int:
    """Position of an entry in a PROPS vector, from 0; raises KeyError for an unknown name."""
    return _PROPS[name].index - 1


def default(name: str) -> float:
    """Default of an entry of PROPS; raises KeyError for an unknown name, ValueError for a required one."""
    value = _PROPS[name].default
    if value is None:
        raise ValueError(f"{name} has no default")
    return value


def joint_constants(kn: float, ks: float) -> dict[str, float]:
    """Constants by name, in the order of PROPS, of a joint without bond with these stiffnesses."""
    props = np.full(N_FIXED_PROPS, np.nan)
    _core.asperity_joint(kn, ks, props)
    places = np.flatnonzero(~np.isnan(props)).tolist()
    return {props_table()[i].name: float(props[i]) for i in places}


def pack(values: dict[str, float], listed: Iterable[float] = ()) -> Floats:
    """Vector PROPS from values by name, with defaults for the others, and the values of the listed planes."""
    props = np.array([0.0 if row.default is None else row.default for row in props_table()])
    for name, value in values.items():
        props[index(name)] = number(name, value, _PROPS[name].admissible)
    return np.concatenate([props, np.array(list(listed), dtype=float)])


def number(name: str, value: float | str, admissible: str = "a finite number") -> float:
    """Convert a value to a double; raises ValueError with its name if that is not possible.

    Of texts only those that other programs read, too: Python takes 1_0 for 10, and digits of any script.
    """
    try:
        return float(plain(value) if isinstance(value, str) else value)
    except (OverflowError, TypeError, ValueError):
        raise ValueError(f"{name} = {shown(value)}: expected {admissible}") from None


def plain(text: str) -> str:
    """Return the text of a number; raises ValueError for one that no other program reads as Python does."""
    if "_" in text or not text.isascii():
        raise ValueError(text)
    return text


def array(name: str, value: ArrayLike, *shapes: tuple[int | str, ...]) -> Floats:
    """Convert an array to contiguous doubles; raises ValueError with its name and the value that is wrong.

    shapes: those that are admissible, if not any is; a letter stands for any length.
    """
    # arrays of doubles, as those of each call in a loop, need no conversion
    if type(value) is np.ndarray and value.dtype == np.float64 and value.shape in shapes:
        return np.asarray(value, order="C")
    try:
        kind = np.asarray(value).dtype.kind
        if kind in "cmM" or np.ma.is_masked(value):  # NumPy would drop imaginary parts, units and masks
            raise TypeError({"c": "complex", "m": "durations", "M": "dates"}.get(kind, "masked values"))
        converted = np.asarray(value, dtype=float, order="C")
    except (OverflowError, TypeError, ValueError) as error:
        try:
            for i, entry in np.ndenumerate(np.asarray(value, dtype=object)):
                number(f"{name}[{', '.join(map(str, i))}]", entry)
        except ValueError as wrong:
            raise wrong from None
        raise ValueError(f"{name}: {error}, expected numbers") from None
    if not shapes or converted.shape in shapes:
        return converted
    for shape in shapes:
        any_length = (m if isinstance(n, str) else n for n, m in zip(shape, converted.shape, strict=False))
        if len(shape) == converted.ndim and converted.shape == tuple(any_length):
            return converted
    expected = " or ".join(str(shape).replace("'", "") for shape in shapes)
    raise ValueError(f"{name} has shape {converted.shape}: expected {expected}")


def shown(value: object) -> str:
    """Text of a value in a message; a long text is cut."""
    try:
        return reprlib.repr(value)
    except ValueError:  # Python does not print integers of more than 4300 digits.
        return f"an integer of {int.bit_length(value)} bits" if isinstance(value, int) else "a huge number"


def check(props: Floats) -> tuple[int, bool]:
    """Number of planes of a PROPS vector, and whether their facets wear or are crushed.

    These and `yields` are the arguments of `n_statev` and `statev_names`.  Raises ValueError with every bad
    value and what was expected.
    """
    return _sizes(np.ascontiguousarray(props, dtype=float).tobytes())


@lru_cache(maxsize=1024)
def _sizes(constants: bytes) -> tuple[int, bool]:
    """Sizes of the PROPS of these bytes; a load path asks several times for those of its interface."""
    props = np.frombuffer(constants)
    room = calls.message_room(1)
    nstatv = _core.asperity_nstatv(props, room)
    if nstatv == 0:
        calls.content(b"&step s_N = 0 /", props)  # raises, with all errors by name
        # good constants of which the C API takes all but IMPL-EX
        of_law = props.copy()
        of_law[index("implex")] = 0.0
        nstatv = _core.asperity_nstatv(of_law, room)
    n_planes = _core.asperity_planes(props, np.empty((1, 3)), np.empty(1))
    return n_planes, nstatv > n_statev(n_planes, yields=yields(props))


def yields(props: Floats) -> bool:
    """Whether a PROPS vector, which may be too short for it, has a compressive strength, fc > 0."""
    return bool((props[index("fc") :][:1] > 0.0).any())


def library_version() -> str:
    """Version compiled into the library."""
    version: str = tables()["version"]
    return version

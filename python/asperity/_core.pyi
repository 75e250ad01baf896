from numpy import bytes_, float64, int32
from numpy.typing import NDArray

_Floats = NDArray[float64]
_Integers = NDArray[int32]
_Texts = NDArray[bytes_]

def contract_sizes() -> tuple[int, int, int, int, int, int]: ...
def contract_prop(
    i: int,
) -> tuple[bytes, bytes, bytes, bytes, bytes, float, float, float, int]: ...
def contract_statev(i: int) -> tuple[bytes, bytes, bytes]: ...
def contract_version() -> bytes: ...
def interface_review(props: _Floats) -> tuple[int, int]: ...
def interface_complaint(props: _Floats) -> bytes: ...
def interface_warnings(
    props: _Floats, pressure: float, tension: float, slip: float
) -> tuple[bytes, bytes]: ...
def interface_planes(props: _Floats, n_planes: int) -> tuple[_Floats, _Floats]: ...
def interface_update(
    props: _Floats,
    s_old: _Floats,
    s: _Floats,
    dt: float,
    state: _Floats,
    traction: _Floats,
    tangent: _Floats,
) -> tuple[int, bytes]: ...
def interface_initial(props: _Floats, traction: _Floats, state: _Floats) -> tuple[int, bytes]: ...
def step_entry(i: int) -> tuple[bytes, int, float, bytes]: ...
def path_rows(
    props: _Floats,
    counts: _Integers,
    values: _Floats,
    start: _Floats,
    state: _Floats,
    refines: int,
    tolerance: float,
    numbers: _Floats,
    states: _Floats,
    events: _Texts,
) -> tuple[int, int, int, bytes]: ...

"""What counts as a number, a kind and an array at every entry of the FEniCSx room; wrong ones are named."""

from __future__ import annotations

import pytest
from on_ranks import RANKS, WITH_FENICSX, assert_refused, of_all_ranks

pytestmark = WITH_FENICSX


def test_numbers() -> None:
    """A number is finite and no bool, text, array or complex number; a whole one is no float."""
    results = of_all_ranks(
        """
from asperity.fenicsx.ranks import real, whole_number
numbers = 1, 2.5, np.float64(-1.0), np.int32(3), 10**400, True, "1", None, np.nan, np.inf, 1j, np.ones(1)
results["real"] = [real(number) for number in numbers]
numbers = 2, 3, np.int64(2), 1, 2.0, np.float64(2), True, "2", None
results["whole"] = [whole_number(number, 2) for number in numbers]
""",
        1,
    )
    assert results["real"] == [True] * 4 + [False] * 8
    assert results["whole"] == [True] * 3 + [False] * 6


@pytest.mark.parametrize("ranks", RANKS)
def test_wrong_kinds_and_arrays(ranks: int) -> None:
    """Every rank names what one of them has: no instance of a class, and no real numbers."""
    one = "COMM.rank == COMM.size - 1"
    expected = {
        f"expect(str, here=1.0 if {one} else 'a')": "here of the type float: expected str",
        "doubles('x', [True, False])": "x of the type bool: expected numbers",
        f"doubles('x', ['1'] if {one} else [1.0])": "x",
        "doubles('x', np.array([1.0, 2.0], object))": "x of the type object: expected numbers",
        "doubles('x', [1.0, None])": "x of the type object: expected numbers",
        "doubles('x', [1.0, 2j])": "x",
        "doubles('x', [[1.0], [2.0, 3.0]])": "x",
    }
    assert_refused(expected, "from asperity.fenicsx.ranks import doubles, expect\n", ranks)


def test_what_is_accepted() -> None:
    """Whole numbers become doubles, and an instance of a class passes."""
    results = of_all_ranks(
        """
from asperity.fenicsx.ranks import doubles, expect
expect(str, here="a")
row = doubles("x", [1, 2])
results["row"] = row.tolist(), row.dtype.kind
""",
        1,
    )
    assert results["row"] == [[1.0, 2.0], "f"]


@pytest.mark.parametrize("ranks", RANKS)
def test_wrong_arguments_of_results(ranks: int) -> None:
    """`Output` and `measure` name what is wrong."""
    code = """
import tempfile
m = model()
state = State.virgin(m)
folder = COMM.bcast(tempfile.mkdtemp() if COMM.rank == 0 else None)
output = Output(m, f"{folder}/a.pvd")
short = replace(state, u=np.zeros(3))
"""
    expected = {
        "Output(state, 'a.pvd')": "model of the type State: expected Model",
        "Output(m, 3)": "pvd of the type int: expected str or Path",
        "Output(m, f'{folder}/a.vtk')": "expected a name that ends with .pvd",
        "output.write(m)": "state of the type Model: expected State",
        "output.write(short)": "state: expected one of this model",
        "output.write(state, '1')": "time = 1: expected a finite number",
        "output.write(state, np.nan)": "time = nan: expected a finite number",
        "output.write(state, flows=3)": "flows of the type int: expected Sequence",
        "output.write(state, flows=[3])": "flows[0] of the type int: expected Flow",
        "output.write(state, ledger=1.0)": "ledger of the type float: expected Ledger",
        "measure(state, 'joint', state)": "model of the type State: expected Model",
        "measure(m, 3, state)": "name of the type int: expected str",
        "measure(m, 'other', state)": "other: no such joint: expected one of joint",
        "measure(m, 'joint', 1.0)": "state of the type float: expected State",
        "measure(m, 'joint', short)": "state: expected one of this model",
        "measure(m, 'joint', state, 1.0)": "before of the type float: expected State",
        "measure(m, 'joint', state, short)": "state: expected one of this model",
    }
    assert_refused(expected, code, ranks)

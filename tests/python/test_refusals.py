"""What each command refuses: a message with place, value and expectation, exit code 1, and no file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

CASE = """&case title = 'joint' /
&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5, kc = 10.0 /
&pattern sides = 4, theta = 20.0, flat = 0.25 /
&step t_N = -1.0, increments = 10 /
&step slip = 0.2, -0.2, increments = 20, 40 /
"""
PATTERN = "sides = 4, theta = 20.0, flat = 0.25"
LISTED = "normals = 1, 0, 0, weights = 1"
FIRST_STEP = "&step t_N = -1.0, increments = 10 /\n&step slip = 0.2, -0.2, increments = 20, 40 /\n"
JOINT = "kn=82 ks=36 ft=.25 GfI=.018 c=.35 GfII=.125 tan_phi=.75"
INCREASE = "expected x to increase"


def changed(*pairs: str, sweep: str = "") -> str:
    """The case with texts replaced, old and new in turn, and with a sweep of the name x over these values."""
    text = CASE + (f"&sweep name = 'x', values = {sweep} /\n" if sweep else "")
    for old, new in zip(pairs[::2], pairs[1::2], strict=True):
        assert old in text
        text = text.replace(old, new)
    return text


def rows(*columns: np.ndarray, header: str = "") -> str:
    """Text of a CSV."""
    lines = [",".join(f"{value:.12g}" for value in row) for row in np.column_stack(columns)]
    return "\n".join(([header] if header else []) + lines) + "\n"


NINE = np.arange(9.0)
LINE = rows(NINE, np.zeros(9), header="x,z")
GRID = rows(*(axis.ravel() for axis in np.meshgrid(NINE, NINE)), np.zeros(81), header="x,y,z")
TWO_X = rows(np.tile([0.0, 1.0], 9), np.repeat(NINE, 2), np.zeros(18), header="x,y,z")

NEW = [
    ("new mu", "mu: expected NAME=VALUE, as sigma0=3.0"),
    ("new 'mu=0.5 /'", "mu=0.5 /: expected NAME=VALUE"),
    ("new mu=1 mu=2", "mu=2: mu is given twice"),
    ("new -o new.nml mu=-1", "&material: mu = -1: expected >= 0"),
    ("new -o new.nml slip=far", 'slip = "far": expected a number'),
    ("new -o case.nml", "case.nml: this file is there and is not replaced"),
    ("new -o none/case.nml", "-o none/case.nml: no folder none: expected one"),
    ("cases figure99", "figure99: expected a case file, or a name"),
    ("cases -o y.nml", "expected"),
    ("run nothing", "expected"),
    ("run figure05b --label-units m,Pa", "--label-units m,Pa: expected with --plot"),
    ("run case.nml --plot --label-units mm", "--label-units mm: expected LENGTH,STRESS"),
    ("run case.nml --plot no/such/folder.png", "no/such/folder.png"),
    ("explore --no-browser nu=1", "nu=1: expected one of sigma0"),
    ("explore --no-browser mu=x", "mu = 'x': expected a finite number"),
    ("explore --no-browser kc=0", "kc=0: expected a finite number > 0"),
    ("explore --no-browser sides=4.5", "sides=4.5: expected a whole number"),
    ("explore --no-browser --port 70000", "--port 70000: expected 0 to 65535"),
    (f"joint {JOINT[6:]} ks2=3 tan_psi=x --sigma-N 0.3 y", "kn is missing: expected kn=VALUE\n"),
    (f"joint {JOINT} ks2=3 --sigma-N 0.3", "ks2 = 3: expected one of kn, ks, ft"),
    (f"joint {JOINT} ks2=3 --sigma-N 0.3", "\n--sigma-N = 0.3: expected a normal traction <= 0"),
    (
        f"joint {JOINT[6:]} kn=-1 delta=-2",
        "delta = -2.0: expected >= 0 (at most 1e10)\nkn = -1.0: expected > 0",
    ),
    (f"joint {JOINT} delta=2", "delta = 2.0: expected with tan_psi > 0"),
    (f"joint {JOINT} -o case.nml", "case.nml: this file is there"),
]
"""Command and part of its message."""

CARD = [
    ("abaqus", changed("mu = 0.5", "mu = -0.5"), "case.nml:2: &material: mu = -0.5: expected >= 0"),
    ("abaqus", changed("mu = 0.5", "mu = 0.5, guard = maybe"), "guard = maybe: expected 0, 1, .true. or"),
    ("abaqus", changed(PATTERN, PATTERN + ", weights = 1.0"), "sides, theta, flat, turn do not go with"),
    ("abaqus --value=-1", changed("t_N = -1.0", "t_N = x", sweep="-1, -2"), "--value -1: expected where"),
    ("abaqus --value 3", changed("mu = 0.5", "mu = x", sweep="1, 2"), "expected one of x, as 1, 2"),
    ("abaqus --value y", changed("mu = 0.5", "mu = x", sweep="1, 2"), "--value = 'y': expected a finite"),
    (
        "abaqus",
        changed("mu = 0.5", "mu = x", sweep="0.1, 0.2"),
        "asperity: case.nml: --value is missing: expected one for x, as 0.1, 0.2\n",
    ),
    ("mtest", changed("t_N = -1.0", "t_N = -1.0, k_N = 2.0"), "step 1: k_N = 2: expected 0 for mtest"),
    ("mtest", changed(FIRST_STEP, "&step s_N = 0.1, follow = 'branch' /"), "'branch': expected 'stable'"),
    (
        "mtest",
        changed("slip = 0.2, -0.2, increments = 20, 40", "s_N = 0.1"),
        "steps with 2 sets of prescribed components: expected one",
    ),
    ("mtest", changed("&step t_N", "&initial damage = 0.5 /\n&step t_N"), "from a virgin joint for mtest"),
]
"""Host and options of `asperity card`, case, part of the message."""

SELECT = [
    ("", changed("eta = 0.9", "eta = 1.9"), "eta = 1.9: expected 0 < eta < 1"),
    ("", changed("flat = 0.25", "turn = x", sweep="1, 2"), "expected one over sigma_N or direction"),
    ("", changed("slip", "s_Tx"), "expected &step with t_N"),
    ("", changed("increments = 20, 40", "follow = 'branch'"), "expected &step with t_N, then slip under it"),
    ("", CASE + "&initial damage = 0.5 /\n", "&initial: expected a case that starts virgin"),
    ("", CASE + "&step slip = 0.3, direction = 90.0 /", "in one direction"),
    ("", changed("&step t_N = -1.0, increments = 10 /\n", ""), "expected &step with t_N"),
    ("", changed(PATTERN, LISTED), "sides, theta and flat; with listed planes there is nothing to select"),
    ("", changed("mu = 0.5", "mu = 0.5, W0 = 4.0"), "W0 = 4: expected 0, or a planar load case"),
    (
        "--tolerance 1e-6",
        changed("-0.2, increments = 20, 40", "increments = 20", "0.2,", "0.2, "),
        "no pattern up to RP-63 meets the tolerance 1e-06",
    ),
    ("-o case.nml", "", "case.nml: this file is read or written by the same command: expected another name"),
]
"""Options of `asperity select`, case, part of the message."""

SI = ("= 3.0, Gc = 0.3", "= 3.0e6, Gc = 300.0", "-1.0", "-1.0e6")
CIRCLE = "'mu,theta=0.9 theta,flat=0.9 mu,flat=-0.9'"
UNCERTAINTY = [
    ("", "", "case.fit.json: expected the file that asperity fit"),
    ("--sd mu=0", "", "--sd mu=0: expected a standard deviation > 0"),
    ("--sd mu=x", "", "--sd mu=x: expected NAME=VALUE"),
    ("--sd nu=0.1", "", "nu: expected one of sigma0"),
    ("--sd mu=0.1 --samples 1", "", "samples = 1: expected a whole number, 2 to"),
    ("--sd mu=0.1 --plot a.svg", "", "expected a name that ends in .png or .pdf"),
    ("--sd mu=0.1 --correlation mu,theta=0.5", "", "expected two of mu"),
    ("--sd 'mu=0.1 theta=2' --correlation mu,theta=1.5", "", "expected -1 to 1"),
    ("--correlation mu,theta=0.5", "", "--correlation: expected with --sd"),
    ("--sd mu=0.1 --fit x.json", "", "--fit x.json: expected without --sd"),
    (f"--sd 'mu=0.1 theta=2 flat=0.01' --correlation {CIRCLE}", "", "contradict each other"),
    # in N and m the variance of the strength is 1e13 times that of the friction
    (
        f"--sd 'sigma0=3e5 mu=0.05 theta=1 flat=0.01' --correlation {CIRCLE}",
        changed(*SI),
        "contradict each other",
    ),
    (
        "--sd 'mu=0.1 theta=2' --correlation 'mu,theta=0.5 theta,mu=-0.5'",
        "",
        "--correlation mu,theta=0.5: given twice: expected one value",
    ),
    ("--sd theta=1", changed(PATTERN, "sides = 0"), "theta: expected inclined planes"),
    ("--sd flat=0.1", changed(PATTERN, LISTED), "flat: expected a regular pattern"),
    (
        "--sd mu=0.1",
        changed(FIRST_STEP, "&step t_Tx = 1.0 /"),
        "expected &step with a prescribed slip or opening",
    ),
    (
        "--sd mu=0.1",
        changed("&step t_N", "&initial damage = 1.0 /\n&step t_N"),
        "&initial: expected &step from a",
    ),
    ("--sd mu=.1", changed("title =", "tolerance = 1e-3, title ="), "expected increments"),
    (
        "--sd mu=0.1",
        changed("mu = 0.5", "mu = x", sweep="0.4, 0.5"),
        "&sweep: expected one that leaves mu alone",
    ),
    (
        "--sd mu=0.1 --jobs 1",
        changed(PATTERN, "sides = 0", "t_N = -1.0", "t_N = 2.0"),
        "the case itself loses",
    ),
    ("--sd mu=0.1 --plot case.fit.json.png -o case.fit.json", "", "is read or written by the same command"),
]
"""Options of `asperity uncertainty`, case, part of the message."""

EXPORT = [
    ("kit", changed("-0.2,", "-0.2, direction = 30.0,"), "direction = 30: expected 0"),
    ("kit", changed("mu = 0.5", "mu = 0.5, tau_v = 0.1"), "tau_v = 0.1: expected 0"),
    ("kit", changed("t_N = -1.0", "t_N = 0.1"), "expected &step with t_N <= 0"),
    ("kit", changed("slip", "s_N"), "expected &step with t_N, then slip"),
    (
        "kit",
        changed("t_N = -1.0", "t_N = -1.0, p = 0.2"),
        "p = 0.2, a water pressure: expected no p, and its value",
    ),
    (
        "kit",
        changed("0.5, kc = 10.0", "0.7", PATTERN, "sides = 4, theta = 45.0", "-1.0", "0.0"),
        "the joint jumps",
    ),
    ("kit", changed("mu = 0.5", "mu = x", sweep="0.0, 0.7"), "--value is missing: expected one for x"),
    ("kit", changed("slip = 0.2, -0.2", "slip = 0.0, 0.0"), "slip = 0: expected a slip that is not zero"),
    (".", "", "expected an empty folder or a new one; --force replaces"),
    ("case.nml", "", "expected a folder, or a name that is not taken"),
    ("none/kit", "", "none: expected a folder that exists"),
]
"""Folder of `asperity export kratos`, case, part of the message."""

SCANS = [
    ("x,z,q\n1,2,3\n", "columns x, z, q: expected columns x, z"),
    ("x [mm],z\n1,2\n", "expected a unit for all or none"),
    ("x [mm],z [MPa]\n1,2\n", "unit [MPa]: expected m, cm, mm"),
    ("x,z\n", "expected rows of numbers"),
    (LINE + ",9\n", "line 11, column x: empty: expected a finite number"),
    (LINE + "9\n", "line 11: 1 values: expected 2"),
    (LINE + "7,1\n", f"line 11: x = 7 after 8: {INCREASE} (overhang"),
    ("x,z\n1,2\n2,3\n", "2 points: expected at least 8"),
    (GRID + "3,3,1\n", "line 83: x = 3, y = 3 again: expected one height a point"),
    (
        rows(NINE, np.tile(3.0, 9), np.zeros(9), header="x,y,z"),
        "y = 3 throughout: expected a map; a profile is x, z",
    ),
    ("x;z\n0,5;1,25\n1;2.5\n", "line 3, column z: 2.5: expected a finite number with decimal commas"),
    ("x;z\n1;1,900\n2;1,000\n", "line 2, column z: 1,900 may be a decimal number, or have thousands"),
    ("x;z\n0,500;900\n100;0,250\n", "2 points: expected at least 8"),
    (TWO_X, "2 different x: expected at least 8"),
]
"""File of `asperity surface` and part of its message."""

SURFACE = [
    ("--planes 65", "--planes 65: expected 9 to 64 for 8 directions"),
    ("--bins 8", "8 directions of 8 bins and the flat plane are 65 planes: expected at most 64"),
    ("--bins 2 --planes 20", "expected one of them"),
    ("--regular --sides 0", "--sides 0: expected 2 to 64"),
    ("--sides 4", "--sides: expected with --regular"),
    ("--regular --flat-below 5", "--regular: expected without"),
    ("--unit MPa", "scan.csv: unit [MPa]: expected m, cm, mm"),
    ("-o scan.csv", "-o scan.csv: this file is read or written by the same command"),
    ("-o none/planes", "-o none/planes.csv: no folder none: expected one that is there"),
    ("-o .", "-o .: expected a name"),
    ("--case scan.csv", "scan.csv:1: "),
    ("--case case.nml --material sigma0=3,Gc=0.3,eta=0.9,mu=0.5", "--case, --material: expected one"),
    ("--sampling 0.5", "sampling length 0.5: expected at least the spacing, 1"),
    ("--sampling 2", "sampling length 2: expected at most 1.14286, for 8 points"),
    ("--smooth 0.5", "smoothing length 0.5: expected more than the spacing, 1"),
    ("--spacing 1", "x, y, z: expected a matrix of numbers"),
]
"""Options of `asperity surface` and part of its message."""

TESTS = "slip [mm],tau [MPa],dilation [mm],sigma_N [MPa]\n" + "".join(
    f"0.{i},{min(i, 4) * 0.2:.1f},{0.02 * i:.2f},-1\n" for i in range(1, 8)
)
FIT = [
    ("--set eta", "--set eta: expected NAME=VALUE"),
    ("--free foo", "free: foo is unknown: expected one of"),
    ("--free mu --set mu=.5", "mu: expected it free or fixed, not both"),
    ("--units mm", "--units mm: expected LENGTH,STRESS"),
    ("--units mm,mm", "--units mm,mm: [mm]: expected Pa, kPa, MPa, N/mm2"),
    ("--free sigma0,mu", "Gc: expected it among the free ones, or a value, --set Gc="),
    ("--set kc=2 --set kc=3", "--set kc=3: kc is given twice: expected one value"),
    ("-o .", "-o .: expected a file that can be written"),
    ("--sigma-N 1,x", "--sigma-N = 'x': expected a finite number"),
]
"""Options of `asperity fit` and part of its message."""

BARTON = [
    ("--jrc=0", "JRC = 0: expected > 0 and <= 20"),
    ("--phi-r=90", "phi_r = 90: expected degrees, > 0 and <= 70"),
    ("--length=0.05", "sample = 0.1: expected m, > 0 and <= length = 0.05"),
    ("--sigma-n=1,60", "sigma_n = 60: expected compression > 0 and < 50 MPa, JCS of the length"),
    ("--sigma-n=1,x", "--sigma-n = 'x': expected a finite number"),
    ("--sigma-n=1,1", "sigma_n = 1, 1: expected the lower normal stress first"),
    ("--sigma-n=1,2,3", "--sigma-n 1,2,3: expected one normal stress, or LOW,HIGH"),
    ("--sigma-n=1,2 --free=mu", "--free, --set, --sides: expected with one normal stress"),
    ("--sigma-n=0.001", "expected at most 70 degrees of phi_r + JRC log10(JCS/sigma_n), not 76.99"),
    ("--free=mu,sigma0", "sigma0: expected without ks, and not for rock: these are constants of a bond"),
    ("--sigma-n -2,-1", "sigma_n = -2: expected compression > 0"),
    ("--jrc=0 --jcs=-5", "JRC = 0: expected > 0 and <= 20\nJCS = -5: expected"),
]
"""Options of `asperity barton` and part of its message."""


def barton(words: str) -> str:
    """Command with these options, and those of a joint that are not among them."""
    joint = {"--jrc": 10, "--jcs": 50, "--phi-r": 30, "--length": 0.1, "--sigma-n": 1}
    return " ".join(
        ["barton", words, *(f"{name}={value}" for name, value in joint.items() if name not in words)]
    )


TEMPLATES = [
    (changed(f"&pattern {PATTERN} /\n", ""), "case.nml: no group &pattern"),
    (
        changed("mu = 0.5", "mu = x", sweep="0.2, 0.5"),
        "case.nml: &material: expected numbers, not the name of a",
    ),
    (changed("mu = 0.5", "mu = much"), 'case.nml:2: &material: mu = "much": expected a number'),
]
"""Case that `asperity surface --case` copies, and part of the message."""

GROUPED = [
    ("barton --jrc=10 --jcs=50 --phi-r=30 --length=1 --sigma-n=1_0", "--sigma-n = '1_0': expected"),
    ("explore --no-browser mu=0_5", "mu = '0_5': expected a finite number"),
    ("explore --no-browser mu=\u0661", "expected a finite number"),
    (f"joint {JOINT.replace('82', '8_2')}", "kn = '8_2': expected a finite number"),
    ("uncertainty case.nml --sd mu=0_1", "--sd mu=0_1: expected NAME=VALUE, a number"),
    ("fit scan.csv --area 1_0", "--area 1_0: expected A, an area > 0"),
]
"""Numbers that Python alone reads, a typing error elsewhere, and part of the message."""

ROWS = [
    *((command, CASE, message) for command, message in GROUPED),
    *((command, "", message) for command, message in NEW),
    *((f"card {words} case.nml", text, message) for words, text, message in CARD),
    *((f"select case.nml {words}", text, message) for words, text, message in SELECT),
    *((f"uncertainty case.nml {words}", text, message) for words, text, message in UNCERTAINTY),
    *((f"export kratos {folder} --case case.nml", text, message) for folder, text, message in EXPORT),
    *(("surface scan.csv", text, message) for text, message in SCANS),
    *((f"surface scan.csv {words}", "", message) for words, message in SURFACE),
    *(("surface scan.csv --case case.nml", text, message) for text, message in TEMPLATES),
    *((f"fit scan.csv {words}", TESTS, message) for words, message in FIT),
    *((barton(words), "", message) for words, message in BARTON),
    *((f"surface {name}", "", f"asperity: {name}") for name in ("none.csv", "folder.csv", "binary.csv")),
]  # fmt: skip


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
@pytest.mark.parametrize(("command", "text", "message"), ROWS, ids=[f"{row[0]}: {row[2]}" for row in ROWS])
def test_refused(command: str, text: str, message: str, folder: Path, said: Callable) -> None:
    """The message says why, nothing is printed, and every file stays as it was."""
    (folder / "folder.csv").mkdir()
    (folder / "binary.csv").write_bytes(b"PK\3\4\0\0\0")
    (folder / "case.nml").write_text(text if text.startswith("&") else CASE, encoding="utf-8")
    scan = text if text and not text.startswith("&") else GRID.replace("4,4,0\n", "4,4,1\n")
    (folder / "scan.csv").write_text(scan, encoding="utf-8")
    before = {path: path.is_file() and path.read_bytes() for path in folder.rglob("*")}
    out, err = said(command, 1)
    assert message in err and "Traceback" not in err and out == ""
    assert before == {path: path.is_file() and path.read_bytes() for path in folder.rglob("*")}

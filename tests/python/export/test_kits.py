"""`asperity export abaqus`: files, refusals, the check of the decks and what it finds, compilers."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from asperity import contract, hosts, installed, read_case
from asperity.cli import main
from asperity.export import command as kit
from asperity.export.element import Element
from asperity.mesh.deck_joints import judged
from support_abaqus import model, run_explicit, run_standard

from harness.hosts.exported import CASE

ELEMENT = Element.of_case()
THETA = 30.0
RESIDUAL = ELEMENT.interface.material.residual_strength(THETA)
KIT = kit.files("abaqus", ELEMENT)
ENVIRONMENT = KIT["abaqus_v6.env"].decode("ascii")
WRITTEN = {name: text.decode("ascii") for name, text in KIT.items() if name.endswith(".inp")}


def rows_of(text: str) -> np.ndarray:
    """Numbers of the table of the README."""
    lines = [line.strip("| ").split(" | ") for line in text.splitlines() if line.startswith("| 0.")]
    return np.array(lines, dtype=float)


# --- the command ------------------------------------------------------------------------------------------


def test_kit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """All sources, decks that the check accepts, an environment file and the README; the same at any time."""
    folder = tmp_path / "kit"
    assert main(["export", "abaqus", str(folder)]) == 0
    names = {path.name for path in folder.iterdir()}
    sources = {f"asperity_abaqus{part}.f90" for part in ("", "_standard", "_explicit", "_single")}
    assert names == {"README.md", "abaqus_v6.env", "joint.nml", *WRITTEN, *sources} and len(WRITTEN) == 2
    out = capsys.readouterr().out
    readme = (folder / "README.md").read_text(encoding="ascii")
    assert all(f"`{name}`" in readme for name in names - {"README.md"})
    assert "**Abaqus was not run.**" in readme
    assert rows_of(readme).shape == (5, 4) and (rows_of(readme) == rows_of(out)).all()
    for name in WRITTEN:
        assert judged(folder / name).wrong == []
    assert KIT == {path.name: path.read_bytes() for path in folder.iterdir()}
    for name in sources:
        assert max(map(len, (folder / name).read_text(encoding="utf-8").splitlines())) <= 132
    # the folder has the permissions of any new one
    (tmp_path / "other").mkdir()
    assert folder.stat().st_mode == (tmp_path / "other").stat().st_mode


def test_force_replaces_the_files_of_the_kit_only(tmp_path: Path) -> None:
    """Other files stay, old ones of the kit are replaced; a folder in the place of a file is refused."""
    (tmp_path / "kit").mkdir()
    mine, old = tmp_path / "kit" / "mine.txt", tmp_path / "kit" / "single_explicit.inp"
    mine.write_text("mine")
    old.write_text("old")
    assert main(["export", "abaqus", str(tmp_path / "kit"), "--force"]) == 0
    assert (mine.read_text(), old.read_text()) == ("mine", WRITTEN["single_explicit.inp"])
    old.unlink()
    old.mkdir()
    (tmp_path / "kit" / "README.md").write_text("mine")
    assert main(["export", "abaqus", str(tmp_path / "kit"), "--force"]) == 1
    assert (tmp_path / "kit" / "README.md").read_text() == "mine"


@pytest.mark.parametrize("host", hosts.hosts("kit"))
def test_element_of_a_case(host: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The element has the joint of the case up to its first reversal, and the rows of the material point."""
    case, folder = tmp_path / "mine.nml", tmp_path / "kit"
    case.write_text(CASE)
    assert main(["export", host, str(folder), "--case", str(case)]) == 0
    out = capsys.readouterr().out
    readme = (folder / "README.md").read_text(encoding="utf-8")
    printed = rows_of(readme)
    assert (rows_of(out) == printed).all() and printed[:, 0].tolist() == [0.08, 0.16, 0.24, 0.32, 0.4]
    run = read_case(case).runs[0]
    expected = run.interface.confined_slip(0.0, np.linspace(0.0, 0.4, 86)[1:], -0.5, 8)
    np.testing.assert_allclose(printed[:, 2], expected.tau[16::17], atol=1e-7)
    np.testing.assert_allclose(printed[:, 1], expected.dilation[16::17], atol=1e-7)
    assert (folder / "joint.nml").read_text() == CASE and "$" not in readme
    named = set(re.findall(r"`([\w.-]+\.[a-z]\w*)`", readme))
    written_by_a_run = {"single.dat", "single.out", "single.npz", "single_standard.dat"}
    assert named - written_by_a_run <= {path.name for path in folder.iterdir()}
    if host == "abaqus":
        deck = model((folder / "single_standard.inp").read_text(encoding="ascii"))
        rows = run_standard(deck, installed.library())[16::17]
        assert np.abs(rows - printed).max() < 1e-7
        assert not list(folder.glob("single_explicit*"))


@pytest.mark.parametrize("host", ["abaqus", "calculix"])
def test_numbers_have_twenty_characters(host: str, tmp_path: Path) -> None:
    """A case in metres, whose slip and steps have more digits than the host reads."""
    case = tmp_path / "case.nml"
    case.write_text(
        "&material sigma0 = 3.0, Gc = 0.3e-3, eta = 0.9, mu = 0.5 /\n&pattern sides = 2, theta = 30.0 /\n"
        "&step t_N = -1.0, increments = 7 /\n&step slip = 7.3333333333333333e-5, increments = 70 /\n"
    )
    element = Element.of_case(case)
    assert len(repr(element.slip)) > 20
    for name, text in kit.files(host, element).items():
        if name.startswith("single") and name.endswith(".inp"):
            words = re.findall(r"(?<=[\n ])-?\d+\.[\de+-]*(?=[,\n])", text.decode("ascii"))
            assert max(map(len, words)) <= 20
            assert any(float(word) == pytest.approx(element.slip, rel=1e-12) for word in words)


def test_rows_that_differ_are_an_error(capsys: pytest.CaptureFixture[str]) -> None:
    """The scripts of the kits end with an error where the host shows other rows."""

    def follow(factor: float) -> None:
        h = ELEMENT.history
        rows = zip(h.separation[:, 1], h.dilation, factor * h.traction[:, 1], strict=True)
        ELEMENT.follow(lambda slip, _: next(rows) if slip else ())

    follow(1.0)
    with pytest.raises(SystemExit, match="the rows differ by"):
        follow(1.01)
    assert len(capsys.readouterr().out.splitlines()) == 12


def test_nothing_is_half_written(tmp_path: Path) -> None:
    """If a file cannot be written, the folder is not there, and what was made beside it is gone."""
    with pytest.raises(OSError):
        kit.write(tmp_path / "kit", {"a.txt": b"a", "no/such/folder.txt": b"b"})
    assert list(tmp_path.iterdir()) == []


# --- the first run ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("single", [False, True])
def test_explicit_element(single: bool) -> None:
    """The element of the deck by the VUMAT oscillates about the closed form and the rise by the UMAT."""
    static = run_standard(model(WRITTEN["single_standard.inp"]), installed.library())[-1]
    late = run_explicit(model(WRITTEN["single_explicit.inp"]), installed.library(), single)[-2000:]
    assert late[-1, 0] == pytest.approx(ELEMENT.slip, abs=1.0e-12) and abs(late[-1, 3] - 1.0) < 1.0e-6
    slope = np.tan(np.radians(THETA))
    for values, expected in (
        (late[:, 2], RESIDUAL),
        (late[:, 1] - slope * late[:, 0], static[1] - slope * static[0]),
    ):
        mean, deviation = values.mean(), values.std()
        assert abs(mean - expected) < deviation < 0.01 * abs(expected)


# --- the check of the decks -------------------------------------------------------------------------------

PROPS = contract.N_FIXED_PROPS
"""Number of constants of a regular pattern."""

MISTAKES = [
    ("*Heading\n", "**\n", "text before the first keyword: expected a deck"),
    (f"constants={PROPS}", f"constants={PROPS - 1}", f"expected {PROPS}, the number of"),
    ("3.0, 0.3, 0.9, 0.5,", "3.0, 0.3, 0.9, -0.5,", "mu = -0.5: expected >= 0"),
    (f"constants={PROPS}, unsymm", f"constants={PROPS}", "unsymm is missing"),
    ("*Depvar\n17,", "*Depvar\n16,", "16: expected at least 17 state variables"),
    (
        "\n0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0\n",
        "\n0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0\n",
        "17: expected at least 23 state variables",
    ),
    ("JOINT, material=JOINT", "JOINT, material=GLUE", "material=GLUE: no *Material has"),
    ("thickness=SPECIFIED\n1.0,", "thickness=SPECIFIED\n0.5,", "expected 1, the h of PROPS 9"),
    ("\n1, 1, 2, 3, 4, 5, 6, 7, 8\n", "\n1, 1, 2, 3, 4, 5, 6, 7, 999\n", "node 999: no such node"),
    ("\n2, 1.0, 0.0, 0.0\n", "\n1, 1.0, 0.0, 0.0\n", "node 2: no such node"),
]
"""Text of the deck for Standard, what stands there instead, and part of the message."""


@pytest.mark.parametrize(("old", "new", "message"), MISTAKES)
def test_doctor_finds(old: str, new: str, message: str, said, tmp_path: Path) -> None:
    """Each mistake in a deck is found and named."""
    text = WRITTEN["single_standard.inp"]
    assert old in text
    (tmp_path / "job.inp").write_text(text.replace(old, new), encoding="ascii")
    assert message in "".join(said(f"doctor {tmp_path / 'job.inp'}", code=1))


# --- compilers --------------------------------------------------------------------------------------------

SITES = {
    "linux": (
        ["ifort", "-c", "-fPIC", "-auto", "-mP2OPT_hpo_vec_divbyzero=F", "-I%I", "%P"],
        ["ifort", "-shared"],
    ),
    "win32": (["ifort", "/c", "/iface:cref", "/recursive", "/include:%I", "%P"], ["LINK", "/dll"]),
}


def settings(compiler: str, platform: str, monkeypatch: pytest.MonkeyPatch) -> dict[str, list[str]]:
    """What Abaqus knows after its own environment file and the one of the kit."""
    compile_fortran, link = SITES[platform]
    known: dict[str, object] = {"compile_fortran": compile_fortran, "link_sl": link, "link_exe": link}
    text = ENVIRONMENT.replace('asperity_compiler = ""', f'asperity_compiler = "{compiler}"')
    with monkeypatch.context() as patch:
        patch.setattr(sys, "platform", platform)
        # the names need not be global
        exec(text, {}, known)
    return known


@pytest.mark.parametrize("platform", SITES)
def test_environment(platform: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each compiler gets its commands; only settings of Abaqus are left; the default changes nothing."""
    compile_fortran, link = SITES[platform]
    names = {"compile_fortran", "link_sl", "link_exe"}
    assert settings("", platform, monkeypatch)["compile_fortran"] == compile_fortran
    for compiler in ("ifort", "ifx", "gfortran")[: None if platform == "linux" else 2]:
        words = settings(compiler, platform, monkeypatch)
        assert set(words) == names
        assert words["compile_fortran"][0] == compiler
        assert "%P" in words["compile_fortran"]
        assert {"-free", "/free", "-ffree-form"} & set(words["compile_fortran"])
        assert words["link_sl"][0] == (link[0] if link[0] == "LINK" else compiler)
        assert not any(word.startswith("-mP2OPT") for word in words["compile_fortran"]) or compiler == "ifort"
    # older releases have texts instead of lists
    monkeypatch.setitem(SITES, platform, tuple(" ".join(words) for words in SITES[platform]))
    assert settings("ifx", platform, monkeypatch)["compile_fortran"].startswith("ifx ")
    if platform == "linux":
        assert settings("gfortran", platform, monkeypatch)["compile_fortran"][0] == "gfortran"
    else:
        with pytest.raises(ValueError, match="or the DLLs of asperity"):
            settings("gfortran", platform, monkeypatch)
    with pytest.raises(ValueError, match="expected 'ifort', 'ifx', 'gfortran' or ''"):
        settings("g77", platform, monkeypatch)


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("gfortran"), reason="no gfortran")
def test_environment_compiles_and_links(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The commands of the environment file make a library, also under the suffix of fixed form; it runs."""
    # Abaqus provides these
    (tmp_path / "abaqus.c").write_text(
        "".join(f"void {name}_(void) {{}}\n" for name in ("stdb_abqerr", "xit", "xplb_abqerr", "xplb_exit"))
    )
    command = [os.environ.get("CC", "cc"), "-shared", "-fPIC", "abaqus.c", "-o", "libabaqus.so"]
    subprocess.run(command, cwd=tmp_path, check=True)
    # the source of the UMAT alone: test_abaqus_sources.py compiles the others
    (tmp_path / "user.f").write_bytes((installed.abaqus() / "asperity_abaqus_standard.f90").read_bytes())
    words = {"%I": str(tmp_path), "%P": "user.f", "%U": "libuser.so", "%F": "user.o"}
    commands = settings("gfortran", "linux", monkeypatch)
    for setting in ("compile_fortran", "link_sl"):
        command = []
        for word in commands[setting]:
            for mark, text in words.items():
                word = word.replace(mark, text)
            # what is left is a list of Abaqus' own files
            command += [] if "%" in word else [word]
        # the last level counts, and the lowest one takes the compiler a third of the time
        command += ["-O0"] if setting == "compile_fortran" else []
        # found by this library alone, and by no other one of the process
        command += ["libabaqus.so", f"-Wl,-rpath,{tmp_path}"] if setting == "link_sl" else []
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (0, "")
    end = run_standard(model(WRITTEN["single_standard.inp"]), tmp_path / "libuser.so")[-1]
    assert abs(end[2] - RESIDUAL) < 1.0e-9

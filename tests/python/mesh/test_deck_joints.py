"""Joints of a deck of Abaqus or CalculiX, as `asperity doctor DECK.inp` checks them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from asperity import Interface, Material, Pattern
from asperity.cli import main

JOINT = Interface(Material(3.0, 0.3, 0.9, 0.5), Pattern.regular(2, theta=30.0))
CARD = JOINT.card("abaqus", name="JOINT", dimension=2)
FIELD = "*Initial Conditions, type=FIELD, variable=2\nALL, 0.5\n"


def deck(
    water: int,
    kind: str = "COH2D4",
    field: str = FIELD,
    elset: str = "*Elset, elset=JOINT, generate\n7, 8, 1\n",
) -> str:
    """Deck of two joint elements between solids, whose set is made of numbers."""
    rows = [0, 1, 1, 2]
    nodes = "".join(f"{n}, {(n - 1) % 3}., {rows[(n - 1) // 3]}.\n" for n in range(1, 13))
    solids = "*Element, type=CPE4, elset=SOLID\n1, 1, 2, 5, 4\n2, 2, 3, 6, 5\n"
    solids += "3, 7, 8, 11, 10\n4, 8, 9, 12, 11\n"
    joints = f"*Element, type={kind}\n7, 4, 5, 8, 7\n8, 5, 6, 9, 8\n"
    card = CARD if water == 0 else JOINT.card("abaqus", name="JOINT", dimension=2, water=water)
    return f"*Node, nset=ALL\n{nodes}{solids}{joints}{elset}{card}{field}*Step, unsymm=YES\n*End Step\n"


def circle(sets: int) -> str:
    """Sets that name each other, the first of which is that of the joint."""
    names = ["JOINT", *(f"S{i}" for i in range(1, sets))]
    return "".join(f"*Elset, elset={one}\n{names[i - sets + 1]}\n" for i, one in enumerate(names))


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        (deck(0), 0, "sections and water agree"),
        (deck(0, "COH2D4P", ""), 0, "sections and water agree"),
        (deck(2), 0, "sections and water agree"),
        (deck(2, field="*Field, variable=2\nALL, 0.5\n"), 0, "sections and water agree"),
        (deck(2, "COH2D4P"), 1, "COH2D4P carry the water themselves, and so does the law, by field 2"),
        (deck(2, "COH3D8PT"), 1, "expected water = 0, or COH3D8"),
        (deck(1), 1, "water = 1: expected *Field, variable=1 or initial conditions of this field"),
        (deck(2, field=FIELD.replace("FIELD", "TEMPERATURE")), 1, "expected *Field, variable=2"),
        (deck(2, field="*Field, variable=2\n** to come\n"), 1, "has one without data (TMP/job.inp, line"),
        (deck(2, field="*Field, variable=2\n" + FIELD), 0, "sections and water agree"),
        (deck(2, field=FIELD.replace("ALL", "WET")), 1, "field has no value at 6 of 6 nodes of the joint"),
        (deck(2, field=FIELD.replace("ALL", "4, .5\n5, .5\n6")), 1, "no value at 3 of 6 nodes of the joint"),
        (deck(2, field="*Field, variable=2, file=flow, bstep=1\n"), 0, "sections and water agree"),
        (deck(2, field="*Field, variable=2, input=none.txt\n"), 1, "input=none.txt: no such file"),
        (deck(2, elset=circle(3)), 1, "S1: expected a number or a set that is there"),
        (deck(2, elset=circle(3) + "*Elset, elset=S1\n7, 8\n"), 1, "S1: expected a number or a set"),
        (deck(2, elset="*Elset, elset=JOINT\n"), 1, "elset=JOINT: no element is in it"),
        (deck(2, elset="*Elset, elset=JOINT\n900\n"), 1, "*Elset: element 900: no such element"),
        (deck(2, elset=""), 1, "elset=JOINT: no element is in it"),
        (deck(2, "COH2D4P", elset="*Elset, elset=A\n7, 8\n*Elset, elset=JOINT\nA\n"), 1, "COH2D4P carry"),
        (deck(2, elset="*Elset, elset=JOINT, generate\n7\n"), 1, "line 23: 7: expected first, last, step"),
        (deck(2, elset="*Elset, elset=JOINT, generate\n5, 999999999999\n"), 0, "sections and water agree"),
        ("*Node\n1, 0., 0.\n", 1, "expected a *Cohesive Section whose material has PROPS of asperity"),
        (deck(0).replace("3.0, 0.3, 0.9", "-3.0, 0.3, 0.9"), 1, "sigma0 = -3: expected > 0"),
        (deck(0).replace("3.0, 0.3, 0.9", "x, 0.3, 0.9"), 1, "expected numbers"),
        ("a picture", 1, "expected a deck"),
    ],
)  # fmt: skip
def test_doctor_of_a_deck(
    text: str, code: int, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Water twice, by element and law, and a field that nothing gives are named with their lines."""
    (tmp_path / "job.inp").write_text(text, encoding="utf-8")
    assert main(["doctor", str(tmp_path / "job.inp")]) == code
    texts = "".join(capsys.readouterr())
    assert words.replace("TMP", str(tmp_path)) in texts
    if "carry" in words or "no element" in words:
        assert "job.inp, line " in texts and ": *Cohesive Section: " in texts


def in_parts(text: str) -> str:
    """The same joint in a part, beside a part of solids with the same numbers and the same name of a set."""
    nodes, joints = text.partition("*Element, type=CPE4")[0], text[text.index("*Element, type=COH2D4") :]
    mesh, _, card = joints.partition("** ")
    material, _, section = card.partition("*Cohesive Section")
    section, _, step = section.partition("*Initial Conditions")
    solids = "*Element, type=CPE4\n7, 1, 2, 5, 4\n*Elset, elset=JOINT\n7,\n"
    beside = text[text.index("*Element, type=CPE4") : text.index("*Element, type=COH2D4")]
    gap = f"{nodes}{beside}{mesh}*Cohesive Section{section}"
    return (
        f"*Part, name=BLOCK\n{nodes}{solids}*End Part\n*Part, name=GAP\n{gap}*End Part\n"
        "*Assembly, name=A\n*Instance, name=G-1, part=GAP\n*End Instance\n"
        f"*Elset, elset=ALL, instance=G-1\n7, 8\n*End Assembly\n** {material}*Initial Conditions{step}"
    )


OTHER = (
    "*Material, name=OTHER\n*User Material, constants=3, unsymm\n1., 2., 3.\n*Cohesive Section, elset=JOINT, "
    "material=OTHER, response=TRACTION SEPARATION\n,\n*Step"
)
WRONG = {
    r"constants=\d+|constants=9": "constants=9: expected ",
    r"constants=\d+|constants=99": "constants=99: expected ",
    r"(unsymm\n[^,]+,[^,]+,[^,]+,[^,]+),|\1\n": "4 constants: expected 8 on each line but the last",
    ", unsymm|": "unsymm is missing: friction makes the tangent unsymmetric",
    r"\*Step.*|*Step": "no unsymm: friction makes the tangent unsymmetric: expected unsymm=YES",
    r"\*Step.*|*Step, unsymm=NO": "unsymm=NO: friction makes the tangent unsymmetric: expected YES",
    r"\*Depvar\n\d+|*Depvar\n13": "13: expected at least ",
    r"\*Depvar\n(?:\d.*\n)+|": "no *Depvar: expected at least ",
    r"\*Depvar|*Depvar, delete=1": "delete=1: contact survives rupture",
    "TRACTION SEPARATION|CONTINUUM": "response=CONTINUUM: expected TRACTION SEPARATION",
    r"SPECIFIED\n.*|SPECIFIED\n0.5,": "thickness 0.5: expected 1, the h of PROPS 9",
    "material=JOINT, |material=JIONT, ": "material=JIONT: no *Material has this name",
    "elset=JOINT, mat|elset=JOINTS, mat": "elset=JOINTS: no element is in it",
    "=COH2D4|=CPE4": "CPE4: expected COH2D4",
    "User Material,|User Material, type=THERMAL,": "type=THERMAL: expected MECHANICAL",
    r"\*Step|" + OTHER: "eta = 3: expected 0 < eta < 1",
    r"\*Step.*\n|*Step\n*Dynamic, explicit\n": "implex = 0.05 (PROPS 25): expected 0 for Abaqus/Explicit",
}


@pytest.mark.parametrize("parts", [False, True])
@pytest.mark.parametrize("change", WRONG)
def test_wrong_joints(change: str, parts: bool, said, tmp_path: Path) -> None:
    """Constants, state variables, sections and symmetry that a host would read otherwise are named."""
    text = deck(0)
    if "explicit" in change:
        text = text.replace(CARD, JOINT.card("abaqus", name="JOINT", dimension=2, implex=0.05))
    text = in_parts(text) if parts else text
    old, _, new = change.partition("|")
    changed = re.sub(old, new, text, count=1)
    assert changed != text
    (tmp_path / "job.inp").write_text(changed, encoding="utf-8")
    out, err = said(f"doctor {tmp_path / 'job.inp'}", code=1)
    assert WRONG[change] in out + err and "job.inp, line " in out + err


GOOD = (
    "|", "JOINT|joint", r"\*|*", "mu|mu", r"\*Depvar\n\d+|*Depvar\n40", r"SPECIFIED\n.*\n|SPECIFIED\n",
    r"\*Step.*|*Step, unsymm", r"\*Step.*\n|*Step, perturbation\n",
    r"\*Step.*\n|*Step\n*Frequency\n3\n", r"constants=(\d+)(.*)\n|constants=\1\2\n** a comment\n\n",
    r"(\*Cohesive Section, [^,]*),|\1,\n",
    r"\*Step|*Material, name=GLUE\n*Elastic, type=TRACTION\n1., 1.\n*Step",
    r", unsymm\n([^,]+),([^,]+),([^,]+),[^,]+|\n\1,\2,\3, 0.0",
    r", unsymm\n([^,]+),([^,]+),([^,]+),[^,]+([\s\S]*Step).*|\n\1,\2,\3, 0.0\4",
)  # fmt: skip


@pytest.mark.parametrize("parts", [False, True])
@pytest.mark.parametrize("change", GOOD)
def test_good_joints(change: str, parts: bool, said, tmp_path: Path) -> None:
    """What a host reads as well is no error: names in any case, comments, more state variables, mu = 0."""
    text = in_parts(deck(0)) if parts else deck(0)
    old, _, new = change.partition("|")
    (tmp_path / "job.inp").write_text(re.sub(old, new, text), encoding="utf-8")
    said(f"doctor {tmp_path / 'job.inp'}")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("|", "sections and water agree"),
        (r"\*DEPVAR\n\d+|*DEPVAR\n5", "5: expected at least "),
        ("C3D8|C3D8R", "C3D8R: expected C3D8 or C3D6"),
        ("ABAQUSJOINT|ABAQUSNL", "expected none that begins with ABAQUSNL"),
        ("ABAQUSJOINT|JOINT", "CalculiX calls a UMAT for names that begin with ABAQUS"),
        (r"(CONSTANTS=\d+\n)[^,]+|\g<1>3.0000000000000000000", "expected at most 20 characters"),
        (r"CONSTANTS=\d+\n(.*\n)[^*]*|CONSTANTS=8\n\1", "CalculiX expects a further line"),
        (r"CONSTANTS=\d+\n(.*\n)[^*]*|CONSTANTS=8\n\g<1>293.\n", "no element is in it"),
        ("CONSTANTS=21|CONSTANTS=22", "constants=22: expected 21"),
    ],
)
def test_joints_of_calculix(change: str, words: str, said, tmp_path: Path) -> None:
    """A layer of solids is a joint; its name selects the UMAT."""
    nodes = "".join(f"{n + 1}, {n % 4 in (1, 2):d}., {n % 4 > 1:d}., {n // 4}.\n" for n in range(8))
    mesh = f"*NODE\n{nodes}*ELEMENT, TYPE=C3D8, ELSET=JOINT\n1, 1, 2, 3, 4, 5, 6, 7, 8\n"
    text = mesh.replace("JOINT", "NONE" if "293" in change else "JOINT")
    held = "".join(f"{n}, 1, 3, {0.1 if n > 4 else 0.0}\n" for n in range(1, 9))
    text += JOINT.card("calculix", name="JOINT") + f"*STEP\n*BOUNDARY\n{held}*END STEP\n"
    old, _, new = change.partition("|")
    (tmp_path / "job.inp").write_text(re.sub(old, new, text), encoding="utf-8")
    code = int("agree" not in words and "a UMAT for names" not in words)
    out, err = said(f"doctor {tmp_path / 'job.inp'}", code=code)
    assert words in out + err


def test_doctor_of_the_kit(tmp_path: Path) -> None:
    """The decks that `asperity export abaqus` writes are in order."""
    assert main(["export", "abaqus", str(tmp_path / "kit")]) == 0
    decks = list((tmp_path / "kit").glob("*.inp"))
    assert len(decks) == 2 and all(main(["doctor", str(deck)]) == 0 for deck in decks)


def test_doctor_of_no_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A deck that is not there is an error that names it."""
    assert main(["doctor", str(tmp_path / "none.inp")]) == 1
    assert "none.inp" in capsys.readouterr().err

"""Water in the joints of an Abaqus deck, as `asperity doctor DECK.inp` checks it."""

from __future__ import annotations

from pathlib import Path

import pytest
from asperity import Interface, Material, Pattern
from asperity.cli import main

JOINT = Interface(Material(3.0, 0.3, 0.9, 0.5), Pattern.regular(2, theta=30.0))
FIELD = "*Initial Conditions, type=FIELD, variable=2\nALL, 0.5\n"


def deck(
    water: int,
    kind: str = "COH2D4",
    field: str = FIELD,
    elset: str = "*Elset, elset=JOINT, generate\n7, 8, 1\n",
) -> str:
    """Deck of two joint elements between solids, whose set is made of numbers."""
    nodes = "".join(f"{n}, {n % 3}., {n // 3}.\n" for n in range(1, 13))
    solids = "*Element, type=CPE4, elset=SOLID\n1, 1, 2, 5, 4\n2, 2, 3, 6, 5\n"
    joints = f"*Element, type={kind}\n7, 4, 5, 8, 7\n8, 5, 6, 9, 8\n"
    card = JOINT.card("abaqus", name="JOINT", dimension=2, water=water)
    return f"*Node\n{nodes}{solids}{joints}{elset}{card}{field}*Step\n*End Step\n"


def circle(sets: int) -> str:
    """Sets that name each other, the first of which is that of the joint."""
    names = ["JOINT", *(f"S{i}" for i in range(1, sets))]
    return "".join(f"*Elset, elset={one}\n{names[i - sets + 1]}\n" for i, one in enumerate(names))


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        (deck(0), 0, "elements and fields go with the water of the joints"),
        (deck(0, "COH2D4P", ""), 0, "elements and fields go with the water of the joints"),
        (deck(2), 0, "elements and fields go with the water of the joints"),
        (deck(2, field="*Field, variable=2\nALL, 0.5\n"), 0, "elements and fields go with the water"),
        (deck(2, "COH2D4P"), 1, "COH2D4P carry the water themselves, and so does the law, by field 2"),
        (deck(2, "COH3D8PT"), 1, "expected water = 0, or COH3D8"),
        (deck(1), 1, "water = 1: expected *Field, variable=1 or initial conditions of this field"),
        (deck(2, field=FIELD.replace("FIELD", "TEMPERATURE")), 1, "expected *Field, variable=2"),
        (deck(2, field="*Field, variable=2\n** to come\n"), 1, "has one without data (TMP/job.inp, line"),
        (deck(2, field="*Field, variable=2\n" + FIELD), 0, "elements and fields go with the water"),
        (deck(2, field="*Field, variable=2, file=flow, bstep=1\n"), 0, "elements and fields go"),
        (deck(2, field="*Field, variable=2, input=none.txt\n"), 1, "input=none.txt: no such file"),
        (deck(2, elset=circle(3)), 1, "elset=JOINT: no element is in it"),
        (deck(2, "COH2D4P", elset=circle(3) + "*Elset, elset=S1\n7, 8\n"), 1, "COH2D4P carry"),
        (deck(2, elset="*Elset, elset=JOINT\n"), 1, "elset=JOINT: no element is in it"),
        (deck(2, elset="*Elset, elset=JOINT\n900\n"), 1, "elset=JOINT: no element is in it"),
        (deck(2, elset=""), 1, "elset=JOINT: no element is in it"),
        (deck(2, "COH2D4P", elset="*Elset, elset=A\n7, 8\n*Elset, elset=JOINT\nA\n"), 1, "COH2D4P carry"),
        (deck(2, elset="*Elset, elset=JOINT, generate\n7\n"), 1, "line 21: 7: expected first, last, step"),
        (deck(2, elset="*Elset, elset=JOINT, generate\n1, 999999999999\n"), 0, "elements and fields go"),
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


def test_doctor_of_the_kit(tmp_path: Path) -> None:
    """The decks that `asperity export abaqus` writes are in order."""
    assert main(["export", "abaqus", str(tmp_path / "kit")]) == 0
    decks = list((tmp_path / "kit").glob("*.inp"))
    assert len(decks) == 3 and all(main(["doctor", str(deck)]) == 0 for deck in decks)


def test_doctor_of_no_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A deck that is not there is an error that names it."""
    assert main(["doctor", str(tmp_path / "none.inp")]) == 1
    assert "none.inp" in capsys.readouterr().err

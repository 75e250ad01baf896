"""Constants of joints in decks: what `asperity doctor DECK.inp` prints, and values that it doubts."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, Pattern
from asperity.mesh.deck_joints import judged
from asperity.model_checks import model_warnings

UNITS = {"mm, MPa": (1.0, 1.0), "m, kPa": (1e-3, 1e3), "m, Pa": (1e-3, 1e6)}
"""Length of a millimetre and stress of a MPa in each system of units."""


def drawn(rng: np.random.Generator, **changed: float) -> tuple[dict[str, float], str, str]:
    """Constants of a joint, `changed` among them, its deck without a step, and the system of units."""
    name = str(rng.choice([*UNITS]))
    length, stress = UNITS[name]
    sigma0 = float(rng.choice([0.1, 0.25, 0.5, 1.0, 3.0, 10.0]))
    s_f = float(rng.uniform(0.02, 0.4))  # mm
    values = {
        "sigma0": sigma0 * stress,
        "Gc": float(f"{0.5 * sigma0 * s_f * stress * length:.3g}"),
        "eta": float(rng.choice([0.9, 0.95, 0.99])),
        "mu": float(rng.choice([0.4, 0.5, 0.6, 0.7, 0.8])),
        "theta": float(rng.choice([10.0, 15.0, 20.0, 30.0])),
        "m": float(rng.choice([2, 3, 4, 6])),
        "kc": float(rng.choice([1, 8, 20, 50, 100, 1000])),
    } | changed
    size = float(rng.choice([2.0, 10.0, 50.0])) * length
    modulus = float(rng.choice([5e3, 16e3, 3e4, 7e4, 2e5])) * stress
    material = Material(values["sigma0"], values["Gc"], values["eta"], values["mu"], kc=values["kc"])
    joint = Interface(material, Pattern.regular(int(values["m"]), theta=values["theta"], flat=0.0))
    return values, deck(joint, size, modulus), name


def deck(joint: Interface, size: float, modulus: float) -> str:
    """Deck of two joint elements between solids."""
    rows = [0, 1, 1, 2]
    x = [f"{n}, {(n - 1) % 3 * size:.9g}, {rows[(n - 1) // 3] * size:.9g}\n" for n in range(1, 13)]
    solids = (
        "*Element, type=CPE4, elset=SOLID\n1, 1, 2, 5, 4\n2, 2, 3, 6, 5\n3, 7, 8, 11, 10\n4, 8, 9, 12, 11\n"
    )
    section = "*Solid Section, elset=SOLID, material=ROCK\n,\n*Material, name=ROCK\n*Elastic\n"
    joints = "*Element, type=COH2D4, elset=JOINT\n7, 4, 5, 8, 7\n8, 5, 6, 9, 8\n"
    card = joint.card("abaqus", name="JOINT", dimension=2)
    return f"*Node\n{''.join(x)}{solids}{section}{modulus:.9g}, 0.2\n{joints}{card}"


def exchanged(text: str, first: str, second: str, values: dict[str, float]) -> str:
    """Deck in which two constants have each other's place."""
    return written(text, {first: values[second], second: values[first]})


def written(text: str, changed: dict[str, float]) -> str:
    """Deck with other constants, by their place."""
    start = text.index("*User Material")
    first, line, rest = re.split(r"(?<=\n)", text[start:], maxsplit=2)
    words = line.split(",")
    names = "sigma0 Gc eta mu theta m flat turn".split()
    for name, value in changed.items():
        if name in names:
            words[names.index(name)] = f" {float(value)!r}"
    text = text[:start] + first + ",".join(words) + rest
    if "kc" in changed:
        head, block, tail = text.partition("*User Material")
        lines = block + tail
        parts = lines.split("\n", 3)
        second = parts[2].split(",")
        second[7] = f" {float(changed['kc'])!r}"
        text = head + "\n".join([parts[0], parts[1], ",".join(second), parts[3]])
    return text


STEP = "*Step, unsymm=YES\n*Static\n1., 1.\n*Output, field\n*Element Output, elset=JOINT\nS, SDV\n*End Step\n"
EXPLICIT = STEP.replace("*Static\n1., 1.", "*Dynamic, explicit\n, 1.")


def stiffness(v: dict[str, float]) -> float:
    """Stiffness of the bond."""
    return v["sigma0"] ** 2 / (2.0 * v["Gc"] * (1.0 - v["eta"]))


MISTAKES: dict[str, tuple[Callable[[str, dict[str, float]], str], str]] = {
    "sigma0 and Gc": (lambda t, v: exchanged(t, "sigma0", "Gc", v), "the bond breaks at an opening of"),
    "eta and mu": (lambda t, v: exchanged(t, "eta", "mu", v), "expected eta = 1 - s0/s_f near 1"),
    "theta and m": (lambda t, v: exchanged(t, "theta", "m", v), "expected the inclination, then the number"),
    "radians": (lambda t, v: written(t, {"theta": np.radians(v["theta"])}), "expected degrees"),
    "mu in degrees": (lambda t, v: written(t, {"mu": np.degrees(np.arctan(v["mu"]))}), "expected a tangent"),
    "kc a stiffness": (lambda t, v: written(t, {"kc": min(v["kc"] * stiffness(v), 1e9)}), "the ratio of"),
    "E in Pa": (
        lambda t, v: re.sub(r"(?<=\*Elastic\n)[^,]+", lambda e: f"{1e6 * float(e[0])}", t),
        "in one unit?",
    ),
    "strength in kPa": (lambda t, v: written(t, {n: 1e3 * v[n] for n in ("sigma0", "Gc")}), "in one unit?"),
    "strength in MPa": (lambda t, v: written(t, {"sigma0": 1e-3 * v["sigma0"]}), "sigma0 = "),
    "no SDV": (lambda t, v: t + STEP.replace(", SDV", ""), "no output of elements has SDV"),
    "elastic": (
        lambda t, v: t.replace("*Depvar", "*Elastic, type=TRACTION\n1., 1., 1.\n*Depvar"),
        "beside *User Material",
    ),
    "deletion": (
        lambda t, v: t.replace("response=", "controls=C, response=")
        + "*Section Controls, name=C, element deletion=YES\n1., 1., 1.\n",
        "element deletion=YES: contact survives",
    ),
    "no density": (lambda t, v: t + EXPLICIT, "no *Density"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
@pytest.mark.parametrize("seed", range(6))
def test_mistakes(mistake: str, seed: int, tmp_path: Path) -> None:
    """Each mistake is named; of strengths in kPa only those beyond what a solid may have."""
    rng = np.random.default_rng([seed, 66])
    values, text, _ = drawn(rng, **{"kc": 20.0} if mistake == "kc a stiffness" else {})
    change, words = MISTAKES[mistake]
    path = tmp_path / "job.inp"
    path.write_text(change(text, values), encoding="utf-8")
    judgement = judged(path)
    told = [*judgement.wrong, *judgement.doubtful]
    if mistake == "strength in kPa":
        ratio = 1e3 * values["sigma0"] / float(re.findall(r"\*Elastic\n([^,]+)", text)[0])
        assert any(words in one for one in told) == (ratio > 0.01)
    else:
        assert any(words in one and "job.inp, line " in one for one in told), told


@pytest.mark.parametrize("seed", range(40))
def test_right_decks(seed: int, tmp_path: Path) -> None:
    """Constants in usual ranges raise no doubt in any units, nor do those of a joint without bond."""
    rng = np.random.default_rng([seed, 67])
    text = drawn(rng)[1]
    if seed % 5 == 0:
        joint = Interface(Material.from_joint(kn=20.0, ks=5.0, mu=0.6), Pattern.regular(2, theta=10.0))
        text = deck(joint, 10.0, 3e4)
    path = tmp_path / "job.inp"
    path.write_text(text + (STEP if seed % 2 else ""), encoding="utf-8")
    judgement = judged(path)
    assert not judgement.wrong and not judgement.doubtful


def test_what_was_read(said: Callable, tmp_path: Path) -> None:
    """Each constant has its name and unit, and s0, s_f, K and E over the size of the solids stand beside."""
    values, text, _ = drawn(np.random.default_rng(7))
    path = tmp_path / "job.inp"
    path.write_text(text, encoding="utf-8")
    out, _ = said(f"doctor {path}")
    wanted = {*values, "s0", "s_f", "K", "E/size"}
    lines = [line.split() for line in out.splitlines()]
    read = {words[1]: float(words[2]) for words in lines if len(words) > 3 and words[1] in wanted}
    for name, value in values.items():
        assert read[name] == pytest.approx(value, rel=1e-5)
    s_f = 2.0 * values["Gc"] / values["sigma0"]
    expected = {"s0": (1.0 - values["eta"]) * s_f, "s_f": s_f, "K": stiffness(values)}
    nodes = [line.split(",") for line in text.splitlines()[1:3]]
    expected["E/size"] = float(re.findall(r"\*Elastic\n([^,]+)", text)[0]) / float(nodes[1][1])
    for name, value in expected.items():
        assert read[name] == pytest.approx(value, rel=1e-5)
    assert re.search(r"sigma0 .* stress ", out) and re.search(r"Gc .* stress\*length ", out)


def test_warnings_of_the_card(said: Callable, tmp_path: Path) -> None:
    """What the library warns of, doctor warns of, with exit code 0."""
    material, pattern = Material(3.0, 0.3, 0.9, 0.5, sigma02=1.0, Gc2=0.01), Pattern.regular(2, theta=70.0)
    texts = model_warnings(material, pattern)
    path = tmp_path / "job.inp"
    path.write_text(deck(Interface(material, pattern), 10.0, 3e4), encoding="utf-8")
    out, _ = said(f"doctor {path}")
    assert texts and all(f"{text}\n" in out for text in texts)

"""README and docs: output of examples, tables and names of the code, links and formulas."""

from __future__ import annotations

import inspect
import itertools
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import asperity
import pytest
from asperity import cli
from asperity.installed import driver

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
CONTRACT, DRIVER = "docs/reference/contract.md", "docs/reference/driver.md"
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$(?:\n+```text\n(.*?)^```$)?", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\[([^\]]*)\]\(([^)\s]+)\)")


EXTRA = re.compile(r"(?:asperity|\"\.)\[([a-z,-]+)\]")


def test_extras_exist() -> None:
    """Every extra that a page or a message names can be installed."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    part = text.partition("[project.optional-dependencies]")[2].partition("\n[")[0]
    known = set(re.findall(r"^([a-z-]+) =", part, re.MULTILINE))
    sources = [*PAGES, *ROOT.glob("python/asperity/**/*.py"), *ROOT.glob("harness/**/*.py")]
    named = {
        (str(path), name)
        for path in sources
        for found in EXTRA.findall(path.read_text(encoding="utf-8"))
        for name in found.split(",")
    }
    assert len(named) > 10 and {(path, name) for path, name in named if name not in known} == set()


class Block(NamedTuple):
    """A fenced block: position, language, text, and the text block that follows, if any."""

    place: str
    language: str
    text: str
    shown: str | None


def blocks(language: str) -> list[Block]:
    """Blocks of a language on all pages."""
    found = []
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for m in FENCE.finditer(text):
            if m[1] == language:
                line = text.count("\n", 0, m.start()) + 1
                found.append(Block(f"{page.relative_to(ROOT)}:{line}", m[1], m[2], m[3]))
    return found


def examples(language: str) -> pytest.MarkDecorator:
    """Parametrise a test by the blocks of a language, of which there is at least one."""
    found = blocks(language)
    assert found
    return pytest.mark.parametrize("block", found, ids=[block.place for block in found])


def run(*command: str | Path, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run a command; `harness.studies` is found from any folder."""
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.run(
        list(command), capture_output=True, text=True, cwd=cwd, timeout=120, check=False, env=environment
    )


def prose(page: Path) -> str:
    """Text of a page without fenced blocks."""
    return FENCE.sub("", page.read_text(encoding="utf-8"))


def without_code(text: str) -> str:
    """Text without code spans."""
    return re.sub(r"`[^`]*`", "", text)


# --- examples -----------------------------------------------------------------------------------------------


@pytest.mark.slow
@examples("python")
def test_python_example(block: Block, tmp_path: Path) -> None:
    """A Python example prints the shown text, without warnings."""
    done = run(sys.executable, "-c", block.text, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == block.shown


@examples("c")
def test_c_example(block: Block, tmp_path: Path) -> None:
    """A C example compiles without a warning, with the header of the tree and the library of the package."""
    (tmp_path / "example.c").write_text(block.text, encoding="utf-8")
    library = asperity.library()
    # the name in an installation
    for name in (library.name, f"{library.name}.{asperity.__version__.split('.')[0]}"):
        (tmp_path / name).symlink_to(library)
    flags = ["-Wall", "-Wextra", "-Werror", "-I", str(ROOT / "src"), "-L", ".", f"-Wl,-rpath,{tmp_path}"]
    build = run(os.environ.get("CC", "cc"), "example.c", *flags, "-lasperity", "-o", "example", cwd=tmp_path)
    assert (build.returncode, build.stderr) == (0, "")
    done = run(tmp_path / "example")
    assert (done.returncode, done.stdout) == (0, block.shown)


def test_fortran_example() -> None:
    """The program of the page is the one that the test of the installed package compiles and runs."""
    installed = (ROOT / "tests/package/foreign/example.f90").read_text(encoding="utf-8")
    [shown] = [block for block in blocks("fortran") if block.text.startswith("program example")]
    assert installed.endswith(shown.text)


@examples("nml")
def test_case_example(block: Block, tmp_path: Path) -> None:
    """A case has an expected end, and ends so."""
    (tmp_path / "case.nml").write_text(block.text, encoding="utf-8")
    done = run(driver(), "case.nml", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "&expect" in block.text


# --- tables and names ---------------------------------------------------------------------------------------


def test_tables_are_up_to_date() -> None:
    """`python -m harness.studies.tables --check` agrees."""
    done = run(sys.executable, "-m", "harness.studies.tables", "--check", CONTRACT, cwd=ROOT)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    text = (ROOT / CONTRACT).read_text(encoding="utf-8")
    assert "| sigma0 |" in text and "| s_dih |" in text


def test_status_codes_are_those_of_the_header() -> None:
    """The page has number and name of every status code of asperity.h."""
    header = (ROOT / "src" / "asperity.h").read_text(encoding="utf-8")
    contract = (ROOT / CONTRACT).read_text(encoding="utf-8")
    codes = re.findall(r"(ASPERITY_\w+) = (\d+)", header)
    assert codes and re.findall(r"^\| (\d+) \| `(ASPERITY_\w+)`", contract, re.MULTILINE) == [
        (number, name) for name, number in codes
    ]


def test_python_signatures() -> None:
    """The table of the contract has the names and the order of the arguments."""
    text = section(CONTRACT, "## Python")
    shown = re.findall(r"^\| `([\w.]+)\((.*?)\)` \|", text, re.MULTILINE)
    assert len(shown) > 5
    for name, arguments in shown:
        function = asperity.Interface if name.startswith(".") else asperity
        for part in name.removeprefix("asperity").strip(".").split("."):
            function = getattr(function, part)
        names = [parameter for parameter in inspect.signature(function).parameters if parameter != "self"]
        listed = [argument.split("=")[0] for argument in arguments.split(", ") if argument]
        if "..." in listed:
            i = listed.index("...")
            after = len(listed) - i - 1
            names[i : len(names) - after] = ["..."]
        assert listed == names, name


def section(page: str, heading: str) -> str:
    """Text under a heading, up to the next one of its level or above."""
    text = (ROOT / page).read_text(encoding="utf-8")
    level = heading.split(" ")[0]
    pattern = rf"^{re.escape(heading)}\n(.*?)(?=^#{{1,{len(level)}}} |\Z)"
    m = re.search(pattern, text, re.MULTILINE | re.DOTALL)
    assert m, heading
    return m[1]


def names_in_table(text: str) -> set[str]:
    """Names in the first column of a table, head left out, `s_N, ..., t_Ty` written out."""
    body = re.sub(r"^\|.*\n\|---.*\n", "", text, flags=re.MULTILINE)
    cells = re.findall(r"^\| ([^|]*) \|", body, re.MULTILINE)
    names = {name.strip() for cell in cells for name in cell.split(",")}
    if "..." in names:
        names |= {f"{letter}_{component}" for letter in "st" for component in ("N", "Tx", "Ty")}
    return names - {"..."}


@pytest.mark.parametrize(
    "group", ["case", "material", "pattern", "step", "expect", "sweep", "replay", "initial", "state", "umat"]
)
def test_names_of_the_case_file(group: str, tmp_path: Path) -> None:
    """The driver lists the names of a group when it meets an unknown one; the page has just these."""
    (tmp_path / "case.nml").write_text(f"&{group} unheard_of = 1 /\n", encoding="utf-8")
    message = run(driver(), "case.nml", cwd=tmp_path).stderr
    m = re.search(rf"&{group}: unheard_of = 1: unknown name, expected one of (.*)", message)
    assert m, message
    text = section(DRIVER, f"### &{group}")
    shown = set(re.findall(r"(\w+) = ", text)) if group == "sweep" else names_in_table(text)
    assert shown == set(m[1].split(", "))


def test_columns_and_events(tmp_path: Path) -> None:
    """Columns of the driver's CSV with those of one plane, and the events that its source names."""
    case = next(block.text for block in blocks("nml") if block.place.startswith(DRIVER))
    (tmp_path / "case.nml").write_text(case, encoding="utf-8")
    assert run(driver(), "case.nml", "--planes", cwd=tmp_path).returncode == 0
    with (tmp_path / "case.csv").open(encoding="utf-8") as file:
        columns = file.readline().strip().split(",")
    rows = section(DRIVER, "## Rows")
    of_rows, of_events = re.split(r"^(?=\| event \| what)", rows, flags=re.MULTILINE)
    expected = {re.sub(r"_1$", "_k", name) for name in columns if not re.search(r"_[2-9]$", name)}
    assert names_in_table(of_rows) == expected
    sources = [ROOT / name for name in ("src/law/asperity_events.f90", "src/run/asperity_load_path.f90")]
    source = "".join(path.read_text(encoding="utf-8") for path in sources)
    events = set(re.findall(r'name_event\((?:row%)?events?, "(\w+)"', source))
    assert events and names_in_table(of_events) == events


def test_commands_and_options_exist() -> None:
    """Targets of make, options of CMake, cases and files that the pages name."""
    text = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
    targets = set(re.findall(r"`make (\w+)", text))
    assert {"demo", "check"} <= targets
    known = run("make", "--print-data-base", "--question", "--silent", cwd=ROOT).stdout
    assert targets <= set(re.findall(r"^(\w+):", known, re.MULTILINE))
    files = [ROOT / "CMakeLists.txt", *ROOT.glob("cmake/*")]
    cmake = "\n".join(file.read_text(encoding="utf-8") for file in files)
    building = [ROOT / "docs" / "reference" / "c.md", ROOT / "CONTRIBUTING.md"]
    pages = "".join(page.read_text(encoding="utf-8") for page in building)
    options = set(re.findall(r"`((?:ASPERITY|PFUNIT)_[A-Z]+)`", pages)) - {"ASPERITY_OK"}
    assert options and {name for name in options if name not in cmake} == set()
    cases = set(re.findall(r"harness/cases/[\w./]*\w", text))
    assert cases and {case for case in cases if not (ROOT / case).exists()} == set()


# --- links --------------------------------------------------------------------------------------------------


def anchors(page: Path) -> set[str]:
    """Names that GitHub gives to the headings of a page."""
    headings = re.findall(r"^#+ (.*)$", prose(page), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links(page: Path) -> None:
    """Files and headings."""
    links = LINK.findall(prose(page))
    assert links
    for _, target in links:
        assert "://" not in target, target
        path, _, anchor = target.partition("#")
        file = (page.parent / path) if path else page
        assert file.exists(), target
        if anchor:
            assert anchor in anchors(file), target


def test_every_page_is_listed() -> None:
    """docs/README.md, from which the navigation of the site is made, has a link to every page."""
    contents = ROOT / "docs" / "README.md"
    listed = {(contents.parent / target).resolve() for _, target in LINK.findall(prose(contents))}
    assert {page for page in PAGES if page.resolve() not in listed} == {contents, ROOT / "README.md"}


def test_tests_that_the_pages_name_exist() -> None:
    """`test: name` in code type is a subroutine of a pFUnit file or a function of a Python test."""
    text = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
    named = set(re.findall(r"`test: (\w+)`", text))
    sources = [path for folder in ("tests", "harness") for path in (ROOT / folder).rglob("*.p[fy]")]
    code = "\n".join(path.read_text(encoding="utf-8") for path in sources)
    found = set(re.findall(r"^\s*(?:subroutine|def) (\w+)\(", code, re.MULTILINE))
    assert named and named - found == set()


def test_numbers_of_the_paper() -> None:
    """Each linked number of the paper stands on the page that it leads to; citations have an entry."""
    page = ROOT / "docs" / "paper" / "paper.md"
    text = prose(page)
    linked = [(words, target) for words, target in LINK.findall(text) if target.endswith(".md")]
    assert len(linked) > 10
    for words, target in linked:
        found = " ".join((page.parent / target).read_text(encoding="utf-8").split()).replace("**", "")
        number = re.escape(" ".join(words.split()))
        assert re.search(rf"(?<![\d.]){number}(?![\d.]*\d)", found), (words, target)
    cited = set(re.findall(r"@(\w+)", text))
    known = re.findall(r"^@\w+{(\w+),", page.with_suffix(".bib").read_text(encoding="utf-8"), re.MULTILINE)
    assert cited == set(known) and len(known) == len(set(known))


# --- maths --------------------------------------------------------------------------------------------------


def unbalanced(tex: str) -> list[str]:
    """Unpaired delimiters of a formula, or text that GitHub rejects."""
    depth, bad = 0, []
    for brace in re.findall(r"(?<!\\)[{}]", tex):
        depth += 1 if brace == "{" else -1
        if depth < 0:
            bad.append("}")
            depth = 0
    bad += ["{"] * depth
    if len(re.findall(r"\\left\b", tex)) != len(re.findall(r"\\right\b", tex)):
        bad.append(r"\left")
    if re.findall(r"\\begin{(\w+)}", tex) != re.findall(r"\\end{(\w+)}", tex):
        bad.append(r"\begin")
    for opening, closing in ((r"\lvert", r"\rvert"), (r"\lVert", r"\rVert"), (r"\langle", r"\rangle")):
        if tex.count(opening) != tex.count(closing):
            bad.append(opening)
    if r"\operatorname" in tex:
        bad.append(r"\operatorname (GitHub refuses it)")
    return bad


def not_plain(tex: str) -> list[str]:
    """Text that Markdown would change in an inline formula."""
    rules = {
        "emphasis": r"(?<![A-Za-z0-9])_|\*",
        "escape": r"\\[^A-Za-z]",
        "tag": r"<[A-Za-z/!]",
        "space at an end": r"^\s|\s$|^$",
    }
    return [what for what, pattern in rules.items() if re.search(pattern, tex)]


def inline(text: str) -> Iterator[tuple[str, str, str, str]]:
    """Formulas between dollars of a line of prose: line, formula, character before, character after."""
    for line in without_code(text).splitlines():
        pieces = line.split("$")
        assert len(pieces) % 2 == 1, f"odd number of $: {line}"
        for i in range(1, len(pieces), 2):
            yield line, pieces[i], pieces[i - 1][-1:], pieces[i + 1][:1]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_maths(page: Path) -> None:
    """Every formula is balanced, and Markdown does not change it."""
    text = page.read_text(encoding="utf-8")
    assert len(re.findall(r"^```", text, re.MULTILINE)) == 2 * len(re.findall(r"^```$", text, re.MULTILINE))
    for m in FENCE.finditer(text):
        if m[1] == "math":
            assert not unbalanced(m[2]) and "$" not in m[2], m[2]
    for line, tex, before, after in inline(prose(page)):
        assert not unbalanced(tex) and not not_plain(tex), f"{tex}: {unbalanced(tex)} {not_plain(tex)}"
        assert re.fullmatch(r"[\s(|]?", before), f"{before}${tex}$"
        assert re.fullmatch(r"[\s.,;:)|]?", after), f"${tex}${after}"
        assert not (line.startswith("|") and "|" in tex), line


def commands() -> list[tuple[str, list[str]]]:
    """Page and words of every command asperity of the pages, without their shell."""
    found = []
    for page in PAGES:
        blocks = re.findall(r"^```(?:console|sh)\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S)
        for line in "\n".join(blocks).replace("\\\n", " ").splitlines():
            words = shlex.split(re.sub(r"\[[^][]*(\[[^][]*\])?[^][]*\]", "", line), comments=True)
            words = list(itertools.takewhile(lambda word: word not in ("|", ">", "&&", "2>"), words))
            if words[:1] == ["asperity"]:
                found.append((page.name, words[1:]))
    return found


@pytest.mark.parametrize(("page", "words"), commands())
def test_commands_of_the_pages_have_the_options(
    page: str, words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    """Every command of a page is one of the parser, with options that are there."""
    parser = cli._parser(words[0])
    try:
        parser.parse_args(words)
    except SystemExit as end:
        # HOST and RHO stand for values
        assert end.code == 0 or re.search(
            r"invalid (choice|float value): '[A-Za-z|]+'", capsys.readouterr().err
        )

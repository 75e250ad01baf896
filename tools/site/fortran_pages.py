"""fortran_pages.py OUTPUT: a Markdown page for each installed module and each file of external procedures.

The texts are the comments of the source, as FORD reads them.
"""

from __future__ import annotations

import html
import re
import sys
from pathlib import Path

from ford.fortran_project import Project
from ford.settings import ProjectSettings

ROOT = Path(__file__).resolve().parents[2]
KINDS = {
    "types": "Types",
    "functions": "Functions",
    "subroutines": "Subroutines",
    "interfaces": "Interfaces",
    "absinterfaces": "Abstract interfaces",
    "variables": "Constants",
}


def plain(comment: str) -> str:
    """Text of a comment that Markdown does not change: what it would read as markup is escaped."""
    parts = re.split(r"(`[^`\n]*`)", comment)
    return "".join(p if i % 2 else re.sub(r"([\[\]*<$])", r"\\\1", p) for i, p in enumerate(parts))


def text_of(entity: object) -> str:
    """Comment of an entity as Markdown."""
    lines = [line[1:] if line.startswith(" ") else line for line in entity.doc_list]  # type: ignore[attr-defined]
    return plain("\n".join(lines).strip())


def declared(variable: object) -> str:
    """Type of a variable with intent, attributes and shape."""
    parts = [re.sub(r"<[^>]*>", "", str(variable.full_type))]  # type: ignore[attr-defined]
    parts += [f"intent({variable.intent})"] if variable.intent else []  # type: ignore[attr-defined]
    parts += [name for name in ("optional", "parameter") if getattr(variable, name, False)]
    parts += [str(a) for a in variable.attribs]  # type: ignore[attr-defined]
    return html.unescape(", ".join(parts))


def rows(variables: list[object]) -> list[str]:
    """Table of arguments or components."""
    table = ["| name | declaration | meaning |", "|---|---|---|"]
    for v in variables:
        meaning = text_of(v).replace("\n", " ").replace("|", "\\|")
        table.append(f"| `{v.name}{v.dimension}` | `{declared(v)}` | {meaning} |")  # type: ignore[attr-defined]
    return [*table, ""]


def entry(entity: object, kind: str) -> list[str]:
    """Section of a procedure, an interface or a type."""
    procedure = getattr(entity, "procedure", entity)
    arguments = list(getattr(procedure, "args", []))
    result = getattr(procedure, "retvar", None)
    lines = [f"### {entity.name}", ""]  # type: ignore[attr-defined]
    if kind in ("functions", "subroutines", "absinterfaces"):
        attributes = " ".join([*getattr(procedure, "attribs", []), kind.removesuffix("s")])
        word = {"absinterface": "interface"}.get(kind.removesuffix("s"), attributes)
        names = ", ".join(a.name for a in arguments)
        lines += ["```fortran", f"{word} {entity.name}({names})", "```", ""]  # type: ignore[attr-defined]
    lines += [text_of(entity) or text_of(procedure), ""]
    fields = list(entity.variables) if kind == "types" else arguments  # type: ignore[attr-defined]
    fields += [result] if result is not None and not isinstance(result, str) else []
    return lines + (rows(fields) if fields else [])


def page(module: object, name: str) -> str:
    """Page of a module, or of a file."""
    lines = [f"# {name}", "", text_of(module), ""]  # type: ignore[attr-defined]
    for kind, heading in KINDS.items():
        entities = sorted(getattr(module, kind, []), key=lambda e: e.name)
        if not entities:
            continue
        lines += [f"## {heading}", ""]
        lines += (
            rows(entities) if kind == "variables" else [line for e in entities for line in entry(e, kind)]
        )
    return "\n".join(lines)


def main() -> None:
    """Run the command."""
    output = Path(sys.argv[1])
    output.mkdir(parents=True, exist_ok=True)
    settings = ProjectSettings(
        project="asperity",
        src_dir=[ROOT / "src"],
        # variants of modules of the library: messages of the single sources, and the choice of kernels
        exclude_dir=[ROOT / "src" / "adapters" / "abaqus", ROOT / "src" / "dispatch"],
        docmark="!",
        predocmark=">",
        display=["public"],
        preprocess=False,
        quiet=True,
        warn=False,
    )
    settings.normalise_paths(ROOT)
    project = Project(settings)
    project.correlate()
    assert project.modules, "src: expected modules"
    text = (ROOT / "src" / "CMakeLists.txt").read_text(encoding="utf-8")
    installed = re.findall(r"^  set\(public ([\w ]+)\)", text, re.MULTILINE)[0].split()
    modules = {module.name: module for module in project.modules}
    pages = {name: modules[name] for name in (f"asperity_{end}" for end in installed)}
    pages |= {Path(file.name).stem: file for file in project.files if file.functions or file.subroutines}
    for name, entity in pages.items():
        (output / f"{name}.md").write_text(page(entity, name), encoding="utf-8")
    print(f"{len(pages)} pages")


if __name__ == "__main__":
    main()

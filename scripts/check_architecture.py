#!/usr/bin/env python3
"""The diagrams of the architecture agree with the link lists.

docs/architecture.md opens with a diagram of the top folders of src/ and their arrows, docs/modules.md lists every module with
the first paragraph of its README and the modules that it may include. Both are generated from the cosiva_module(...) calls;
this check fails if a document differs, or a module has no README. --write regenerates them, --self-test checks small good
and bad trees.
"""

import pathlib
import re
import sys

import check_arrows
import checker

BEGIN, END = "<!-- arrows: begin, written by scripts/check_architecture.py --write -->", "<!-- arrows: end -->"


def top(module):
    return module.split("/")[0]


def arrows_of(modules):
    """{folder: folders that it uses}, without tests and without arrows implied by others."""
    uses = {top(name): set() for name in modules if not name.endswith(("testing", "oracle"))}
    for name, module in modules.items():
        for target in module.links["PUBLIC"] + module.links["PRIVATE"]:
            if top(name) in uses and target in modules and top(target) != top(name):
                uses[top(name)].add(top(target))

    def reached(start, seen):
        for target in uses[start]:
            if target not in seen:
                seen.add(target)
                reached(target, seen)
        return seen

    implied = {name: set().union(*(reached(t, set()) for t in targets)) for name, targets in uses.items()}
    return {name: targets - implied[name] for name, targets in uses.items()}


def diagram(modules):
    lines = ["```mermaid", "flowchart TD"]
    for name, targets in sorted(arrows_of(modules).items()):
        lines += [f"  {name} --> {target}" for target in sorted(targets)]
    return "\n".join([BEGIN, *lines, "```", END])


def first_paragraph(readme):
    lines = readme.read_text().splitlines()[1:]
    while lines and not lines[0].strip():
        lines.pop(0)
    end = next((i for i, line in enumerate(lines) if not line.strip() or line.startswith(("|", "```", "-"))), len(lines))
    return " ".join(line.strip() for line in lines[:end])


def table(src, modules, problems):
    lines = [
        "# Modules",
        "Every module of `src/`, with the first paragraph of its README and the modules that it may include (tests left out). Written by",
        "`scripts/check_architecture.py --write` from the link lists; a test compares.",
        "",
        "| module | what | may include |",
        "| --- | --- | --- |",
    ]
    for name, module in sorted(modules.items()):
        readme = src / name / "README.md"
        if not readme.exists():
            problems.append(f"src/{name}: has no README.md")
            continue
        uses = ", ".join(t for t in sorted(module.links["PUBLIC"] + module.links["PRIVATE"]) if t in modules)
        lines.append(f"| `src/{name}` | {first_paragraph(readme)} | {uses or '-'} |")
    return "\n".join(lines) + "\n"


def wanted(root, problems):
    """{document: its expected text}"""
    modules = check_arrows.read_modules(root / "src", [])
    page = root / "docs/architecture.md"
    text = page.read_text() if page.exists() else ""
    if BEGIN not in text or END not in text:
        problems.append("docs/architecture.md: lacks the markers of the diagram")
    else:
        text = text[: text.index(BEGIN)] + diagram(modules) + text[text.index(END) + len(END) :]
    return modules, {page: text, root / "docs/modules.md": table(root / "src", modules, problems)}


def check(root):
    problems = []
    modules, documents = wanted(root, problems)
    for path, text in documents.items():
        if not path.exists() or path.read_text().rstrip() != text.rstrip():
            problems.append(f"{path.relative_to(root)}: differs from the link lists; --write regenerates it")
    return modules, problems


# ---- self-test -------------------------------------------------------------------------------------------------------

DIAGRAM = f"{BEGIN}\n```mermaid\nflowchart TD\n  wire --> zone\n  zone --> base\n```\n{END}"
GOOD = {
    "src/base/CMakeLists.txt": "cosiva_module(base)",
    "src/base/README.md": "# base\nResults.\nTime.\n\nMore.",
    "src/zone/circuit/CMakeLists.txt": "cosiva_module(zone/circuit PUBLIC base TEST wire)",
    "src/zone/circuit/README.md": "# zone/circuit\nThe graph.",
    "src/wire/CMakeLists.txt": "cosiva_module(wire PUBLIC base PRIVATE zone/circuit)",
    "src/wire/README.md": "# wire\nMessages.",
    "docs/architecture.md": f"# Architecture\n{DIAGRAM}\nMore.",
    "docs/modules.md": table(pathlib.Path(), {}, [])
    + "| `src/base` | Results. Time. | - |\n| `src/wire` | Messages. | base, zone/circuit |\n"
    + "| `src/zone/circuit` | The graph. | base |",
}
BAD = [
    ({"src/wire/CMakeLists.txt": "cosiva_module(wire PUBLIC base)"}, "docs/architecture.md: differs from the link lists"),
    ({"src/wire/README.md": "# wire\nOther."}, "docs/modules.md: differs from the link lists"),
    ({"src/zone/rtm/CMakeLists.txt": "cosiva_module(zone/rtm PUBLIC base)"}, "src/zone/rtm: has no README.md"),
    ({"docs/architecture.md": "# Architecture"}, "lacks the markers of the diagram"),
]


if __name__ == "__main__":
    if sys.argv[1:] == ["--write"]:
        for document, content in wanted(pathlib.Path(__file__).resolve().parent.parent, [])[1].items():
            document.write_text(content)
        sys.exit(0)
    sys.exit(checker.main("architecture", __doc__, "modules", check, GOOD, BAD))

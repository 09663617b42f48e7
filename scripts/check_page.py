#!/usr/bin/env python3
"""The dependencies between the page's features: every import in web/src must be declared in web/src/README.md.

The table of web/src/README.md has a row per feature, "| `map` | `commands`, `shell`, `live` |". The check fails on
  - an import of another feature that the feature's row does not name, and a row that names a feature never imported;
  - a folder without a row, and a row without a folder;
  - arrows that form a cycle;
  - a feature that imports a file of web/src itself (App.svelte and main.ts combine the features);
  - a file outside every feature, except those, and an import from outside web/src, except the VDA 5050 schemas.
The same rules apply to tests. With --self-test the check evaluates small good and bad trees.
"""

import posixpath
import re
import sys

import checker

FOLDER = "web/src"
TOP_FILES = {"App.svelte", "main.ts", "app.css", "env.d.ts", "README.md"}
ROW = re.compile(r"^\| `(\w+)` \| (.*?) \|", re.MULTILINE)
# from '…', import '…', import('…'), new URL('…', import.meta.url) and import.meta.glob('…').
IMPORT = re.compile(r"""(?:\bfrom\s+|\bimport\s*\(?\s*|\bnew\s+URL\(\s*|\bglob(?:<[^>]*>)?\(\s*)(['"])(\.[^'"]*)\1""")
OUTSIDE = re.compile(r"\.\./\.\./src/[\w/]*vda5050/schemas/")


def read_arrows(readme):
    return {name: set(re.findall(r"`(\w+)`", targets)) for name, targets in ROW.findall(readme)}


def cycle_in(arrows):
    """The features of one cycle, in order; an empty list if there is none."""
    done = set()

    def visit(name, path):
        if name in path:
            return [*path[path.index(name):], name]
        if name in done:
            return []
        for target in sorted(arrows.get(name, ())):
            found = visit(target, [*path, name])
            if found:
                return found
        done.add(name)
        return []

    return next((found for name in sorted(arrows) if (found := visit(name, []))), [])


def imports_of(path, text):
    """(line, imported file, relative to web/src; a leading ../ is outside of it) for each relative import."""
    for match in IMPORT.finditer(text):
        line = text.count("\n", 0, match.start(2)) + 1
        yield line, posixpath.normpath(posixpath.join(posixpath.dirname(path), match.group(2)))


def check_file(path, text, arrows, used, problems):
    feature = path.partition("/")[0] if "/" in path else None
    for line, target in imports_of(path, text):
        where = f"{FOLDER}/{path}:{line}"
        if target.startswith(".."):
            if not OUTSIDE.match(target):
                problems.append(f"{where}: imports {target}, which is not the page's")
            continue
        other = target.partition("/")[0] if "/" in target else None
        if feature is None or other == feature:
            continue
        if other is None:
            problems.append(f"{where}: {feature} imports {target}, which puts the features together")
        elif other not in arrows.get(feature, ()):
            problems.append(f"{where}: {feature} imports {other}, an arrow that {FOLDER}/README.md does not have")
        used.add((feature, other))


def check(root):
    folder, problems, used = root / FOLDER, [], set()
    readme = folder / "README.md"
    arrows = read_arrows(readme.read_text() if readme.exists() else "")
    files = {p.relative_to(folder).as_posix(): p for p in sorted(folder.rglob("*")) if p.is_file()}
    folders = {path.partition("/")[0] for path in files if "/" in path}
    problems += [f"{FOLDER}/{path}: belongs to no feature" for path in files if "/" not in path and path not in TOP_FILES]
    problems += [f"{FOLDER}/README.md: has no row for {name}" for name in sorted(folders - arrows.keys())]
    problems += [f"{FOLDER}/README.md: there is no folder {name}" for name in sorted(arrows.keys() - folders)]
    for path, file in files.items():
        if file.suffix in (".ts", ".svelte"):
            check_file(path, file.read_text(), arrows, used, problems)
    declared = {(name, target) for name, targets in arrows.items() for target in targets}
    problems += [f"{FOLDER}/README.md: {a} does not import {b}; remove the arrow" for a, b in sorted(declared - used)]
    if found := cycle_in(arrows):
        problems.append(f"{FOLDER}/README.md: the arrows form a cycle: {' → '.join(found)}")
    return len(files), problems


# ---- self-test -------------------------------------------------------------------------------------------------------

README = "| feature | imports |\n| --- | --- |\n| `map` | `shell`, `live` |\n| `shell` | `live` |\n| `live` | nothing |"
GOOD = {
    "web/src/README.md": README,
    "web/src/App.svelte": "<script>\n  import Map from './map/Map.svelte';\n  import('./shell/Late.svelte');\n</script>",
    "web/src/map/Map.svelte": "import { frame } from '../shell/frame';\nimport { a,\n  b } from '../live/a';\nimport './own';",
    "web/src/map/map.test.ts": "import { describe } from 'vitest';\nimport { field } from './sample';",
    "web/src/shell/frame.ts": "import type { Row } from '../live/a';",
    "web/src/live/a.ts": "new Worker(new URL('./worker.ts', import.meta.url));\n"
    "import state from '../../../src/wire/vda5050/schemas/state.schema';",
}
BAD = [
    ({"web/src/live/a.ts": "\nimport x from '../shell/frame';"}, "web/src/live/a.ts:2: live imports shell, an arrow"),
    ({"web/src/live/a.ts": "const x = await import('../map/x');"}, "live imports map, an arrow"),
    ({"web/src/live/a.ts": "let x: typeof import(\"../map/x\");"}, "live imports map, an arrow"),
    ({"web/src/live/a.ts": "new Worker(new URL('../map/worker.ts', import.meta.url))"}, "live imports map, an arrow"),
    ({"web/src/live/a.ts": "import.meta.glob<string>('../map/*.ts')"}, "live imports map, an arrow"),
    ({"web/src/live/a.test.ts": "import { x } from '../map/x';"}, "web/src/live/a.test.ts:1: live imports map, an arrow"),
    ({"web/src/live/a.ts": "export { x } from '../App.svelte';"}, "live imports App.svelte, which puts the features"),
    ({"web/src/live/a.ts": "import x from '../../dev/mock.mjs';"}, "imports ../dev/mock.mjs, which is not the page's"),
    ({"web/src/gvs/a.ts": ""}, "web/src/README.md: has no row for gvs"),
    ({"web/src/util.ts": ""}, "web/src/util.ts: belongs to no feature"),
    ({"web/src/README.md": README + "\n| `gvs` | `live` |"}, "web/src/README.md: there is no folder gvs"),
    ({"web/src/shell/frame.ts": ""}, "shell does not import live; remove the arrow"),
    (
        {
            "web/src/README.md": README.replace("| nothing |", "| `map` |"),
            "web/src/live/a.ts": "import x from '../map/x';",
        },
        "the arrows form a cycle: live → map → live",
    ),
    ({"web/src/README.md": ""}, "web/src/README.md: has no row for map"),
]


if __name__ == "__main__":
    sys.exit(checker.main("page", __doc__, "files", check, GOOD, BAD))

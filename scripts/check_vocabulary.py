#!/usr/bin/env python3
"""The number of retired words in the tree, and of comments whose subject is "it" or "who".

scripts/vocabulary_retired.txt lists the words, docs/glossary.md their replacements; both contain the same words. The check
counts each word in
  identifiers  of C++ in src/, e2e/, bench/, fuzz/ and examples/, split at underscores and capitals;
  text         comments there, and strings with spaces: logs, help;
  names        strings without spaces there and in docs/protocols/openapi.json: JSON keys, topics, options;
  files        names of files and folders;
  web          web/src and web/index.html, all of it;
  docs         all *.md but CHANGELOG.md and the glossary, which have to name what was renamed, and docs/modules.md;
and in comments
  subject-it   sentences that begin with "It";
  subject-who  "who", "whoever", "nobody", "somebody" before a verb.

The counts are in scripts/vocabulary_allowed.txt, which may only shrink (scripts/ratchet.py): --write lowers them after a
renaming, --measure rewrites them, --show WORD lists the occurrences of a word, --self-test checks small good and bad trees.
"""

import collections
import os
import pathlib
import re
import sys
from dataclasses import dataclass

import ratchet
from cpp_source import Source

SCOPES = ("identifiers", "text", "names", "files", "web", "docs")
CODE_FOLDERS = ("src", "e2e", "bench", "fuzz", "examples")
NAMED_FOLDERS = (*CODE_FOLDERS, "web/src", "docs", "scripts", "scenarios")
SKIPPED_FOLDERS = {"node_modules", "dist", "build", "artefacts", "corpus", "testdata", "golden", ".git"}
SKIPPED_DOCUMENTS = {"CHANGELOG.md", "docs/glossary.md", "docs/modules.md"}  # the last is generated from READMEs
RETIRED = "scripts/vocabulary_retired.txt"
GLOSSARY = "docs/glossary.md"

IDENTIFIER = re.compile(r"[A-Za-z_]\w*")
DIRECTIVE = re.compile(r"^[ \t]*#(?:\\\n|[^\n])*", re.MULTILINE)
CAMEL = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")
NO_LETTER = re.compile(r"[^a-z]+")
JSON_STRING = re.compile(r'"((?:\\.|[^"\\])*)"')
ROW = re.compile(r"^\| `([a-z-]+)` \|", re.MULTILINE)

COMMENT_MARK = re.compile(r"^\s*(?:///?<?!?|/?\*+/?)\s?", re.MULTILINE)
VERBS = (
    "is|are|was|has|have|had|can|may|must|will|would|should|does|do|did|stands?|drives?|waits?|goes|go|says?|asks?"
    "|hears?|looks?|comes?|wants?|knows?|needs?|gets?|takes?|sees?|reads?|uses?|holds?|sends?|tells?|told|calls?|moves?"
    "|stays?|leaves?|gives?"
)
SUBJECTS = {
    "subject-it": re.compile(r"(?:\A|[.:;!?]\s+|\n\s*\n)It\s"),
    "subject-who": re.compile(rf"\b(?:who|whoever|nobody|somebody)\s+(?:{VERBS})\b", re.IGNORECASE),
}


@dataclass(frozen=True)
class Word:
    key: str
    scopes: tuple
    forms: tuple
    exact: tuple
    exceptions: tuple


def read_words(path, problems):
    words = []
    for number, line in enumerate(path.read_text().splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        parts = [part.strip() for part in line.split("|")]
        if len(parts) != 4 or not parts[0] or not parts[2]:
            problems.append(f"{RETIRED}:{number}: a word is KEY | SCOPES | FORMS | EXCEPT")
            continue
        key, scopes, forms, exceptions = parts[0], parts[1].split(), *(
            [form.strip() for form in part.split(",") if form.strip()] for part in parts[2:])
        scopes = SCOPES if scopes == ["all"] else tuple(scopes)
        for scope in set(scopes) - set(SCOPES):
            problems.append(f"{RETIRED}:{number}: '{scope}' is not a scope")
        exact = tuple(form[1:] for form in forms if form.startswith("="))
        words.append(Word(key, scopes, tuple(f for f in forms if not f.startswith("=")), exact, tuple(exceptions)))
    return words


def normal(text):
    """Words in small letters between single spaces: `feltBy`, `felt_by` and "felt by" are " felt by "."""
    return f" {NO_LETTER.sub(' ', CAMEL.sub(' ', text).lower())} "


def files_below(root, folders):
    for folder in folders:
        for path, names, files in os.walk(root / folder):
            names[:] = sorted(name for name in names if name not in SKIPPED_FOLDERS)
            yield from (pathlib.Path(path) / name for name in sorted(files))


def documents(root):
    yield from sorted(root.glob("*.md"))
    folders = (*CODE_FOLDERS, "docs", "scripts", "scenarios", "zones", "batteries", "rules", "web")
    yield from (path for path in files_below(root, folders) if path.suffix == ".md")


class Tree:
    """The texts of each scope, joined; a full stop on a line of its own keeps sequences from crossing."""

    def __init__(self, root):
        self.files = 0
        self.pieces = {scope: [] for scope in SCOPES}  # (file name, raw text)
        self.comments = []
        self.identifiers = collections.Counter()
        for path in files_below(root, CODE_FOLDERS):
            if path.suffix in (".h", ".cpp"):
                self._read_code(path, path.relative_to(root).as_posix())
        names = [path.relative_to(root).as_posix() for path in files_below(root, NAMED_FOLDERS)]
        self.pieces["files"] = [(name, name.rpartition("/")[2]) for name in names]
        self._read("web", root, [p for p in files_below(root, ["web/src"])] + [root / "web/index.html"])
        self._read("docs", root, [p for p in documents(root) if p.relative_to(root).as_posix() not in SKIPPED_DOCUMENTS])
        openapi = root / "docs/protocols/openapi.json"
        if openapi.exists():
            self.pieces["names"].append(
                ("docs/protocols/openapi.json", "\n.\n".join(JSON_STRING.findall(openapi.read_text()))))

    def _read(self, scope, root, paths):
        for path in paths:
            if path.exists():
                self.files += 1
                self.pieces[scope].append((path.relative_to(root).as_posix(), path.read_text(errors="replace")))

    def _read_code(self, path, name):
        self.files += 1
        source = Source(path.read_text(), with_declarations=False)
        text = source.text
        code = DIRECTIVE.sub("", source.code)
        identifiers = IDENTIFIER.findall(code)
        self.identifiers.update(identifiers)
        self.pieces["identifiers"].append((name, "\n.\n".join(identifiers)))
        comments = joined_comments(source)
        self.comments.append((name, comments))
        strings = [text[start + 1 : end - 1] for start, end in source.strings]
        self.pieces["text"].append((name, "\n.\n".join([*comments, *(s for s in strings if " " in s)])))
        self.pieces["names"].append((name, "\n.\n".join(s for s in strings if " " not in s)))

    def normal(self, scope):
        if scope == "identifiers":  # each name once, times its count
            return None
        return " . ".join(normal_lines(text) for _, text in self.pieces[scope])


def normal_lines(text):
    return " . ".join(normal(piece) for piece in text.split("\n.\n"))


def joined_comments(source):
    """The comments of a file, consecutive lines as one."""
    joined, last_end = [], None
    for start, end in source.comments:
        text = COMMENT_MARK.sub("", source.text[start:end])
        between = source.text[last_end:start] if last_end is not None else "\n\n"
        if not between.strip() and between.count("\n") <= 1:
            joined[-1] += "\n" + text
        else:
            joined.append(text)
        last_end = end
    return joined


class Counts:
    """The number of words and sequences of words in a text that is normal()."""

    def __init__(self, text):
        self.text = text
        self.words = collections.Counter(text.split(" "))

    def of(self, form):
        return self.words[form] if " " not in form else self.text.count(f" {form} ")

    def of_word(self, word):
        # A form inside an exception is not an occurrence: "right of way" takes one from "way".
        excluded = sum(
            self.of(exception) * sum(f" {exception} ".count(f" {form} ") for form in word.forms)
            for exception in word.exceptions
        )
        return max(0, sum(self.of(form) for form in word.forms) - excluded)


def identifier_counts(identifiers, words):
    """The retired words in identifiers: for each name, only words whose form begins with one of its parts are tried."""
    by_piece = {}
    for word in words:
        if "identifiers" in word.scopes:
            for form in word.forms:
                by_piece.setdefault(form.split(" ")[0], []).append(word)
    counts = collections.Counter()
    for name, count in identifiers.items():
        text = normal(name)
        candidates = {word for piece in set(text.split(" ")) & by_piece.keys() for word in by_piece[piece]}
        if candidates:
            one = Counts(text)
            for word in candidates:
                counts[word.key] += one.of_word(word) * count
    for word in words:
        counts[word.key] += sum(identifiers[name] for name in word.exact)
    return counts


def subject_counts(tree):
    text = "\n\n".join(comment for _, comments in tree.comments for comment in comments)
    return {subject: len(pattern.findall(text)) for subject, pattern in SUBJECTS.items()}


def check_glossary(root, words, problems):
    path = root / GLOSSARY
    rows = ROW.findall(path.read_text()) if path.exists() else []
    keys = [word.key for word in words]
    for key in sorted(set(keys) - set(rows)):
        problems.append(f"{GLOSSARY}: has no row for the retired word `{key}` of {RETIRED}")
    for key in sorted(set(rows) - set(keys)):
        problems.append(f"{RETIRED}: has no line for the retired word `{key}` of {GLOSSARY}")
    for key in sorted({key for key in keys if keys.count(key) > 1}):
        problems.append(f"{RETIRED}: has two lines for `{key}`")


def measure(root, problems):
    root = pathlib.Path(root)
    words = read_words(root / RETIRED, problems)
    check_glossary(root, words, problems)
    tree = Tree(root)
    measured = {}
    for scope in SCOPES:
        if scope == "identifiers":
            counts = identifier_counts(tree.identifiers, words)
        else:
            in_text = Counts(tree.normal(scope))
            counts = {word.key: in_text.of_word(word) for word in words}
        for word in words:
            if scope in word.scopes and counts[word.key]:
                complaint = f"{scope}: '{word.key}' is retired, and occurs here {counts[word.key]} times"
                measured[scope, word.key] = (counts[word.key], f"{complaint}; --show {word.key} lists them")
    for subject, count in subject_counts(tree).items():
        if count:
            measured["comments", subject] = (count, f"comments: {count} of {subject}; --show {subject} lists them")
    return tree.files, measured


def show(root, key):
    """Prints the occurrences of a word: identifiers and names with their counts, other texts by file."""
    word = next((word for word in read_words(root / RETIRED, []) if word.key == key), None)
    tree = Tree(root)
    if key in SUBJECTS:
        for name, comments in tree.comments:
            for comment in comments:
                for match in SUBJECTS[key].finditer(comment):
                    print(f"{name}: {' '.join(comment[match.start():].split())[:100]}")
        return 0
    if word is None:
        print(f"{key}: is not a word of {RETIRED}")
        return 1
    for scope in word.scopes:
        found = collections.Counter()
        for name, text in tree.pieces[scope]:
            for piece in text.split("\n.\n") if scope in ("identifiers", "names") else [text]:
                exactly = scope == "identifiers" and piece in word.exact
                count = Counts(normal(piece)).of_word(word) + exactly
                if count:
                    found[piece if scope in ("identifiers", "names") else name] += count
        print(f"{scope}: {sum(found.values())}")
        for what, count in found.most_common():
            print(f"  {count:5} {what}")
    return 0


# ---- self-test -------------------------------------------------------------------------------------------------------

LIST = "scripts/vocabulary_allowed.txt"
GOOD = {
    RETIRED: "# head\ninside | identifiers | =Inside, =inside_ |\nway | all | way, ways | right of way, both ways\n"
    "line | text docs | off the line |\nfelt | all | felt, feels |",
    GLOSSARY: "| retired | term |\n| --- | --- |\n| `inside` | x |\n| `way` | path |\n| `line` | y |\n| `felt` | perceived |",
    "CHANGELOG.md": "`felt` is perceived now",
    "README.md": "the right of way, inside",
    "src/aiv/a.h": "#include <way>\n// Paths with right of way, in both ways. 1'000 of the way\n"
    "int right_of_way{}, halfway, rightOfWay, inside;\n"
    'auto key = "felt-tip"; char c = \'"\';',
    "web/src/a.ts": "const path = 1",
    "web/src/node_modules/way.ts": "way",
    LIST: "cap text 1\ntext way 1 not renamed yet\ncap names 1\nnames felt 1 not renamed yet",
}
BAD = [
    ({"src/aiv/b.h": "int way_ahead();"}, "identifiers: 'way' is retired, and occurs here 1 times"),
    ({"src/aiv/b.h": "struct WayMap { Way x; };"}, "identifiers: 'way' is retired, and occurs here 2 times"),
    ({"src/aiv/b.h": "struct A::Inside {};"}, "identifiers: 'inside' is retired, and occurs here 1"),
    ({"src/aiv/b.h": "/* It feels\n good */"}, "text: 'felt' is retired"),
    ({"src/aiv/b.h": "// off the\n// line\nint x;"}, "text: 'line' is retired, and occurs here 1"),
    ({"e2e/b.cpp": 'log("no way to there");'}, "text: 'way' is retired, and occurs here 2 times"),
    ({"e2e/b.cpp": 'json.key("feltBy");'}, "names: 'felt' is retired, and occurs here 2"),
    ({"docs/protocols/openapi.json": '{"felt_ms": 1}'}, "names: 'felt' is retired, and occurs here 2"),
    ({"src/aiv/way_map.h": ""}, "files: 'way' is retired"),
    ({"web/src/b.svelte": "<p>No way</p>"}, "web: 'way' is retired"),
    ({"docs/a.md": "its way"}, "docs: 'way' is retired"),
    ({"src/aiv/README.md": "its way"}, "docs: 'way' is retired"),
    ({"src/aiv/b.h": "/// The speed. It is positive.\nint x;"}, "comments: 1 of subject-it"),
    ({"src/aiv/b.h": "/// It is positive.\nint x;  ///< It too"}, "comments: 2 of subject-it"),
    ({"src/aiv/b.h": "// Before whoever waits, who is first"}, "comments: 2 of subject-who"),
    ({GLOSSARY: GOOD[GLOSSARY].replace("| `way` | path |\n", "")}, "has no row for the retired word `way`"),
    ({GLOSSARY: GOOD[GLOSSARY] + "\n| `hall` | control area |"}, "has no line for the retired word `hall`"),
    ({RETIRED: GOOD[RETIRED] + "\nway | all | ways |"}, "has two lines for `way`"),
    ({RETIRED: GOOD[RETIRED] + "\nhall | docs code | control area |"}, "'code' is not a scope"),
    ({RETIRED: GOOD[RETIRED] + "\nhall"}, "a word is KEY | SCOPES | FORMS | EXCEPT"),
    ({"src/aiv/a.h": ""}, "text way: the entry is no longer needed"),
    ({LIST: GOOD[LIST].replace("way 1", "way 2")}, "text way: shrink the entry from 2 to 1"),
    ({"src/aiv/b.h": "// the way"}, "occurs here 2 times; --show way lists them; vocabulary_allowed.txt allows 1"),
]

RULES = {scope: "not renamed yet" for scope in (*SCOPES, "comments")}
HEAD = "What scripts/check_vocabulary.py lets pass: RULE NAME VALUE REASON. The list may only shrink (scripts/ratchet.py)."
CHECK = ratchet.Ratchet("vocabulary", "files", RULES, HEAD, LIST, measure)

if __name__ == "__main__":
    if len(sys.argv) == 3 and sys.argv[1] == "--show":
        sys.exit(show(pathlib.Path(__file__).resolve().parent.parent, sys.argv[2]))
    sys.exit(CHECK.main(__doc__, GOOD, BAD))

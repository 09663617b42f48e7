"""A small reader of C++ for the checks: classes with their members and functions, and where functions are defined.

The reader knows declarations, not expressions. Comments, literals and preprocessor lines are blanked, brackets are
matched, and function bodies are skipped. The formatting of the tree (.clang-format) is used in one place: a `<` directly
after a name opens template arguments, a `<` after a space compares.
"""

import bisect
import re
from dataclasses import dataclass, field

# Each alternative begins with a literal character, which lets the search skip all other text. The quotes in 1'000 and
# 0xff'ff are digit separators.
LEXEME = re.compile(
    r"//(?:\\\n|[^\n])*"
    r"|/\*.*?\*/"
    r'|"(?<=R")([^\s()\\]{0,16})\(.*?\)\1"'
    r'|"(?:\\.|[^"\\\n])*"'
    r"|'(?<![0-9a-fA-F]')(?:\\.|[^'\\\n])+'",
    re.DOTALL,
)
DIRECTIVE = re.compile(r"^[ \t]*#(?:\\\n|[^\n])*", re.MULTILINE)
OPERATOR = re.compile(r"\boperator\s*(?:\(\s*\)|\[\s*\]|[-+*/%^&|!=<>~,]+)")
BRACKET = re.compile(r"[(){}\[\]]")
STOP = re.compile(r"[;{}(\[]")
INNERMOST_ANGLES = re.compile(r"(?:(?<=\w)|(?<=template ))<[^<>]*>")
SPACES = re.compile(r"\s+")
FOLLOWING = re.compile(r"\s*(.?)(.?)")
BLANK = re.compile(r"[\s;]*")
POINTER = re.compile(r"[*&^]|(?:\w+::)+\*")
EMPTIED = {"(": "()", "{": "{}", "[": "[]"}
REQUIRES_END = re.compile(r"\brequires\s*(\(\))?$")
REQUIRES = re.compile(
    r"requires\s*(?:\(\)\s*(?:\{\})?|[\w:]+(?:<>)?)(?:\s*(?:&&|\|\|)\s*(?:\(\)|[\w:]+(?:<>)?))*\s*"
)
TYPE_HEAD = re.compile(r"(?:typedef\s+)?(class|struct|union|enum)\b")
NAMESPACE = re.compile(r"(?:inline\s+)?namespace\b\s*([\w:]*)|extern\s*\"\s*\"\s*\{")
SPECIFIERS = re.compile(r"^(?:(?:static|constexpr|inline|const)\s+)+")
ENUM_OR_FORWARD = re.compile(r"enum\b|(?:class|struct|union)\s+[\w:<>]+$")
CUT = re.compile(r"(?<![=!<>])=(?!=)|\{\}|(?<!:):(?!:)")
STATIC = re.compile(r"\bstatic\b")
CONST = re.compile(r"\s*const\b")
DEFAULTED = re.compile(r"=\s*(default|delete)$")
STATIC_MEMBER = re.compile(r"(?:inline |constexpr )*static\b")
PAIRS = {")": "(", "}": "{", "]": "["}
ACCESS = re.compile(r"\s*(public|private|protected)\s*:(?!:)")
PREFIX = re.compile(r"(?:\[\]\s*|template\s*<>\s*|alignas\(\)\s*)+")
CLASS_HEAD = re.compile(
    r"(?P<key>class|struct|union)\b\s*(?:(?:\[\]|alignas\(\))\s*)*(?P<name>[\w:<>]*)\s*(?:final\b\s*)?"
    r"(?P<bases>:(?!:)[^{]*)?\{\}"
)
FUNCTION = re.compile(r"(?P<qualifier>(?:\w+(?:<>)?::)*)(?P<name>~?\w+|operator\s+[\w:<>*& ]+?)\s*\(\)")
NO_FUNCTION = {"explicit", "decltype", "alignas", "noexcept", "requires", "__attribute__", "asm"}
NEITHER = re.compile(r"(friend|using|typedef|static_assert|concept|extern)\b")


class UnreadableSource(Exception):
    """Brackets that do not match: this reader does not support the file."""


@dataclass
class Function:
    name: str
    qualifier: str  # of a definition outside its class: "Outer::Inner"
    access: str
    is_static: bool
    is_const: bool
    is_defaulted: bool  # or deleted
    body: str | None  # without comments and literals; None: only declared

    @property
    def is_operator(self):
        return self.name.startswith("operator")


@dataclass
class Class:
    name: str  # "Outer::Inner"
    key: str
    line: int
    comment: str
    out_of_line: bool  # struct Outer::Inner {…}
    access: str  # of the enclosing section; "public" at namespace scope
    in_namespace: bool
    has_bases: bool
    hidden: bool = False  # in an unnamed namespace
    functions: list = field(default_factory=list)
    members: dict = field(default_factory=dict)  # access: number of data members that are not static
    has_restricted_section: bool = False


def blanked(text):
    return re.sub(r"[^\n]", " ", text)


def without_prefix(flat):
    """A declaration without its attributes, template parameters and constraints."""
    prefix = PREFIX.match(flat)
    if prefix:
        flat = flat[prefix.end() :]
    constraint = REQUIRES.match(flat)
    return flat[constraint.end() :] if constraint else flat


def flat_angles(text):
    """Template arguments become <>, the innermost first."""
    if "<" not in text:
        return text
    count = 1
    while count:
        text, count = INNERMOST_ANGLES.subn("\x01", text)
    return text.replace("\x01", "<>")


class Source:
    """One file: `classes`, `definitions` (functions with a qualified name and a body), comments and strings."""

    def __init__(self, text, with_declarations=True):
        self.text = text
        self.comments, self.strings = [], []  # (start, end)
        code = LEXEME.sub(self._take_lexeme, text)
        self.code = code
        if with_declarations:
            code = DIRECTIVE.sub(lambda m: blanked(m.group()), code)
            self.code = OPERATOR.sub(lambda m: "operator" + "_" * (len(m.group()) - 8), code)
            self.pair = self._match_brackets()
            self._comment_ends = [end for _, end in self.comments]
            self.classes, self.definitions = [], []
            self._read_scope(0, len(self.code), None, False)

    def _take_lexeme(self, match):
        text = match.group()
        if text[0] == "/":
            self.comments.append(match.span())
            return blanked(text)
        if text[0] == '"':
            self.strings.append(match.span())
        return '"' + blanked(text[1:-1]) + '"'

    def _match_brackets(self):
        pair, stack = {}, []
        for match in BRACKET.finditer(self.code):
            c = match.group()
            if c in "({[":
                stack.append((c, match.start()))
            elif not stack or stack[-1][0] != PAIRS[c]:
                raise UnreadableSource(f"{self.line(match.start())}: '{c}' closes nothing")
            else:
                pair[stack.pop()[1]] = match.start()
        if stack:
            raise UnreadableSource(f"{self.line(stack[-1][1])}: '{stack[-1][0]}' is never closed")
        return pair

    def line(self, position):
        return self.text.count("\n", 0, position) + 1

    def comment_before(self, position):
        """The comment that ends directly above a declaration."""
        lines, i = [], bisect.bisect_right(self._comment_ends, position) - 1
        while i >= 0:
            start, end = self.comments[i]
            between = self.text[end:position]
            if between.strip() or between.count("\n") > 1:
                break
            line_start = self.text.rfind("\n", 0, start) + 1
            if self.text[line_start:start].strip():
                break  # a trailing comment of the previous line
            lines.append(self.text[start:end])
            position, i = start, i - 1
        return "\n".join(reversed(lines))

    # ---- declarations ------------------------------------------------------------------------------------------------

    def _flat(self, start, end):
        """The text between the positions, with empty brackets: `void f(int x) {…}` is `void f() {}`."""
        code, pieces, i = self.code, [], start
        while True:
            match = STOP.search(code, i, end)
            if not match:
                pieces.append(code[i:end])
                break
            at, c = match.start(), match.group()
            pieces.append(code[i:at])
            i = at + 1
            if c in EMPTIED:
                pieces.append("(*)" if c == "(" and POINTER.match(code, at + 1) else EMPTIED[c])
                i = self.pair[at] + 1
        flat = SPACES.sub(" ", "".join(pieces).replace("->", "  "))
        return flat_angles(flat).strip()

    def _end_of_statement(self, start, end):
        code, i = self.code, start
        while True:
            match = STOP.search(code, i, end)
            if not match:
                return end
            at, c = match.start(), match.group()
            if c == ";":
                return at + 1
            if c == "}":
                return at + 1
            i = self.pair[at] + 1
            if c == "{" and self._ends_with_block(start, at, i, end):
                return i

    def _ends_with_block(self, start, opening, after, end):
        """Whether a statement that began at `start` ends with the block {…} that ends before `after`."""
        rest = FOLLOWING.match(self.code, after, end)
        following = rest.group(1)
        if following in (";", ",", "{", "(", ".", "+", "-", "*", "/", "?", "|", "&", "<", ">", "="):
            return False
        if following == ":" and rest.group(2) != ":":
            return False
        head = self._flat(start, opening)
        if REQUIRES_END.search(head):
            return False
        bare = without_prefix(head)
        return not (TYPE_HEAD.match(bare) and "()" not in bare.replace("alignas()", ""))

    def _read_scope(self, start, end, owner, hidden):
        access = "private" if owner and owner.key == "class" else "public"
        i = start
        while True:
            i = BLANK.match(self.code, i, end).end()
            if i >= end:
                return
            label = ACCESS.match(self.code, i, end) if owner else None
            if label:
                access = label.group(1)
                owner.has_restricted_section |= access != "public"
                i = label.end()
                continue
            stop = self._end_of_statement(i, end)
            self._read_statement(i, stop, owner, access, hidden)
            i = stop

    def _read_statement(self, start, stop, owner, access, hidden):
        flat = self._flat(start, stop).rstrip("; ")
        flat = without_prefix(flat)
        space = NAMESPACE.match(flat)
        if space and flat.endswith("{}"):
            opening = self.code.index("{", start)
            unnamed = flat.startswith("namespace") and not space.group(1)
            self._read_scope(opening + 1, self.pair[opening], None, hidden or unnamed)
            return
        if space or not flat or NEITHER.match(flat):
            return
        if flat.startswith("enum ") and "{}" in flat:
            self._add_members(owner, access, flat[flat.index("{}") + 2 :])
            return
        head = CLASS_HEAD.match(SPECIFIERS.sub("", flat))
        if head:
            self._read_class(head, start, stop, owner, access, hidden)
            self._add_members(owner, access, flat[flat.index("{}") + 2 :])
            return
        if ENUM_OR_FORWARD.match(flat):
            return
        function = self._as_function(flat, start, stop, access)
        if function is None:
            self._add_members(owner, access, flat)
        elif owner:
            owner.functions.append(function)
        elif function.qualifier and (function.body is not None or function.is_defaulted):
            self.definitions.append(function)

    def _read_class(self, head, start, stop, owner, access, hidden):
        # The body is the first block outside of attributes and template arguments.
        opening = self.code.index("{", start)
        name = re.sub(r"<>", "", head.group("name")) or f"(unnamed in line {self.line(start)})"
        full = f"{owner.name}::{name}" if owner else name
        made = Class(
            full, head.group("key"), self.line(start), self.comment_before(start), "::" in name, access, owner is None,
            bool(head.group("bases")), hidden,
        )
        self.classes.append(made)
        self._read_scope(opening + 1, self.pair[opening], made, hidden)

    def _as_function(self, flat, start, stop, access):
        """The function that is declared here; None: not a function."""
        cut = CUT.search(flat)
        limit = cut.start() if cut else len(flat)
        if "(*)" in flat[:limit]:
            return None
        for found in FUNCTION.finditer(flat):
            if found.start() >= limit:
                return None
            if found.group("name") in NO_FUNCTION:
                continue
            before, after = flat[: found.start()], flat[found.end() :]
            body = None
            if flat.endswith("{}"):
                opening = self._last_block(start, stop)
                body = self.code[opening : self.pair[opening] + 1]
            return Function(
                SPACES.sub(" ", found.group("name")), found.group("qualifier").replace("<>", "").rstrip(":"), access,
                bool(STATIC.search(before)), bool(CONST.match(after)),
                bool(DEFAULTED.search(after)), body,
            )
        return None

    def _last_block(self, start, stop):
        last, i = None, start
        while True:
            match = STOP.search(self.code, i, stop)
            if not match:
                return last
            i = match.end()
            if match.group() in "({[":
                if match.group() == "{":
                    last = match.start()
                i = self.pair[match.start()] + 1

    @staticmethod
    def _add_members(owner, access, flat):
        """Counts the data members that `flat` declares: `double x{}, y{}` are two."""
        if owner is None or not flat.strip() or STATIC_MEMBER.match(flat):
            return
        owner.members[access] = owner.members.get(access, 0) + flat.count(",") + 1

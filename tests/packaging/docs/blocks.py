"""The blocks of code in Markdown pages, and the comments on their tests (tests/packaging/docs/README.md)."""

import re
import shlex
import shutil
import tomllib
from dataclasses import dataclass, field

FENCE = re.compile(r"^( *)(```+|~~~+) *(\S*)")
DIRECTIVE = re.compile(r"<!-- test: (.*?)\s*-->", re.DOTALL)
MODES = ("run", "validate", "skip", "save", "append", "output", "text")
SHELL = ("sh", "bash", "shell", "console")


class PageError(Exception):
    """A page that does not keep to the conventions; its text names page and line."""


@dataclass
class Block:
    page: str  # path in the repository
    line: int  # of its first line
    language: str  # of a fence; empty: indented, or a fence without one
    text: str
    mode: str = ""  # one of MODES; empty: no comment
    options: dict = field(default_factory=dict)
    reason: str = ""

    @property
    def place(self):
        return f"{self.page}:{self.line}"


def read_directive(text, place):
    """(mode, options, reason) of a comment: "run code=2 add='--max-steps 3', because..."."""
    words, _, reason = " ".join(text.split()).partition(", ")
    mode, *rest = shlex.split(words)
    if mode not in MODES:
        raise PageError(f"{place}: 'test: {mode}' is none of {', '.join(MODES)}")
    options = {}
    for word in rest:
        key, equals, value = word.partition("=")
        if mode in ("save", "append"):
            options["file"] = word
        elif mode == "run" and equals and key in ("code", "add", "limit"):
            options[key] = value
        else:
            raise PageError(f"{place}: 'test: {mode}' has no option '{word}'")
    if (mode in ("validate", "skip") or "add" in options) and not reason:
        raise PageError(f"{place}: 'test: {mode}' needs a reason after a comma")
    if mode in ("save", "append") and "file" not in options:
        raise PageError(f"{place}: 'test: {mode}' needs the name of a file")
    return mode, options, reason


def blocks(page, text):
    """Fenced blocks, and those indented by four spaces after an empty line, in order."""
    lines = text.splitlines()
    found, comment, comment_line, n = [], None, 0, 0
    while n < len(lines):
        line = lines[n]
        fence = FENCE.match(line)
        if line.lstrip().startswith("<!-- test:"):
            end = n
            while "-->" not in lines[end]:
                end += 1
                if end == len(lines):
                    raise PageError(f"{page}:{n + 1}: this comment does not end")
            comment, comment_line = DIRECTIVE.search("\n".join(lines[n:end + 1]))[1], n + 1
            n = end + 1
            continue
        block = None
        if fence:
            end = n + 1
            while end < len(lines) and lines[end].strip() != fence[2]:
                end += 1
            block = Block(page, n + 2, fence[3], "\n".join(without(lines[n + 1:end], len(fence[1]))))
            n = end + 1
        elif line.startswith("    ") and (n == 0 or not lines[n - 1].strip() or comment is not None):
            end = n
            while end < len(lines) and (lines[end].startswith("    ") or not lines[end].strip()):
                end += 1
            block = Block(page, n + 1, "", "\n".join(without(lines[n:end], 4)).rstrip())
            n = end
        elif line.strip() and comment is not None:
            raise PageError(f"{page}:{comment_line}: no block follows this comment")
        else:
            n += 1
        if block is not None:
            if comment is not None:
                block.mode, block.options, block.reason = read_directive(comment, f"{page}:{comment_line}")
            comment = None
            found.append(block)
    if comment is not None:
        raise PageError(f"{page}:{comment_line}: no block follows this comment")
    return found


def without(lines, indentation):
    return [line[indentation:] if not line[:indentation].strip() else line for line in lines]


def commands(text):
    """The commands of a block: lines without remarks, those that end in a backslash joined."""
    joined = re.sub(r"\\\n\s*", " ", text)
    for line in joined.splitlines():
        words = shlex.split(line, comments=True)
        if words:
            yield words


def without_variables(words):
    """A command without the settings of variables before it."""
    while words and re.match(r"[A-Z_]+=", words[0]):
        words = words[1:]
    return words


def is_shell(block, root):
    """Whether a block contains commands: by its comment, or because its first word is a program."""
    if block.language:
        return block.language in SHELL
    if is_toml(block.text):
        return False
    try:
        first = without_variables(next(commands(block.text), []))
    except ValueError:  # a quotation mark that stands alone: no shell
        return False
    if not first:
        return False
    name = first[0]
    return name in (".", "bulkley", "build/bulkley", "mpirun") or \
        ("/" in name and (root / name).is_file()) or ("/" not in name and shutil.which(name) is not None)


def is_toml(text):
    try:
        return bool(tomllib.loads(text))
    except tomllib.TOMLDecodeError:
        return False

"""Texts of a checkout that a person reads: messages, docstrings, comments, docs, subjects."""

from __future__ import annotations

import ast
import io
import re
import subprocess
import sys
import tokenize
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

GROUPS = ("cli", "page", "docstrings", "comments", "docs", "commits", "identifiers")


class Text(NamedTuple):
    """One piece of text and where it stands in the checkout."""

    group: str
    place: str
    text: str


class Hit(NamedTuple):
    """One breach of one rule."""

    rule: str
    group: str
    place: str
    text: str


NOT_PROSE = re.compile(
    r"[\w-]+:\s*[-\w#().%, ]+;|=>|\bconst |\breturn |\b(INSERT|SELECT|CREATE|UPDATE|DELETE|PRAGMA) "
    r"|</?\w+[ >]|^[\w.-]+( [\w.-]+)? --|^(import|from) \w+|^layerjam \w+|\\[a-z]+\{|\(\) ?\{|-src '|^VAC \d"
    r"|\b(w-full|gap-\d|dense|no-caps|items-\w+|text-(xs|sm|lg|base)|opacity-\d+|size=sm|flat round|color=\w+)\b"
)


def is_prose(text: str) -> bool:
    """Tell whether a string literal is likely to be read by a person."""
    words = re.findall(r"[A-Za-z]{2,}", text)
    return " " in text.strip() and len(words) >= 2 and not NOT_PROSE.search(text)


def joined_text(node: ast.JoinedStr) -> str:
    """Return an f-string's text with each replacement field written as `X`."""
    return "".join(str(v.value) if isinstance(v, ast.Constant) else "`X`" for v in node.values)


def python_texts(root: Path, path: Path) -> Iterator[Text]:
    """Yield the user-visible strings, docstrings and comments of one module."""
    source = path.read_text(encoding="utf-8")
    place = path.relative_to(root).as_posix()
    shown = "page" if "/workbench/" in place else "cli"
    tree = ast.parse(source)
    seen: set[int] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            if isinstance(node.value.value, str):
                seen.add(id(node.value))
                yield Text("docstrings", f"{place}:{node.lineno}", node.value.value)
        elif isinstance(node, ast.JoinedStr):
            seen.update(id(value) for value in ast.walk(node))
            text = joined_text(node)
            if is_prose(text):
                yield Text(shown, f"{place}:{node.lineno}", text)
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            if id(node) not in seen and is_prose(node.value):
                yield Text(shown, f"{place}:{node.lineno}", node.value)
    yield from comment_blocks(source, place)


def comment_blocks(source: str, place: str) -> Iterator[Text]:
    """Yield comments, consecutive lines joined; tool directives are left out."""
    block: list[str] = []
    start, last = 0, -1
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type != tokenize.COMMENT:
            continue
        text = token.string.lstrip("#!:- ").strip()
        if re.match(r"(pragma|type: ignore|noqa|fmt:|mypy|ruff|pylint)", text) or not text:
            continue
        if token.start[0] != last + 1 and block:
            yield Text("comments", f"{place}:{start}", " ".join(block))
            block = []
        if not block:
            start = token.start[0]
        block.append(text)
        last = token.start[0]
    if block:
        yield Text("comments", f"{place}:{start}", " ".join(block))


def markdown_texts(root: Path, path: Path) -> Iterator[Text]:
    """Yield the paragraphs of a Markdown file outside code, mathematics and tables."""
    place = path.relative_to(root).as_posix()
    lines: list[str] = []
    start, fenced = 0, ""
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines() + [""], 1):
        mark = re.match(r"\s*(```|~~~|\$\$)", line)
        if mark:
            one_line = mark[1] == "$$" and line.strip().endswith("$$") and len(line.strip()) > 2
            fenced = "" if fenced or one_line else mark[1]
        item = re.match(r"\s*([-*+]|\d+\.|#+)\s", line)
        stop = bool(fenced or mark or not line.strip() or line.lstrip().startswith(("|", "<", "!")))
        if (stop or item) and lines:
            yield Text("docs", f"{place}:{start}", " ".join(lines))
            lines = []
        if not lines and line.startswith("    "):
            continue  # an indented code block
        if not stop:
            start = start if lines else number
            lines.append(re.sub(r"^\s*([-*+>]|\d+\.|#+)\s+", "", line).strip())


def table_texts(root: Path, path: Path) -> Iterator[Text]:
    """Yield the values of the tables of a TOML file, such as docs/scpi_headers.toml."""
    place = path.relative_to(root).as_posix()
    for table in tomllib.loads(path.read_text(encoding="utf-8")).values():
        for name, text in table.items():
            yield Text("docs", f"{place}:{name}", text)


def read_words(svg: str) -> list[str]:
    """Return the words and numbers in a picture; Matplotlib writes them as comments."""
    found = re.findall(r"<!-- (.*?) -->|>([^<>]*)</t", svg)
    return [word for pair in found for word in pair if word.strip()]


def picture_texts(root: Path, path: Path) -> Iterator[Text]:
    """Yield the words of an SVG picture."""
    place = path.relative_to(root).as_posix()
    for text in read_words(path.read_text(encoding="utf-8")):
        yield Text("docs", place, text)


def commit_texts(root: Path, since: str) -> Iterator[Text]:
    """Yield commit subjects, all of them or those after the commit `since`."""
    span = [f"{since}..HEAD"] if since else []
    command = ["git", "-C", str(root), "log", "--no-merges", "--format=%h%x09%s", *span]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    if result.returncode:
        print(f"commit subjects not read: {result.stderr.strip()}", file=sys.stderr)
    for line in result.stdout.splitlines():
        ident, subject = line.split("\t", 1)
        yield Text("commits", ident, subject)


def clean(text: str) -> str:
    """Return text with code, mathematics and links reduced to a short stand-in."""
    text = re.sub(r"``.+?``|`[^`]*`|\$[^$]*\$", "X", text, flags=re.S)
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text)
    text = re.sub(r"https?://\S+", "X", text)
    return re.sub(r"\*\*|__|\s+", lambda m: " " if m[0].isspace() else "", text)


ABBREVIATION = re.compile(r"\b(e\.g|i\.e|eq|Eq|Fig|fig|vs|ca|etc|cf|al|no|No|approx)\.\s")


def sentences(text: str) -> list[str]:
    """Split text at full stops, question marks, exclamation marks and blank lines."""
    out = []
    for part in re.split(r"\n\s*\n", text):
        part = clean(part)
        part = ABBREVIATION.sub(lambda m: m[0].replace(". ", ".\u00a0"), part)
        pieces = re.split(r"(?<=[.!?])['\")]* +", part)
        out += [s.strip().replace("\u00a0", " ") for s in pieces if s.strip()]
    return out

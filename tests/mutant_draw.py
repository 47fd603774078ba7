"""Random changes of the code that computes numbers, in Python and in C: `tests/mutants.py`."""

from __future__ import annotations

import ast
import random
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "src" / "layerjam"
FOLDERS = (
    "brake/mechanics",
    "brake/fluid",
    "brake/simulate",
    "brake/kernel/c",
    "laboratory/measure",
    "laboratory/identify",
    "laboratory/dataset",
    "bench/control",
    "workshop/design",
    "workshop/fabricate",
)
NOT_COMPILED = ("brake/kernel/c/web/web.c",)
"""Only the package ziglang, which `make test` does not have, compiles it."""

SWAP = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.Pow: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.Lt: ast.GtE,
    ast.LtE: ast.Gt,
    ast.Gt: ast.LtE,
    ast.GtE: ast.Lt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.And: ast.Or,
    ast.Or: ast.And,
}
KEEP = {"minimum": (0, 1), "maximum": (0, 1), "where": (1, 2), "clip": (0,), "keep_if": (1,)}
KEEP |= {"safe_sqrt": (0,), "cbrt": (0,), "floor": (0,), "ceil": (0,), "abs": (0,), "roll": (0,)}
"""Functions of which a mutant keeps only one argument."""

PAIRS = (("+", "-"), ("*", "/"), ("<", ">="), (">", "<="), ("==", "!="), ("&&", "||"))
PAIRS += (("+=", "-="), ("*=", "/="), ("lj_max", "lj_min"), ("fmax", "fmin"))
SWAP_IN_C = dict(PAIRS) | {new: old for old, new in PAIRS}
IN_C = re.compile(
    rb"/\*.*?\*/|//[^\n]*|^[ \t]*#(?:[^\n]*\\\n)*[^\n]*|\"(?:\\.|[^\"\\])*\"|'(?:\\.|[^'\\])*'"
    rb"|^[ \t]*[\w \t*]+\[[^;=(]*;"  # an array that is declared larger computes the same
    rb"|(?P<operator>(?<= )(?:[-+*/]=?|[<>=!]=|[<>]|&&|\|\|)(?= ))|(?P<minus>(?<=[ (\[])-(?=[\w(]))"
    rb"|(?P<name>\b(?:lj_max|lj_min|fmax|fmin)(?=\())|(?P<number>\b\d[\w.]*(?:(?<=[eEpP])[-+]\d+)?)",
    re.MULTILINE | re.DOTALL,
)
"""Tokens of C: those that a mutant leaves alone first. Operators have spaces on both sides."""


@dataclass(frozen=True, order=True)
class Mutant:
    """One change of one file below SOURCE: the bytes that are replaced, and by what.

    `statement` has the first and last line of the statement, without the body of a compound one.
    """

    file: str
    line: int
    start: int
    end: int
    text: str
    statement: tuple[int, int]

    @property
    def folder(self) -> str:
        return next(folder for folder in FOLDERS if self.file.startswith(folder + "/"))

    def apply(self, source: str) -> str:
        raw = source.encode()
        return (raw[: self.start] + self.text.encode() + raw[self.end :]).decode()

    def changed_line(self, source: str) -> str:
        return self.apply(source).splitlines()[self.line - 1].strip()


def replacements(node: ast.AST) -> Iterator[ast.expr]:
    """What an expression may be changed into."""
    if isinstance(node, ast.BinOp) and type(node.op) in SWAP:
        yield ast.BinOp(node.left, SWAP[type(node.op)](), node.right)
    elif isinstance(node, ast.BoolOp):
        yield ast.BoolOp(SWAP[type(node.op)](), node.values)
    elif isinstance(node, ast.Compare) and type(node.ops[0]) in SWAP:
        ops = [SWAP[type(node.ops[0])](), *node.ops[1:]]
        yield ast.Compare(node.left, ops, node.comparators)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Invert | ast.Not):
        yield node.operand
    elif isinstance(node, ast.Constant) and isinstance(node.value, bool):
        yield ast.Constant(not node.value)
    elif isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        yield ast.Constant(node.value + 1)
    elif isinstance(node, ast.Call):
        name = getattr(node.func, "attr", getattr(node.func, "id", ""))
        yield from (node.args[place] for place in KEEP.get(name, ()) if place < len(node.args))


Lines = tuple[int, int]


def expressions(node: ast.AST, statement: Lines = (1, 1)) -> Iterator[tuple[ast.AST, Lines]]:
    """Yield all nodes with the lines of their statement, without annotations and decorators."""
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "type_comment", "decorator_list"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if not isinstance(child, ast.AST):
                continue
            lines = statement
            if isinstance(child, ast.stmt):
                body = getattr(child, "body", None)
                last = max(child.lineno, body[0].lineno - 1) if body else child.end_lineno
                lines = (child.lineno, last or child.lineno)
            yield child, lines
            yield from expressions(child, lines)


def fillers(tree: ast.AST) -> set[ast.AST]:
    """The 1.0 of `jnp.where(condition, value, 1.0)`: keeps a gradient finite, is never used."""
    calls = (n for n in ast.walk(tree) if isinstance(n, ast.Call) and len(n.args) == 3)
    last = (n.args[2] for n in calls if getattr(n.func, "attr", "") == "where")
    return {n for n in last if isinstance(n, ast.Constant) and n.value == 1.0}


def mutate_python(file: str, source: str) -> Iterator[Mutant]:
    tree = ast.parse(source)
    unused, starts = fillers(tree), [0]
    for line in source.encode().splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    for node, statement in expressions(tree):
        for new in replacements(node) if node not in unused else ():
            assert isinstance(node, ast.expr) and node.end_lineno and node.end_col_offset
            start = starts[node.lineno - 1] + node.col_offset
            end = starts[node.end_lineno - 1] + node.end_col_offset
            text = f"({ast.unparse(ast.fix_missing_locations(new))})"
            yield Mutant(file, node.lineno, start, end, text, statement)


def mutate_c(file: str, source: str) -> Iterator[Mutant]:
    raw = source.encode()
    for token in IN_C.finditer(raw):
        old = token.group().decode()
        is_filler = old == "1.0" and raw[: token.start()].endswith(b": LJ(")
        if token.lastgroup is None or is_filler:
            continue
        line = raw.count(b"\n", 0, token.start()) + 1
        new = {"minus": " ", "number": f"({old} + 1)"}.get(token.lastgroup, SWAP_IN_C.get(old))
        if new is not None:
            yield Mutant(file, line, *token.span(), new, (line, line))


def read_sources(folders: Sequence[str] = FOLDERS) -> dict[str, str]:
    """Return the text of each file of some folders that may be changed."""
    paths = (path for folder in folders for path in sorted((SOURCE / folder).rglob("*.*")))
    names = {path.relative_to(SOURCE).as_posix(): path for path in paths}
    return {
        name: path.read_text("utf-8")
        for name, path in names.items()
        if path.suffix in (".py", ".c", ".h") and name not in NOT_COMPILED
    }


def mutate(sources: dict[str, str]) -> list[Mutant]:
    """Return all mutants of some files."""
    return [
        mutant
        for file, source in sources.items()
        for mutant in (mutate_python if file.endswith(".py") else mutate_c)(file, source)
    ]


def draw(mutants: Sequence[Mutant], count: int, seed: int) -> list[Mutant]:
    """Return a random sample of some mutants, in random order: each part of it is one as well."""
    return random.Random(seed).sample(sorted(mutants), min(count, len(mutants)))

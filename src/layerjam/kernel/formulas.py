"""The kernel's formulas in C, printed from the laws in Python: each equation is written once.

`python -m layerjam.kernel.formulas` writes `c/formulas.h` again; a test compares.
"""

import ast
import inspect
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from layerjam.mechanics import enclosure, memory, pull

FILE = Path(__file__).parent / "c" / "formulas.h"
LAWS: tuple[Callable[..., Any], ...] = (
    enclosure.enclosure_of,
    memory.branch,
    pull.spread_root,
)
"""Laws in the order of printing: each uses only earlier ones."""
HEAD = """/* Printed by layerjam/kernel/formulas.py from the Python laws. Apache License 2.0. */
"""
OPERATORS: dict[type, tuple[str, int]] = {
    ast.BitOr: ("||", 1),
    ast.BitAnd: ("&&", 2),
    ast.Lt: ("<", 3),
    ast.Gt: (">", 3),
    ast.LtE: ("<=", 3),
    ast.GtE: (">=", 3),
    ast.Add: ("+", 4),
    ast.Sub: ("-", 4),
    ast.Mult: ("*", 5),
    ast.Div: ("/", 5),
}
"""{operator of Python: (operator of C, precedence)}."""
ATOM = 9
CALLS = {"maximum": "max", "minimum": "min", "safe_sqrt": "sqrt"}
"""Names that are shorter in C; others keep theirs."""
RESERVED = {"short", "long", "double", "float", "int", "register", "signed", "static"}
TYPES = {"EnclosureLaw": "lj_enclosure", "Any": "lj_real"}


def print_file() -> str:
    """Return the text of the file."""
    return HEAD + "\n" + _record() + "\n" + "\n".join(function(law) for law in LAWS)


def _record() -> str:
    """Return the class of an enclosure's constants as a C structure."""
    fields = "".join(f"    lj_real {name};\n" for name in enclosure.EnclosureLaw._fields)
    return f"typedef struct {{\n{fields}}} lj_enclosure;\n"


def function(law: Callable[..., Any]) -> str:
    """Return a law as a function in C; raises TypeError for Python that it cannot print."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(law))).body[0]
    if not isinstance(tree, ast.FunctionDef):
        raise TypeError(f"{law.__name__} is not a function")
    kinds = {a.arg: _type(a.annotation) for a in tree.args.args}
    places = (
        f"const {kind} *{name}" if kind == TYPES["EnclosureLaw"] else f"{kind} {name}"
        for name, kind in kinds.items()
    )
    head = f"static inline {_type(tree.returns)} {_name(law.__name__)}({', '.join(places)})"
    lines = [_wrap(line) for line in _statements(tree, kinds)]
    return "\n".join([head, "{", *lines, "}", ""])


def _type(annotation: ast.expr | None) -> str:
    return TYPES[ast.unparse(annotation)] if annotation else TYPES["Any"]


def _wrap(line: str) -> str:
    return textwrap.fill(
        line, 100, initial_indent=" " * 4, subsequent_indent=" " * 8, break_on_hyphens=False
    )


def _name(name: str) -> str:
    bare = name.lstrip("_")
    return "lj_" + CALLS.get(bare, bare)


def _variable(node: ast.expr) -> str:
    name = ast.unparse(node)
    return name + "_" if name in RESERVED else name


def _statements(tree: ast.FunctionDef, kinds: dict[str, str]) -> Iterator[str]:
    names = set(kinds)
    pointers = {name for name, kind in kinds.items() if kind == TYPES["EnclosureLaw"]}
    for line in tree.body:
        if isinstance(line, ast.Expr) and isinstance(line.value, ast.Constant):
            continue  # skip the docstring
        if isinstance(line, ast.Return) and line.value is not None:
            yield f"return {_text(line.value, pointers)[0]};"
            continue
        if not isinstance(line, ast.Assign):
            raise TypeError(f"{tree.name}: {ast.unparse(line)} is not printed")
        target, value = line.targets[0], line.value
        pairs: list[tuple[ast.expr, ast.expr]] = [(target, value)]
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            pairs = list(zip(target.elts, value.elts, strict=True))
        for place, expression in pairs:
            name, (text, tight) = _variable(place), _text(expression, pointers)
            kind = "" if name in names else "int " if tight <= 3 else "lj_real "
            names.add(name)
            yield f"{kind}{name} = {text};"


def _text(node: ast.expr, pointers: set[str]) -> tuple[str, int]:
    """Return an expression and its precedence; the order of operations stays that of Python."""

    def wrap(part: ast.expr, least: int) -> str:
        text, tight = _text(part, pointers)
        return text if tight >= least else f"({text})"

    match node:
        case ast.Constant(value=int() | float() as number):
            return f"LJ({number})", ATOM
        case ast.Name():
            return _variable(node), ATOM
        case ast.Attribute(value=ast.Name(id=owner)) if owner in pointers:
            return f"{owner}->{node.attr}", ATOM
        case ast.BinOp(op=ast.Pow(), right=ast.Constant(value=2)):
            return f"lj_square({_text(node.left, pointers)[0]})", ATOM
        case ast.BinOp() if type(node.op) in OPERATORS:
            sign, tight = OPERATORS[type(node.op)]
            return f"{wrap(node.left, tight)} {sign} {wrap(node.right, tight + 1)}", tight
        case ast.Compare(ops=[operator], comparators=[right]) if type(operator) in OPERATORS:
            sign, tight = OPERATORS[type(operator)]
            return f"{wrap(node.left, tight + 1)} {sign} {wrap(right, tight + 1)}", tight
        case ast.Call():
            return _call(node, pointers), ATOM
    raise TypeError(f"{ast.unparse(node)} is not printed")


def _call(node: ast.Call, pointers: set[str]) -> str:
    name = node.func.attr if isinstance(node.func, ast.Attribute) else ast.unparse(node.func)
    args = [_text(arg, pointers)[0] for arg in node.args]
    if name == "where":
        return f"({args[0]} ? {args[1]} : {args[2]})"
    if name == "EnclosureLaw":
        return f"(lj_enclosure){{{', '.join(args)}}}"
    return f"{_name(name)}({', '.join(args)})"


if __name__ == "__main__":
    FILE.write_text(print_file(), encoding="utf-8")

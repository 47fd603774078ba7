"""The kernel's formulas in C, printed from the laws in Python, so that each is written once.

`python tests/print_c.py` rewrites the files of LAWS in `brake/kernel/c`; a test checks them.
"""

import ast
import inspect
import textwrap
from collections.abc import Callable, Iterator
from typing import Any

from c_printers.c_text import c_variable, wrap_line
from layerjam.brake.mechanics import enclosure, memory
from layerjam.brake.mechanics.stop import algebra

_STRIP = enclosure.EnclosureLaw
LAWS: dict[str, tuple[Callable[..., Any], ...]] = {
    "formulas.h": (_STRIP, enclosure.make_enclosure, memory.branch, enclosure.spread_root),
    "stop_formulas.h": (
        _STRIP,
        algebra.Setup,
        algebra.Quartic,
        algebra.Search,
        algebra.Stop,
        algebra.make_setup,
        algebra.positive_root,
        algebra.balance_root,
        algebra.quartic,
        algebra.quartic_value,
        algebra.quartic_slope,
        algebra.snap_root,
        algebra.bracket_root,
        algebra.guess_root,
        algebra.curvature_step,
        algebra.polish_root,
        algebra.make_stop,
        enclosure.first_loading,
    ),
}
"""{file: records and laws in the order of printing}; each uses only earlier ones."""
HEAD = """/* Printed from the Python laws by tests/c_printers/formulas.py. Apache License 2.0. */
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
"""{name in Python: shorter name in C}; other names are unchanged."""
TYPES = {
    "Any": "lj_real",
    "EnclosureLaw": "lj_enclosure",
    "Setup": "lj_case",
    "Quartic": "lj_energy",
    "Search": "lj_bracket",
    "Stop": "lj_end",
}
RECORDS = {"enclosure": "lj_enclosure", "energy": "lj_energy"}
"""{field that is a record: its type}."""


def format_file(name: str) -> str:
    """Return the C text of a file in LAWS."""
    parts = (format_record(x) if isinstance(x, type) else format_function(x) for x in LAWS[name])
    return HEAD + "\n" + "\n".join(parts)


def format_record(record: Any) -> str:
    """Return a named tuple of numbers as a C structure."""
    kinds = {name: RECORDS.get(name, "lj_real") for name in record._fields}
    fields = "".join(f"    {kind} {name};\n" for name, kind in kinds.items())
    return f"typedef struct {{\n{fields}}} {TYPES[record.__name__]};\n"


def format_function(law: Callable[..., Any]) -> str:
    """Return a law as a C function; raises TypeError for Python code that it cannot print."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(law))).body[0]
    if not isinstance(tree, ast.FunctionDef):
        raise TypeError(f"{law.__name__} is not a function")
    kinds = {a.arg: _c_type(a.annotation) for a in tree.args.args}
    places = (
        f"{kind} {c_variable(name)}"
        if kind == TYPES["Any"]
        else f"const {kind} *{c_variable(name)}"
        for name, kind in kinds.items()
    )
    head = f"static inline {_c_type(tree.returns)} {_c_name(law.__name__)}({', '.join(places)})"
    lines = [wrap_line(line, 1) for line in _Printer(law, kinds).print_statements(tree)]
    return "\n".join([wrap_line(head), "{", *lines, "}", ""])


def _c_type(annotation: ast.expr | None) -> str:
    return TYPES[ast.unparse(annotation)] if annotation else TYPES["Any"]


def _c_name(name: str) -> str:
    public_name = name.lstrip("_")
    return "lj_" + CALLS.get(public_name, public_name)


class _Printer:
    """Printer of one law's statements in C; records are passed by pointer."""

    def __init__(self, law: Callable[..., Any], kinds: dict[str, str]) -> None:
        self.home = law.__globals__
        self.kinds = dict(kinds)
        self.pointers = {name for name, kind in kinds.items() if kind != TYPES["Any"]}

    def print_statements(self, tree: ast.FunctionDef) -> Iterator[str]:
        for line in tree.body:
            if isinstance(line, ast.Expr) and isinstance(line.value, ast.Constant):
                continue  # skip the docstring
            if isinstance(line, ast.Return) and line.value is not None:
                yield f"return {self.print_node(line.value)[0]};"
                continue
            if not isinstance(line, ast.Assign):
                raise TypeError(f"{tree.name}: {ast.unparse(line)} cannot be printed")
            target, value = line.targets[0], line.value
            pairs: list[tuple[ast.expr, ast.expr]] = [(target, value)]
            if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
                pairs = list(zip(target.elts, value.elts, strict=True))
            for place, expression in pairs:
                name, (text, precedence) = ast.unparse(place), self.print_node(expression)
                kind = "" if name in self.kinds else self.infer_type(expression, precedence) + " "
                self.kinds.setdefault(name, kind.strip())
                yield f"{kind}{c_variable(name)} = {text};"

    def infer_type(self, node: ast.expr, tight: int = ATOM) -> str:
        """Return the C type of an expression."""
        match node:
            case ast.Name() if ast.unparse(node) in self.kinds:
                return self.kinds[ast.unparse(node)]
            case ast.Attribute():
                return RECORDS.get(node.attr, TYPES["Any"])
            case ast.Call(func=ast.Name(id=name)) if name in self.home:
                law = self.home[name]
                if isinstance(law, type):
                    return TYPES[name]
                result_type = inspect.signature(law).return_annotation
                return TYPES[getattr(result_type, "__name__", result_type)]
        return "int" if tight <= 3 else TYPES["Any"]

    def print_node(self, node: ast.expr) -> tuple[str, int]:
        """Return an expression in C and its precedence, with Python's order of operations."""

        def wrap(part: ast.expr, min_precedence: int) -> str:
            text, precedence = self.print_node(part)
            return text if precedence >= min_precedence else f"({text})"

        match node:
            case ast.Constant(value=int() | float() as number):
                return f"LJ({number})", ATOM
            case ast.UnaryOp(op=ast.USub(), operand=ast.Constant(value=int() | float() as number)):
                return f"LJ(-{number})", ATOM
            case ast.Name(id=name) if name.isupper():
                return f"LJ({self.home[name]})", ATOM
            case ast.Name(id=name):
                return c_variable(name), ATOM
            case ast.Attribute(value=ast.Name(id="xp")):
                return "LJ_INFINITY", ATOM
            case ast.Attribute(value=owner):
                arrow = "->" if ast.unparse(owner) in self.pointers else "."
                return f"{self.print_node(owner)[0]}{arrow}{node.attr}", ATOM
            case ast.BinOp(op=ast.Pow(), right=ast.Constant(value=2)):
                return f"lj_square({self.print_node(node.left)[0]})", ATOM
            case ast.BinOp() if type(node.op) in OPERATORS:
                sign, precedence = OPERATORS[type(node.op)]
                return (
                    f"{wrap(node.left, precedence)} {sign} {wrap(node.right, precedence + 1)}",
                    precedence,
                )
            case ast.Compare(ops=[operator], comparators=[right]) if type(operator) in OPERATORS:
                sign, precedence = OPERATORS[type(operator)]
                return (
                    f"{wrap(node.left, precedence + 1)} {sign} {wrap(right, precedence + 1)}",
                    precedence,
                )
            case ast.Call():
                return self.print_call(node), ATOM
        raise TypeError(f"{ast.unparse(node)} cannot be printed")

    def print_call(self, node: ast.Call) -> str:
        name = node.func.attr if isinstance(node.func, ast.Attribute) else ast.unparse(node.func)
        args = [self.print_argument(arg, name in TYPES) for arg in node.args]
        if name == "where":
            return f"({args[0]} ? {args[1]} : {args[2]})"
        if name in TYPES:
            return f"({TYPES[name]}){{{', '.join(args)}}}"
        return f"{_c_name(name)}({', '.join(args)})"

    def print_argument(self, node: ast.expr, is_field: bool) -> str:
        """Return an argument: a record by value as a field of another record, else its address."""
        text, is_address = self.print_node(node)[0], ast.unparse(node) in self.pointers
        if self.infer_type(node) in ("int", TYPES["Any"]) or is_address != is_field:
            return text
        return f"*{text}" if is_field else f"&{text}"

"""Expressions of Python printed as C, with the types and the lengths of tuples that they need."""

import ast
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from c_printers.c_text import (
    INTEGER,
    REAL,
    TRUTH,
    TYPES,
    WORD,
    c_function,
    c_variable,
    field_types,
    record_name,
)

OPERATORS: dict[type, tuple[str, int]] = {
    ast.Or: ("||", 1),
    ast.And: ("&&", 2),
    ast.BitXor: ("^", 4),
    ast.BitAnd: ("&", 5),
    ast.Eq: ("==", 6),
    ast.NotEq: ("!=", 6),
    ast.Lt: ("<", 7),
    ast.Gt: (">", 7),
    ast.LtE: ("<=", 7),
    ast.GtE: (">=", 7),
    ast.RShift: (">>", 8),
    ast.Add: ("+", 9),
    ast.Sub: ("-", 9),
    ast.Mult: ("*", 10),
    ast.Div: ("/", 10),
}
"""{operator of Python: (operator of C, precedence)}."""
BITS = ast.BitXor | ast.BitAnd | ast.RShift
UNARY, ATOM = 11, 12
NAMES = {"abs": "fabs", "max": "lj_max", "min": "lj_min", "round": "rint"}
CONSTANTS = {"inf": "INFINITY", "nan": "NAN"}


class Program:
    """Lengths of tuples and types of results, which all functions share."""

    def __init__(self, trees: Mapping[str, ast.FunctionDef], records: Sequence[Any]) -> None:
        self.trees, self.records = trees, {record.__name__ for record in records}
        self.fields = {n: kind for record in records for n, kind in field_types(record).items()}
        """{field of a record: its C type}; one name has one type in all records."""
        self.lengths: dict[str, int] = {}
        """{name of a tuple: number of floats in it}."""
        pairs = [pair for tree in trees.values() for pair in _unpackings(tree)]
        for _ in range(2):  # in the second pass, the types of nested tuples are known
            for name, parts in pairs:
                self.lengths[name] = sum(self.lengths.get(part, 1) for part in parts)
        self.results = {name: self._count_results(tree) for name, tree in trees.items()}
        """{function: number of floats in its tuple, or 0 if it returns no tuple}."""

    def _count_results(self, tree: ast.FunctionDef) -> int:
        result_kind = ast.unparse(tree.returns) if tree.returns else ""
        if not result_kind.startswith("tuple"):
            return 0
        values = [n.value for n in ast.walk(tree) if isinstance(n, ast.Return) and n.value]
        counts = {self.count(value) for value in values if not isinstance(value, ast.Call)}
        for value in values:
            if isinstance(value, ast.Call) and not counts:
                counts = {self._count_results(self.trees[ast.unparse(value.func)])}
        if len(counts) != 1:
            raise TypeError(f"{tree.name}: its tuples have different lengths")
        return counts.pop()

    def count(self, node: ast.expr) -> int:
        """Return the number of floats in an expression."""
        if isinstance(node, ast.Tuple):
            return sum(map(self.count, node.elts))
        return self.lengths.get(node.id, 1) if isinstance(node, ast.Name) else 1

    def is_tuple(self, node: ast.expr) -> bool:
        """Return whether an expression is the name of a tuple."""
        return isinstance(node, ast.Name) and node.id in self.lengths

    def c_type(self, annotation: ast.expr | None) -> str:
        """Return the C type of a parameter or of a result."""
        text = ast.unparse(annotation) if annotation else "float"
        if text in ("None", "float") or text in TYPES:
            return "void" if text == "None" else TYPES[text]
        if text.startswith("tuple"):
            return "const double *"
        name = text.removeprefix("Sequence[").removesuffix("]")
        if name not in self.records:
            raise TypeError(f"the type {text} cannot be printed")
        return f"const {record_name(name)} *"


def _unpackings(tree: ast.FunctionDef) -> Iterator[tuple[str, list[str]]]:
    """Yield (name, names of its parts) for each `part, ... = name` and `name = part, ...`."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.Assign):
            continue
        left, right = node.targets[0], node.value
        if isinstance(left, ast.Name) and isinstance(right, ast.Tuple):
            left, right = right, left
        if isinstance(left, ast.Tuple) and isinstance(right, ast.Name):
            yield right.id, [part.id if isinstance(part, ast.Name) else "" for part in left.elts]


class ExpressionPrinter:
    """Printer of the expressions of one function."""

    def __init__(self, program: Program, tree: ast.FunctionDef, home: Mapping[str, Any]) -> None:
        self.program, self.tree, self.home = program, tree, home
        self.kinds = {a.arg: program.c_type(a.annotation) for a in tree.args.args}
        """{parameter or local variable: its C type}."""

    def refusal(self, node: ast.AST) -> TypeError:
        """Return the error for code that cannot be printed."""
        return TypeError(f"{self.tree.name}: {ast.unparse(node)} cannot be printed")

    def text(self, node: ast.expr, min_precedence: int = 0) -> str:
        """Return an expression in C, in parentheses if it binds less than `min_precedence`."""
        text, rank = self.print_node(node)
        return text if rank >= min_precedence else f"({text})"

    def print_node(self, node: ast.expr) -> tuple[str, int]:
        """Return an expression in C and its precedence."""
        match node:
            case ast.Constant(value=bool() | int() | float() as number):
                return self._format_number(number), ATOM
            case ast.Name(id=name) if name.isupper() and name in self.home:
                return self._format_number(self.home[name]), ATOM
            case ast.Name(id=name):
                return c_variable(name), ATOM
            case ast.Attribute(value=ast.Name(id="math"), attr=name):
                return CONSTANTS[name], ATOM
            case ast.Attribute(value=owner):
                arrow = "." if isinstance(owner, ast.Subscript) else "->"
                return f"{self.text(owner)}{arrow}{c_variable(node.attr)}", ATOM
            case ast.Subscript(value=owner, slice=index):
                return f"{self.text(owner)}[{self.text(index)}]", ATOM
            case ast.BinOp(left=left, op=ast.Pow(), right=right):
                return f"pow({self.text(left)}, {self.text(right)})", ATOM
            case ast.BinOp(left=left, op=op, right=right):
                sign, rank = OPERATORS[type(op)]
                # compilers warn about + within & without parentheses
                inner = UNARY if isinstance(op, BITS) else rank
                return (
                    f"{self.text(left, inner)} {sign} {self.text(right, max(inner, rank + 1))}",
                    rank,
                )
            case ast.UnaryOp(op=ast.Not(), operand=part):
                return f"!{self.text(part, UNARY)}", UNARY
            case ast.UnaryOp(op=ast.USub(), operand=part):
                return f"-{self.text(part, UNARY)}", UNARY
            case ast.BoolOp(op=op, values=values):
                sign, rank = OPERATORS[type(op)]
                # compilers warn about && within || without parentheses
                return f" {sign} ".join(self.text(part, 3) for part in values), rank
            case ast.Compare(left=left, ops=ops, comparators=rest):
                return self._print_comparison([left, *rest], ops)
            case ast.IfExp(test=test, body=one, orelse=two):
                parts = f"{self.text(test, 1)} ? {self.text(one, 1)} : {self.text(two, 1)}"
                return f"({parts})", ATOM
            case ast.Call():
                return self.print_call(node), ATOM
        raise self.refusal(node)

    def _print_comparison(
        self, parts: Sequence[ast.expr], ops: Sequence[ast.cmpop]
    ) -> tuple[str, int]:
        texts = []
        for left, op, right in zip(parts, ops, parts[1:], strict=False):
            sign, rank = OPERATORS[type(op)]
            texts.append(f"{self.text(left, rank + 1)} {sign} {self.text(right, rank + 1)}")
        rank = OPERATORS[ast.And][1] if len(texts) > 1 else OPERATORS[type(ops[0])][1]
        return " && ".join(texts), rank

    def _format_number(self, number: Any) -> str:
        if isinstance(number, float):
            return CONSTANTS.get(repr(number), repr(number))
        return f"UINT64_C({number})" if number >= 2**31 else str(int(number))

    def print_call(self, node: ast.Call, out: str = "") -> str:
        """Return a call in C; `out` is where a function that returns a tuple puts it."""
        name = node.func.attr if isinstance(node.func, ast.Attribute) else ast.unparse(node.func)
        if name in ("int", "float"):
            return f"({TYPES[name]}){self.text(node.args[0], UNARY)}"
        args = [self._print_argument(arg) for arg in node.args] + ([out] if out else [])
        if name in self.program.trees:
            return f"{c_function(name)}({', '.join(args)})"
        if not isinstance(node.func, ast.Attribute) and name not in NAMES:
            raise self.refusal(node)
        return f"{NAMES.get(name, name)}({', '.join(args)})"

    def _print_argument(self, node: ast.expr) -> str:
        is_record = isinstance(node, ast.Subscript) and self.infer(node).endswith("*")
        return f"&{self.text(node)}" if is_record else self.text(node)

    def infer(self, node: ast.expr) -> str:
        """Return the C type of an expression."""
        match node:
            case (
                ast.Constant(value=number)
                | ast.UnaryOp(op=ast.USub(), operand=ast.Constant(value=number))
            ):
                return REAL if isinstance(number, float) else INTEGER
            case ast.Name(id=name) if name in self.kinds:
                return self.kinds[name]
            case ast.Name(id=name) if name.isupper() and isinstance(self.home.get(name), int):
                return INTEGER
            case ast.Attribute(attr=name) if name in self.program.fields:
                return self.program.fields[name]
            case ast.Subscript(value=owner):
                kind = self.infer(owner)
                base_kind = kind.removeprefix("const ").removesuffix(" *")
                return kind if base_kind.startswith("lj_") else base_kind
            case ast.BinOp(op=op, left=left, right=right) if not isinstance(op, ast.Div | ast.Pow):
                kinds = {self.infer(left), self.infer(right)}
                return next((kind for kind in (REAL, WORD) if kind in kinds), INTEGER)
            case ast.Compare() | ast.BoolOp() | ast.UnaryOp(op=ast.Not()):
                return TRUTH
            case ast.IfExp(body=one, orelse=two):
                return REAL if REAL in (self.infer(one), self.infer(two)) else self.infer(one)
            case ast.Call(func=ast.Name(id=name)) if name in self.program.trees:
                return self.program.c_type(self.program.trees[name].returns)
            case ast.Call(func=ast.Name(id="int")):
                return INTEGER
        return REAL

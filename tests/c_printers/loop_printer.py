"""Loops in C, printed from modules of Python, so that each loop is written once.

`python tests/print_c.py` rewrites the files of MODULES in `brake/kernel/c`; a test checks them.
A module consists of constants, named tuples, and functions of numbers, arrays and named tuples. The
order of operations stays, so both languages compute the same bits.
"""

import ast
import inspect
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from c_printers.c_text import RESERVED
from layerjam.brake.mechanics.stack import enclosure, history, lasso, peaks, solve

MODULES: dict[str, tuple[ModuleType, ...]] = {
    "stack_loops.h": (lasso, enclosure, solve, history, peaks)
}
"""{file: modules in the order of printing}; each uses only earlier ones."""
EXPORTED = {"follow_path", "follow_peaks"}
"""Functions that Python calls; their names in C start with `lj_`."""
HEAD = (
    "/* Printed from the Python loops by tests/c_printers/loop_printer.py. Apache License 2.0. */\n"
)
KINDS = {
    "float": "double",
    "int": "int64_t",
    "bool": "int64_t",
    "Array": "double *",
    "Signs": "int64_t *",
    "Flags": "uint8_t *",
    "Terms": "double (*)[4]",
    "Turns": f"double (*)[{enclosure.DEPTH}]",
    "None": "void",
}
"""{annotation: type in C}; named tuples are passed by pointer."""
_OPERATORS: dict[type, tuple[str, int]] = {
    ast.Or: ("||", 1),
    ast.And: ("&&", 2),
    ast.Eq: ("==", 3),
    ast.NotEq: ("!=", 3),
    ast.Lt: ("<", 4),
    ast.Gt: (">", 4),
    ast.LtE: ("<=", 4),
    ast.GtE: (">=", 4),
    ast.Add: ("+", 5),
    ast.Sub: ("-", 5),
    ast.Mult: ("*", 6),
    ast.Div: ("/", 6),
    ast.BitAnd: ("&", 0),
    ast.BitOr: ("|", 0),
}
"""{operator of Python: (operator of C, precedence)}; the last two only in assignments."""
_UNARY, _ATOM = 7, 9
_CALLS = {"abs": "fabs", "min": "lj_min", "max": "lj_max"}


@dataclass(frozen=True)
class _Function:
    kinds: dict[str, str]
    answer: str


class Printer:
    """Printer of modules: the types of their records and functions, in the order of printing."""

    def __init__(self) -> None:
        self.records: dict[str, dict[str, str]] = {}
        self.functions: dict[str, _Function] = {}
        self.results: dict[str, list[str]] = {}

    def read_kind(self, annotation: ast.expr) -> str:
        """Return the C type of an annotation; a tuple of numbers becomes a structure."""
        name = ast.unparse(annotation)
        if name.startswith("tuple["):
            kinds = [KINDS[part.strip()] for part in name[6:-1].split(",")]
            result = "Result" + "".join("D" if kind == "double" else "I" for kind in kinds)
            self.results[result] = kinds
            return result
        return f"{name} *" if name in self.records else KINDS[name]

    def print_module(self, module: ModuleType) -> Iterator[str]:
        """Yield the records and functions of a module; raises TypeError for other code."""
        for node in ast.parse(inspect.getsource(module)).body:
            if isinstance(node, ast.ClassDef):
                yield self.print_record(node)
            elif isinstance(node, ast.FunctionDef):
                before = set(self.results)
                kinds = {a.arg: self.read_kind(_require_type(a.annotation)) for a in node.args.args}
                answer = self.read_kind(_require_type(node.returns))
                self.functions[node.name] = _Function(kinds, answer)
                for result in self.results.keys() - before:
                    parts = [_declare(k, f"v{i}") for i, k in enumerate(self.results[result])]
                    members = "".join(f"{part}; " for part in parts)
                    yield f"typedef struct {{ {members}}} {result};\n"
                yield _Body(self, vars(module), node).print_function()

    def print_record(self, node: ast.ClassDef) -> str:
        """Return a named tuple as a structure of its fields and properties."""
        kinds = {}
        for part in node.body:
            if isinstance(part, ast.AnnAssign):
                kinds[ast.unparse(part.target)] = self.read_kind(part.annotation)
            elif isinstance(part, ast.FunctionDef):
                kinds[part.name] = self.read_kind(_require_type(part.returns))
        # a record inside another one is a part of it
        self.records[node.name] = {n: _strip_pointer(k, self.records) for n, k in kinds.items()}
        fields = (f"    {_declare(k, n)};\n" for n, k in self.records[node.name].items())
        return f"typedef struct {{\n{''.join(fields)}}} {node.name};\n"


def _require_type(annotation: ast.expr | None) -> ast.expr:
    if annotation is None:
        raise TypeError("a loop needs the types of its arguments and of its result")
    return annotation


def _strip_pointer(kind: str, records: dict[str, Any]) -> str:
    return kind[:-2] if kind[:-2] in records else kind


def _declare(kind: str, name: str) -> str:
    if "(*)" in kind:
        return kind.replace("(*)", f"(*{name})")
    return f"{kind}{name}" if kind.endswith("*") else f"{kind} {name}"


def _c_name(name: str) -> str:
    return f"lj_{name}" if name in EXPORTED else name.lstrip("_")


class _Body:
    """Printer of one function."""

    def __init__(self, printer: Printer, home: dict[str, Any], tree: ast.FunctionDef) -> None:
        self.printer, self.home, self.tree = printer, home, tree
        self.function = printer.functions[tree.name]
        self.kinds = dict(self.function.kinds)
        self.counters: set[str] = set()
        self.count = 0

    def print_function(self) -> str:
        arguments = (_declare(k, _variable(n)) for n, k in self.function.kinds.items())
        statements = [line for part in self.tree.body[1:] for line in self.print_statement(part, 1)]
        kind = self.function.answer
        name = _declare(kind, _c_name(self.tree.name))
        head = f"{'' if self.tree.name in EXPORTED else 'static '}{name}({', '.join(arguments)})"
        summary = (ast.get_docstring(self.tree) or "").split("\n")[0]
        names = self.kinds.keys() - self.function.kinds.keys() - self.counters
        lines = [f"/* {summary} */", head, "{", *self.print_locals(sorted(names)), *statements, "}"]
        if self.tree.name in EXPORTED:
            lines.insert(1, f"{head};")
        return "\n".join([*map(_wrap, lines), ""])

    def print_locals(self, names: list[str]) -> Iterator[str]:
        """Yield the declarations of local variables, one line for each type."""
        for kind in sorted({self.kinds[name] for name in names}):
            same = [_variable(name) for name in names if self.kinds[name] == kind]
            base, star = kind.removesuffix(" *"), "*" * kind.endswith("*")
            yield f"    {base} {', '.join(star + name for name in same)};"

    def print_statement(self, node: ast.stmt, depth: int) -> Iterator[str]:
        space = "    " * depth

        def block(parts: Sequence[ast.stmt]) -> Iterator[str]:
            for part in parts:
                yield from self.print_statement(part, depth + 1)

        match node:
            case ast.Assign(targets=[target], value=value):
                yield from (space + line for line in self.print_assignment(target, value))
            case ast.AugAssign(target=target, op=operator, value=value):
                sign = _OPERATORS[type(operator)][0]
                yield f"{space}{self.text(target)} {sign}= {self.text(value)};"
            case ast.If(test=test, body=body, orelse=others):
                yield f"{space}if ({self.text(test)}) {{"
                yield from block(body)
                if others:
                    yield f"{space}}} else {{"
                    yield from block(others)
                yield space + "}"
            case ast.For(target=ast.Name(id=name), iter=ast.Call(args=args), body=body):
                yield f"{space}for ({self.print_range(_variable(name), args)}) {{"
                self.kinds[name] = "int64_t"
                self.counters.add(name)
                yield from block(body)
                yield space + "}"
            case ast.While(test=test, body=body):
                yield f"{space}while ({self.text(test)}) {{"
                yield from block(body)
                yield space + "}"
            case ast.Return(value=ast.Tuple(elts=parts)):
                texts = ", ".join(map(self.text, parts))
                yield f"{space}return ({self.function.answer}){{{texts}}};"
            case ast.Return(value=ast.expr() as value):
                yield f"{space}return {self.text(value)};"
            case ast.Return():
                yield space + "return;"
            case ast.Break() | ast.Continue():
                yield f"{space}{type(node).__name__.lower()};"
            case ast.Expr(value=ast.Call() as call):
                yield f"{space}{self.text(call)};"
            case _:
                raise TypeError(f"{self.tree.name}: '{ast.unparse(node)}' cannot be printed")

    def print_range(self, name: str, args: list[ast.expr]) -> str:
        bounds = [self.text(arg) for arg in args]
        if len(bounds) == 3 and bounds[2] == "-1":
            return f"int64_t {name} = {bounds[0]}; {name} > {bounds[1]}; {name}--"
        start, end = ("0", *bounds) if len(bounds) == 1 else bounds
        return f"int64_t {name} = {start}; {name} < {end}; {name}++"

    def print_assignment(self, target: ast.expr, value: ast.expr) -> Iterator[str]:
        """Yield assignments in C; raises TypeError if their order would matter."""
        if not isinstance(target, ast.Tuple):
            pairs = [(target, self.text(value), self.kind(value))]
        elif isinstance(value, ast.Tuple):
            for i, place in enumerate(target.elts):
                later = [ast.unparse(n) for v in value.elts[i + 1 :] for n in ast.walk(v)
                         if isinstance(n, ast.expr)]  # fmt: skip
                if ast.unparse(place) in later:
                    raise TypeError(f"{self.tree.name}: order matters in '{ast.unparse(value)}'")
            couples = zip(target.elts, value.elts, strict=True)
            pairs = [(t, self.text(v), self.kind(v)) for t, v in couples]
        elif self.kind(value) in self.printer.results:
            self.count += 1
            kind, result = self.kind(value), f"result{self.count}"
            yield f"{kind} {result} = {self.text(value)};"
            kinds = self.printer.results[kind]
            pairs = [(t, f"{result}.v{i}", kinds[i]) for i, t in enumerate(target.elts)]
        else:
            array, kind = self.text(value), _element_type(self.kind(value))
            pairs = [(t, f"{array}[{i}]", kind) for i, t in enumerate(target.elts)]
        for place, text, kind in pairs:
            if isinstance(place, ast.Name):
                if place.id == "_":
                    continue
                former = self.kinds.get(place.id, kind)
                self.kinds[place.id] = "double" if "double" in (former, kind) else former
            yield f"{self.text(place)} = {text};"

    def kind(self, node: ast.expr) -> str:
        """Return the C type of an expression."""
        match node:
            case ast.Constant(value=value):
                return "double" if isinstance(value, float) else "int64_t"
            case ast.Name(id=name):
                if name in self.kinds:
                    return self.kinds[name]
                return "double" if isinstance(self.home[name], float) else "int64_t"
            case ast.Attribute(value=ast.Name(id="np")):
                return "double"
            case ast.Attribute(value=owner, attr=name):
                return self.printer.records[_strip_pointer(self.kind(owner), self.printer.records)][
                    name
                ]
            case ast.Subscript(value=owner, slice=place):
                kind = self.kind(owner)
                if kind in self.printer.results:
                    return self.printer.results[kind][ast.literal_eval(place)]
                return "double" if isinstance(place, ast.Tuple) else _element_type(kind)
            case ast.BinOp(op=ast.Div()):
                return "double"
            case ast.BinOp(left=a, right=b) | ast.IfExp(body=a, orelse=b):
                return "double" if "double" in (self.kind(a), self.kind(b)) else self.kind(a)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return self.kind(operand)
            case ast.Call(func=ast.Name(id=name)) if name in self.printer.functions:
                return self.printer.functions[name].answer
            case ast.Call(func=ast.Attribute(attr="isinf")):
                return "int64_t"
            case ast.Call():
                return "double"
        return "int64_t"

    def text(self, node: ast.expr) -> str:
        """Return an expression in C."""
        return self.print_node(node)[0]

    def print_node(self, node: ast.expr) -> tuple[str, int]:
        """Return an expression in C and its precedence, with Python's order of operations."""

        def wrap(part: ast.expr, min_precedence: int) -> str:
            text, precedence = self.print_node(part)
            return text if precedence >= min_precedence else f"({text})"

        match node:
            case ast.Constant(value=value):
                return repr(int(value) if isinstance(value, bool) else value), _ATOM
            case ast.Name(id=name) if name in self.kinds:
                return _variable(name), _ATOM
            case ast.Name(id=name):
                return repr(self.home[name]), _ATOM if self.home[name] >= 0 else _UNARY
            case ast.Attribute(value=ast.Name(id="np"), attr=name):
                return {"inf": "INFINITY", "nan": "NAN"}[name], _ATOM
            case ast.Attribute(value=owner, attr=name):
                arrow = "->" if self.kind(owner).endswith("*") else "."
                return f"{self.text(owner)}{arrow}{name}", _ATOM
            case ast.Subscript(value=owner, slice=ast.Tuple(elts=places)):
                return self.text(owner) + "".join(f"[{self.text(p)}]" for p in places), _ATOM
            case ast.Subscript(value=owner, slice=place):
                is_result = self.kind(owner) in self.printer.results
                text = f".v{self.text(place)}" if is_result else f"[{self.text(place)}]"
                return self.text(owner) + text, _ATOM
            case ast.BinOp(left=a, op=operator, right=b) if type(operator) in _OPERATORS:
                sign, precedence = _OPERATORS[type(operator)]
                cast = sign == "/" and "double" not in (self.kind(a), self.kind(b))
                left = "(double)" * cast + wrap(a, _ATOM if cast else precedence)
                return f"{left} {sign} {wrap(b, precedence + 1)}", precedence
            case ast.UnaryOp(op=operator, operand=operand):
                return f"{'!' if isinstance(operator, ast.Not) else '-'}{wrap(operand, 8)}", _UNARY
            case ast.BoolOp(op=operator, values=values):
                sign, precedence = _OPERATORS[type(operator)]
                return f" {sign} ".join(wrap(value, 3) for value in values), precedence
            case ast.Compare(left=a, ops=[ast.In()], comparators=[ast.Tuple(elts=choices)]):
                same = [f"{wrap(a, 4)} == {wrap(choice, 4)}" for choice in choices]
                return " || ".join(same), 1
            case ast.Compare(left=a, ops=[operator], comparators=[b]):
                sign, precedence = _OPERATORS[type(operator)]
                return f"{wrap(a, precedence + 1)} {sign} {wrap(b, precedence + 1)}", precedence
            case ast.IfExp(test=test, body=a, orelse=b):
                return f"{wrap(test, 1)} ? {wrap(a, 1)} : {self.text(b)}", 0
            case ast.Call():
                return self.print_call(node), _ATOM
        raise TypeError(f"{self.tree.name}: '{ast.unparse(node)}' cannot be printed")

    def print_call(self, node: ast.Call) -> str:
        name = node.func.attr if isinstance(node.func, ast.Attribute) else ast.unparse(node.func)
        texts = [
            f"&{self.text(arg)}" if self.kind(arg) in self.printer.records else self.text(arg)
            for arg in node.args
        ]
        if name in ("float", "bool", "int"):
            return f"({texts[0]})"
        if name not in self.printer.functions and name not in (*_CALLS, "sqrt", "isinf"):
            raise TypeError(f"{self.tree.name}: '{name}' is not a loop")
        return f"{_CALLS.get(name, _c_name(name))}({', '.join(texts)})"


def _variable(name: str) -> str:
    return name + "_" if name in RESERVED else name


def _element_type(kind: str) -> str:
    if "(*)" in kind:
        return "double *"
    return "int64_t" if kind == "uint8_t *" else kind.removesuffix(" *")


def _wrap(line: str) -> str:
    """Return a line of at most 100 characters each; a star stays with what precedes it."""
    space = " " * (len(line) - len(line.lstrip()))
    text = textwrap.fill(
        line.strip().replace(" *", "\u00a0*"), 100, initial_indent=space,
        subsequent_indent=space + "        ", break_on_hyphens=False, break_long_words=False,
    )  # fmt: skip
    return text.replace("\u00a0*", " *")


def format_loops(name: str) -> str:
    """Return the C text of a file in MODULES."""
    printer = Printer()
    return HEAD + "\n" + "\n".join(t for m in MODULES[name] for t in printer.print_module(m))

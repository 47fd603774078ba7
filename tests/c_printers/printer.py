"""Plain Python functions of numbers, tuples and records, printed as C that computes the same bits.

The printed subset: numbers, named tuples of numbers, tuples of known length, sequences by index,
`if`, `for ... in range(...)`, `while`, and calls of printed functions or of `math`. Python's order
of operations stays, and so does the answer of `min` and `max` to NaN. A tuple that is unpacked
once under its name has that length everywhere; functions write tuples, flattened, into `out`.
"""

import ast
import inspect
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

from c_printers.c_expressions import OPERATORS, ExpressionPrinter, Program
from c_printers.c_text import (
    INTEGER,
    REAL,
    c_function,
    c_variable,
    format_record,
    join_declaration,
    wrap_line,
)

HEAD = """\
/* Printed by {home} from the Python sources. Apache License 2.0. */

#include <math.h>
#include <stdint.h>
#include <string.h>

#define LJ_WITHIN static inline __attribute__((always_inline))
#define LJ_APART static __attribute__((noinline))

LJ_WITHIN double lj_max(double a, double b) {{ return b > a ? b : a; }}

LJ_WITHIN double lj_min(double a, double b) {{ return b < a ? b : a; }}

LJ_WITHIN void lj_copy(double *to, const double *from, int count)
{{
    memcpy(to, from, (size_t)count * sizeof(double));
}}
"""


def format_program(
    home: str,
    functions: Sequence[Callable[..., Any]],
    records: Sequence[Any],
    exports: set[str],
    separate: set[str],
) -> str:
    """Return the C text of records and functions; each function calls only earlier ones.

    Functions are inlined, except those named in `exports`, which are visible outside the file, and
    in `separate`. Raises TypeError for Python code that cannot be printed.
    """
    trees = {function.__name__: _parse(function) for function in functions}
    program = Program(trees, records)
    parts = [HEAD.format(home=home), *(format_record(record) for record in records)]
    for function in functions:
        name = function.__name__
        kind = "" if name in exports else "LJ_APART " if name in separate else "LJ_WITHIN "
        parts.append(FunctionPrinter(program, trees[name], function.__globals__).format(kind))
    return "\n".join(parts)


def _parse(function: Callable[..., Any]) -> ast.FunctionDef:
    tree = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
    if not isinstance(tree, ast.FunctionDef):
        raise TypeError(f"{function.__name__} is not a function")
    return tree


class FunctionPrinter(ExpressionPrinter):
    """Printer of one function."""

    def __init__(self, program: Program, tree: ast.FunctionDef, home: Mapping[str, Any]) -> None:
        super().__init__(program, tree, home)
        self.count = program.results[tree.name]
        self.declared: dict[str, str] = {}
        """{local variable: its declaration}."""
        self.stored = [
            node.id
            for node in ast.walk(tree)
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
        ]
        self.scratch = 0

    def format(self, kind: str) -> str:
        """Return the function in C; `kind` precedes its head."""
        changes = [n for n in self.kinds if n in self.program.lengths and n in self.stored]
        copies = []
        for name in changes:
            self._declare_tuple(name)
            copies.append(f"lj_copy({name}, {name}_before, {self.program.lengths[name]});")
        places = [
            join_declaration(kind, f"{name}_before" if name in changes else c_variable(name))
            for name, kind in self.kinds.items()
        ]
        result = "void" if self.count else self.program.c_type(self.tree.returns)
        places += ["double *out"] if self.count else []
        head = (
            f"{join_declaration(result, c_function(self.tree.name))}({', '.join(places) or 'void'})"
        )
        lines = list(self.print_block(self.tree.body, 1))
        if lines[-1].strip() == "return;":
            lines.pop()
        return "\n".join(
            [
                wrap_line(kind + head),
                "{",
                *(wrap_line(f"{text};", 1) for text in self._group_declarations()),
                *(wrap_line(text, 1) for text in copies),
                *lines,
                "}",
                "",
            ]
        )

    def _group_declarations(self) -> list[str]:
        """Return the declarations, those of scalars of one type in one line."""
        groups: dict[str, str] = {}
        for name, text in self.declared.items():
            kind = text.partition(" ")[0]
            key = kind if text == f"{kind} {c_variable(name)}" else name
            groups[key] = f"{groups[key]}, {c_variable(name)}" if key in groups else text
        return list(groups.values())

    def print_block(self, statements: Iterable[ast.stmt], depth: int) -> Iterator[str]:
        """Yield the lines of a block."""
        for node in statements:
            match node:
                case ast.Expr(value=ast.Constant()):
                    continue  # skip the docstring
                case ast.If():
                    yield from self._print_branches(node, depth)
                case ast.While(test=test, body=body):
                    endless = isinstance(test, ast.Constant)
                    yield wrap_line(
                        "for (;;) {" if endless else f"while ({self.text(test)}) {{", depth
                    )
                    yield from self.print_block(body, depth + 1)
                    yield wrap_line("}", depth)
                case ast.For(
                    target=ast.Name(id=name),
                    iter=ast.Call(func=ast.Name(id="range"), args=[limit]),
                    body=body,
                ):
                    self.kinds[name], n = INTEGER, c_variable(name)
                    head = f"for (int64_t {n} = 0; {n} < {self.text(limit)}; {n}++) {{"
                    yield wrap_line(head, depth)
                    yield from self.print_block(body, depth + 1)
                    yield wrap_line("}", depth)
                case ast.AugAssign(target=target, op=op, value=value):
                    sign = OPERATORS[type(op)][0]
                    yield wrap_line(f"{self.text(target)} {sign}= {self.text(value)};", depth)
                case ast.Assign(targets=targets, value=value):
                    for place in targets:
                        yield from (
                            wrap_line(text, depth) for text in self.print_assign(place, value)
                        )
                case ast.Return(value=value):
                    yield from (wrap_line(text, depth) for text in self.print_return(value))
                case _:
                    raise self.refusal(node)

    def _print_branches(self, node: ast.If, depth: int, before: str = "") -> Iterator[str]:
        yield wrap_line(f"{before}if ({self.text(node.test)}) {{", depth)
        yield from self.print_block(node.body, depth + 1)
        match node.orelse:
            case [ast.If() as other]:
                yield from self._print_branches(other, depth, "} else ")
                return
            case [_, *_]:
                yield wrap_line("} else {", depth)
                yield from self.print_block(node.orelse, depth + 1)
        yield wrap_line("}", depth)

    def print_return(self, value: ast.expr | None) -> Iterator[str]:
        """Yield the statements that return a value; tuples go, flattened, into `out`."""
        if value is None or not self.count:
            yield "return;" if value is None else f"return {self.text(value)};"
            return
        if isinstance(value, ast.Call):
            yield f"{self.print_call(value, 'out')};"
        else:
            place = 0
            for part in self._flatten(value):
                size = self.program.count(part)
                yield self._store(f"out[{place}]", f"out + {place}", part, size)
                place += size
        yield "return;"

    def _flatten(self, node: ast.expr) -> Iterator[ast.expr]:
        if isinstance(node, ast.Tuple):
            for part in node.elts:
                yield from self._flatten(part)
        else:
            yield node

    def _store(self, place: str, address: str, value: ast.expr, size: int) -> str:
        if self.program.is_tuple(value):
            return f"lj_copy({address}, {self.text(value)}, {size});"
        return f"{place} = {self.text(value)};"

    def print_assign(self, target: ast.expr, value: ast.expr) -> Iterator[str]:
        """Yield the statements of an assignment."""
        match target, value:
            case ast.Tuple(elts=places), ast.Tuple(elts=values):
                yield from self._assign_together(places, values)
            case ast.Tuple(elts=places), ast.IfExp(
                test=test, body=ast.Tuple(elts=one), orelse=ast.Tuple(elts=two)
            ):
                first = " ".join(self._assign_together(places, one))
                second = " ".join(self._assign_together(places, two))
                yield f"if ({self.text(test)}) {{ {first} }} else {{ {second} }}"
            case ast.Tuple(elts=places), ast.Name():
                yield from self._unpack(places, self.text(value))
            case ast.Tuple(elts=places), ast.Call():
                source = f"r{self.scratch}"
                self.scratch += 1
                count = self.program.results[ast.unparse(value.func)]
                self.declared[source] = f"double {source}[{count}]"
                yield f"{self.print_call(value, source)};"
                yield from self._unpack(places, source)
            case ast.Name(id=name), ast.Call() if name in self.program.lengths:
                source = f"r{self.scratch}"
                self.scratch += 1
                self._declare_tuple(name)
                self.declared[source] = f"double {source}[{self.program.lengths[name]}]"
                yield f"{self.print_call(value, source)};"
                yield f"lj_copy({c_variable(name)}, {source}, {self.program.lengths[name]});"
            case ast.Name(id=name), ast.Tuple(elts=values):
                self._declare_tuple(name)
                for index, part in enumerate(values):
                    yield f"{c_variable(name)}[{index}] = {self.text(part)};"
            case ast.Name(id=name), _:
                kind = self.infer(value)
                if kind.endswith("*"):  # one of several records
                    self.declared[name], self.kinds[name] = (
                        join_declaration(kind, c_variable(name)),
                        kind,
                    )
                    yield f"{c_variable(name)} = &{self.text(value)};"
                else:
                    self._declare(name, kind)
                    yield f"{c_variable(name)} = {self.text(value)};"
            case ast.Subscript(), _:
                yield f"{self.text(target)} = {self.text(value)};"
            case _:
                raise self.refusal(target)

    def _declare(self, name: str, kind: str) -> None:
        if name not in self.kinds:
            self.kinds[name] = kind
            self.declared[name] = join_declaration(kind, c_variable(name))

    def _declare_tuple(self, name: str) -> None:
        if name not in self.declared:
            self.declared[name] = f"double {c_variable(name)}[{self.program.lengths[name]}]"

    def _assign_together(
        self, places: Sequence[ast.expr], values: Sequence[ast.expr]
    ) -> Iterator[str]:
        """Yield `a, b = x, y`, with temporaries if a later value reads an earlier target."""
        names = [ast.unparse(place) for place in places]
        used = {
            ast.unparse(part)
            for value in values[1:]
            for part in ast.walk(value)
            if isinstance(part, ast.Name | ast.Subscript)
        }
        if not used & set(names[:-1]):
            for place, value in zip(places, values, strict=True):
                yield from self.print_assign(place, value)
            return
        kinds = [self.infer(value) for value in values]
        temporary = [f"t{self.scratch + index}" for index in range(len(values))]
        self.scratch += len(values)
        for name, kind, value in zip(temporary, kinds, values, strict=True):
            self.declared[name] = f"{kind} {name}"
            yield f"{name} = {self.text(value)};"
        for name, variable, kind in zip(temporary, names, kinds, strict=True):
            self._declare(variable, kind)
            yield f"{c_variable(variable)} = {name};"

    def _unpack(self, places: Sequence[ast.expr], source: str) -> Iterator[str]:
        """Yield the statements that take a flattened tuple apart; `_name` is left out."""
        start = 0
        for place in places:
            name, size = ast.unparse(place), self.program.count(place)
            is_alias = self.stored.count(name) == 1 and name not in self.kinds
            if name in self.program.lengths and is_alias:
                self.declared[name] = f"const double *{c_variable(name)}"
                yield f"{c_variable(name)} = {source} + {start};"
            elif name in self.program.lengths:
                self._declare_tuple(name)
                yield f"lj_copy({c_variable(name)}, {source} + {start}, {size});"
            elif not name.startswith("_"):
                self._declare(name, REAL)
                yield f"{c_variable(name)} = {source}[{start}];"
            start += size

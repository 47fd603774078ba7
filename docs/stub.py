"""The stub `layerjam/__init__.pyi`: what a caller may give to each public command."""

from __future__ import annotations

import ast
import collections.abc
import importlib
import inspect
import subprocess
import sys
import types
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin

from layerjam.core.command.declare import (
    FLATTENED,
    PYTHON_ONLY,
    Command,
    Input,
    Parameter,
    declare_parameter,
    variants,
)
from layerjam.core.command.results import Result

PACKAGE = Path(inspect.getfile(sys.modules["layerjam"])).parent
NAMES = PACKAGE / "_names.pyi"
STUB = PACKAGE / "__init__.pyi"
RUFF = str(Path(sys.executable).parent / "ruff")
HEAD = '''"""The public names as a caller sees them, from `_names.pyi` by `docs/generate.py`.

The functions of the commands take text with units as well as SI numbers.
"""

'''


class Stub:
    """Text of the stub, and the imports that its annotations need."""

    def __init__(self) -> None:
        self.imports: dict[str, str] = {}
        self.classes: dict[str, list[str]] = {}

    def name(self, module: str, name: str) -> str:
        """The private alias of a class of the package; raises ValueError for two of one name."""
        if self.imports.setdefault(f"_{name}", module) != module:
            raise ValueError(f"{name} is in {module} and in {self.imports[f'_{name}']}")
        return f"_{name}"

    def text(self, kind: Any, module: str) -> str:
        """An annotation as text; names that only type checkers know are looked up in `module`."""
        if isinstance(kind, str):
            tree = ast.parse(kind, mode="eval")
            known = vars(sys.modules[module])
            for node in ast.walk(tree):
                if isinstance(node, ast.Name):
                    found = known.get(node.id, vars(sys.modules["builtins"]).get(node.id))
                    node.id = (
                        self.name(imported_from(module, node.id), node.id)
                        if found is None
                        else self.text(found, module)
                    )
            return ast.unparse(tree)
        if kind is None or kind is types.NoneType:
            return "None"
        if kind is Any or kind is inspect.Parameter.empty:
            return "Any"
        origin, inside = get_origin(kind), get_args(kind)
        if origin is Annotated:
            return self.text(inside[0], module)
        if origin is Literal:
            return f"Literal[{', '.join(map(repr, inside))}]"
        if len(members := list(variants(kind))) > 1:
            return " | ".join(dict.fromkeys(self.text(one, module) for one in members))
        if origin is collections.abc.Callable:
            takes = ", ".join(self.text(one, module) for one in inside[0])
            name = self.name("collections.abc", "Callable")
            return f"{name}[[{takes}], {self.text(inside[1], module)}]"
        if origin is not None:
            words = ("..." if one is ... else self.text(one, module) for one in inside)
            return f"{self.text(origin, module)}[{', '.join(words)}]"
        return (
            kind.__name__
            if kind.__module__ == "builtins"
            else self.name(kind.__module__, kind.__name__)
        )

    def given(self, p: Parameter, kind: Any, module: str, arrays: bool = True) -> str:
        """Return the type that a caller may give for a parameter, with or without arrays."""
        words = [f"Literal[{word!r}]" for word in p.words]
        if p.spec is not None:
            plain = [*words, "int" if p.spec.whole else "float", "str"]
            if arrays and p.array:
                plain.append(self.name("numpy.typing", "ArrayLike"))
            if arrays or not p.array:
                plain.append(self.name("layerjam.core.conversion", "HasUnit"))
        elif isinstance(p.help, Input) and p.help.convert is not None:
            plain = [self.text(p.type, p.help.convert.__module__)]
        else:
            return self.text(kind, module)
        return " | ".join(dict.fromkeys([*plain, *(["None"] if p.optional else [])]))

    def function(self, name: str, command: Command) -> Iterator[str]:
        """Lines of a command's function; one that takes arrays has a result for them."""
        result = self.result(command.result)
        if any(p.array for p in command.parameters):
            yield "@overload"
            first, *rest = self.signature(name, command, result, arrays=False)
            yield f"{first}  # type: ignore[overload-overlap]"
            yield from rest
            yield "    ..."
            yield "@overload"
            result = self.arrays(command.result)
        yield from self.signature(name, command, result, arrays=True)
        yield from self.doc(command.doc)

    def signature(self, name: str, command: Command, result: str, arrays: bool) -> Iterator[str]:
        """Lines of a function up to its colon."""
        known = {p.name: p for p in command.parameters}
        yield f"def {name}("
        keyword_only = False
        for parameter_name, at in command.signature.parameters.items():
            kind = command._find_type(at.annotation)
            kind = at.annotation if kind is PYTHON_ONLY else kind
            if parameter_name in known:
                words = self.given(known[parameter_name], kind, command.module, arrays)
            else:
                words = self.text(kind, command.module)
            several = at.kind is inspect.Parameter.VAR_POSITIONAL
            if at.kind is inspect.Parameter.KEYWORD_ONLY and not keyword_only:
                yield "    *,"
            keyword_only = keyword_only or several or at.kind is inspect.Parameter.KEYWORD_ONLY
            default = "" if at.default is inspect.Parameter.empty else " = ..."
            yield f"    {'*' if several else ''}{parameter_name}: {words}{default},"
        yield f") -> {result}:"

    def result(self, cls: type[Result]) -> str:
        """The class of a result; `require` of one with optional keys returns one without them."""
        plain = self.name(cls.__module__, cls.__name__)
        optional = {f.name: f.type for f in cls.keys() if "None" in str(f.type)}  # noqa: SIM118
        if not optional:
            return plain
        known, made = f"{plain}Known", f"{plain}Result"
        self.classes[made] = [
            f"class {made}({plain}):",
            f"    def require(self) -> {known}: ...",
            f"class {known}({made}):",
            *(f"    {name}: {self.without_none(kind, cls)}" for name, kind in optional.items()),
        ]
        return made

    def without_none(self, kind: Any, cls: type[Result]) -> str:
        """An optional annotation of a result without None."""
        module = next(
            base.__module__
            for base in cls.__mro__
            if kind in inspect.get_annotations(base).values()
        )
        text = self.text(kind, module)
        return " | ".join(word for word in text.split(" | ") if word != "None")

    def arrays(self, cls: type[Result]) -> str:
        """Add the class of an array result, whose numbers may be arrays of NumPy or xarray."""
        made = f"_{cls.__name__}Array"
        keys = cls.keys()
        names = [f.name for f in keys if f.metadata["quantity"] or f.name == "feasible"]
        self.classes[made] = [
            f"class {made}({self.name(cls.__module__, cls.__name__)}):",
            *(f"    {name}: Any" for name in names),
        ]
        return made

    def options(self, name: str, cls: type) -> Iterator[str]:
        """Lines of a record of options, which takes text too."""
        yield f"class {name}({self.name(cls.__module__, cls.__name__)}):"
        yield from self.doc(inspect.getdoc(cls) or "")
        yield ""
        yield "    def __init__("
        yield "        self,"
        yield "        *,"
        hints = inspect.get_annotations(cls, eval_str=True)
        for field, kind in hints.items():
            words = self.given(declare_parameter(field, kind, None), kind, cls.__module__)
            yield f"        {field}: {words} = ...,"
        yield "    ) -> None: ..."

    def doc(self, text: str) -> Iterator[str]:
        """Lines of a docstring."""
        first, *rest = text.splitlines()
        quote = '"""'
        yield f"    {quote}{first}{'' if rest else quote}"
        yield from (f"    {line}" if line else "" for line in rest)
        if rest:
            yield f"    {quote}"


def imported_from(module: str, name: str) -> str:
    """The module that a module imports a name from, for type checkers alone."""
    tree = ast.parse(inspect.getsource(sys.modules[module]))
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and name in (a.name for a in node.names):
            return str(node.module)
    raise LookupError(f"{name} of {module}")


def stub() -> str:
    """The text of `__init__.pyi`."""
    made, lines, imports = Stub(), list[str](), ["from typing import Any, Literal, overload"]
    for node in ast.parse(NAMES.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign):
            lines = [ast.unparse(node), *lines]
        for alias in node.names if isinstance(node, ast.ImportFrom) else ():
            public, module = alias.asname or alias.name, str(node.module)
            found = getattr(importlib.import_module(module), alias.name, None)
            if hasattr(found, "declaration"):
                lines += made.function(public, found.declaration)
            elif hasattr(found, FLATTENED):
                lines += made.options(public, found)
            else:
                imports.append(f"from {module} import {alias.name} as {public}")
    imports += [f"from {m} import {name[1:]} as {name}" for name, m in made.imports.items()]
    classes = [line for one in made.classes.values() for line in one]
    text = HEAD + "\n".join([*imports, *classes, *lines, ""])
    for words in (["check", "--select", "F401,I", "--fix", "-q"], ["format", "-q"]):
        command = [RUFF, *words, "--stdin-filename", str(STUB), "-"]
        done = subprocess.run(command, input=text, capture_output=True, text=True, check=True)
        text = done.stdout
    return text

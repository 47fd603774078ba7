"""A command is one annotated function: its signature is the declaration.

    @command("predict")
    def force(brake: BrakeInput, *, slip: Slip, vacuum: Vacuum) -> Force: ...

A parameter is annotated with a quantity's specification (`Annotated[float, QuantitySpec]`), a
`Help`, an `Input` that is converted, or a record of `options` whose fields become options. The
annotation states the type that the function receives; `__init__.pyi` the types that a caller may
give. The annotations define the checks of every call, the command line, the page's controls, the
copied code, the reference and the JSON Schema (`commands/schema.py`).
"""

import contextlib
import functools
import importlib
import inspect
import re
import sys
import typing
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Annotated, Any, Literal, ParamSpec, TypeVar, get_args, get_origin

from layerjam.core.command.arguments import (
    bind_arguments,
    check_kind,
    command_line_name,
    gather_options,
    make_list,
    variants,
)
from layerjam.core.command.index import DECLARED, EXAMPLES, GROUPS, Entry, commands, find_entry
from layerjam.core.command.results import Result
from layerjam.core.conversion import refuse_traced, strip_unit
from layerjam.core.errors import (
    Notice,
    QuantityError,
    UnknownNameError,
    explain_arguments,
    short_text,
)
from layerjam.core.system import check_source_date
from layerjam.core.toml_files.changes import find_record_files
from layerjam.core.units import QuantitySpec, show

if TYPE_CHECKING:
    from layerjam.core.command.labels import Grid

P = ParamSpec("P")
R = TypeVar("R", bound=Result)
T = TypeVar("T")


@dataclass(frozen=True)
class Help:
    """Parameter that is not a quantity: its meaning and its form on the command line.

    `option` is the command line name if it differs from the parameter's. `old` are former names,
    which are hidden; using one prints the new name. A `greedy` option of several values accepts all
    words up to the next option, so that a shell's pattern can follow it.
    """

    text: str = ""
    metavar: str = ""
    option: str = ""
    old: tuple[str, ...] = ()
    greedy: bool = False


@dataclass(frozen=True)
class PythonOnly(Help):
    """Parameter without an option or a control; `typed` receives the typed command line."""

    typed: bool = False


@dataclass(frozen=True)
class Input(Help):
    """Parameter that `convert(value, given)` converts for the function.

    `given` contains the other arguments of the call, unconverted. The annotation of `value` states
    the types that a caller may give.
    """

    convert: Callable[[Any, Mapping[str, Any]], Any] | None = None


def input_type(convert: Callable[..., Any]) -> Any:
    """Return the type that an `Input` accepts, as text if only type checkers know it."""
    kind = next(iter(convert.__annotations__.values()))
    with contextlib.suppress(NameError):
        return eval(kind, convert.__globals__) if isinstance(kind, str) else kind
    return kind


@dataclass(frozen=True)
class OutFile(Help):
    """File that the command writes; its extension is checked before anything is computed."""

    endings: tuple[str, ...] = ()


Progress = Callable[[str, float], None]
"""Progress callback: receives the current stage and the completed fraction of it."""
FLATTENED = "__layerjam_options__"


@typing.dataclass_transform(kw_only_default=True, frozen_default=True)
def options(cls: type[T]) -> type[T]:
    """Make a frozen record of related parameters, each of which becomes an option."""
    record = explain_arguments(dataclass(frozen=True, kw_only=True)(cls))
    setattr(record, FLATTENED, True)
    return record


@dataclass(frozen=True)
class Parameter:
    """One declared parameter."""

    name: str
    default: Any = None
    required: bool = False
    spec: QuantitySpec | None = None
    help: Help = field(default_factory=Help)
    words: tuple[str, ...] = ()
    type: Any = Any
    optional: bool = False
    array: bool = False
    record: str = ""
    positional: bool = False
    several: bool = False

    @property
    def option(self) -> str:
        """Name of the parameter on the command line."""
        return self.help.option or "--" + self.name.replace("_", "-")

    @property
    def is_offered(self) -> bool:
        """Whether it has an option and a control."""
        return self.type not in (Progress, PYTHON_ONLY) and not isinstance(self.help, PythonOnly)

    @property
    def is_positional(self) -> bool:
        """Whether it is a positional argument."""
        return self.positional and not self.help.option and not isinstance(self.help, OutFile)

    @property
    def label(self) -> str:
        """Name of the parameter in errors."""
        return self.option.lstrip("-").replace("-", " ")

    @property
    def sentence(self) -> str:
        """Help text: its meaning, the allowed values and an example."""
        if self.spec is None:
            return self.help.text
        text = self.help.text or self.spec.text
        text = text[0].upper() + text[1:].rstrip(" .,")
        example = f", e.g. {self.spec.example}" if self.spec.example else ""
        return f"{text}{example}."

    @property
    def default_text(self) -> str:
        """Default as it would be typed; empty if there is none."""
        if self.spec is not None and isinstance(self.default, float):
            return show(self.default, self.spec.unit)
        return "" if self.default in (None, ()) else str(self.default)

    @property
    def metavar(self) -> str:
        """Placeholder for its value in the help."""
        if self.help.metavar:
            return self.help.metavar
        if self.words:
            return "|".join((*self.words, *(("Q",) if self.spec else ())))
        if self.spec is None:
            return ""
        return "N" if self.spec.whole else "NUMBER" if self.spec.unit == "1" else "Q"

    def read(self, value: Any, arguments: Mapping[str, Any], notices: list[Notice]) -> Any:
        """Return the value for the function, checked and in SI units."""
        if value is None:
            if self.required or not (self.optional or self.default is None):
                raise QuantityError.of(self.label, f"missing; {self.sentence}")
            return None
        if isinstance(value, str) and value in self.words:
            return value
        if self.words and (self.spec is None or not re.search(r"\d", str(value))):
            raise UnknownNameError(self.label, str(value), self.words)
        if self.spec is not None:
            return self._read_quantity(self.spec, value, notices)
        value = make_list(value, self.type)
        check_kind(value, self.type, self.label)
        if isinstance(self.help, Input) and self.help.convert is not None:
            return self.help.convert(value, arguments)
        return value

    def _read_quantity(self, spec: QuantitySpec, value: Any, notices: list[Notice]) -> Any:
        if isinstance(value, str):
            return spec.read(value, self.label)
        refuse_traced(value, self.label)
        value = strip_unit(value, spec.unit, self.label)
        if self.array and not isinstance(value, int | float):
            values = spec.array(value, self.label)
            if values.shape:
                return values
            value = values.item()
        if not self.array and (isinstance(value, list | tuple) or getattr(value, "shape", None)):
            words = f"{short_text(value)} is not a single number; layerjam.batch evaluates a law, "
            raise QuantityError.of(self.label, f"{words}such as layerjam.laws.stop, for many cases")
        number = spec.si(value, self.label)
        if 0 < number < spec.unlikely_below:
            notices.append(
                Notice(
                    f"{self.label}: {number:g} was read as {show(number, spec.unit)}; for a "
                    f"different unit, append it, such as '{number:g} kPa'",
                    "unlikely-unit",
                )
            )
        return number


def declare_parameter(name: str, kind: Any, default: Any, **more: Any) -> Parameter:
    """Return the parameter that one annotation declares."""
    spec: QuantitySpec | None = None
    help_note, optional, array = Help(), False, False
    words: list[str] = []
    plain: Any = None
    for member in variants(kind):
        if member is type(None):
            optional = True
        elif get_origin(member) is Literal:
            words += get_args(member)
        elif get_origin(member) is Annotated:
            inner, *notes = get_args(member)
            array = array or ARRAY in notes
            for note in notes:
                if isinstance(note, QuantitySpec):
                    spec = note
                elif isinstance(note, Help):
                    help_note = note
            for base in variants(inner):
                if get_origin(base) is Annotated:
                    raise TypeError(f"{name}: write Annotated[QUANTITY, ...] | None")
                if get_origin(base) is Literal:
                    words += get_args(base)
                optional = optional or base is type(None)
            plain = plain or inner
        else:
            plain = plain or member
    if isinstance(help_note, Input) and help_note.convert is not None:
        plain = input_type(help_note.convert)
    required = default is inspect.Parameter.empty
    return Parameter(
        name=name,
        default=None if required else default,
        required=required,
        spec=spec,
        help=help_note,
        words=tuple(words),
        type=plain,
        optional=optional,
        array=array,
        **more,
    )


def list_record_parameters(group: Any, record: str = "") -> Iterator[Parameter]:
    """Return the annotated fields of an `options` record."""
    hints = typing.get_type_hints(group, include_extras=True)
    for f in fields(group):
        if any(get_origin(kind) is Annotated for kind in variants(hints[f.name])):
            yield declare_parameter(f.name, hints[f.name], f.default, record=record)


PYTHON_ONLY = object()
"""Type of a parameter that only type checkers see."""
ARRAY = object()
"""Extra annotation of a specification: arrays are also accepted, and are broadcast."""


class Command:
    """A declared command: its parameters, its result, and how it is called."""

    def __init__(
        self,
        function: Callable[..., Result],
        group: str,
        record_endings: tuple[str, ...],
        parent: str = "",
    ) -> None:
        self.function, self.group = function, group
        self.record_endings = record_endings
        self.python_name = function.__name__
        self.name = command_line_name(self.python_name, parent)
        self.examples = EXAMPLES.get(self.name, [])
        self.module = function.__module__

    @property
    def doc(self) -> str:
        """Docstring of the function."""
        return inspect.getdoc(self.function) or ""

    @property
    def summary(self) -> str:
        """First paragraph of the docstring."""
        return self.doc.split("\n\n")[0].replace("\n", " ")

    @functools.cached_property
    def signature(self) -> inspect.Signature:
        """Signature of the function."""
        return inspect.signature(self.function)

    def _find_type(self, text: Any) -> Any:
        """Return the type that an annotation names; Any for names that only type checkers know."""
        if not isinstance(text, str):
            return text
        try:
            return eval(text, vars(sys.modules[self.module]))  # source code of this package
        except (NameError, TypeError):
            return PYTHON_ONLY

    @functools.cached_property
    def result(self) -> type[Result]:
        """Class of its result."""
        return_type = self._find_type(self.signature.return_annotation)
        if not (isinstance(return_type, type) and issubclass(return_type, Result)):
            raise TypeError(f"{self.python_name} does not declare which Result it returns")
        return return_type

    @functools.cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """All parameters, including those of flattened records."""
        parameters: list[Parameter] = []
        for name, place in self.signature.parameters.items():
            kind = self._find_type(place.annotation)
            group = next((k for k in variants(kind) if hasattr(k, FLATTENED)), None)
            if group is None:
                positional = place.kind is not inspect.Parameter.KEYWORD_ONLY
                several = place.kind is inspect.Parameter.VAR_POSITIONAL
                default = () if several else place.default
                parameters.append(
                    declare_parameter(name, kind, default, positional=positional, several=several)
                )
                continue
            parameters += list_record_parameters(group, name)
        return tuple(parameters)

    @functools.cached_property
    def records(self) -> dict[str, type]:
        """Return {parameter: class} of the records whose fields become options."""
        kinds = {n: self._find_type(p.annotation) for n, p in self.signature.parameters.items()}
        return {n: m for n, kind in kinds.items() for m in variants(kind) if hasattr(m, FLATTENED)}

    def convert_arguments(
        self, args: Sequence[Any], kwargs: Mapping[str, Any], notices: list[Notice]
    ) -> dict[str, Any]:
        """Return the arguments converted for the function; raises the same errors as a call."""
        record_of = {p.name: p.record for p in self.parameters if p.record}
        options = ((o, p.name) for p in self.parameters for o in (p.option, *p.help.old))
        own_names = {o.lstrip("-").replace("-", "_"): name for o, name in options}
        kwargs = {own_names.get(name, name): value for name, value in kwargs.items()}
        direct = self.signature.parameters
        loose = {k: v for k, v in kwargs.items() if k in record_of and k not in direct}
        command_arguments = {k: v for k, v in kwargs.items() if k not in loose}
        for p in self.parameters:
            if p.several:
                args = (*args, *command_arguments.pop(p.name, ()))
        required_sentences = {p.name: p.sentence for p in self.parameters if p.required}
        call = bind_arguments(
            self.python_name, self.signature, record_of, required_sentences, args, command_arguments
        )
        for name, cls in self.records.items():
            values = {k: v for k, v in loose.items() if record_of[k] == name}
            inner = [p for p in self.parameters if p.record == name]
            settings = gather_options(name, cls, call.get(name), values, [p.name for p in inner])
            call[name] = cls(
                **{p.name: p.read(settings.get(p.name, p.default), call, notices) for p in inner}
            )
        bindings = dict(call)
        for p in self.parameters:
            if not p.record and (p.name in call or p.default is not None):
                bindings[p.name] = p.read(call.get(p.name, p.default), call, notices)
        return bindings

    def _align_grid(self, values: dict[str, Any]) -> "Grid | None":
        """Return the grid of the array arguments; None if all are single numbers."""
        units = {p.name: p.spec.unit for p in self.parameters if p.array and p.spec is not None}
        if all(isinstance(values.get(name, 0), int | float) for name in units):
            return None  # this test must not load NumPy
        from layerjam.core.command.labels import align_grid

        return align_grid(values, units)

    def __call__(self, *args: Any, **named: Any) -> Result:
        """Check the arguments, compute, and add notices about the input."""
        check_source_date()  # otherwise a library raises while it is imported
        notes: list[Notice] = []
        values = self.convert_arguments(args, named, notes)
        grid = self._align_grid(values)
        bound = inspect.BoundArguments(self.signature, values)  # type: ignore[arg-type]
        result = self.function(*bound.args, **bound.kwargs).with_notices(*notes).with_grid(grid)
        return result.with_verdicts(find_record_files(bound.arguments.values()))


REGISTRY: dict[str, Command] = {}
"""{name on the command line: Command} of every command declared so far."""


def load_command(name: str) -> Command:
    """Return the declaration of the command that `find_entry` returns, after importing its module.

    Raises UnknownNameError if there is none.
    """
    entry = find_entry(name)
    if entry is None:
        raise UnknownNameError("command", name, commands())
    if entry.module:
        importlib.import_module(entry.module)
    return REGISTRY[entry.name]


def command(
    group: str,
    *,
    record: tuple[str, ...] = (),
    parent: str = "",
) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Declare a command of one of the GROUPS; help.toml contains its position and examples.

    `record` lists the file extensions that `--out` accepts for the result's record. A command of
    two words is declared `parent` the first: the function export_c under "export" is "export c".
    """
    if group not in GROUPS:
        raise UnknownNameError("group of commands", group, GROUPS)

    def declare_function(function: Callable[P, R]) -> Callable[P, R]:
        instance = Command(function, group, record, parent)

        @functools.wraps(function)
        def call(*args: P.args, **keywords: P.kwargs) -> R:
            return instance(*args, **keywords)  # type: ignore[return-value]

        call.declaration = instance  # type: ignore[attr-defined]
        entry = Entry(instance.name, instance.python_name, "", group, instance.summary)
        REGISTRY[instance.name], DECLARED[instance.name] = instance, entry
        return call

    return declare_function

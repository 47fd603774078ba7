"""`schema`: JSON Schema of the --json output of every command, from its declaration."""

import builtins
import inspect
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import Field, fields, is_dataclass
from typing import Annotated, Any, Literal, get_args, get_origin

from layerjam.core.command.arguments import variants
from layerjam.core.command.declare import Command, Help, command, load_command
from layerjam.core.command.index import commands
from layerjam.core.command.results import Result, fact, result
from layerjam.core.outputs import field_key

DIALECT = "https://json-schema.org/draft/2020-12/schema"
NULL = {"type": "null"}
PLAIN = {
    bool: {"type": "boolean"},
    int: {"type": "integer"},
    float: {"type": "number"},
    str: {"type": "string"},
    type(None): NULL,
}


class _Names(dict[str, Any]):
    """{name in an annotation: type}; a name that only type checkers know is Any."""

    def __missing__(self, name: str) -> Any:
        return getattr(builtins, name, Any)


def _command_names(cls: type) -> _Names:
    return _Names(vars(sys.modules[cls.__module__]))


def _field_type(cls: type, name: str) -> Any:
    """Return the type of a field, looked up in the module of the class that declares it."""
    owner = next(base for base in cls.__mro__ if name in inspect.get_annotations(base))
    text = inspect.get_annotations(owner)[name]
    # the text is source code of this package
    return eval(text, {}, _command_names(owner)) if isinstance(text, str) else text


def type_schema(kind: Any) -> dict[str, Any]:
    """Return the schema for values of a Python type; {} for unknown types."""
    members = list(variants(kind))
    if len(members) > 1:
        schemas = [type_schema(member) for member in members]
        if {} in schemas:
            return {}
        if all(set(member_schema) == {"type"} for member_schema in schemas):
            return {"type": [member_schema["type"] for member_schema in schemas]}
        return {"anyOf": schemas}
    if kind in PLAIN:
        return dict(PLAIN[kind])
    origin, type_arguments = get_origin(kind), get_args(kind)
    if origin is Literal:
        return {"enum": list(type_arguments)}
    if origin is Annotated:
        return type_schema(type_arguments[0])
    if is_dataclass(kind):
        names = [f.name for f in fields(kind)]
        return _object_schema({name: type_schema(_field_type(kind, name)) for name in names})  # type: ignore[arg-type]
    if not inspect.isclass(origin):
        return {}
    if issubclass(origin, Mapping):
        return {"type": "object", "additionalProperties": type_schema(type_arguments[1])}
    if origin is tuple and type_arguments[-1] is not ...:
        schemas = [type_schema(member_schema) for member_schema in type_arguments]
        return {"type": "array", "prefixItems": schemas, "items": False, "minItems": len(schemas)}
    if issubclass(origin, Sequence):
        return {"type": "array", "items": type_schema(type_arguments[0])}
    return {}


def _object_schema(properties: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "type": "object",
        "properties": dict(properties),
        "required": list(properties),
        "additionalProperties": False,
    }


def _field_schema(cls: type[Result], f: Field[Any]) -> dict[str, Any]:
    spec = f.metadata["quantity"]
    entry = {"description": f.metadata["result"], **({"unit": spec.unit} if spec else {})}
    return {**type_schema(_field_type(cls, f.name)), **entry}


def command_schema(command: Command) -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a command's result; `unit` is a key's SI unit."""
    cls = command.result
    key_fields = cls.keys()
    keys = {field_key(f): _field_schema(cls, f) for f in key_fields}
    common = {
        "units": {
            "type": "object",
            "additionalProperties": {"type": "string"},
            "description": "SI unit of each key",
        },
        "warnings": {"type": "array", "items": {"type": "string"}, "description": "notices"},
    }
    verdict_schema = {
        "verdict": {"type": "string", "description": "outcome of the checks"},
        "failed_checks": {
            "type": "array",
            "items": {"type": "object", "additionalProperties": {"type": "string"}},
            "description": "name and reason of each failed check",
        },
        "accepted": {
            "type": "array",
            "items": {"type": "object"},
            "description": "failed checks that were accepted",
        },
    }
    summary = (inspect.getdoc(cls) or "").split("\n\n")[0].replace("\n", " ")
    schema = _object_schema({**keys, **common})
    # these keys are present if checks were applied to the numbers or to those of an input file
    schema["properties"] = {**verdict_schema, **schema["properties"]}
    return {
        "title": f"layerjam {command.name} --json",
        "description": summary,
        **schema,
    }


@result
class Schemas(Result):
    """One JSON Schema that accepts the output of any command, with a definition for each."""

    dialect: str = fact("dialect of the schema", default=DIALECT, key="$schema", listed=False)
    any_of: Sequence[Mapping[str, str]] = fact(
        "references to the definitions", key="anyOf", listed=False
    )
    definitions: Mapping[str, Any] = fact("schema of each command", key="$defs", listed=False)

    def lines(self) -> Iterator[str]:
        """Yield every command with its keys: type, unit, meaning."""
        for index, (name, schema) in enumerate(self.definitions.items()):
            yield from ("",) if index else ()
            yield f"layerjam {name}: {schema['description']}"
            for key, entry in schema["properties"].items():
                unit = f" [{entry['unit']}]" if "unit" in entry else ""
                yield f"  {key}{unit}, {_describe_type(entry)}: {entry['description']}"


def _describe_type(schema: Mapping[str, Any]) -> str:
    if "anyOf" in schema:
        return " or ".join(_describe_type(member) for member in schema["anyOf"])
    if "enum" in schema:
        return " or ".join(map(str, schema["enum"]))
    kind = schema.get("type", "any value")
    return kind if isinstance(kind, str) else " or ".join(kind)


@command("develop")
def schema(
    name: Annotated[
        str | None, Help("Name of a command. Default: all commands.", metavar="COMMAND")
    ] = None,
) -> Schemas:
    """Return the JSON Schema of the --json output of a command.

    Draft 2020-12; each key has type, meaning and SI `unit`. The output is itself a schema: `anyOf`
    refers to the definitions of `$defs`, one for each command.
    """
    names = list(commands()) if name is None else [load_command(name).name]
    return Schemas(
        any_of=[{"$ref": f"#/$defs/{command_name}"} for command_name in names],
        definitions={
            command_name: command_schema(load_command(command_name)) for command_name in names
        },
    )

"""What of a JSON document does not hold by a JSON Schema: the keywords that `schema` writes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

TYPES: dict[str, Any] = {
    "object": Mapping,
    "array": list,
    "string": str,
    "number": int | float,
    "integer": int,
    "boolean": bool,
    "null": type(None),
}
KNOWN = {
    *("$schema", "$defs", "$ref", "anyOf", "enum", "type", "properties", "required", "items"),
    *("additionalProperties", "prefixItems", "minItems", "title", "description", "unit"),
    *("units", "warnings", "verdict", "failed_checks", "accepted"),
}
"""Keywords; the last five are not keywords, but keys that every command may print."""


def problems(value: Any, schema: Any, root: Any = None, at: str = "$") -> list[str]:
    """A sentence for each place where `value` breaks the schema."""
    return list(_problems(value, schema, schema if root is None else root, at))


def _problems(value: Any, schema: Any, root: Any, at: str) -> Iterator[str]:
    if schema is True or schema is False:
        yield from () if schema else (f"{at}: is not allowed",)
        return
    unknown = set(schema) - KNOWN
    assert not unknown, f"the schema at {at} uses {unknown}"
    if "$ref" in schema:
        yield from problems(value, root["$defs"][schema["$ref"].rpartition("/")[2]], root, at)
    if "anyOf" in schema:
        tried = [problems(value, one, root, at) for one in schema["anyOf"]]
        if all(tried):
            yield from min(tried, key=len)
    if "enum" in schema and value not in schema["enum"]:
        yield f"{at}: {value!r} is none of {schema['enum']}"
    allowed = schema.get("type", ())
    allowed = [allowed] if isinstance(allowed, str) else allowed
    if allowed and not any(_is(value, one) for one in allowed):
        yield f"{at}: {value!r} is no {' or '.join(allowed)}"
    elif isinstance(value, Mapping):
        yield from _object(value, schema, root, at)
    elif isinstance(value, list):
        yield from _array(value, schema, root, at)


def _is(value: Any, name: str) -> bool:
    plain = isinstance(value, TYPES[name])
    return plain and (name == "boolean" or not isinstance(value, bool))


def _object(value: Mapping[str, Any], schema: Any, root: Any, at: str) -> Iterator[str]:
    for name in schema.get("required", ()):
        if name not in value:
            yield f"{at}: {name} is missing"
    for name, inner in value.items():
        rule = schema.get("properties", {}).get(name, schema.get("additionalProperties", True))
        yield from problems(inner, rule, root, f"{at}.{name}")


def _array(value: list[Any], schema: Any, root: Any, at: str) -> Iterator[str]:
    if len(value) < schema.get("minItems", 0):
        yield f"{at}: fewer than {schema['minItems']} items"
    first = schema.get("prefixItems", [])
    for index, inner in enumerate(value):
        rule = first[index] if index < len(first) else schema.get("items", True)
        yield from problems(inner, rule, root, f"{at}[{index}]")

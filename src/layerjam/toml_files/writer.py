"""Records as TOML text: complete and commented, or a user's text with some changed values."""

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from layerjam.errors import QuantityError
from layerjam.toml_files.source import Source
from layerjam.toml_files.toml import quote
from layerjam.toml_files.values import Entry, ValueSpec
from layerjam.units import QuantitySpec
from layerjam.verdict import Acceptance, remaining

_UNSTATED = Source().to_toml()
WIDE = 100
"""Line length above which a list is written with one entry per line."""


def literal(value: object) -> str:
    """Return a text, a switch, a number, a list or a table as TOML text."""
    if isinstance(value, str):
        return quote(value)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(literal, value))}]"
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{k} = {literal(v)}' for k, v in value.items())} }}"
    return repr(value)


def describe_spec(spec: ValueSpec) -> str:
    """Return a comment line with symbol, meaning, unit and bounds of a value."""
    symbol, unit = "", ""
    if isinstance(spec, QuantitySpec):
        symbol = f"{spec.symbol}: " if spec.symbol else ""
        unit = "" if spec.unit == "1" else f" [{spec.unit}]"
    return f"# {symbol}{spec.text}{unit}; {spec.limits()}"


def plain_lines(rows: Mapping[str, Entry], values: Mapping[str, Any]) -> list[str]:
    """Return lines that set every value other than a default, with tables under headings."""
    lines, table = [], ""
    for path, entry in rows.items():
        head, _, key = path.rpartition(".")
        value = values.get(path)
        if value is None or value == entry.default:
            continue
        if head != table:
            lines += ["", f"[{head}]"]
            table = head
        toml_value = entry.spec.to_toml(value)
        text = f"{key} = {literal(toml_value)}"
        if len(text) > WIDE and isinstance(toml_value, list):
            text = "\n".join([f"{key} = [", *(f"    {literal(w)}," for w in toml_value), "]"])
        lines.append(text)
    return lines


def commented_lines(
    rows: Iterable[tuple[str, Entry]], values: Mapping[str, Any], sources: Mapping[str, Source]
) -> list[str]:
    """Return lines that set every value, after a comment on its meaning, by table.

    An unknown value, or a default without a source, becomes a comment.
    """
    lines, table = [], ""
    for path, entry in rows:
        head, _, key = path.rpartition(".")
        if head != table:
            lines += ["", f"[{head}]"]
            table = head
        lines.append(describe_spec(entry.spec))
        value, source = values.get(path), sources.get(path)
        if value is None:
            lines.append(f"# {key} =        (not known)")
            continue
        text = literal(entry.spec.to_toml(value))
        if source is None and value == entry.default:
            lines.append(f"# {key} = {text}        (the default)")
            continue
        words = {} if source is None else source.to_toml()
        inner = "".join(f", {k} = {quote(w)}" for k, w in words.items() if words != _UNSTATED)
        lines.append(f"{key} = {{ value = {text}{inner} }}" if inner else f"{key} = {text}")
    return lines


def update_text(
    text: str,
    fields: Mapping[str, Entry],
    changes: Mapping[str, tuple[Any, Source] | None],
    *,
    name: str | None = None,
    tables: Mapping[str, Mapping[str, Any] | None] = MappingProxyType({}),
    new: Sequence[Acceptance] = (),
) -> str:
    """Return a file's text with some changed values; comments and everything else are unchanged.

    A change is (value in SI, its source), or None to remove the key. `tables` are first replaced as
    a whole, or removed if None or empty. `new` acceptances are added to those of the file; an
    earlier one ends when all its numbers change. Raises QuantityError for a missing key.
    """
    import tomlkit

    document = tomlkit.parse(text)
    earlier = [Acceptance.read(row) for row in document.unwrap().get("accepted", [])]
    document.pop("accepted", None)
    if name is not None:
        document["name"] = name
    for table, entries in tables.items():
        document.pop(table, None)
        if entries:
            document[table] = dict(entries)
    for path, change in changes.items():
        table, _, key = path.rpartition(".")
        if change is None:
            _remove_key(document, path)
            continue
        if table and table not in document:
            document[table] = tomlkit.table()
        place: Any = document[table] if table else document
        value, source = change
        item = tomlkit.inline_table()
        item.update({"value": fields[path].spec.to_toml(value), **source.to_toml()})
        old = place.get(key)
        if isinstance(old, tomlkit.items.Table):
            for word in set(old) - set(item):
                old.remove(word)
            old.update(item)
        elif table or key in place:
            place[key] = item
        else:  # after tables, a plain key would belong to the last of them
            full = tomlkit.table()
            full.update(item)
            place.append(key, full)
    decisions = [*remaining(earlier, changes), *new]
    if decisions:
        rows = tomlkit.aot()
        for decision in decisions:
            rows.append(tomlkit.item(decision.to_toml()))
        document["accepted"] = rows
    return dump_toml(document, text)


def dump_toml(document: Any, text: str) -> str:
    """Return an edited tomlkit document as text, with the line breaks of its original text."""
    import tomlkit

    new_text = tomlkit.dumps(document).replace("\r\n", "\n")
    return new_text.replace("\n", "\r\n") if "\r\n" in text else new_text


def _remove_key(document: Any, path: str) -> None:
    table, _, key = path.rpartition(".")
    place = document.get(table, {}) if table else document
    if key not in place:
        raise QuantityError.of(path, "is set by a part, material or default; change the value")
    place.remove(key)

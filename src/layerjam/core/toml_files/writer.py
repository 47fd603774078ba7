"""Records as TOML text: complete and commented, or a user's text with some changed values."""

import os
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any

from layerjam.core.errors import QuantityError
from layerjam.core.toml_files.source import Source
from layerjam.core.toml_files.toml import quote
from layerjam.core.toml_files.values import Entry, ValueSpec
from layerjam.core.units import QuantitySpec
from layerjam.core.verdict import Acceptance, Verdict, remaining

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
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{k} = {literal(v)}' for k, v in value.items())} }}"
    return repr(value)


def format_tables(tables: Mapping[str, Any], head: str = "") -> str:
    """Return nested mappings as TOML text; a list of mappings is an array of tables."""
    lines, inner = [], ""
    for key, value in tables.items():
        path = f"{head}.{key}" if head else key
        plain = value.tolist() if hasattr(value, "tolist") else value
        if isinstance(plain, Mapping) and not head:
            inner += f"\n[{path}]\n{format_tables(plain, path)}"
        elif isinstance(plain, list | tuple) and plain and isinstance(plain[0], Mapping):
            inner += "".join(f"\n[[{path}]]\n{format_tables(row, path)}" for row in plain)
        elif plain is not None:
            text = str(plain) if isinstance(plain, os.PathLike) else plain
            lines.append(f"{key} = {literal(text)}\n")
    return "".join(lines) + inner


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
    tables: Mapping[str, Any] = MappingProxyType({}),
    verdict: Verdict | None = None,
) -> str:
    """Return a file's text with some changed values; comments and everything else are unchanged.

    A change is (value in SI, its source), or None to remove the key. `tables` are first replaced as
    a whole, or removed if None or empty; a list is an array of tables. `verdict` is that of the
    measurement of the new values, if they were measured: it adds its acceptances and may end
    earlier ones (`remaining`). Raises QuantityError for a missing key.
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
            document[table] = list(entries) if isinstance(entries, list) else dict(entries)
    for path, change in changes.items():
        table, _, key = path.rpartition(".")
        if change is None:
            _remove_key(document, path)
            continue
        place: Any = document
        parts = table.split(".") if table else []
        for depth, part in enumerate(parts, 1):
            if part not in place:
                place[part] = tomlkit.table(is_super_table=depth < len(parts))
            place = place[part]
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
            new_table = tomlkit.table()
            new_table.update(item)
            place.append(key, new_table)
    old_keys = [path for path, change in changes.items() if change is None]
    decisions = [*remaining(earlier, verdict, old_keys), *(verdict.decisions if verdict else ())]
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
    place = document
    for part in table.split(".") if table else ():
        place = place.get(part, {})
    if key not in place:
        raise QuantityError.of(path, "is set by a part, material or default; change the value")
    place.remove(key)

"""Records of other packages in a file: tables such as [effects.humidity], found by entry points.

A record class has a field of `plugin_records`, a tuple. Entry points are read only for a file with
such a table, or for a change to one.
"""

import contextlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field, fields
from functools import cache
from typing import Any

from layerjam.core.errors import QuantityError
from layerjam.core.plugins import list_plugins, load_plugin
from layerjam.core.record_classes import RECORDS
from layerjam.core.toml_files.values import Entry, entries
from layerjam.core.units import QuantitySpec, build, quantities

_BROKEN = (ImportError, AttributeError)
"""Errors of an entry point whose module or class does not exist."""


def plugin_records(group: str) -> Any:
    """Return a dataclass field for records that the entry points of a `group` provide."""
    return field(default=(), metadata={"plugins": group})


@cache
def plugin_groups(cls: type) -> Mapping[str, str]:
    """Return {field: group of entry points} of the fields of `plugin_records` in a class."""
    return {f.name: f.metadata["plugins"] for f in fields(cls) if "plugins" in f.metadata}


@cache
def load_table_class(cls: type, table: str) -> type:
    """Return the record class of a table of `cls`, such as "effects.humidity".

    Raises QuantityError for a name that no installed package provides, with the known names.
    """
    key, _, name = table.partition(".")
    group = plugin_groups(cls)[key]
    if name in list_plugins(group):
        return _load_record(group, name, table)
    if name in {path.partition(".")[0] for path, _ in entries(cls)}:
        raise QuantityError.of(table, f"{name} is built in; write it outside [{key}]")
    known = ", ".join(list_plugins(group)) or "none"
    raise QuantityError.of(
        table[:80],
        f"no installed package provides it (installed: {known}); install the one that has "
        f"'{name[:80]}' as an entry point of {group}",
    )


def _load_record(group: str, name: str, table: str) -> type:
    """Return the record class of an entry point; raises QuantityError if it provides none."""
    try:
        record_class: Any = load_plugin(group, name)
    except _BROKEN as error:
        raise QuantityError.of(table, f"its package cannot be loaded: {error}") from None
    if record_class not in RECORDS:
        raise QuantityError.of(table, f"{record_class!r} of {group} is not a class with @record")
    cls: type = record_class
    return cls


@cache
def _find_name(group: str, cls: type) -> str | None:
    """Return the name of the entry point that provides a class, or None."""
    package = cls.__module__.partition(".")[0]
    for name, point in list_plugins(group).items():
        if point.value.startswith(package):
            with contextlib.suppress(*_BROKEN):
                if point.load() is cls:
                    return name
    return None


def name_table(key: str, group: str, cls: Any) -> str:
    """Return the table of a record class, "effects.humidity", or the key if it has none."""
    name = _find_name(group, cls)
    return key if name is None else f"{key}.{name}"


def plugin_tables(rec: Any) -> Iterator[tuple[str, Any]]:
    """Yield (table, record) of the records of other packages in a record.

    The table is "effects.humidity", or "effects" for a record without an entry point, which a file
    cannot state.
    """
    cls: Any = type(rec)
    for key, group in plugin_groups(cls).items():
        for part in getattr(rec, key):
            yield name_table(key, group, type(part)), part


def check_tables(rec: Any) -> None:
    """Raise QuantityError for a record of another package that a file cannot state."""
    cls: Any = type(rec)
    groups = plugin_groups(cls)
    for table, part in plugin_tables(rec):
        if table in groups:
            raise QuantityError.of(
                table,
                f"a file cannot state {type(part).__name__}, because it is not an entry point of "
                f"{groups[table]}; remove it first",
            )


def known_tables(rec: Any, paths: Iterable[str] = ()) -> dict[str, type]:
    """Return {table: class} of other packages' records in `rec`, and of those that `paths` name.

    Raises QuantityError for a table that no installed package provides.
    """
    cls: Any = type(rec)
    groups = plugin_groups(cls)
    tables = [table for table, _ in plugin_tables(rec) if table not in groups]
    heads = (path.rpartition(".")[0] for path in paths if path.partition(".")[0] in groups)
    tables += [head for head in heads if "." in head]
    return {table: load_table_class(cls, table) for table in tables}


def known_entries(rec: Any, paths: Iterable[str] = ()) -> dict[str, Entry]:
    """Return {dotted path: Entry} of the `known_tables`."""
    tables = known_tables(rec, paths)
    return {p: e for table, cls in tables.items() for p, e in entries(cls, f"{table}.")}


def known_quantities(rec: Any, paths: Iterable[str] = ()) -> dict[str, tuple[QuantitySpec, bool]]:
    """Return {dotted path: (specification, required)} of the numbers of the `known_tables`."""
    tables = known_tables(rec, paths)
    rows = (row for table, cls in tables.items() for row in quantities(cls, f"{table}."))
    return {path: (spec, is_required) for path, spec, is_required in rows}


def named_tables(cls: type, names: Iterable[str]) -> Iterator[tuple[str, type]]:
    """Yield (table, record class) of the plug-ins that keyword `names` mention.

    A keyword is the dotted path with underscores, such as `effects_humidity_slope`.
    """
    for key, group in plugin_groups(cls).items():
        names_of_field = [name for name in names if name.startswith(f"{key}_")]
        for plugin in list_plugins(group) if names_of_field else ():
            table = f"{key}.{plugin}"
            if any(name.startswith(f"{keyword(table)}_") for name in names_of_field):
                yield table, load_table_class(cls, table)


def build_table(cls: type, values: Mapping[str, Any], table: str) -> Any:
    """Return the record of a table from {dotted path: SI value}; raises QuantityError."""
    prefix = f"{table}."
    return build(cls, {p[len(prefix) :]: v for p, v in values.items() if p.startswith(prefix)})


def keyword(path: str) -> str:
    """Return the keyword of a dotted path, such as `effects_humidity_slope`."""
    return path.replace(".", "_").replace("-", "_")

"""Tables of the commands: all of them, and the options and JSON keys of each."""

from __future__ import annotations

import html
import re
from collections import Counter
from collections.abc import Iterable
from functools import cache

import click
from markdown_tables import SHARED, row, table, unit

from layerjam.cli.main import app
from layerjam.core.command.declare import load_command
from layerjam.core.command.index import GROUPS, commands
from layerjam.core.outputs import field_key

Row = tuple[str, str, str]
"""Name of an option or a key as typed, the same with its value or unit, and its meaning."""


def command_table() -> str:
    """Every declared command by its group, most used first."""
    parts = []
    for group, title in GROUPS.items():
        names = [entry.name for entry in commands().values() if entry.group == group]
        links = ", ".join(f"[`{name}`](#{name.replace(' ', '-')})" for name in names)
        parts.append(row(title, links))
    return table(("to", "command"), parts)


def described(name: str) -> str:
    """The summary of a command, an example, its options, and the keys of its JSON.

    The command's schema states the unit and the meaning of each key.
    """
    own = [p for p in _options(name) if p not in _shared()]
    common = [p for p in _options(name) if p in _shared() and p[0] != "--json"]
    entry = commands()[name]
    parts = [entry.summary, f"`{entry.examples[0]}`"]
    parts += [_listed(("option", "meaning"), own)] if own else []
    if common:
        parts.append(_shared_names("options", common))
    keys = [f"`{key}`" for key, *rest in _keys(name) if (key, *rest) not in _shared()]
    common = [k for k in _keys(name) if k in _shared()]
    listed = [", ".join(keys)] if keys else []
    listed += [_shared_names("keys", common)] if common else []
    return "\n\n".join([*parts, f"JSON: {'; '.join(listed)}"])


def _shared_names(kind: str, rows: Iterable[Row]) -> str:
    names = ", ".join(f"`{name}`" for name, _, _ in rows)
    return f"[Shared {kind}](#shared-options-and-keys): {names}"


def _listed(head: tuple[str, str], rows: Iterable[Row]) -> str:
    return table(head, [row(shown, meaning) for _, shown, meaning in rows])


@cache
def _shared() -> dict[Row, str]:
    """Options and keys that several commands have, with their kind."""
    found: dict[Row, str] = {}
    for kind, rows_of in (("option", _options), ("key", _keys)):
        counts = Counter(each for name in commands() for each in rows_of(name))
        first: dict[str, Row] = {}
        for each, count in counts.most_common():
            # of two meanings of one name only the most frequent is shared
            if count >= SHARED and first.setdefault(each[0], each) == each:
                found[each] = kind
    return found


def shared_options() -> str:
    """Options and JSON keys that several commands share."""
    parts = []
    for kind, head in (("option", "option"), ("key", "JSON key")):
        rows = sorted(each for each, what in _shared().items() if what == kind)
        parts.append(_listed((head, "meaning"), rows))
    return "\n\n".join(parts)


@cache
def _options(name: str) -> tuple[Row, ...]:
    """The options of a command as the command line has them."""
    command = app.get_command(click.Context(app), name)
    rows = []
    for p in command.params:
        if getattr(p, "hidden", False):
            continue
        words = html.escape(p.help or "", quote=False)
        if p.param_type_name == "argument":
            words = re.sub(r"  \[default: (.+)\]$", r" Default \1.", words)
            rows.append((p.metavar, f"`{p.metavar}`", words))
            continue
        words += " Required." if p.required else ""
        words += f" Default {p.default}." if isinstance(p.default, str) and p.default else ""
        words, value = _with_example(words, "" if p.is_flag else p.metavar or "")
        rows.append((p.opts[0], ", ".join(f"`{o}{value}`" for o in p.opts), words))
    return tuple(rows)


def _with_example(words: str, metavar: str) -> tuple[str, str]:
    """The meaning of an option, and its value as typed: the example in place of a placeholder."""
    found = re.search(r",? e\.g\. (.+?)\.(?= |$)", words)
    if found is None or metavar not in ("Q", "NUMBER"):
        return words, f" {metavar.replace('|', ' or ')}" if metavar else ""
    return words[: found.start()] + words[found.end() - 1 :], f" {html.unescape(found[1])}"


@cache
def _keys(name: str) -> tuple[Row, ...]:
    """The keys of a command's JSON."""
    rows = []
    listed = load_command(name).result.keys()
    for f in listed:
        spec = f.metadata["quantity"]
        si = f" [{unit(spec)}]" if spec and spec.unit != "1" else ""
        rows.append((field_key(f), f"`{field_key(f)}`{si}", f.metadata["result"]))
    return tuple(rows)

"""The brake's TOML file: read, checked, changed in place, written (docs/file-format.md).

A quantity is text with its unit (``width = "13 mm"``) or a table that also says where the number
comes from (``width = { value = "13 mm", source = "caliper", kind = "measured" }``).
``use = "kapton-hn"`` in [film] or [enclosure] takes what is not given from the materials of the
catalogue.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from layerjam.device.brake import Brake, validate
from layerjam.device.mount import Site
from layerjam.device.source import KINDS, Source
from layerjam.errors import FileError, LayerjamError, UnknownNameError
from layerjam.units import Meaning, build, exact_text, get, quantities

MAX_BYTES = 1_000_000
_FIELDS: dict[str, tuple[Meaning, bool]] = {p: (m, r) for p, m, r in quantities(Brake)}
_TABLES = {p.split(".")[0] for p in _FIELDS if "." in p}
_DEFAULTS = {f"site.{name}": value for name, value in vars(Site()).items()} | {
    "rope.damping": 0.0,
    "scale_factor": 1.0,
}
_USE = {"film": "films", "enclosure": "silicones"}
_PLAIN = {"name", "title", "note"}
_ENTRY = {"value", "kind", "source", "spread", "conflict"}


@dataclass(frozen=True, kw_only=True)
class BrakeFile:
    """A brake with its name and where each of its numbers comes from.

    `brake` holds the numbers, `sources` a Source for every dotted path that was given, `notes`
    further tables of the file that describe but do not count (``[made_by]``), `text` the file.
    """

    name: str
    brake: Brake
    sources: Mapping[str, Source] = field(repr=False)
    text: str = field(repr=False)
    title: str = ""
    notes: Mapping[str, Any] = field(default_factory=dict)

    def warnings(self, without: Collection[str] = ()) -> list[str]:
        """What every result made with this brake has to say about its numbers.

        `without`: paths of numbers the result does not rest on.
        """
        out = []
        for kind, word in (("handbook", "handbook values"), ("assumed", "assumed values")):
            paths = [
                p for p, s in self.sources.items() if s.kind == kind and p in _MATTERS - {*without}
            ]
            if paths:
                which = ", ".join(paths)
                out.append(f"{which} of {self.name}: {word}, not measured on this brake")
        if self.brake.stiffness_measured is None and "stiffness_measured" not in without:
            out.append(
                f"no stiffness was measured for {self.name}: the sheets' computed one stands in, "
                "a real rig is several times softer"
            )
        return out


_MATTERS = {"film.static", "film.kinetic", "film.friction_on_silicone", "enclosure.modulus"}
_MATTERS |= {"film.modulus", "scale_factor", "stiffness_measured"}


def parse_toml(text: str, path: object) -> dict[str, Any]:
    """The tables of a TOML text; raises FileError with the line for anything that is not TOML."""
    if len(text) > MAX_BYTES:
        raise FileError(path, f"is larger than {MAX_BYTES // 1000} kB, too large for a brake file")
    for number, row in enumerate(text.split("\n"), 1):
        if row.count(".") > 300:  # tomllib takes minutes over a key of thousands of parts
            raise FileError(path, "has a line of more than 300 dots, no brake file", number)
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as err:
        match = re.search(r"\(at line (\d+), column \d+\)", str(err))
        reason = re.sub(r"\s*\(at .*\)", "", str(err))
        line = int(match.group(1)) if match else text.count("\n") + 1
        wrong = text.splitlines()[line - 1 : line] if line <= text.count("\n") + 1 else []
        if wrong and re.search(r"=\s*[\d.]+\s*[A-Za-z%µ]", wrong[0][:200]):
            reason += '; a quantity stands in quotes, such as "0.254 mm"'
        raise FileError(path, f"is not TOML: {reason}", line) from None
    except (ValueError, RecursionError) as err:
        raise FileError(path, f"is not TOML that can be read: {str(err)[:80]}") from None


def read_text(path: Path) -> str:
    """The text of a small UTF-8 file; raises FileError where there is none."""
    try:
        if path.is_dir():
            raise FileError(path, "is a folder, not a file")
        # opening a pipe or a device may wait for ever
        if path.exists() and not path.is_file():
            raise FileError(path, "is no regular file")
        with path.open("rb") as handle:
            raw = handle.read(MAX_BYTES + 1)
    except (OSError, ValueError) as err:
        raise FileError(path, f"cannot be read: {getattr(err, 'strerror', None) or err}") from None
    if len(raw) > MAX_BYTES:
        raise FileError(path, f"is larger than {MAX_BYTES // 1000} kB, too large for a brake file")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as err:
        line = raw[: err.start].count(b"\n") + 1
        raise FileError(path, "is not UTF-8 text", line) from None


def read_brake(
    text: str, path: object, materials: Mapping[str, Mapping[str, str]] | None = None
) -> BrakeFile:
    """A BrakeFile from TOML text.

    `materials` maps "films" and "silicones" to {name: TOML text}, for ``use``. Raises FileError
    with file and line for broken TOML, an unknown or missing key, a value without unit, of the
    wrong dimension or out of bounds, or values that contradict each other.
    """
    tables = parse_toml(text, path)
    reader = _Reader(text, path)
    for table, folder in _USE.items():
        inner = tables.get(table)
        if isinstance(inner, dict) and "use" in inner:
            reader.take_material(table, inner.pop("use"), (materials or {}).get(folder, {}))
    notes = reader.take(tables)
    missing = [p for p, (_, due) in _FIELDS.items() if due and p not in reader.values]
    if "rope.stiffness" in missing and not any(p.startswith("rope.") for p in reader.values):
        missing.remove("rope.stiffness")
    if missing:
        what = ", ".join(f"{p} ({_FIELDS[p][0].text})" for p in missing[:4])
        raise FileError(path, f"{what} {'is' if len(missing) == 1 else 'are'} missing")
    try:
        brake = build(Brake, reader.values)
        validate(brake)
    except LayerjamError as err:
        key = str(err).split(":")[0]
        raise FileError(path, str(err), line_of(text, key)) from None
    name = tables.get("name")
    if not isinstance(name, str) or not re.fullmatch(r"[\w][\w .+-]{0,79}", name):
        raise FileError(
            path,
            "name is missing or not a short text of letters, digits, '-', '_', '.' and '+'",
            line_of(text, "name"),
        )
    title = tables.get("title", "")
    return BrakeFile(
        name=name,
        brake=brake,
        sources=reader.sources,
        text=text,
        title=title if isinstance(title, str) else "",
        notes=notes,
    )


class _Reader:
    """Collects SI values and sources under dotted paths."""

    def __init__(self, text: str, path: object) -> None:
        self.text, self.path = text, path
        self.values: dict[str, Any] = {}
        self.sources: dict[str, Source] = {}

    def fail(self, key: str, reason: str) -> FileError:
        return FileError(self.path, reason, line_of(self.text, key))

    def take_material(self, table: str, use: object, known: Mapping[str, str]) -> None:
        if not isinstance(use, str) or use not in known:
            unknown = UnknownNameError(f"material for [{table}]", str(use), known or ["none here"])
            raise self.fail(f"{table}.use", str(unknown))
        material = parse_toml(known[use], f"material {use}")
        inner = _Reader(known[use], f"material {use}")
        inner.take({table: {k: v for k, v in material.items() if k not in _PLAIN}})
        self.values |= inner.values
        self.sources |= inner.sources

    def take(self, tables: Mapping[str, Any]) -> dict[str, Any]:
        notes: dict[str, Any] = {}
        for key, value in tables.items():
            if key in _PLAIN:
                if not isinstance(value, str):
                    raise self.fail(key, f"{key} must be a text in quotes")
            elif key in _TABLES:
                if not isinstance(value, dict):
                    raise self.fail(key, f"{key} must be a table, [{key}]")
                for inner, entry in value.items():
                    self.entry(f"{key}.{inner}", entry)
            elif key in _FIELDS:
                self.entry(key, value)
            elif key == "made_by" and isinstance(value, dict):
                notes = value
            else:
                raise self.fail(key, self.unknown(key))
        return notes

    def unknown(self, key: str) -> str:
        names = [*_FIELDS, *_TABLES, *_PLAIN, "made_by"]
        return str(UnknownNameError("key", key, names))

    def entry(self, path: str, entry: object) -> None:
        if path not in _FIELDS:
            raise self.fail(path, self.unknown(path))
        value, source = entry, Source()
        if isinstance(entry, dict):
            odd = set(entry) - _ENTRY
            if odd or "value" not in entry:
                what = f"does not know {', '.join(sorted(odd))[:60]}" if odd else "has no value"
                raise self.fail(path, f"{path} {what}; a table holds {', '.join(sorted(_ENTRY))}")
            for word in _ENTRY - {"value"}:
                if not isinstance(entry.get(word, ""), str):
                    raise self.fail(path, f"{path}.{word} must be a text in quotes")
            kind = entry.get("kind", "unstated")
            if kind not in KINDS:
                raise self.fail(path, str(UnknownNameError("kind", kind, KINDS)))
            value = entry["value"]
            source = Source(
                kind=kind,
                text=entry.get("source", ""),
                spread=entry.get("spread", ""),
                conflict=entry.get("conflict", ""),
            )
        try:
            self.values[path] = _FIELDS[path][0].read(value, path)
        except LayerjamError as err:
            raise self.fail(path, str(err)) from None
        self.sources[path] = source


def line_of(text: str, path: str) -> int | None:
    """The line on which a dotted path is set, None where it cannot be found."""
    table, _, key = path.rpartition(".")
    here = ""
    table_line = None
    for number, line in enumerate(text.splitlines(), 1):
        if len(line) > 400:  # no key stands so far in, and the pattern below takes its time
            continue
        head = re.match(r"\[([^\[\]]+)\]", line.strip())
        if head:
            here = head.group(1).strip()
            if here in (path, table):
                table_line = table_line or number
            if here == path:
                return number
        elif (here == table and re.match(rf"\s*\"?{re.escape(key)}\"?\s*[=.]", line)) or (
            not here and re.match(rf"\s*{re.escape(path)}\s*[=.]", line)
        ):
            return number
    return table_line


def updated_text(
    file: BrakeFile,
    name: str,
    changes: Mapping[str, tuple[float, Source]],
    made_by: Mapping[str, Any] | None = None,
) -> str:
    """The file's text with a new name and some values changed, comments and the rest kept.

    `made_by` becomes the [made_by] table, which describes and does not count.
    """
    import tomlkit

    document = tomlkit.parse(file.text)
    document["name"] = name
    for path, (value, source) in changes.items():
        table, _, key = path.rpartition(".")
        if table and table not in document:
            document[table] = tomlkit.table()
        place: Any = document[table] if table else document
        item = tomlkit.inline_table()
        meaning = _FIELDS[path][0]
        item["value"] = value if meaning.unit == "1" else exact_text(float(value), meaning.unit)
        words = {"kind": source.kind, "source": source.text}
        words |= {"spread": source.spread, "conflict": source.conflict}
        item.update({k: v for k, v in words.items() if v})
        old = place.get(key)
        if isinstance(old, tomlkit.items.Table):
            for word in list(old):
                if word not in item:
                    old.remove(word)
            old.update(item)
        elif table or key in place:
            place[key] = item
        else:
            full = tomlkit.table()
            full.update(item)
            place.append(key, full)
    document.pop("made_by", None)
    if made_by:
        document["made_by"] = dict(made_by)
    return tomlkit.dumps(document)


def render(file: BrakeFile, name: str) -> str:
    """A complete, commented file: every field with its meaning and what is allowed."""
    lines = [
        "# A layer-jamming brake. Every quantity carries its unit; edit what differs for yours.",
        "# A number can say where it comes from:",
        '#   width = { value = "13 mm", kind = "measured", source = "caliper, 3 places" }',
        f"# kind: {', '.join(KINDS)}",
        f"name = {_quoted(name)}",
    ]
    if file.title:
        lines.append(f"title = {_quoted(file.title)}")
    table = ""
    for path in sorted(_FIELDS, key=lambda p: "." in p):
        meaning, _ = _FIELDS[path]
        head, _, key = path.rpartition(".")
        if head != table:
            lines += ["", f"[{head}]"]
            table = head
        value = get(file.brake, path)
        unit = "" if meaning.unit == "1" else f" [{meaning.unit}]"
        symbol = f"{meaning.symbol}: " if meaning.symbol else ""
        lines.append(f"# {symbol}{meaning.text}{unit}; {meaning.allowed()}")
        if value is None:
            lines.append(f"# {key} =        (not known)")
            continue
        text = repr(value) if meaning.unit == "1" else _quoted(exact_text(value, meaning.unit))
        source = file.sources.get(path)
        if source is None and value == _DEFAULTS.get(path):
            lines.append(f"# {key} = {text}        (the default)")
            continue
        if source is None or source == Source():
            lines.append(f"{key} = {text}")
            continue
        words = {"kind": source.kind, "source": source.text}
        words |= {"spread": source.spread, "conflict": source.conflict}
        inner = "".join(f", {k} = {_quoted(v)}" for k, v in words.items() if v)
        lines.append(f"{key} = {{ value = {text}{inner} }}")
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    out = []
    for char in text:
        if char in '"\\':
            out.append("\\" + char)
        elif ord(char) < 32 or 127 <= ord(char) < 160 or char in "\u2028\u2029":
            out.append(f"\\u{ord(char):04x}")
        else:
            out.append(char)
    return '"' + "".join(out) + '"'

"""The brake's TOML file: read, checked, changed in place, written (docs/file-format.md).

A quantity is text with its unit (``width = "13 mm"``) or a table that also says where the number
comes from (``width = { value = "13 mm", source = "caliper", kind = "measured" }``).
``use = "kapton-hn"`` in [film] or [enclosure] takes what is not given from the materials of the
catalogue.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

from layerjam.device.brake import Brake, validate
from layerjam.device.mount import Site
from layerjam.device.source import KINDS, Source
from layerjam.device.toml import Reader, line_of, parse_toml, quoted
from layerjam.errors import FileError, LayerjamError
from layerjam.units import QuantitySpec, build, exact_text, get, quantities

_FIELDS: dict[str, tuple[QuantitySpec, bool]] = {p: (m, r) for p, m, r in quantities(Brake)}
_TABLES = {p.split(".")[0] for p in _FIELDS if "." in p}
_DEFAULTS = {f"site.{name}": value for name, value in vars(Site()).items()} | {
    "rope.damping": 0.0,
    "scale_factor": 1.0,
}
_USE = {"film": "films", "enclosure": "silicones"}


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


def read_brake(
    text: str, path: object, materials: Mapping[str, Mapping[str, str]] | None = None
) -> BrakeFile:
    """A BrakeFile from TOML text.

    `materials` maps "films" and "silicones" to {name: TOML text}, for ``use``. Raises FileError
    with file and line for broken TOML, an unknown or missing key, a value without unit, of the
    wrong dimension or out of bounds, or values that contradict each other.
    """
    tables = parse_toml(text, path)
    reader = Reader(text, path, _FIELDS)
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
        spec = _FIELDS[path][0]
        item["value"] = value if spec.unit == "1" else exact_text(float(value), spec.unit)
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
        f"name = {quoted(name)}",
    ]
    if file.title:
        lines.append(f"title = {quoted(file.title)}")
    table = ""
    for path in sorted(_FIELDS, key=lambda p: "." in p):
        spec, _ = _FIELDS[path]
        head, _, key = path.rpartition(".")
        if head != table:
            lines += ["", f"[{head}]"]
            table = head
        value = get(file.brake, path)
        unit = "" if spec.unit == "1" else f" [{spec.unit}]"
        symbol = f"{spec.symbol}: " if spec.symbol else ""
        lines.append(f"# {symbol}{spec.text}{unit}; {spec.allowed()}")
        if value is None:
            lines.append(f"# {key} =        (not known)")
            continue
        text = repr(value) if spec.unit == "1" else quoted(exact_text(value, spec.unit))
        source = file.sources.get(path)
        if source is None and value == _DEFAULTS.get(path):
            lines.append(f"# {key} = {text}        (the default)")
            continue
        if source is None or source == Source():
            lines.append(f"{key} = {text}")
            continue
        words = {"kind": source.kind, "source": source.text}
        words |= {"spread": source.spread, "conflict": source.conflict}
        inner = "".join(f", {k} = {quoted(v)}" for k, v in words.items() if v)
        lines.append(f"{key} = {{ value = {text}{inner} }}")
    return "\n".join(lines) + "\n"

"""The brake's TOML file: read, checked, changed in place, written (docs/file-format.md).

A quantity is text with its unit (``width = "13 mm"``) or a table that also says where the number
comes from (``width = { value = "13 mm", source = "caliper", kind = "measured" }``).
``use = "kapton-hn"`` in [film] or [enclosure] takes what is not given from the materials of the
catalogue.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, ClassVar, Self

from layerjam.device.brake import Brake, validate
from layerjam.device.fan import MATTERS, fan_exponent, fan_factor
from layerjam.device.workshop import FilmCutting, Making, agree
from layerjam.errors import Notice, UnknownNameError
from layerjam.records.changes import RecordFile, paths_of, values_of
from layerjam.records.reader import DESCRIBING, Reader
from layerjam.records.shipped import shipped
from layerjam.records.source import Source
from layerjam.records.toml import parse_toml
from layerjam.records.values import Entry, entries
from layerjam.records.writer import updated
from layerjam.units import check
from layerjam.verdict import Acceptance

_USE = {"film": "films", "enclosure": "silicones"}
_LASER = "film.laser"
_SCREWS, _DRAWN = "mount.screws", "build.screws"
_MATTERS = {
    "film.static",
    "film.kinetic",
    "film.friction_on_silicone",
    "film.modulus",
    "enclosure.modulus",
    "scale_factor",
    "stiffness_measured",
}
"""Numbers whose kind of source every result mentions."""


def _fields() -> Mapping[str, Entry]:
    """All that a brake's file may set; what belongs to one table stands together."""
    known = dict(entries(Brake)) | dict(entries(Making))
    tables = list(dict.fromkeys(path.rpartition(".")[0] for path in known))
    rows = sorted(known.items(), key=lambda row: tables.index(row[0].rpartition(".")[0]))
    return MappingProxyType(dict(rows))


@dataclass(frozen=True, kw_only=True)
class BrakeFile(RecordFile[Brake]):
    """A brake with its name and where each of its numbers comes from.

    `brake` holds the numbers, `making` what is said of building it (``[build]``), `sources` a
    Source for every dotted path that was given, `text` the file.
    """

    brake: Brake
    making: Making = Making()

    fields: ClassVar[Mapping[str, Entry]] = _fields()
    holds: ClassVar[str] = "brake"
    heading: ClassVar[str] = "A layer-jamming brake."
    kind: ClassVar[type] = Brake
    check = staticmethod(validate)
    named = (
        r"[\w][\w .+-]{0,79}",
        "name is missing or not a short text of letters, digits, '-', '_', '.' and '+'",
    )

    @classmethod
    def read(cls, text: str, path: object) -> Self:
        """The file from its TOML text; ``use`` takes from the materials of the catalogue.

        Raises FileError with file and line for broken TOML, an unknown or missing key, a value
        without unit, of the wrong dimension or out of bounds, or values that contradict each other.
        """
        reader = Reader(text, path, cls.fields)
        tables = parse_toml(text, path)
        for table, folder in _USE.items():
            inner = tables.get(table)
            if isinstance(inner, dict) and "use" in inner:
                _take_material(reader, table, inner.pop("use"), materials()[folder])
        before = dict(reader.values), dict(reader.sources)
        reader.take(tables)
        _remember(reader, *before)
        _count_screws(reader)
        with reader.located():
            making = reader.record(Making)
            check(making)
        file = cls.taken(reader, making=making)
        if any(path.startswith("build.") for path in reader.sources):
            with reader.located():
                agree(file.brake, making.build)
        return file

    @property
    def given(self) -> dict[str, Any]:
        """{dotted path: value in SI} of all that is known."""
        return values_of(self.brake) | values_of(self.making)

    @property
    def calibrated(self) -> bool:
        """Whether its scale factor was found on pulls, by whomever, and not just set to a value."""
        source = self.sources.get("scale_factor")
        return source is not None and source.kind not in ("assumed", "unstated")

    @property
    def synthetic(self) -> list[str]:
        """Dotted paths of numbers that were found in files that a program wrote."""
        return paths_of(self.sources, "synthetic")

    def synthetic_mark(self, without: Collection[str] = ()) -> str:
        """Return the sentence about synthetic numbers, empty if there are none."""
        paths = [path for path in self.synthetic if path not in without]
        if not paths:
            return ""
        return f"{', '.join(paths)} of {self.name}: synthetic, a program wrote the files behind it"

    def mark(self) -> str:
        """Return what every exported file states: synthetic numbers and accepted failed checks."""
        return ". ".join(
            filter(None, [self.synthetic_mark(), *(a.notice() for a in self.accepted)])
        )

    def warnings(self, without: Collection[str] = ()) -> list[str]:
        """What every result made with this brake has to say about its numbers.

        `without`: paths of numbers the result does not rest on.
        """
        out: list[str] = []
        for kind, word in (("handbook", "handbook values"), ("assumed", "assumed values")):
            paths = [p for p in paths_of(self.sources, kind) if p in _MATTERS - {*without}]
            if paths:
                which = ", ".join(paths)
                out.append(f"{which} of {self.name}: {word}, not measured on this brake")
        if mark := self.synthetic_mark(without):
            out.append(Notice(mark, "synthetic-brake"))
        if self.brake.stiffness_measured is None and "stiffness_measured" not in without:
            out.append(
                f"no stiffness was measured for {self.name}: the sheets' computed one stands in, "
                "a real rig is several times softer"
            )
        return out + list(self.fanning())

    def fanning(self) -> Iterator[Notice]:
        """What is not known of the sheets' way out of the caps, where it matters."""
        brake = self.brake
        held, sheets = brake.amplification_held, brake.sheets
        factor = fan_factor(min(fan_exponent(brake), 50.0))
        more = factor / (held or 1.0)
        if brake.mount.spacers is None and abs(more - 1) > MATTERS:
            size = f"{more:.3g} times" if more < 100 else "more than 100 times"
            yield Notice(
                f"whether {self.name} has spacers in its caps is not stated: without them "
                f"{sheets.count} sheets would hold {size} the friction computed here, and their "
                "stress would rise with it; say spacers = true or false in [mount]",
                "spacers-unstated",
            )
        fitted = brake.scale_factor != 1.0 and held is None
        if brake.mount.spacers is not None and fitted and factor - 1 > MATTERS:
            yield Notice(
                f"scale_factor of {self.name} is taken to hold no self-amplification; if it was "
                "fitted on a brake without spacers, and spacers were not stated then, give that "
                "brake's amplification_held",
                "amplification-unstated",
            )


def materials() -> dict[str, dict[str, str]]:
    """{"films": {name: TOML text}, "silicones": ...} of the catalogue."""
    return {folder: shipped("layerjam.device", "catalogue", folder) for folder in _USE.values()}


def film_cutting(use: str) -> tuple[FilmCutting, Mapping[str, Source]]:
    """What the catalogue says of buying and cutting a film, and where from by dotted path."""
    reader = Reader("", f"material {use}", BrakeFile.fields)
    _take_material(reader, "film", use, materials()["films"])
    return reader.record(FilmCutting, "film."), reader.sources


def _take_material(reader: Reader, table: str, use: object, known: Mapping[str, str]) -> None:
    """What a `use` names, from the catalogue."""
    if not isinstance(use, str) or use not in known:
        unknown = UnknownNameError(f"material for [{table}]", str(use), known)
        raise reader.fail(f"{table}.use", unknown)
    inner = Reader(known[use], f"material {use}", reader.fields)
    material = parse_toml(known[use], f"material {use}")
    inner.take({k: v for k, v in material.items() if k not in DESCRIBING}, table)
    reader.values |= {f"{table}.product": material["name"], **inner.values}
    reader.sources |= inner.sources


def _remember(reader: Reader, values: Mapping[str, Any], sources: Mapping[str, Source]) -> None:
    """What the catalogue says against a laser is not forgotten where the file lifts it."""
    now = reader.values.get(_LASER)
    if values.get(_LASER) == "never" and now != "never" and not reader.sources[_LASER].was:
        was = f"never: {sources[_LASER].text}"
        reader.sources[_LASER] = replace(reader.sources[_LASER], was=was)


def _count_screws(reader: Reader) -> None:
    """Screws that only [build] states are those of [mount]: a brake has them once."""
    if _DRAWN in reader.values:
        reader.values.setdefault(_SCREWS, reader.values[_DRAWN])
        reader.sources.setdefault(_SCREWS, reader.sources[_DRAWN])


def updated_text(
    file: BrakeFile,
    name: str,
    changes: Mapping[str, tuple[float, Source] | None],
    made_by: Mapping[str, Any] | None = None,
    accepted: Sequence[Acceptance] = (),
) -> str:
    """The file's text with a new name and some values changed, comments and the rest kept.

    `made_by` becomes the [made_by] table, which describes and does not count; it names the file
    that was changed by its digest. `accepted` are the failed checks that somebody accepted.
    """
    if made_by is not None:
        made_by = {**made_by, "brake_sha256": file.sha256}
    made: dict[str, tuple[Any, Source] | None] = dict(changes)
    held = file.brake.amplification_held is not None and "amplification_held" in file.sources
    if held and "scale_factor" in changes and file.brake.mount.spacers is None:
        made["amplification_held"] = None  # it belonged to the old one
    return updated(
        file.text, file.fields, made, name=name, tables={"made_by": made_by}, accepted=accepted
    )

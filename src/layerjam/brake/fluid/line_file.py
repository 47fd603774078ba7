"""A vacuum line's TOML file, from the catalogue or the user.

`part = "NAME"` in [pump], [valve] or [sensor] selects a part from the catalogue with its sources;
other keys in the table override the part's values.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, Self

from layerjam.brake.fluid.line import Line, validate
from layerjam.brake.fluid.parts import FAMILIES, part_entries
from layerjam.core.brief import brief
from layerjam.core.errors import Notice
from layerjam.core.toml_files.changes import RecordFile, find_paths
from layerjam.core.toml_files.reader import Reader
from layerjam.core.toml_files.shipped import shipped_files
from layerjam.core.toml_files.toml import parse_toml
from layerjam.core.toml_files.values import Entry, entries


@brief
@dataclass(frozen=True, kw_only=True)
class LineFile(RecordFile[Line]):
    """A line with its name, and the source of each of its values."""

    line: Line
    parts: Mapping[str, str] = field(default_factory=dict)
    """Names of parts from the catalogue, by table."""

    fields: ClassVar[Mapping[str, Entry]] = MappingProxyType(dict(entries(Line)))
    holds: ClassVar[str] = "line"
    heading: ClassVar[str] = "A vacuum line."
    kind: ClassVar[type] = Line
    check = staticmethod(validate)

    @classmethod
    def read(cls, text: str, path: object) -> Self:
        """Return the file from its TOML text; FileError with file and line if it is invalid."""
        tables = parse_toml(text, path)
        reader = Reader(text, path, cls.fields)
        parts = _insert_parts(tables, reader)
        reader.read_all(tables)
        return cls.build_from_reader(
            reader, *([] if "pump.curve" in reader.values else ["pump.flow"]), parts=parts
        )

    def warnings(self) -> list[Notice]:
        """Return the warnings about the line's values, which every result repeats."""
        return [
            Notice(f"{', '.join(paths)} of {self.name}: {word}, not measured")
            for kind, word in (("inferred", "inferred"), ("assumed", "assumed values"))
            if (paths := find_paths(self.sources, kind))
        ]


def _catalogue_texts() -> dict[str, str]:
    return shipped_files("layerjam.brake.fluid", "catalogue", "lines")


def lines() -> list[str]:
    """Names of the lines in the catalogue."""
    return list(_catalogue_texts())


def load_line(line: str | Path) -> LineFile:
    """Return a line, given its catalogue name or the path of its TOML file.

    Raises UnknownNameError (with the nearest names) or FileError.
    """
    return LineFile.load(line, _catalogue_texts())


def _insert_parts(tables: dict[str, Any], reader: Reader) -> dict[str, str]:
    """Replace `part` in the tables of a line by the part's entries; return part names by table."""
    names = {}
    for family in FAMILIES:
        table = tables.get(family)
        if not isinstance(table, dict) or "part" not in table:
            continue
        overrides = {k: v for k, v in table.items() if k != "part"}
        with reader.locate_errors(f"{family}.part"):
            tables[family] = part_entries(family, table["part"], overrides)
        names[family] = table["part"]
    return names

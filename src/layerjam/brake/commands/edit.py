"""Edits of numbers in the text of a brake file or line file that keep comments and sources."""

from collections.abc import Iterator, Mapping
from typing import Any

from layerjam.brake.commands.arguments import AnyBrake, convert_brake
from layerjam.brake.commands.lines import AnyLine, load_line_file
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.fluid.line import Line
from layerjam.brake.fluid.line_file import LineFile
from layerjam.brake.fluid.parts import FAMILIES, parts
from layerjam.core.command.results import Result, fact, result
from layerjam.core.errors import Notice, QuantityError, UnknownNameError, explain_arguments
from layerjam.core.toml_files.changes import Change, RecordFile, collect_values
from layerjam.core.toml_files.plugin_tables import known_quantities
from layerjam.core.toml_files.source import KINDS, Source
from layerjam.core.units import QuantitySpec, quantities, show

Fields = dict[str, tuple[QuantitySpec, bool]]
BRAKE_FIELDS: Fields = {path: (spec, is_required) for path, spec, is_required in quantities(Brake)}
"""{dotted path: (specification, required)} of every number in a brake."""
LINE_FIELDS: Fields = {path: (spec, is_required) for path, spec, is_required in quantities(Line)}
"""Numbers of a line in the same form, except its flow curve, which is not a number."""


def list_numbers(
    file: BrakeFile,
) -> Iterator[tuple[str, QuantitySpec, Any, Source | None]]:
    """Yield (dotted path, specification, SI value, source) of each known number of a brake."""
    values = collect_values(file.brake)
    for path, (spec, _) in (BRAKE_FIELDS | known_quantities(file.brake)).items():
        if values.get(path) is not None:
            yield path, spec, values[path], file.sources.get(path)


BY_HAND = "set by hand"
GEOMETRY = ("sheets", "film", "enclosure", "mount")
OF_THE_BRAKE = ("scale_factor", "stiffness_measured", "weighed_mass", "fittings_mass")
"""Numbers measured or fitted on one brake that are not valid for any other."""


@result
class EditedFile(Result):
    """A changed brake or line; `record` is its BrakeFile or LineFile."""

    record: BrakeFile | LineFile
    name: str = fact("name of the record")
    text: str = fact("text of the file", listed=False)


@explain_arguments
def edit(
    brake: AnyBrake,
    changes: Mapping[str, Change] | None = None,
    *,
    name: str | None = None,
    kind: str = "assumed",
    source: str = "",
) -> EditedFile:
    """Return a brake with a different name and different numbers.

    `changes` maps a dotted path to text with a unit, an SI number or None. None means unknown, the
    value of the material, or the default. `kind` and `source` state the source of the new numbers;
    if no source is given, the previous one is kept. Raises QuantityError for a bad value or path,
    FileError for values that contradict each other.
    """
    file = convert_brake(brake)
    edition = file.edit(_convert_changes(file, changes, BRAKE_FIELDS, kind, source), name=name)
    notices = [*edition.warnings(), *find_stale_numbers(edition)]
    return EditedFile(name=edition.name, text=edition.text, warnings=notices, record=edition)


@explain_arguments
def edit_line(
    line: AnyLine,
    changes: Mapping[str, Change] | None = None,
    *,
    takes: Mapping[str, str | None] | None = None,
    name: str | None = None,
    kind: str = "assumed",
    source: str = "",
) -> EditedFile:
    """Return a line with different numbers or parts; `changes`, `kind` and `source` as in `edit`.

    `takes` maps a table to a part of the catalogue, which replaces the whole table, or to None if
    the line has no such part; parts are set before numbers. Raises UnknownNameError, QuantityError
    for a bad value, and FileError for an invalid line, such as a tube without a bore.
    """
    file = load_line_file(line)
    tables = {table: _find_catalogue_part(table, part) for table, part in (takes or {}).items()}
    changes_by_path = _convert_changes(file, changes, LINE_FIELDS, kind, source)
    edition = file.edit(changes_by_path, name=name, tables=tables)
    return EditedFile(
        name=edition.name,
        text=edition.text,
        warnings=edition.warnings(),
        record=edition,
    )


def _convert_changes(
    file: RecordFile[Any],
    changes: Mapping[str, Change] | None,
    fields: Fields,
    kind: str,
    source: str,
) -> dict[str, tuple[Any, Source] | None]:
    """Return {dotted path: (SI value, source) or None} of the numbers to change in a file."""
    if kind not in KINDS:
        raise UnknownNameError("kind", kind, KINDS)
    entries: dict[str, tuple[Any, Source] | None] = {}
    fields = fields | known_quantities(file.record, changes or ())
    known_values = file.known_values
    for path, value in (changes or {}).items():
        if path not in fields:
            raise UnknownNameError("key", path, fields)
        if value is None:
            entries[path] = None
            continue
        spec, _ = fields[path]
        original_value = "" if source else _original_value(file, known_values.get(path), path, spec)
        entries[path] = (
            spec.si(value, path),
            Source(kind=kind, text=source or BY_HAND, was=original_value),
        )
    return entries


def _original_value(file: RecordFile[Any], value: Any, path: str, spec: QuantitySpec) -> str:
    """Return the value before all edits, with its source."""
    old = file.sources.get(path)
    if old is not None and old.was:
        return old.was
    if value is None:
        return "not known"
    origin = old.sentence() if old is not None else "the default"
    return f"{show(value, spec.unit)}, {origin}"


def find_stale_numbers(file: BrakeFile) -> list[Notice]:
    """Return notices of numbers measured or fitted before other numbers were changed."""
    by_hand = [path for path, source in file.sources.items() if source.was]
    sizes = [path for path in by_hand if path.split(".")[0] in GEOMETRY]
    paths = [path for path in OF_THE_BRAKE if path in file.sources and path not in by_hand]
    if not (sizes and paths):
        return []
    sentence = (
        f"{', '.join(paths)} {'date' if len(paths) > 1 else 'dates'} from before "
        f"{', '.join(sizes)} {'were' if len(sizes) > 1 else 'was'} set by hand"
    )
    return [Notice(sentence, "stale")]


def _find_catalogue_part(table: str, part: str | None) -> dict[str, str] | None:
    """Return the table of a line that accepts a catalogue part, or None."""
    tables = {path.split(".")[0] for path in LINE_FIELDS if "." in path}
    if table not in tables:
        raise UnknownNameError("table", table, tables)
    if part is None:
        return None
    if table not in FAMILIES:
        raise QuantityError.of(table, f"unknown part family; choose one of {', '.join(FAMILIES)}")
    if part not in parts(table):
        raise UnknownNameError(f"part for [{table}]", part, parts(table))
    return {"part": part}

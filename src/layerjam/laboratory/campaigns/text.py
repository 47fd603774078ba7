"""A campaign's TOML, read with the file and line in every error, and written with comments."""

from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

from layerjam.core.evolve import evolve
from layerjam.core.toml_files.reader import Reader
from layerjam.core.toml_files.toml import parse_toml, read_text
from layerjam.core.toml_files.values import entries
from layerjam.core.toml_files.writer import describe_spec, literal
from layerjam.laboratory.campaigns.spec import TABLES, Spec, Truth, check_spec

_HEADINGS = {
    "brakes": (
        "One [[brakes]] table for each brake, with the true values that differ from its file."
    ),
    "pulls": "Pulls of each brake: every vacuum at every speed.",
    "friction": "Friction tests of each brake's film: a sled pulled over it by a string.",
    "scatter": "Scatter of the brake from pull to pull.",
    "machine": "The test machine and its faults; 0 for none.",
    "files": "Layout of the files.",
    "practice": "Number of pull files with each fault.",
    "odd": "Outliers, and how they differ.",
}
_FIELDS = dict(entries(Spec))


def example_spec() -> Spec:
    """Return a small example campaign, with the faults of an ordinary machine."""
    place = files("layerjam.laboratory.campaigns") / "practice.toml"
    return parse_spec(place.read_text(encoding="utf-8"), "practice.toml")


def read_spec(path: str | Path) -> Spec:
    """Return the campaign in a TOML file; paths of brakes are relative to its folder.

    Raises FileError, with file and line, if the text is not TOML, a key is unknown, or a value
    lacks a unit, is out of bounds or contradicts another value.
    """
    path = Path(path)
    return parse_spec(read_text(path), path, path.parent)


def parse_spec(text: str, path: object, folder: Path | None = None) -> Spec:
    """Return the campaign in a TOML text; errors name its `path`."""
    tables = parse_toml(text, path)
    reader = Reader(text, path, _FIELDS, words={})
    brakes: tuple[Any, ...] = ()
    if "brakes" in tables:
        brakes = reader.read_rows("brakes", _resolve_paths(tables.pop("brakes"), folder), Truth)
    reader.read_all(tables)
    with reader.locate_errors():
        return check_spec(evolve(reader.build_record(Spec), brakes=brakes))


def _resolve_paths(rows: object, folder: Path | None) -> object:
    if folder is None or not isinstance(rows, list):
        return rows
    tables = []
    for row in rows:
        name = row.get("brake") if isinstance(row, dict) else None
        is_file = isinstance(name, str) and name.endswith(".toml")
        tables.append({**row, "brake": str(folder / str(name))} if is_file else row)
    return tables


def format_spec(spec: Spec) -> str:
    """Return the campaign as a commented text, with the meaning and bounds of every field."""
    lines = [
        "# A campaign of the virtual laboratory: layerjam lab THIS.toml --out DIR",
        "# Every quantity carries its unit; a missing value takes the default in its comment.",
        "",
        describe_spec(_FIELDS["seed"].spec),
        f"seed = {spec.seed}",
    ]
    for table, cls in TABLES.items():
        records = spec.brakes if table == "brakes" else (getattr(spec, table),)
        for record in records:
            head = "[[brakes]]" if table == "brakes" else f"[{table}]"
            lines += ["", f"# {_HEADINGS[table]}", head, *_format_record(record, cls)]
    return "\n".join([*lines, ""])


def _format_record(record: Any, cls: type) -> Iterator[str]:
    for name, entry in entries(cls):
        value = getattr(record, name)
        yield describe_spec(entry.spec)
        yield f"# {name} =" if value is None else f"{name} = {literal(entry.spec.to_toml(value))}"

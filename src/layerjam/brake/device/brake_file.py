"""The TOML file of a brake: reading, checking, changing in place, writing (docs/file-format.md).

A quantity is text with its unit (``width = "13 mm"``) or a table that also gives its source
(``width = { value = "13 mm", source = "caliper", kind = "measured" }``). ``use = "kapton-hn"`` in
[film] or [enclosure] adds missing values from a material in the catalogue.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, ClassVar, Self

from layerjam.brake.device.brake import FAN_EFFECT, Brake, fan_exponent, fan_factor, validate
from layerjam.brake.device.evidence import Evidence, read_evidence, replace_evidence
from layerjam.brake.device.workshop import FilmCutting, Making, check_build
from layerjam.core.brief import brief
from layerjam.core.errors import Notice, QuantityError, UnknownNameError, make_notices
from layerjam.core.evolve import evolve
from layerjam.core.toml_files.changes import RecordFile, collect_values, find_paths
from layerjam.core.toml_files.plugin_tables import check_tables
from layerjam.core.toml_files.reader import DESCRIBING, Reader
from layerjam.core.toml_files.shipped import shipped_files
from layerjam.core.toml_files.source import Source
from layerjam.core.toml_files.toml import parse_toml
from layerjam.core.toml_files.values import Entry, entries
from layerjam.core.toml_files.writer import update_text
from layerjam.core.units import QuantitySpec, check, show
from layerjam.core.verdict import Verdict

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
"""Values that every result mentions if they are handbook or assumed values."""


def _file_fields() -> Mapping[str, Entry]:
    """Return all fields that a brake's file may set, table by table."""
    fields = dict(entries(Brake)) | dict(entries(Making))
    tables = list(dict.fromkeys(path.rpartition(".")[0] for path in fields))
    rows = sorted(fields.items(), key=lambda row: tables.index(row[0].rpartition(".")[0]))
    return MappingProxyType(dict(rows))


@brief
@dataclass(frozen=True, kw_only=True)
class BrakeFile(RecordFile[Brake]):
    """A brake with its name and the source of each of its values.

    `brake` contains the values, `making` the data for making the brake (``[build]``), `sources` a
    Source for every dotted path in the file, `evidence` what tests showed ([[tested]]), and `text`
    the file itself.
    """

    brake: Brake
    making: Making = Making()
    evidence: tuple[Evidence, ...] = ()

    fields: ClassVar[Mapping[str, Entry]] = _file_fields()
    holds: ClassVar[str] = "brake"
    heading: ClassVar[str] = "A layer-jamming brake."
    kind: ClassVar[type] = Brake
    check = staticmethod(validate)
    name_rule = (
        r"[\w][\w .+-]{0,79}",
        "name is missing or not a short text of letters, digits, '-', '_', '.' and '+'",
    )

    @classmethod
    def read(cls, text: str, path: object) -> Self:
        """Return the file from its TOML text; ``use`` adds values from a catalogue material.

        Raises FileError with file and line if the text is not TOML, a key is unknown or missing, or
        values lack a unit, are out of bounds or contradict each other.
        """
        reader = Reader(text, path, cls.fields, kind=cls.kind)
        tables = parse_toml(text, path)
        uses = {}
        for table, folder in _USE.items():
            inner = tables.get(table)
            if isinstance(inner, dict) and "use" in inner:
                uses[table] = inner.pop("use")
                _apply_material(reader, table, uses[table], materials()[folder])
        with reader.locate_errors("tested"):
            evidence = read_evidence(tables.pop("tested", ()))
        before = dict(reader.values), dict(reader.sources)
        reader.read_all(tables)
        for table, use in uses.items():
            product = f"{table}.product"
            if reader.values[product] != before[0][product]:  # the file states one itself
                _check_product(reader, table, use, materials()[_USE[table]])
        _keep_laser_warning(reader, *before)
        _copy_screw_count(reader)
        with reader.locate_errors():
            making = reader.build_record(Making)
            check(making)
        file = cls.build_from_reader(reader, making=making, evidence=evidence)
        # not a field, so that brakes with equal numbers are equal
        object.__setattr__(file.brake, "_evidence", evidence)
        if any(path.startswith("build.") for path in reader.sources):
            with reader.locate_errors():
                check_build(file.brake, making.build)
        return file

    @classmethod
    def from_record(cls, record: Brake, name: str = "unnamed") -> Self:
        """Return a file for a plain brake, with the evidence of the file from which it was read."""
        file = super().from_record(record, name)
        return replace(file, evidence=getattr(record, "_evidence", ()))

    def render(self, name: str) -> str:
        """Return a complete, commented file, with the evidence of tests at its end."""
        if not self.evidence:
            return super().render(name)
        import tomlkit

        rows = [entry.to_toml() for entry in self.evidence]
        return f"{super().render(name)}\n{tomlkit.dumps({'tested': rows})}"

    @cached_property
    def known_values(self) -> dict[str, Any]:
        """{dotted path: value in SI} of all known values."""
        return collect_values(self.brake) | collect_values(self.making)

    @property
    def is_calibrated(self) -> bool:
        """Whether the scale factor has a source, such as a fit to pulls of this very brake."""
        source = self.sources.get("scale_factor")
        has_source = source is not None and source.kind not in ("assumed", "unstated")
        return has_source and not self.is_changed

    @property
    def is_changed(self) -> bool:
        """Whether the brake is no longer the one that was calibrated."""
        return any(entry.command == "calibrate" for entry in self.outdated_evidence)

    @cached_property
    def _changes_since_tests(self) -> tuple[bool, ...]:
        """Whether the brake was changed since the tests of each entry of the evidence."""
        values = self.known_values if self.evidence else {}
        return tuple(bool(entry.find_changes(values)) for entry in self.evidence)

    def valid_evidence(self, command: str) -> Evidence | None:
        """Return what the tests of a command showed; None for a brake that is not as tested."""
        entries = zip(self.evidence, self._changes_since_tests, strict=True)
        return next(
            (e for e, is_outdated in entries if e.command == command and not is_outdated), None
        )

    @property
    def outdated_evidence(self) -> tuple[Evidence, ...]:
        """Evidence of tests of a brake that has been changed since."""
        entries = zip(self.evidence, self._changes_since_tests, strict=True)
        return tuple(entry for entry, is_outdated in entries if is_outdated)

    @property
    def synthetic(self) -> list[str]:
        """Dotted paths of values derived from files that a program wrote."""
        return find_paths(self.sources, "synthetic")

    def synthetic_mark(self, without: Collection[str] = ()) -> str:
        """Return the sentence about synthetic values, or empty text if there are none."""
        paths = [path for path in self.synthetic if path not in without]
        if not paths:
            return ""
        return f"{', '.join(paths)} of {self.name}: synthetic, from files written by a program"

    def mark(self) -> str:
        """Return the statement on synthetic values and accepted failed checks for an export."""
        return ". ".join(
            filter(None, [self.synthetic_mark(), *(a.notice() for a in self.accepted)])
        )

    def warnings(self, without: Collection[str] = ()) -> list[Notice]:
        """Return the warnings about the brake's values, which every result repeats.

        `without` contains paths of values that do not affect the result.
        """
        out: list[str] = []
        for kind, word in (("handbook", "handbook values"), ("assumed", "assumed values")):
            paths = [p for p in find_paths(self.sources, kind) if p in _MATTERS - {*without}]
            if paths:
                numbers = ", ".join(paths)
                out.append(f"{numbers} of {self.name}: {word}, not measured on this brake")
        if mark := self.synthetic_mark(without):
            out.append(Notice(mark, "synthetic-brake"))
        if self.brake.stiffness_measured is None and "stiffness_measured" not in without:
            out.append(
                f"no stiffness was measured for {self.name}: the sheets' computed "
                "stiffness is used; real rigs are several times more compliant"
            )
        return make_notices([*out, *self.spacer_notices(), *self.change_notices()])

    def change_notices(self) -> Iterator[Notice]:
        """Yield a notice if the brake is no longer the one that was calibrated."""
        for entry in self.outdated_evidence:
            if entry.command == "calibrate":
                changes = list_changes(entry.find_changes(self.known_values))
                yield Notice(
                    f"{self.name} was calibrated on {entry.date} and changed since: "
                    f"{changes}; calibrate it again",
                    "changed-since-tests",
                )

    def spacer_notices(self) -> Iterator[Notice]:
        """Yield a notice if spacers or their effect are not stated but may change the friction."""
        brake = self.brake
        fitted_factor, sheets = brake.amplification_held, brake.sheets
        factor = fan_factor(min(fan_exponent(brake), 50.0))
        ratio = factor / (fitted_factor or 1.0)
        if brake.mount.spacers is None and abs(ratio - 1) > FAN_EFFECT:
            size = f"{ratio:.3g} times" if ratio < 100 else "more than 100 times"
            yield Notice(
                f"{self.name} does not state whether its caps have spacers: without them "
                f"{sheets.count} sheets would hold {size} the computed friction, at a higher "
                "stress; write spacers = true or false in [mount]",
                "spacers-unstated",
            )
        fitted = brake.scale_factor != 1.0 and fitted_factor is None
        if brake.mount.spacers is not None and fitted and factor - 1 > FAN_EFFECT:
            yield Notice(
                f"scale_factor of {self.name} is assumed to include no "
                "self-amplification; if it was fitted on a brake without spacers, and "
                "spacers were not stated then, give that brake's amplification_held",
                "amplification-unstated",
            )


def list_changes(changes: Mapping[str, tuple[Any, Any]]) -> str:
    """Return the first three changes {path: (before, now)} as text, and how many more there are."""
    texts = [_describe_change(path, *ends) for path, ends in changes.items()]
    remainder = f" and {len(texts) - 3} more" if len(texts) > 3 else ""
    return f"{', '.join(texts[:3])}{remainder}"


def _describe_change(path: str, test_value: Any, current_value: Any) -> str:
    def text(value: Any) -> str:
        if value is None or isinstance(value, str | bool):
            return "not stated" if value is None else str(value).lower()
        spec = BrakeFile.fields[path].spec
        return show(value, spec.unit if isinstance(spec, QuantitySpec) else "1")

    return f"{path} was {text(test_value)}, is {text(current_value)}"


def materials() -> dict[str, dict[str, str]]:
    """Return {"films": {name: TOML text}, "silicones": ...} of the catalogue."""
    return {
        folder: shipped_files("layerjam.brake.device", "catalogue", folder)
        for folder in _USE.values()
    }


def load_film_cutting(use: str) -> tuple[FilmCutting, Mapping[str, Source]]:
    """Return the catalogue data for buying and cutting a film, and {dotted path: source}."""
    reader = Reader("", f"material {use}", BrakeFile.fields)
    _apply_material(reader, "film", use, materials()["films"])
    return reader.build_record(FilmCutting, "film."), reader.sources


def _apply_material(reader: Reader, table: str, use: object, texts: Mapping[str, str]) -> None:
    """Add values from the catalogue material that `use` names."""
    if not isinstance(use, str) or use not in texts:
        unknown = UnknownNameError(f"material for [{table}]", str(use), texts)
        raise reader.make_error(f"{table}.use", unknown)
    inner = Reader(texts[use], f"material {use}", reader.fields)
    material = parse_toml(texts[use], f"material {use}")
    inner.read_all({k: v for k, v in material.items() if k not in DESCRIBING}, table)
    reader.values |= {f"{table}.product": material["name"], **inner.values}
    reader.sources |= inner.sources


def _check_product(reader: Reader, table: str, use: str, texts: Mapping[str, str]) -> None:
    """Check that the file does not state the values of another material than the one it uses."""
    products = {parse_toml(text, name)["name"]: name for name, text in texts.items()}
    product = reader.values[f"{table}.product"]
    if products.get(product, use) != use:
        raise reader.make_error(
            f"{table}.use",
            QuantityError(
                f'{table}.use: "{use}" gives only values that the file does not state, and the '
                f"file states those of {product}: remove them, or the line with use"
            ),
        )


def _keep_laser_warning(
    reader: Reader, values: Mapping[str, Any], sources: Mapping[str, Source]
) -> None:
    """Store the catalogue's warning against lasers as `was` if the file overrides the warning."""
    choice = reader.values.get(_LASER)
    if values.get(_LASER) == "never" and choice != "never" and not reader.sources[_LASER].was:
        old_source = f"never: {sources[_LASER].text}"
        reader.sources[_LASER] = evolve(reader.sources[_LASER], was=old_source)


def _copy_screw_count(reader: Reader) -> None:
    """Copy the number of screws from [build] to [mount], unless [mount] states one."""
    if _DRAWN in reader.values:
        reader.values.setdefault(_SCREWS, reader.values[_DRAWN])
        reader.sources.setdefault(_SCREWS, reader.sources[_DRAWN])


def updated_text(
    file: BrakeFile,
    name: str,
    changes: Mapping[str, tuple[float, Source] | None],
    made_by: Mapping[str, Any] | None = None,
    verdict: Verdict | None = None,
    evidence: Evidence | None = None,
) -> str:
    """Return the file's text with a new name and some changed values; everything else is kept.

    `evidence` replaces that of the same command in [[tested]]. `made_by` becomes the descriptive
    table [made_by], to which the digest of the original file is added, unless the table states it.
    `verdict` is that of the measurement of the changed values.
    """
    check_tables(file.brake)
    if made_by is not None:
        made_by = {**made_by, "brake_sha256": made_by.get("brake_sha256", file.sha256)}
    edits: dict[str, tuple[Any, Source] | None] = dict(changes)
    held = file.brake.amplification_held is not None and "amplification_held" in file.sources
    if held and "scale_factor" in changes and file.brake.mount.spacers is None:
        edits["amplification_held"] = None  # the scale factor was fitted with the old value
    tables: dict[str, Any] = {"made_by": made_by}
    if evidence is not None:
        entries = replace_evidence(file.evidence, evidence)
        tables["tested"] = [entry.to_toml() for entry in entries]
    fields = file.all_fields(edits)
    return update_text(file.text, fields, edits, name=name, tables=tables, verdict=verdict)

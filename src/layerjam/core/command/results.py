"""Results of commands: frozen records whose fields are the keys of the contract."""

from __future__ import annotations

import contextlib
import json
import math
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import MISSING, Field, dataclass, field, fields, replace
from functools import cache
from inspect import get_annotations
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeVar, dataclass_transform

from layerjam.core import outputs
from layerjam.core.brief import shorten_group
from layerjam.core.command import description, wording
from layerjam.core.command.arguments import check_kind
from layerjam.core.command.description import Block, Lines, Remark, Rows, Section
from layerjam.core.command.documentation import list_members
from layerjam.core.command.known import KnownResult
from layerjam.core.drawing.folder import to_json
from layerjam.core.errors import (
    FileError,
    LayerjamError,
    MissingExtraError,
    Notice,
    UnknownNameError,
    make_notices,
)
from layerjam.core.outputs import ENDS, Figure, add_prefix, declare, fact, number
from layerjam.core.store import accept_force_option, store_file
from layerjam.core.verdict import Acceptance, Verdict, accepted_rows, list_failures, remaining

if TYPE_CHECKING:
    import pandas
    import xarray

    from layerjam.core.command.labels import Grid
    from layerjam.core.drawing.chart import Curve, Pane
    from layerjam.core.toml_files.changes import RecordFile

__all__ = ["Figure", "Judged", "Result", "add_prefix", "fact", "number", "result"]
T = TypeVar("T")
PICTURES = (".svg", ".png", ".pdf")
STOPPED = 130
"""Exit code of a command that was interrupted and returns a partial result."""
FAILED = 4
"""Exit code if a check failed and was not accepted."""
JUDGED = ("verdict", "failed_checks", "accepted")
"""Fields that `Result.create` copies from a Verdict by name."""


@dataclass_transform(
    kw_only_default=True, frozen_default=True, field_specifiers=(number, fact, field)
)
def result(cls: type[T]) -> type[T]:
    """Make a frozen, keyword-only record whose `number` and `fact` fields are keys of the JSON."""
    return dataclass(frozen=True, kw_only=True, repr=False, eq=False)(declare(cls))


@result
class Result:
    """Base of all results.

    `warnings` are sentences, each with a key (`Notice`). `record` contains the arrays or the fit
    behind the numbers, if any. `verdict` is `passed`, `failed`, `accepted`, or None if no check
    judged the numbers; `failed_checks` has rows of `name` and `reason`, `accepted` rows of `check`,
    `reason`, `date` and `file`. `new_verdict` is the Verdict on the numbers computed here, if any.
    """

    command: ClassVar[str] = ""
    warnings: Sequence[Notice] = ()
    record: object = None
    verdict: str | None = None
    failed_checks: Sequence[Mapping[str, str]] = ()
    accepted: Sequence[Mapping[str, Any]] = ()
    new_verdict: Verdict | None = None
    grid: Grid | None = None
    """Array arguments of the computation; None if all were single numbers."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "record", shorten_group(self.record))
        object.__setattr__(self, "warnings", make_notices(dict.fromkeys(self.warnings)))

    @classmethod
    def create(cls, *known: object, **given: Any) -> Self:
        """Return a result with the values `given`; other keys are taken from `known` by name.

        Each of `known` is a record, a mapping, `add_prefix(...)`, or None; the first that has the
        name is used. A float that is not finite becomes None (unknown), as does an optional value
        that no source has. Raises TypeError for a key without value or default.
        """
        for f in cls.keys():  # noqa: SIM118
            value = outputs.look_up(f.name, (given, *known))
            if value is not MISSING:
                lost = isinstance(value, float) and not math.isfinite(value)
                given[f.name] = None if lost else value
            elif f.default is MISSING and "None" in str(f.type):
                given[f.name] = None
        for source in known:
            if isinstance(source, Verdict) and (source.checks or source.decisions):
                given |= {name: getattr(source, name) for name in JUDGED}
                given["new_verdict"] = source
                if issubclass(cls, Judged):
                    given["checks"] = to_json(source.checks)
                given["warnings"] = [*given.get("warnings", ()), *source.notices()]
        return cls(**given)

    def require(self) -> Self:
        """Return the same result with the guarantee that no number is None.

        Raises NotKnownError with the reason if the result is infeasible, or later if an unknown
        number is read.
        """
        return KnownResult(self)  # type: ignore[return-value]

    @property
    def values(self) -> dict[str, Any]:
        """Return {key of the contract: value in SI}."""
        return {outputs.field_key(f): getattr(self, f.name) for f in self.keys()}

    @property
    def units(self) -> dict[str, str]:
        """Return {key: SI unit} of every quantity."""
        units = {f.name: f.metadata["quantity"].unit for f in self.keys() if f.metadata["quantity"]}
        return {**self.table_units(), **units}

    @classmethod
    def table_units(cls) -> Mapping[str, str]:
        """Return {key: SI unit} of the result's tables, if it has any."""
        return {}

    @property
    def synthetic(self) -> bool:
        """Whether it is based on files that a program generated."""
        return any(getattr(w, "key", "") == "synthetic" for w in self.warnings)

    @property
    def exit_code(self) -> int:
        """Exit code: 4 if a check failed, 1 if the result is negative, 3 if files were rejected."""
        if self.failed_checks:
            return FAILED
        feasible = getattr(self, "feasible", None)
        if feasible is False or not getattr(feasible, "all", lambda: True)():
            return 1
        return 3 if getattr(self, "refused", None) else 0

    @classmethod
    @cache
    def keys(cls) -> tuple[Field[Any], ...]:
        """Return the fields that are keys of the contract.

        Fields of base records that are not results come first, then the class's own, then those of
        base results. A key that the class declares again takes its new position.
        """
        key_fields = {f.name: f for f in fields(cls) if "result" in f.metadata}
        latest = get_annotations(cls)
        bases = sorted(cls.__mro__, key=lambda base: issubclass(base, Result))
        names = [
            n for base in bases for n in get_annotations(base) if base is cls or n not in latest
        ]
        return tuple(key_fields[name] for name in dict.fromkeys(names) if name in key_fields)

    def lines(self) -> Iterable[str]:
        """Yield the lines of text under the table."""
        return ()

    def check_lines(self) -> Iterable[str]:
        """Return the checks of the numbers as lines of text."""
        return ()

    def panes(self) -> Sequence[Pane]:
        """Return the panes of its figure, for commands whose figure the page also draws."""
        raise LayerjamError(f"{self.command or type(self).__name__} has no curve to draw")

    def draw(self) -> Figure:
        """Return the figure of this result."""
        return self.draw_panes(self.panes())

    def draw_panes(self, panes: Sequence[Pane]) -> Figure:
        """Return the figure of its `panes`, possibly with added curves."""
        from layerjam.core.drawing.chart import draw_panes

        return draw_panes(panes)

    @classmethod
    def is_drawable(cls) -> bool:
        """Return whether this kind of result has a figure."""
        return (cls.draw, cls.panes) != (Result.draw, Result.panes)

    @property
    def has_curve(self) -> bool:
        """Return whether this result has anything to draw."""
        return self.record is not None

    def overlay_curves(self) -> Sequence[Curve]:
        """Return its main curve in each pane; none if results of this command are not overlaid."""
        described = type(self).panes is not Result.panes and self.has_curve
        return [pane.curves[0] for pane in self.panes()] if described else ()

    curve_kind = ""
    """Kind of its curves; a result may accept those of its kind from other commands."""

    @classmethod
    def can_overlay(cls, kind: type[Result]) -> bool:
        """Return whether curves of a different kind of result can be added to those of this one."""
        return kind is cls

    @accept_force_option
    def plot(
        self,
        path: str | Path | None = None,
        *,
        ax: Any = None,
        overwrite: bool = False,
        beside: Mapping[str, Result] | None = None,
    ) -> Figure:
        """Return the figure, and write it to `path` (.svg, .png or .pdf) if one is given.

        It is drawn into `ax`, Matplotlib axes or a list or array with as many axes as the figure
        has; if None, failed checks are stated below it. `beside` maps labels to other results of
        the command, drawn as faint curves; a `tensile` also accepts those of `pull`, drawn as
        points. Raises FileError if the file exists unless `overwrite`, and LayerjamError for
        results that have no such curve.
        """
        from layerjam.core.drawing import chart
        from layerjam.core.drawing.style import add_failures, draw_into, save, show_in_notebooks

        check_kind(path, str | Path | None, "path")
        check_kind(beside, Mapping[str, Result] | None, "beside")
        quiet = {label: item.overlay_curves() for label, item in (beside or {}).items()}
        for label, curves in quiet.items():
            if not curves or not self.can_overlay(type((beside or {})[label])):
                raise LayerjamError(f"{label}: has no curve to compare with this one")
        with contextlib.nullcontext() if ax is None else draw_into(ax):
            panes = chart.add_comparisons(self.panes(), quiet) if quiet else None
            figure = self.draw() if panes is None else self.draw_panes(panes)
        if ax is None:
            show_in_notebooks(figure)
            add_failures(figure, list_failures(self, *(beside or {}).values()))
        if path is not None:
            save(figure, Path(path), overwrite)
        return figure

    def to_frame(self) -> pandas.DataFrame:
        """Return the record's columns as a data frame in SI, or one row with the numbers."""
        if hasattr(self.record, "to_frame"):
            data_frame: pandas.DataFrame = self.record.to_frame()
            return data_frame
        import pandas

        numbers = self._numeric_values()
        if self.grid is not None:
            frame, units = self.grid.to_frame(numbers), {**self.grid.units, **self.units}
        else:
            row_numbers = {k: float("nan") if v is None else v for k, v in numbers.items()}
            frame, units = pandas.DataFrame([row_numbers]), self.units
        frame.attrs["units"] = units
        return frame

    def _numeric_values(self) -> dict[str, Any]:
        """Return the quantities of the result and, for an array result, its flags."""
        return {
            f.name: value
            for f in self.keys()
            if (value := getattr(self, f.name)) is None
            or not isinstance(value, Mapping | list | tuple | str)
            if f.metadata["quantity"] or hasattr(value, "dtype")
        }

    def to_xarray(self) -> xarray.Dataset:
        """Return the record with its units as a Dataset, or the numbers of the result."""
        if hasattr(self.record, "to_xarray"):
            dataset: xarray.Dataset = self.record.to_xarray()
            return dataset
        if self.grid is not None:
            return self.grid.to_xarray(self._numeric_values(), self.units)
        with MissingExtraError.raise_if_missing("a labelled result (xarray)", "labelled"):
            import xarray
        data = xarray.Dataset.from_dataframe(self.to_frame())
        for name in data.data_vars:
            data[name].attrs["units"] = self.units[str(name)]
        return data

    @accept_force_option
    def save(self, path: str | Path, *, overwrite: bool = False) -> Path:
        """Write the result: .json, a figure (.svg, .png, .pdf), or the record (.csv, .nc, .toml).

        Raises FileError if the file exists unless `overwrite`, or if the extension is unknown.
        """
        check_kind(path, str | Path, "path")
        path = Path(path)
        ending = path.suffix.lower()
        if ending == ".json":
            return store_file(path, self.json() + "\n", overwrite)
        if ending in PICTURES and self.is_drawable():
            self.plot(path, overwrite=overwrite)
            return path
        if hasattr(content := self.content(), "save"):
            target: Path = content.save(path, overwrite=overwrite)
            return target
        endings = [".json", *(PICTURES if self.is_drawable() else ())]
        raise FileError(path, f"extension '{path.suffix}' is unknown; use {', '.join(endings)}")

    def content(self) -> object:
        """Return the object that `save` writes, such as a record of curves or a brake file."""
        return self.record

    def json(self) -> str:
        """Return the JSON of the command line's contract."""
        document = {
            **self.values,
            **(self.judgement if self.verdict is not None else {}),
            "units": self.units,
            "warnings": list(map(str, self.warnings)),
        }
        return json.dumps(to_json(document), indent=2, allow_nan=False)

    @property
    def judgement(self) -> dict[str, Any]:
        """Return the verdict with its failed and accepted checks, in the form of the JSON."""
        return {
            "verdict": self.verdict,
            "failed_checks": list(self.failed_checks),
            "accepted": list(self.accepted),
        }

    def interval(self, name: str) -> tuple[float | None, float | None]:
        """Return the 95 % interval of a number, if it has one; None marks an open or unknown end.

        Raises UnknownNameError for a number without an interval.
        """
        if not hasattr(self, f"{name}_{ENDS[0]}"):
            names = [f.name for f in self.keys() if f.metadata["interval"]]
            raise UnknownNameError("number with an interval", name, names)
        low, high = (getattr(self, f"{name}_{end}") for end in ENDS)
        return low, high

    def find_interval(self, f: Field[Any]) -> tuple[float | None, float | None]:
        """Return the interval of a field to print with its number; None marks an open end."""
        return self.interval(f.name) if f.metadata["interval"] else (None, None)

    def with_notices(self, *notices: Notice) -> Self:
        """Return the same result with more warnings."""
        return replace(self, warnings=[*self.warnings, *notices]) if notices else self

    def with_grid(self, grid: Grid | None) -> Self:
        """Return the result with the grid of its array arguments, labelled if they are."""
        if grid is None:
            return self
        labels = grid.label_values(self._numeric_values(), self.units) if grid.labelled else {}
        return replace(self, grid=grid, **labels)

    def with_verdicts(self, files: Iterable[RecordFile[Any]]) -> Self:
        """Return the result with the verdicts of the files from which it was computed."""
        verdicts: list[str | None] = []
        decisions: list[Acceptance] = []
        for file in files:
            verdicts.append(file.verdict)
            decisions += remaining(file.accepted, self.new_verdict)
        verdicts_seen = {self.verdict, *verdicts} - {None}
        if not verdicts_seen:
            return self
        acceptances = [*self.accepted, *accepted_rows(dict.fromkeys(decisions))]
        verdict = "failed" if self.failed_checks else "accepted" if acceptances else "passed"
        noted = self.with_notices(*dict.fromkeys(decision.notice() for decision in decisions))
        return replace(noted, verdict=verdict, accepted=acceptances)

    of, noting, over, judged_by = create, with_notices, with_grid, with_verdicts  # former names

    def rows(self) -> list[tuple[str, str]]:
        """Return (name, text) of each row, without unknown numbers."""
        pairs = []
        for f in self.keys():
            value, show_text = getattr(self, f.name), f.metadata["shown"]
            if value is None or not f.metadata["listed"]:
                continue
            if self.grid is not None and getattr(value, "shape", None):
                continue  # it is one column of the table
            spec = f.metadata["quantity"]
            unit = spec.unit if spec else ""
            text = show_text(value) if show_text else wording.format_words(value, unit)
            text += wording.format_interval(self.find_interval(f), unit, value)
            if text:
                pairs.append((outputs.field_key(f).replace("_", " "), text))
        return pairs

    def describe(self) -> Iterator[Block]:
        """Yield the printed parts: table, further lines, rejected files, failed checks, notes."""
        rows = self.rows()
        yield Rows(rows)
        if self.grid is not None:
            grid_lines = self.grid.lines(self._numeric_values(), self.units)
            yield Lines([*([""] if rows else []), *grid_lines], is_fixed=True)
        yield Lines([*self.lines(), *self.check_lines()])
        yield Section("read:", [*wording.format_readings(getattr(self, "understood", ()))])
        refused: Mapping[str, str] = getattr(self, "refused", None) or {}
        yield Section("refused:", [f"{path}: {text}" for path, text in refused.items()])
        for failed_row in self.failed_checks:
            # the checks already state the reason
            reason = "" if isinstance(self, Judged) else f": {failed_row['reason']}"
            yield Remark("FAILED: ", f"{failed_row['name']}{reason}")
        if self.failed_checks:
            name = self.failed_checks[0]["name"]
            advice = f'nothing was written; to use the numbers anyway: --accept "{name}=REASON"'
            yield Remark("", advice)
        for warning in self.warnings:
            yield Remark("note: ", warning)

    def table(self, width: int = 80) -> str:
        """Return the text of the command line."""
        return description.format_text(self.describe(), width)

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self.json() == other.json()  # type: ignore[attr-defined]

    def __hash__(self) -> int:
        return hash((type(self), self.json()))

    def __str__(self) -> str:
        return self.table(min(shutil.get_terminal_size((80, 24)).columns, 100))

    def __repr__(self) -> str:
        return self.table(100)

    def __dir__(self) -> list[str]:
        return list_members(super().__dir__(), Result)

    def _repr_html_(self) -> str:
        return description.format_html(self.describe())


MARKS = {"passed": "ok  ", "note": "note", "warning": "LOOK", "failed": "FAIL"}


@result
class Judged(Result):
    """A result whose numbers were checked; `checks` has rows of `name`, `level` and `sentence`."""

    checks: Sequence[Mapping[str, Any]] = fact("checks of the numbers", default=(), listed=False)

    def check_lines(self) -> Iterator[str]:
        """Return one line per check."""
        if self.checks:
            yield from ("", "checks")
        for row in self.checks:
            yield f"  {MARKS[row['level']]}  {row['name']}: {row['sentence']}"

"""Conversion of a design request into a specification, with the files it names and all designs."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import catalogue, load, materials
from layerjam.brake.device.sheets import Film
from layerjam.brake.device.workshop import FilmCutting
from layerjam.brake.fluid.line_file import LineFile, lines, load_line
from layerjam.core.errors import QuantityError, UnknownNameError
from layerjam.core.evolve import evolve
from layerjam.core.toml_files.reader import DESCRIBING, Reader
from layerjam.core.toml_files.shipped import load_text, shipped_files
from layerjam.core.toml_files.toml import parse_toml
from layerjam.core.toml_files.values import entries
from layerjam.core.units import show
from layerjam.workshop.design.grid import AXES, Array, Evaluation, Grid
from layerjam.workshop.design.merit import (
    LINE_MERITS,
    STOP_MERITS,
    VARIABLES,
    Stock,
    line_table,
    make_point,
    make_stock,
)
from layerjam.workshop.design.request import DesignRequest, Range, open_reader, read_request
from layerjam.workshop.design.requirements import (
    Constraint,
    DesignSpecification,
    Objective,
)
from layerjam.workshop.design.stopping import StopRequirement

MOST_DESIGNS = 10**12
F = TypeVar("F", bound=BrakeFile | LineFile)


def example_texts() -> dict[str, str]:
    """Return {name: TOML text} of the specifications in the package."""
    return shipped_files("layerjam.workshop.design", "examples")


def load_spec(spec: str | Path) -> DesignSpecification:
    """Return a specification by example name or path; raises FileError or UnknownNameError."""
    return read_spec(*load_text("specification", spec, example_texts()))


def read_spec(
    text: str, path: object, records: Mapping[str, BrakeFile | LineFile] | None = None
) -> DesignSpecification:
    """Return a specification from TOML text; raises FileError with file and line.

    With `records`, no file is opened: names refer to these records or to the catalogue.
    """
    reader = open_reader(text, path)
    request = read_request(reader)
    with reader.locate_errors():
        return make_specification(request, FileFinder(Path(str(path)).parent, records), text)


@dataclass(frozen=True)
class FileFinder:
    """Finder of brakes and lines by catalogue name, or by a path relative to a folder.

    With `records`, no file is opened: names refer to these records or to the catalogue.
    """

    folder: Path = Path()
    records: Mapping[str, BrakeFile | LineFile] | None = None

    def brake(self, name: str, quantity: str = "brake") -> BrakeFile:
        """Return the brake with this name; an UnknownNameError quotes `quantity`."""
        return self._find(name, quantity, load, catalogue(), BrakeFile)

    def line(self, name: str) -> LineFile:
        """Return the vacuum line with this name."""
        return self._find(name, "line", load_line, lines(), LineFile)

    def _find(
        self,
        name: str,
        quantity: str,
        reader: Callable[[str | Path], F],
        names: Sequence[str],
        kind: type[F],
    ) -> F:
        records = self.records
        if records is not None:
            record = records.get(name)
            if isinstance(record, kind):
                return record
            if name not in names:
                word = "line" if quantity == "line" else "brake"
                raise UnknownNameError(word, name, [*records, *names], quantity=name)
            return reader(name)
        path = self.folder / name
        try:
            return reader(path if name.endswith(".toml") and path.is_file() else name)
        except UnknownNameError as err:
            err.quantity = quantity
            raise


def make_specification(
    request: DesignRequest, finder: FileFinder | None = None, text: str | None = None
) -> DesignSpecification:
    """Return the specification of a request, with every file it names read.

    Raises QuantityError or UnknownNameError for a part of the request, FileError for a file.
    """
    finder = finder or FileFinder()
    file, line = finder.brake(request.brake), None
    notes: list[str] = []
    if request.line is not None:
        line = finder.line(request.line)
        notes += _closed_form_notice(line)
    if request.atmosphere is not None:
        file = evolve(file, brake=file.brake.with_(atmosphere=request.atmosphere))
        if line is not None:
            site = evolve(line.line.site, atmosphere=request.atmosphere)
            line = evolve(line, line=evolve(line.line, site=site))
    if line is not None and line.line.site.atmosphere != file.brake.site.atmosphere:
        raise QuantityError(
            f"atmosphere: differs between {line.name} and {file.name}", quantity="line"
        )
    films, origins = _make_films(request, finder, file, notes)
    grid = _make_grid(request, file, films)
    evaluation = Evaluation(
        base=file.brake,
        stick_slip=request.judder,
        stop=request.stop,
        line=None if line is None else line_table(grid.axes["vacuum"], line.line),
    )
    _check_inputs([*request.constraints, *request.objectives], evaluation)
    return DesignSpecification(
        name=request.name,
        brake=file,
        line=line,
        grid=grid,
        evaluation=evaluation,
        constraints=request.constraints + _stop_constraints(request.stop),
        objectives=request.objectives,
        scatter=request.scatter,
        films=origins,
        text=request.text() if text is None else text,
        notes=tuple(notes),
        without=request.without,
    )


def _closed_form_notice(file: LineFile) -> list[str]:
    line = file.line
    is_approximate = line.tube is not None or line.leak.orifice or line.polytropic != 1
    if not is_approximate and not line.chamber.shrink:
        return []
    return [
        f"rise_time on {file.name} is that of a rigid chamber at constant "
        "temperature: the line's tube, orifice leak and shrinkage are ignored"
    ]


def _stop_constraints(stop: StopRequirement | None) -> tuple[Constraint, ...]:
    if stop is None:
        return ()
    slip = () if stop.travel is None else (Constraint("stop_slip", True, stop.travel),)
    peak = () if stop.force is None else (Constraint("stop_peak", True, stop.force),)
    # even without limits, the mass must come to rest
    return (*slip, *peak) or (Constraint("stop_slip", True, 1e9),)


def _check_inputs(requirements: Iterable[Constraint | Objective], evaluation: Evaluation) -> None:
    """Raise QuantityError if a merit needs an input that the request lacks."""
    inputs = {**dict.fromkeys(LINE_MERITS, "a line"), **dict.fromkeys(STOP_MERITS, "a [stop]")}
    inputs["judder_margin"] = "a [judder]"
    for requirement in requirements:
        if requirement.name in inputs and requirement.name not in evaluation.all_names:
            kind = "constraint" if isinstance(requirement, Constraint) else "objective"
            reason = f"{kind} '{requirement}' needs {inputs[requirement.name]} in the specification"
            raise QuantityError(reason, quantity=requirement.name)


# ---- variables


def _make_grid(request: DesignRequest, file: BrakeFile, films: "_Films") -> Grid:
    start = make_point(file.brake)
    axes, ranges = {}, {}
    for name in AXES:
        axis = request.vary.get(name)
        if isinstance(axis, Range):
            axes[name] = axis.values()
            if not VARIABLES[name].whole and axis.last > axis.first:
                ranges[name] = (axis.first, axis.last)
        elif axis is not None:
            axes[name] = np.sort(np.array(axis, float))
        elif name != "usable_travel":
            axes[name] = np.array([float(getattr(start, name))])
    stock, names, thickness = films
    build = file.making.build
    grid = Grid(stock, names, thickness, axes, ranges, build.fittings_length, build.gap)
    if grid.size > MOST_DESIGNS:
        raise QuantityError(
            f"{grid.size:.3g} designs; at most {MOST_DESIGNS:.0e} are allowed", quantity="vary"
        )
    high, atmosphere = float(axes["vacuum"].max()), file.brake.site.atmosphere
    if high > atmosphere * (1 + 1e-12):
        raise QuantityError.of(
            "vary.vacuum",
            f"{show(high, 'Pa', 6)} exceeds atmospheric pressure, {show(atmosphere, 'Pa', 6)}",
        )
    return grid


_Films = tuple[Stock, tuple[str, ...], Array]
"""(film, name, a thickness in which it is sold) for each row of the grid's first axis."""


def _make_films(
    request: DesignRequest, finder: FileFinder, file: BrakeFile, notes: list[str]
) -> tuple[_Films, dict[str, BrakeFile]]:
    """Return the films with the thicknesses in which they are sold, and the brakes they come from.

    The default thickness is the brake's own.
    """
    axis = request.vary.get("thickness")
    default = (file.brake.sheets.thickness,) if axis is None else axis
    default = tuple(default.values()) if isinstance(default, Range) else default
    origins: dict[str, BrakeFile] = {} if request.film else {file.name: file}
    films = [
        (
            choice.use,
            _read_film(choice.use, finder, file, notes, origins),
            choice.thickness or default,
        )
        for choice in request.film
    ] or [(file.name, _make_stock(file), default)]
    rows = [(name, stock, thickness) for name, stock, values in films for thickness in values]
    if len({name for name, _, _ in films}) < len(films):
        raise QuantityError.of("film", "a film is listed twice")
    columns = zip(*(stock for _, stock, _ in rows), strict=True)
    stock = Stock(*(np.array(column, float) for column in columns))
    thickness = np.array([thickness for *_, thickness in rows], float)
    return (stock, tuple(name for name, *_ in rows), thickness), origins


def _make_stock(file: BrakeFile) -> Stock:
    brake = file.brake
    return make_stock(brake.film, brake.scale_factor, brake.amplification_held)


def _read_film(
    use: str,
    finder: FileFinder,
    file: BrakeFile,
    notes: list[str],
    origins: dict[str, BrakeFile],
) -> Stock:
    """Return a film from a brake (with friction and scale factor) or from the catalogue (a = 1).

    A brake is added to `origins`.
    """
    films = materials()["films"]
    if use in catalogue() or use.endswith(".toml"):
        source = finder.brake(use, use)
        brake = source.brake
        if brake.effects != file.brake.effects:
            raise QuantityError(
                f"{use} and {file.name} have different [effects]; films must share one law",
                quantity=use,
            )
        if brake.pressure_exponent != file.brake.pressure_exponent:
            raise QuantityError(
                f"{use} and {file.name} have different pressure_exponent values; films "
                "must share one law",
                quantity=use,
            )
        origins[use] = source
        return _make_stock(source)
    if use not in films:
        raise UnknownNameError("film", use, [*films, *catalogue()], quantity=use)
    keys = {**dict(entries(Film)), **dict(entries(FilmCutting))}
    reader = Reader(films[use], f"film {use}", keys)
    reader.read_all({k: v for k, v in parse_toml(films[use], use).items() if k not in DESCRIBING})
    reader.check_required()
    notes.append(f"{use}: handbook friction and a scale factor of 1, not measured on a brake")
    return make_stock(reader.build_record(Film))

"""From what is asked of a design to its specification: the files it names, and all its designs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from layerjam.design.grid import AXES, Array, Evaluation, Grid
from layerjam.design.merit import (
    LINE_MERITS,
    STOP_MERITS,
    VARIABLES,
    Stock,
    line_table,
    point_of,
    stock_of,
)
from layerjam.design.request import DesignRequest, Range, read_request, reader_of
from layerjam.design.requirements import Constraint, DesignSpecification, Objective, Scatter
from layerjam.design.stopping import StopRequirement
from layerjam.device.file import BrakeFile
from layerjam.device.load import catalogue, load, materials
from layerjam.device.sheets import Film
from layerjam.device.workshop import FilmCutting
from layerjam.errors import QuantityError, UnknownNameError
from layerjam.fluid.file import LineFile, lines, load_line
from layerjam.records.reader import DESCRIBING, Reader
from layerjam.records.shipped import shipped, text_of
from layerjam.records.toml import parse_toml
from layerjam.records.values import entries
from layerjam.units import show

MOST_DESIGNS = 10**12
F = TypeVar("F", bound=BrakeFile | LineFile)


def examples() -> dict[str, str]:
    """{name: TOML text} of the specifications that come with the program."""
    return shipped("layerjam.design", "examples")


def load_spec(spec: str | Path) -> DesignSpecification:
    """A specification by the name of an example or the path of its file.

    Raises FileError, or UnknownNameError with the nearest names.
    """
    return read_spec(*text_of("specification", spec, examples()))


def read_spec(
    text: str, path: object, beside: Mapping[str, BrakeFile | LineFile] | None = None
) -> DesignSpecification:
    """A specification from TOML text; raises FileError with file and line.

    With `beside` no file is opened: what the text names is one of these, or in the catalogue.
    """
    reader = reader_of(text, path)
    request = read_request(reader)
    with reader.locate_errors():
        return specification(request, Named(Path(str(path)).parent, beside), text)


@dataclass(frozen=True)
class Named:
    """Finds brakes and lines by catalogue name, or by a path from a folder.

    With `beside` no file is opened: a name is one of these, or in the catalogue.
    """

    folder: Path = Path()
    beside: Mapping[str, BrakeFile | LineFile] | None = None

    def brake(self, name: str, quantity: str = "brake") -> BrakeFile:
        """The brake of this name; UnknownNameError about `quantity` where there is none."""
        return self._find(name, quantity, load, catalogue(), BrakeFile)

    def line(self, name: str) -> LineFile:
        """The vacuum line of this name."""
        return self._find(name, "line", load_line, lines(), LineFile)

    def _find(
        self,
        name: str,
        quantity: str,
        reader: Callable[[str | Path], F],
        known: Sequence[str],
        kind: type[F],
    ) -> F:
        beside = self.beside
        if beside is not None:
            given = beside.get(name)
            if isinstance(given, kind):
                return given
            if name not in known:
                what = "line" if quantity == "line" else "brake"
                raise UnknownNameError(what, name, [*beside, *known], quantity=name)
            return reader(name)
        near = self.folder / name
        try:
            return reader(near if name.endswith(".toml") and near.is_file() else name)
        except UnknownNameError as err:
            err.quantity = quantity
            raise


def specification(
    request: DesignRequest, named: Named | None = None, text: str | None = None
) -> DesignSpecification:
    """The specification of a request, every file it names read.

    Raises QuantityError or UnknownNameError about a part of the request, FileError for a file.
    """
    named = named or Named()
    file, line = named.brake(request.brake), None
    notes: list[str] = []
    if request.line is not None:
        line = named.line(request.line)
        notes += _roughly(line)
    if request.atmosphere is not None:
        file = replace(file, brake=file.brake.with_(atmosphere=request.atmosphere))
        if line is not None:
            site = replace(line.line.site, atmosphere=request.atmosphere)
            line = replace(line, line=replace(line.line, site=site))
    if line is not None and line.line.site.atmosphere != file.brake.site.atmosphere:
        raise QuantityError(
            f"atmosphere: not the same in {line.name} and {file.name}", quantity="line"
        )
    films = _films(request, named, file, notes)
    grid = _grid(request, file, films)
    evaluation = Evaluation(
        base=file.brake,
        stick_slip=request.judder,
        stop=request.stop,
        line=None if line is None else line_table(grid.axes["vacuum"], line.line),
    )
    _check_known([*request.constraints, *request.objectives], evaluation)
    return DesignSpecification(
        name=request.name,
        brake=file,
        line=line,
        grid=grid,
        evaluation=evaluation,
        constraints=request.constraints + _of_stop(request.stop),
        objectives=request.objectives,
        scatter=_scatter(request, file),
        text=request.text() if text is None else text,
        notes=tuple(notes),
        without=request.without,
    )


def _roughly(file: LineFile) -> list[str]:
    """What the closed forms leave out of a line."""
    line = file.line
    rough = line.tube is not None or line.leak.orifice or line.polytropic != 1
    if not rough and not line.chamber.shrink:
        return []
    return [
        f"rise_time on {file.name} by the closed form of a rigid chamber at one temperature: its "
        "tube, orifice leak and shrinking are left out"
    ]


def _of_stop(stop: StopRequirement | None) -> tuple[Constraint, ...]:
    if stop is None:
        return ()
    slip = () if stop.travel is None else (Constraint("stop_slip", True, stop.travel),)
    peak = () if stop.force is None else (Constraint("stop_peak", True, stop.force),)
    # a stop without limits must still be one
    return (*slip, *peak) or (Constraint("stop_slip", True, 1e9),)


def _scatter(request: DesignRequest, file: BrakeFile) -> Scatter | None:
    """The scatter asked for, else what the sources of the brake's friction state."""
    given = {} if request.scatter is None else vars(request.scatter).copy()
    stated = {n: file.sources[p].sd for n in _FRICTION if (p := f"film.{n}") in file.sources}
    own = {n: sd for n in _FRICTION if (sd := given.pop(n, None)) is not None}
    sd = {n: v for n, v in {**stated, **own}.items() if v is not None}
    if not sd:
        return None
    source = "the specification" if own else f"the spread that {file.name} states for its friction"
    return Scatter(sd.get("static", 0.0), sd.get("kinetic", 0.0), source, **given)


_FRICTION = ("static", "kinetic")


def _check_known(wanted: Iterable[Constraint | Objective], evaluation: Evaluation) -> None:
    """Raise QuantityError for a merit that needs more than the request says."""
    due = {**dict.fromkeys(LINE_MERITS, "a line"), **dict.fromkeys(STOP_MERITS, "a [stop]")}
    due["judder_margin"] = "a [judder]"
    for one in wanted:
        if one.name in due and one.name not in evaluation.all_names:
            kind = "constraint" if isinstance(one, Constraint) else "objective"
            reason = f"{kind} '{one}' needs {due[one.name]} in the specification"
            raise QuantityError(reason, quantity=one.name)


# ---- what is varied


def _grid(request: DesignRequest, file: BrakeFile, films: _Films) -> Grid:
    start = point_of(file.brake)
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
    grid = Grid(stock, names, thickness, axes, ranges)
    if grid.size > MOST_DESIGNS:
        raise QuantityError(
            f"{grid.size:.3g} designs are too many; {MOST_DESIGNS:.0e} go", quantity="vary"
        )
    high, most = float(axes["vacuum"].max()), file.brake.site.atmosphere
    if high > most * (1 + 1e-12):
        raise QuantityError.of(
            "vary.vacuum",
            f"{show(high, 'Pa', 6)} is more than the atmosphere, {show(most, 'Pa', 6)}",
        )
    return grid


_Films = tuple[Stock, tuple[str, ...], Array]
"""Rows of the grid's first axis: film, its name, a thickness it is sold in."""


def _films(request: DesignRequest, named: Named, file: BrakeFile, notes: list[str]) -> _Films:
    """Films, each with the thicknesses it is sold in; without any the brake's own."""
    varied = request.vary.get("thickness")
    usual = (file.brake.sheets.thickness,) if varied is None else varied
    usual = tuple(usual.values()) if isinstance(usual, Range) else usual
    made = [
        (choice.use, _film(choice.use, named, file, notes), choice.thickness or usual)
        for choice in request.film
    ] or [(file.name, _stock(file), usual)]
    rows = [(name, stock, thickness) for name, stock, each in made for thickness in each]
    if len({name for name, _, _ in made}) < len(made):
        raise QuantityError.of("film", "a film stands twice")
    columns = zip(*(stock for _, stock, _ in rows), strict=True)
    stock = Stock(*(np.array(column, float) for column in columns))
    thickness = np.array([thickness for *_, thickness in rows], float)
    return stock, tuple(name for name, *_ in rows), thickness


def _stock(file: BrakeFile) -> Stock:
    brake = file.brake
    return stock_of(brake.film, brake.scale_factor, brake.amplification_held)


def _film(use: str, named: Named, file: BrakeFile, notes: list[str]) -> Stock:
    """Film by brake (its friction and scale factor) or by name in the catalogue (a = 1)."""
    films = materials()["films"]
    if use in catalogue() or use.endswith(".toml"):
        known = named.brake(use, use)
        other = known.brake
        if other.pressure_exponent != file.brake.pressure_exponent:
            raise QuantityError(
                f"{use} has another pressure_exponent than {file.name}; films are compared under "
                "one law",
                quantity=use,
            )
        return _stock(known)
    if use not in films:
        raise UnknownNameError("film", use, [*films, *catalogue()], quantity=use)
    keys = {**dict(entries(Film)), **dict(entries(FilmCutting))}
    reader = Reader(films[use], f"film {use}", keys)
    reader.take({k: v for k, v in parse_toml(films[use], use).items() if k not in DESCRIBING})
    reader.require()
    notes.append(f"{use}: handbook friction and a scale factor of 1, not measured on a brake")
    return stock_of(reader.record(Film))

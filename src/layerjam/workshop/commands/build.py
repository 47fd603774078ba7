"""`build`: from a brake file to everything that a workshop needs to build the brake."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from layerjam._version import __version__
from layerjam.brake.commands.arguments import Accept, BrakeInput, Overwrite
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.workshop import CUTTERS, Build, SizeSpec
from layerjam.core.command.declare import REGISTRY, Help, Input, Progress, command
from layerjam.core.command.results import Result, fact, number, result
from layerjam.core.errors import Notice, QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.installation import install_command
from layerjam.core.units import get_spec, show
from layerjam.core.verdict import judge, to_key
from layerjam.workshop.commands.array import PARALLEL, SERIES

if TYPE_CHECKING:
    from layerjam.workshop.fabricate.choices import Choices
    from layerjam.workshop.fabricate.drawing import Drawing

BRAKES_LIMIT = 100
"""Largest number of brakes in one build."""
MARKS = {"passed": "ok  ", "warning": "LOOK", "failed": "FAIL"}
"""Symbol for the level of a check, at the start of its line."""


def _size(sides: int, name: str) -> Callable[[Any, Mapping[str, Any]], Size]:
    """Return a function that parses lengths such as "600x400mm", or SI numbers."""
    spec = SizeSpec("", sides)

    def convert(value: str | Collection[float], arguments: Mapping[str, Any]) -> Size:
        return spec.read(value, name) if isinstance(value, str) else spec.check(tuple(value), name)

    return convert


Size = tuple[float, ...] | None
"""Lengths [m] from text such as "600x400mm" or from SI numbers; a single word on the command line.
"""


def _mass_list(masses: Mapping[str, float] | None) -> str:
    return ", ".join(f"{k} {show(v, 'kg')}" for k, v in (masses or {}).items())


@result
class Built(Result):
    """Files written, or the reason why the brake cannot be built; `record` is the drawing.

    `checks` are rows of code, ok (null: not checked, or it does not apply), level, value, limit,
    unit, text and key.
    """

    record: Drawing | None = None
    feasible: bool = fact("whether the brake can be drawn and every failed check was accepted")
    reason: str | None = fact("reason if it is not feasible")
    files: Sequence[str] = fact(
        "files in the folder", shown=lambda found: f"{len(found)} in the folder" if found else ""
    )
    brakes: int = number("1", "total number of brakes")
    mass: float | None = number("kg", "mass of the parts as drawn, except those of unknown mass")
    fittings_mass: float | None = number("kg", "part of that mass, without sheets and enclosure")
    pin_to_pin: float | None = number("m", "distance between the pins at rest")
    overall_length: float | None = number("m", "overall length at rest, including both heads")
    sleeve_length: float | None = number("m", "trimmed length of the enclosure")
    strap_length: float | None = number("m", "distance between the pins at the end of the travel")
    film_pieces: int | None = number("1", "pieces of film")
    film_area: float | None = number("m^2", "area of all film parts")
    film_used: float | None = number("1", "fraction of the film used for parts")
    cut_length: float | None = number("m", "length of all cuts")
    silicone_volume: float | None = number("m^3", "silicone in the mould, over all castings")
    silicone_mass: float | None = number("kg", "silicone to mix, including waste")
    silicone_parts: Mapping[str, float] | None = fact("components A and B [kg]", shown=_mass_list)
    printed_volume: float | None = number("m^3", "plastic to print, including mould and core")
    screw: str | None = fact("clamp screw")
    preload: float | None = number("N", "preload per screw that holds the sheets by friction")
    torque: float | None = number("N m", "torque for that preload")
    yoke_moment: float | None = number("N m", "bending moment in each yoke")
    mass_parts: Sequence[Mapping[str, Any]] | None = fact("mass of each part", listed=False)
    mass_missing: Sequence[str] | None = fact("parts whose mass is unknown until they are weighed")
    checks: Sequence[Mapping[str, Any]] = fact("checks", listed=False)
    assumptions: Sequence[str] = fact("assumed values, neither measured nor given", listed=False)

    @classmethod
    def table_units(cls) -> Mapping[str, str]:
        """Return {key: SI unit} of the tables; each check states its own unit."""
        return {"each": "kg", "silicone_parts": "kg"}

    def lines(self) -> Iterator[str]:
        """Yield the checks and the number of assumptions."""
        yield from ("", "checks")
        for check in self.checks:
            mark = "--  " if check["ok"] is None else MARKS[check["level"]]
            yield f"  {mark}  {check['code']:<3}  {check['text']}"
        if self.assumptions:
            yield f"{len(self.assumptions)} assumptions, listed in build.json"


@command("build")
def build(
    brake: BrakeInput,
    *,
    out: Annotated[str | Path, Help("Folder to create.", metavar="DIR")],
    workshop: Annotated[
        str | Path | None,
        Help(
            "A workshop's own [build] table. The brake's table takes precedence.",
            metavar="FILE.toml",
        ),
    ] = None,
    cutter: Annotated[
        str | None, Help("How the film is cut: service, laser or knife.", metavar="|".join(CUTTERS))
    ] = None,
    kerf: Annotated[float | None, get_spec(Build, "kerf")] = None,
    stock: Annotated[
        Size, Input("Size of the film, length by width.", metavar="QxQ", convert=_size(2, "stock"))
    ] = None,
    laser_bed: Annotated[
        Size, Input("Size of the laser bed.", metavar="QxQ", convert=_size(2, "laser bed"))
    ] = None,
    print_bed: Annotated[
        Size, Input("Build volume of the printer.", metavar="QxQxQ", convert=_size(3, "print bed"))
    ] = None,
    parallel: Annotated[int, PARALLEL] = 1,
    series: Annotated[int, SERIES] = 1,
    coupons: Annotated[
        bool, Help("Also draw test parts: a comb for the kerf and strips for the friction.")
    ] = False,
    no_step: Annotated[bool, Help("Do not write STEP files.")] = False,
    accept: Accept = None,
    overwrite: Overwrite = False,
    progress: Progress = lambda what, share: None,
) -> Built:
    """Write everything a workshop needs to build a brake: patterns, parts, mould, instructions.

    The folder is written completely or not at all, and the same brake produces the same bytes.
    `feasible` is False if the brake cannot be drawn (exit code 1), or if a part is loaded beyond
    its strength or a seal leaks (exit code 4); `reason` names the checks, and nothing is written.
    `accept` accepts failed checks by their code, {code: reason}; the folder then states them. We
    have not cut, printed or cast any of it. Raises FileError, QuantityError, MissingExtraError.
    """
    from layerjam.workshop.fabricate.folder import LIST, check_folder, require_extra, write_folder
    from layerjam.workshop.fabricate.step import is_available

    rows, row = _array_counts(parallel, series)
    workshop_choice = _combine_choices(brake, workshop, cutter, kerf, stock, laser_bed, print_bed)
    check_folder(out, overwrite)
    require_extra()
    with_step = not no_step and is_available()
    progress("drawing", 0.1)
    verdict_result = _judge_drawing(brake, workshop_choice, rows, row, accept)
    if verdict_result.record is None or not verdict_result.feasible:
        return verdict_result
    drawing, notices = verdict_result.record, list(verdict_result.warnings)
    if not (with_step or no_step):
        text = f"no STEP files: run {install_command('step')} to enable them"
        notices.append(Notice(text, "no-step"))
    content = _collect_files(drawing, with_step, coupons, notices, progress)
    names = sorted([*content, LIST])
    complete = evolve(verdict_result, files=names, warnings=notices)
    content[LIST] = _render_result(complete, brake)
    write_folder(Path(out), content, overwrite)
    return complete


CHOICES = ("workshop", "cutter", "kerf", "stock", "laser_bed", "print_bed")
"""Inputs that affect how the brake is built."""


def judge_build(brake: Any, **options: Any) -> Built:
    """Return the numbers and checks of `build`, which writes no file.

    `options` are those of `build`; file options have no effect. Raises the errors of `build`.
    """
    from layerjam.workshop.fabricate.folder import require_extra

    require_extra()
    notices: list[Notice] = []
    bindings = REGISTRY["build"].convert_arguments((brake,), {**options, "out": ""}, notices)
    choice = _combine_choices(bindings["brake"], *(bindings.get(name) for name in CHOICES))
    counts = _array_counts(bindings["parallel"], bindings["series"])
    return _judge_drawing(bindings["brake"], choice, *counts, bindings.get("accept"))


def _combine_choices(
    brake: BrakeFile,
    workshop: str | Path | None,
    cutter: str | None,
    kerf: float | None,
    stock: Size,
    laser_bed: Size,
    print_bed: Size,
) -> Choices:
    from layerjam.workshop.fabricate.choices import resolve_choices

    settings: dict[str, Any] = {"cutter": cutter, "kerf": kerf}
    settings |= {"laser_bed": laser_bed, "print_bed": print_bed}
    if stock is not None:
        settings |= dict(zip(("stock_length", "stock_width"), stock, strict=True))
    return resolve_choices(brake, workshop, settings)


def _judge_drawing(
    file: BrakeFile,
    choices: Choices,
    parallel: int,
    series: int,
    accept: Mapping[str, str] | None = None,
) -> Built:
    """Return the result without files; its record is the drawing, if there is one.

    A brake that cannot be drawn has no verdict, because there is no check to accept.
    """
    from layerjam.brake.mechanics.limits import greatest_force
    from layerjam.workshop.fabricate.drawing import draw_build
    from layerjam.workshop.fabricate.folder import LIST
    from layerjam.workshop.fabricate.lengths import CannotBuildError
    from layerjam.workshop.fabricate.verdicts import refusal_reason, refusals

    try:
        with choices.locate_errors():
            force = float(greatest_force(file.brake))
            drawing = draw_build(file, choices, force, parallel, series)
    except CannotBuildError as error:
        return _make_refused_build(error, file, parallel * series)
    verdict = None
    if reasons := refusals(drawing.checks):
        for check in reasons:
            if to_key(check.code) in map(to_key, accept or ()):
                raise QuantityError.of(
                    "accept", f"{check.code}: the brake cannot be drawn, {check.text}"
                )
    else:
        verdict = judge((check.to_judged_check() for check in drawing.checks), accept, file=LIST)
        drawing = drawing.with_acceptances((*file.accepted, *verdict.decisions))
        failed_names = {check.name for check in verdict.failed}
        reasons = [c for c in drawing.checks if c.level == "failed" and c.code in failed_names]
    return Built.create(
        _drawing_quantities(drawing),
        verdict,
        feasible=not reasons,
        reason=refusal_reason(reasons),
        files=[],
        warnings=[*file.warnings(), *drawing.notices()],
        record=drawing,
    )


def _collect_files(
    drawing: Drawing, with_step: bool, coupons: bool, notices: list[Notice], progress: Progress
) -> dict[str, str | bytes]:
    """Return {path: content} of all files except the list.

    For a file that cannot be created, a notice is added to `notices`.
    """
    from layerjam.workshop.fabricate.folder import make_files
    from layerjam.workshop.figures.assembly_steps import PATTERN
    from layerjam.workshop.figures.build_files import make_documents

    progress("patterns and parts", 0.3)
    content = make_files(drawing, with_step=with_step, coupons=coupons)
    progress("pictures and instructions", 0.5)
    content |= make_documents(drawing, coupons, content)
    if PATTERN not in content:
        text = "no paper pattern: a piece of film is larger than every paper size"
        notices.append(Notice(text, "no-pattern"))
    progress("writing files", 0.9)
    return content


def _array_counts(rows: int, row: int) -> tuple[int, int]:
    """Return the number of chains in parallel and the number of brakes in each chain."""
    if rows * row > BRAKES_LIMIT:
        raise QuantityError(
            f"build: {rows} by {row} makes {rows * row} brakes; at most {BRAKES_LIMIT} are allowed"
        )
    return rows, row


def _make_refused_build(error: Any, file: BrakeFile, brakes: int) -> Built:
    """Return the result for a brake of unknown lengths, of which nothing can be checked."""
    from layerjam.workshop.fabricate.verdicts import finding

    limits = {"value": error.value, "limit": error.limit, "unit": "m", "passes": False}
    check = finding("C4", error.reason, str(error), otherwise="refused", **limits)
    return Built.create(
        feasible=False,
        reason=f"C4: {error}",
        files=[],
        brakes=brakes,
        checks=[check.row()],
        assumptions=[],
        warnings=file.warnings(),
    )


def _drawing_quantities(drawing: Drawing) -> dict[str, Any]:
    """Return {key of the result: value}; masses, film and silicone are totals for all brakes."""
    from layerjam.workshop.fabricate.masses import UNWEIGHED, screw_name
    from layerjam.workshop.fabricate.silicone import cavity_volume

    count, lengths, film = drawing.brakes, drawing.lengths, drawing.film
    halves = drawing.silicone_parts
    return {
        "brakes": count,
        "mass": count * sum(row.mass for row in drawing.masses),
        "fittings_mass": count * sum(row.mass for row in drawing.masses if row.fitting),
        "mass_parts": [
            {"name": r.name, "count": count * r.count, "each": r.unit_mass, "basis": r.basis}
            for r in drawing.masses
        ],
        "mass_missing": list(UNWEIGHED),
        "pin_to_pin": lengths.pin_to_pin * 1e-3,
        "overall_length": lengths.overall * 1e-3,
        "sleeve_length": lengths.sleeve * 1e-3,
        "strap_length": lengths.strap * 1e-3,
        "film_pieces": len(film.pieces),
        "film_area": film.area,
        "film_used": film.used,
        "cut_length": film.cut_length,
        "silicone_volume": count * cavity_volume(lengths),
        "silicone_mass": drawing.silicone_mass,
        "silicone_parts": None if halves is None else dict(zip("AB", halves, strict=True)),
        "printed_volume": sum(
            part.solid.volume * part.count * (count if part.stays else 1)
            for part in drawing.parts
            if part.printed
        )
        * 1e-9,
        "screw": screw_name(lengths),
        "preload": drawing.preload,
        "torque": drawing.torque,
        "yoke_moment": drawing.yoke_moment,
        "checks": [check.row() for check in drawing.checks],
        "assumptions": drawing.assumptions(),
    }


def _render_result(result: Built, file: BrakeFile) -> str:
    """Return the result and its inputs as the text of a file in the folder."""
    facts = {"layerjam": __version__, "brake": file.name, "brake_sha256": file.sha256}
    document = json.loads(result.with_verdicts([file]).json())
    return json.dumps(facts | document, indent=2) + "\n"

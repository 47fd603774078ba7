"""`ageing`: growth of static friction while the films rest, from pulls after holds."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from layerjam.brake.commands.arguments import OutBrake, Overwrite, TargetBrake
from layerjam.brake.device.sheets import Film
from layerjam.core.command.declare import Help, Progress, command
from layerjam.core.command.results import Figure, fact, number, result
from layerjam.core.errors import FitError, QuantityError
from layerjam.core.outputs import bounds
from layerjam.core.units import get_spec, show
from layerjam.laboratory.commands.files import FromFiles, describe_readings, read_each, write_brake
from layerjam.laboratory.commands.friction import FrictionTest
from layerjam.laboratory.commands.reading import FileOptions, Files, Partial
from layerjam.laboratory.measure.synthetic import SYNTHETIC

if TYPE_CHECKING:
    from layerjam.laboratory.identify.friction.ageing import AgeingFit
    from layerjam.laboratory.measure.trace import Trace

HOLD = replace(get_spec(Film, "static_hold"), text="hold time under load", example="10s")


@result
class Ageing(FromFiles):
    """Static friction after a hold and its growth per decade of hold time.

    `record` is the AgeingFit.
    """

    record: "AgeingFit"
    static: float = number("1", "static friction after the hold", interval=True)
    ageing: float = number("1", "growth of static friction per decade of hold time", interval=True)
    hold: float = number("s", "hold time to which it applies")
    scatter: float = number("1", "SD of the pulls about the fitted line")
    pulls: int = number("1", "pulls used")
    pulls_table: Sequence[Mapping[str, Any]] = fact("each pull", listed=False)

    def lines(self) -> Iterator[str]:
        """Yield one line per pull."""
        yield from ("", "file: hold, static")
        for row in self.pulls_table:
            yield f"  {Path(row['file']).name}: {show(row['hold'], 's')}, {row['static']:.4f}"

    def draw(self) -> Figure:
        """Return the figure of static friction versus hold time, with the fitted line."""
        from layerjam.core.drawing.style import mark_figure
        from layerjam.laboratory.figures import measurement_figures

        return mark_figure(measurement_figures.draw_ageing(self.record), self.synthetic)


@command("test")
def ageing(
    files: Files,
    *,
    test: FrictionTest = FrictionTest(),
    hold: Annotated[
        float | None, HOLD, Help("Hold time for which the static friction is reported.")
    ] = None,
    brake: TargetBrake | None = None,
    out: OutBrake | None = None,
    partial: Partial = False,
    options: FileOptions = FileOptions(),
    progress: Progress | None = None,
    overwrite: Overwrite = False,
) -> Ageing:
    """Fit the growth of static friction while the films rest under load, from pulls after holds.

    Each file is a friction test whose sidecar states its `hold`; static friction is evaluated as in
    `friction`. With `brake` and `out`, static friction at `hold` (the geometric mean of all holds
    unless given) and its growth are written into a copy of the brake's file.
    """
    from layerjam.laboratory.identify.friction.ageing import fit_ageing
    from layerjam.laboratory.identify.friction.reduction import GRAVITY, reduce_repeat
    from layerjam.laboratory.identify.friction.standards import find_standard
    from layerjam.laboratory.identify.load_cell import NOTICED

    if (brake is None) != (out is None):
        raise QuantityError("--brake and --out: give both to write a brake, or neither")
    rule = find_standard(test.standard)
    span = test.kinetic_window(rule)
    by_rule = None if rule.sled_mass is None else rule.sled_mass * GRAVITY
    file_warnings: list[str] = []

    def reduce_pull(trace: "Trace") -> "tuple[Trace, float, float]":
        pressed = test.normal_force or trace.facts.normal_force or by_rule
        if pressed is None:
            raise FitError("the normal force on the films is unknown; give --normal-force")
        hold_time = trace.facts.hold
        if hold_time is None:
            raise FitError('its sidecar must state the hold before the pull, e.g. hold = "10 s"')
        repeat = reduce_repeat(trace, pressed, span, rule, test.accept_stick_slip, test.tare)
        zero = repeat.record.zero
        if zero is not None and abs(zero.effect(repeat.static * pressed)) > NOTICED:
            file_warnings.append(
                f"{Path(trace.path).name}: the force is {show(zero.force, 'N')} before the load "
                "rises: a zero error, or a preload (--tare subtracts it)"
            )
        return trace.thinned(2), hold_time, repeat.static

    used, refusals = read_each(files, reduce_pull, options, progress)
    fit = fit_ageing([h for _, h, _ in used], [s for _, _, s in used], hold)
    path, notices = write_brake(
        out, lambda name: _render_brake(brake, fit, used, name), overwrite, bool(refusals), partial
    )
    table = [{"file": t.path, "hold": h, "static": s} for t, h, s in used]
    return Ageing.create(
        fit,
        **bounds(static=fit.static_interval, ageing=fit.ageing_interval),
        scatter=fit.sd,
        pulls=len(used),
        pulls_table=table,
        understood=describe_readings(t for t, _, _ in used),
        refused=refusals,
        file=path,
        warnings=[*[SYNTHETIC] * _has_synthetic(used), *file_warnings, *fit.warnings, *notices],
        record=fit,
    )


def _render_brake(
    brake: Any, fit: Any, used: "Sequence[tuple[Trace, float, float]]", name: str
) -> str:
    from layerjam.brake.device.brake_file import updated_text
    from layerjam.core.toml_files.source import Source
    from layerjam.laboratory.identify.provenance import digest_files, mark_sources

    def make_source(interval: tuple[float, float]) -> Source:
        low, high = interval
        text = f"{len(used)} pulls after holds; 95 % interval {low:.4g} to {high:.4g}"
        return Source(kind="measured", text=text)

    hold = Source(kind="measured", text="hold time to which film.static applies")
    changes = {
        "film.static": (fit.static, make_source(fit.static_interval)),
        "film.ageing": (fit.ageing, make_source(fit.ageing_interval)),
        "film.static_hold": (fit.hold, hold),
    }
    files = digest_files([t.path for t, _, _ in used], [t.path for t, _, _ in used if t.synthetic])
    made_by = {"program": "layerjam ageing", "files": files}
    return updated_text(brake, name, mark_sources(changes, _has_synthetic(used)), made_by)


def _has_synthetic(used: "Sequence[tuple[Trace, float, float]]") -> bool:
    return any(trace.synthetic for trace, _, _ in used)

"""`pull`: features of measured pulls, file by file, without a model of the brake."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layerjam.brake.commands.arguments import Accept, Tare
from layerjam.core.command.declare import Progress, command
from layerjam.core.command.results import Figure, Judged, Result, fact, result
from layerjam.core.errors import FileError, Notice
from layerjam.core.units import show
from layerjam.core.verdict import Check, check, judge
from layerjam.laboratory.commands.files import CURVE, describe_readings, read_each
from layerjam.laboratory.commands.pressure_log import End, Start, check_window
from layerjam.laboratory.commands.reading import FileOptions, Files

if TYPE_CHECKING:
    from layerjam.core.drawing.chart import Curve
    from layerjam.laboratory.identify.pull.summary import PullSummary
    from layerjam.laboratory.measure.trace import Trace

_OF_UNIT = {
    "Pa": "vacuum",
    "m/s": "speed",
    "s": "stick_slip_period ripple_period second_rise_time",
    "J": "work loop_energy",
    "m": "slack onset onset_se peak_elongation steady_from steady_to stick_slip_spacing "
    "residual_elongation ripple_spacing",
    "N": "preload preload_se peak_force peak_force_se peak_sample steady_force residual_force "
    "noise stick_slip_amplitude stick_slip_upper stick_slip_lower tared ripple_amplitude",
    "N/m": "stiffness stiffness_se steady_slope steady_slope_se unloading_stiffness "
    "unloading_stiffness_se stick_slip_stiffness",
}
UNITS_OF_A_PULL = {name: unit for unit, names in _OF_UNIT.items() for name in names.split()}
"""{key of one pull's table: its unit}."""


@result
class Pulls(Judged):
    """Summaries of pulls; `record` is a list of (trace, PullSummary), the traces thinned."""

    record: list[tuple[Trace, PullSummary]]
    pulls: Sequence[Mapping[str, Any]] = fact("each pull", listed=False)
    tare: bool = fact("whether the force before the load rise was subtracted", listed=False)
    understood: Mapping[str, Any] = fact("how each file was read", listed=False)
    refused: Mapping[str, str] = fact("files not used, with reasons", listed=False)

    def lines(self) -> Iterator[str]:
        """Yield a paragraph per pull."""
        for number, row in enumerate(self.pulls):
            if number:
                yield ""
            yield from _format_pull(row)

    def draw(self) -> Figure:
        """Return the figure of force versus elongation with the features of the pulls."""
        from layerjam.laboratory.figures import pull_figures

        return pull_figures.draw_pulls(self.record)

    def overlay_curves(self) -> Sequence[Curve]:
        """Return force [N] versus elongation [mm] of all pulls from their onsets, in one series."""
        import numpy as np

        from layerjam.core.drawing.chart import Curve

        parts = [summary.features for _, summary in self.record]
        gap = np.array([np.nan])
        x = [column for curve in parts for column in (curve.elongation * 1e3, gap)]
        y = [column for curve in parts for column in (curve.force, gap)]
        return [Curve(np.concatenate(x), np.concatenate(y), measured=True)]

    curve_kind = "pull"

    @classmethod
    def can_overlay(cls, kind: type[Result]) -> bool:
        """Return False, because each file has its own panel."""
        return False


@command("test")
def pull(
    files: Files,
    *,
    tare: Tare = False,
    start: Start = None,
    end: End = None,
    accept: Accept = None,
    options: FileOptions = FileOptions(),
    progress: Progress | None = None,
) -> Pulls:
    """Analyse measured pulls: slack, preload, onset, stiffness, peak, stick–slip, unloading.

    `files` are one or more paths or traces. The force before the load rise is subtracted only with
    `tare`. `start` and `end` select a part of each record by its time. The spacing of stick–slip
    grows with its amplitude; identical spacing with different amplitudes in several files indicates
    a ripple of the machine.
    """
    from layerjam.laboratory.identify.pull.summary import pull_summary
    from layerjam.laboratory.identify.stick_slip import find_ripple

    span = check_window(start, end)

    def summarise_trace(trace: Trace) -> tuple[Trace, PullSummary]:
        part = _select_span(trace, span)
        return part.thinned(CURVE), pull_summary(part, tare).thinned(CURVE)

    used, refusals = read_each(files, summarise_trace, options, progress)
    ripples = find_ripple([summary.ripple or summary.teeth for _, summary in used])
    used = [
        (trace, (ripple and summary.as_ripple) or summary)
        for (trace, summary), ripple in zip(used, ripples, strict=True)
    ]
    warnings = [w for trace, _ in used for w in trace.warnings]
    warnings += [
        Notice(f"{_trace_name(trace)}: {note}", "pull")
        for trace, summary in used
        for note in summary.notes
    ]
    return Pulls.create(
        judge([_check_rises(used), _check_zero(used)], accept),
        pulls=[_make_pull_row(trace, summary) for trace, summary in used],
        tare=tare,
        understood=describe_readings(t for t, _ in used),
        refused=refusals,
        warnings=warnings,
        record=used,
    )


def _select_span(trace: Trace, span: tuple[float | None, float | None]) -> Trace:
    """Return the part of the trace in a span of time [s], or all of it if no span is given."""
    if span == (None, None):
        return trace
    if trace.time is None:
        raise FileError(trace.path, "has no time column for --from and --to; crop the file")
    return trace.between(*span)


def _second_rise_time(trace: Trace, summary: PullSummary) -> float | None:
    """Return the time [s] at which the second rise begins; None if unknown."""
    second = summary.second_rise
    if second is None or trace.time is None:
        return None
    index = int((trace.elongation - summary.features.origin >= second.start).argmax())
    return float(trace.time[index])


def _check_rises(used: list[tuple[Trace, PullSummary]]) -> Check:
    """Check that each record has one rise; with two, stiffness and onset are meaningless."""
    places = []
    for trace, summary in used:
        if summary.second_rise is not None:
            time = _second_rise_time(trace, summary)
            begin = f" (second from {show(time, 's', 3)})" if time is not None else ""
            places.append(f"{_trace_name(trace)}{begin}")
    return check(
        "rises",
        not places,
        f"two rises: {', '.join(places)}" if places else "every record has one rise",
        (
            "; the brake slides, then its force rises again. Select one rise with --from, "
            "--to and --tare"
        ),
        "failed",
    )


def _check_zero(used: list[tuple[Trace, PullSummary]]) -> Check:
    """Check that the force before the load rises does not change the peak."""
    from layerjam.laboratory.identify.load_cell import Zero, check_zero

    effects = {}
    for trace, summary in used:
        start = summary.start
        if start.seen:
            zero = Zero(force=start.baseline, error=start.baseline_se or 0.0)
            effect = zero.effect(summary.features.peak_force)
            effects[_trace_name(trace)] = (show(start.baseline, "N"), effect)
    return check_zero(effects, "the peak")


def _trace_name(trace: Trace) -> str:
    """Return the name of the file, and the specimen if the file has several."""
    return f"{trace.path}, specimen {trace.specimen}" if trace.specimen else trace.path


def _make_pull_row(trace: Trace, summary: PullSummary) -> dict[str, Any]:
    """Return the row of one pull with every key; a value that the record does not show is None."""
    from layerjam.laboratory.identify.stick_slip import CAUSE

    features, start, steady = summary.features, summary.start, summary.steady
    straight, peak = features.straight or None, features.has_peak or None
    teeth, ripple, unloading = summary.teeth, summary.ripple, summary.unloading
    return {
        "file": trace.path,
        "specimen": trace.specimen or None,
        "vacuum": trace.facts.vacuum,
        "speed": trace.facts.speed,
        "slack": start.slack,
        "preload": start.baseline,
        "preload_se": start.baseline_se,
        "onset": start.onset,
        "onset_se": start.onset_se,
        "stiffness": straight and features.stiffness,
        "stiffness_se": straight and features.stiffness_se,
        "peak_force": peak and features.peak_force,
        "peak_force_se": peak and features.peak_error,
        "peak_sample": peak and features.peak_sample,
        "peak_elongation": peak and features.peak_elongation,
        "steady_slope": steady and steady.slope,
        "steady_slope_se": steady and steady.slope_se,
        "steady_force": steady and steady.force,
        "steady_from": steady and steady.start,
        "steady_to": steady and steady.end,
        "stick_slip": teeth is not None,
        "stick_slip_amplitude": teeth and teeth.amplitude,
        "stick_slip_upper": teeth and teeth.upper,
        "stick_slip_lower": teeth and teeth.lower,
        "stick_slip_spacing": teeth and teeth.spacing,
        "stick_slip_period": teeth and teeth.period,
        "stick_slip_stiffness": teeth and teeth.stiffness,
        "teeth": teeth and teeth.teeth,
        "ripple": ripple is not None,
        "ripple_amplitude": ripple and ripple.amplitude,
        "ripple_spacing": ripple and ripple.spacing,
        "ripple_period": ripple and ripple.period,
        "ripple_cause": ripple and CAUSE,
        "second_rise_time": _second_rise_time(trace, summary),
        "unloading_stiffness": unloading and unloading.stiffness,
        "unloading_stiffness_se": unloading and unloading.stiffness_se,
        "residual_force": unloading and unloading.residual_force,
        "residual_elongation": unloading and unloading.residual_elongation,
        "work": unloading and unloading.work,
        "loop_energy": unloading and unloading.loop,
        "loop_closed": unloading and unloading.closed,
        "noise": summary.noise,
        "tared": summary.tared,
    }


def _format_pull(row: Mapping[str, Any]) -> Iterator[str]:
    def format_key(key: str) -> str:
        unit, error = UNITS_OF_A_PULL[key], row.get(f"{key}_se")
        value = show(row[key], unit)
        return value if error is None else f"{value} ± {show(error, unit, 2)}"

    specimen = f", specimen {row['specimen']}" if row["specimen"] else ""
    yield Path(row["file"]).name + specimen
    slack, preload, onset = (format_key(key) for key in ("slack", "preload", "onset"))
    yield f"  slack {slack}, preload {preload}, onset at {onset}"
    peak = "no peak"
    if row["peak_force"] is not None:
        gap = row["peak_sample"] - row["peak_force"]
        peak = (
            f"peak {format_key('peak_force')} at {format_key('peak_elongation')}; largest sample "
            f"{format_key('peak_sample')} ({'+' if gap > 0 else ''}{show(gap, 'N', 2)})"
        )
    yield f"  stiffness {format_key('stiffness')}, {peak}"
    if row["steady_slope"] is not None:
        yield (
            f"  after the peak {format_key('steady_slope')}, {format_key('steady_force')} between "
            f"{format_key('steady_from')} and {format_key('steady_to')}"
        )
    if row["stick_slip"]:
        yield (
            f"  stick–slip ± {format_key('stick_slip_amplitude')}, {row['teeth']} slips, every "
            f"{format_key('stick_slip_spacing')}, {format_key('stick_slip_period')}"
        )
    if row["ripple"]:
        yield (
            f"  ripple ± {format_key('ripple_amplitude')} every {format_key('ripple_spacing')}, "
            f"{format_key('ripple_period')}: {row['ripple_cause']}"
        )
    if row["unloading_stiffness"] is not None:
        yield (
            f"  unloading {format_key('unloading_stiffness')}, residual "
            f"{format_key('residual_elongation')} and {format_key('residual_force')}; dissipated "
            f"{format_key('loop_energy')} of {format_key('work')}"
        )

"""`pull`: what measured pulls show, file by file, without any model of the brake."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from layerjam.commands.answer import Answer
from layerjam.commands.files import CURVE, Paths, Progress, each, understood
from layerjam.identify.pull.summary import PullSummary, pull_summary
from layerjam.measure.options import ReadingOptions
from layerjam.measure.trace import Trace

UNITS_OF_A_PULL = {
    "vacuum": "Pa", "speed": "m/s", "slack": "m", "preload": "N", "preload_se": "N",
    "onset": "m", "onset_se": "m", "stiffness": "N/m", "stiffness_se": "N/m",
    "peak_force": "N", "peak_force_se": "N", "peak_elongation": "m",
    "steady_slope": "N/m", "steady_slope_se": "N/m", "steady_force": "N",
    "steady_from": "m", "steady_to": "m", "stick_slip_amplitude": "N", "stick_slip_upper": "N",
    "stick_slip_lower": "N", "stick_slip_spacing": "m", "stick_slip_period": "s",
    "unloading_stiffness": "N/m", "unloading_stiffness_se": "N/m", "residual_force": "N",
    "residual_elongation": "m", "work": "J", "loop_energy": "J", "noise": "N", "tared": "N",
}  # fmt: skip
"""Unit of each key of one pull's table."""


def pull(
    files: Paths,
    *,
    tare: bool = False,
    choices: ReadingOptions | None = None,
    progress: Progress | None = None,
) -> Answer:
    """Slack, preload, onset, stiffness, peak, steady part, stick-slip and way back of pulls.

    Nothing is subtracted from a force unless `tare` asks for the force before the load rises.
    `choices` answers what a file leaves open (sign, column, decimal sign), `progress` is told
    (what, share done). `record` is a list of (trace, PullSummary), traces thinned.
    """

    def use(trace: Trace) -> tuple[Trace, PullSummary]:
        found = pull_summary(trace, tare)
        features = found.features.thinned(CURVE)
        return trace.thinned(CURVE), replace(found, features=features)

    used, refused = each(files, use, choices, progress)
    warnings = [w for trace, _ in used for w in trace.warnings]
    warnings += [f"{trace.path}: {note}" for trace, found in used for note in found.notes]
    return Answer(
        values={
            "pulls": [_row(trace, found) for trace, found in used],
            "tare": tare,
            "understood": understood(t for t, _ in used),
            "refused": refused,
        },
        units={},
        warnings=warnings,
        refused=refused,
        record=used,
    )


def _row(trace: Trace, found: PullSummary) -> dict[str, Any]:
    """One pull, every key; None where the record does not show it."""
    features, start, steady = found.features, found.start, found.steady
    teeth, back = found.teeth, found.unloading
    return {
        "file": trace.path,
        "vacuum": trace.facts.vacuum,
        "speed": trace.facts.speed,
        "slack": start.slack,
        "preload": start.baseline,
        "preload_se": start.baseline_se,
        "onset": start.onset,
        "onset_se": start.onset_se,
        "stiffness": features.stiffness if features.straight else None,
        "stiffness_se": features.stiffness_se if features.straight else None,
        "peak_force": features.peak_force if features.has_peak else None,
        "peak_force_se": features.peak_force_se if features.has_peak else None,
        "peak_elongation": features.peak_elongation if features.has_peak else None,
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
        "teeth": teeth and teeth.teeth,
        "unloading_stiffness": back and back.stiffness,
        "unloading_stiffness_se": back and back.stiffness_se,
        "residual_force": back and back.residual_force,
        "residual_elongation": back and back.residual_elongation,
        "work": back and back.work,
        "loop_energy": back and back.loop,
        "loop_closed": back and back.closed,
        "noise": found.noise,
        "tared": found.tared,
    }

"""Summary of one measured pull: slack, preload, onset, peak, plateau, stick–slip and return."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from layerjam.core.brief import brief
from layerjam.core.errors import FileError, count_text
from layerjam.core.evolve import evolve
from layerjam.core.units import show
from layerjam.laboratory.identify.pull.cycles import Cycles, select_first_cycle
from layerjam.laboratory.identify.pull.features import (
    LINEAR,
    PullFeatures,
    pull_features,
    select_loading,
)
from layerjam.laboratory.identify.pull.strokes import (
    SecondRise,
    Unloading,
    find_raised_lead,
    find_second_rise,
    find_unloading,
)
from layerjam.laboratory.identify.statistics import fit_line
from layerjam.laboratory.identify.stick_slip import CAUSE, STUCK, SawTeeth, find_saw_teeth
from layerjam.laboratory.measure.noise import noise_sd, running_mean
from layerjam.laboratory.measure.trace import Array, Trace

MARGIN = 0.05
"""Gap between the baseline and the onset, as a fraction of the length of the rise."""
FEWEST = 5
"""Minimum number of samples before the onset for a baseline."""
LEAD = 2
"""Number of samples before the onset that prove the record begins before the rise."""
STEADY = (0.25, 0.98)
"""Range, from the peak (0) to the end of loading (1), that counts as the plateau."""
BLOCKS = 24
"""Number of means over the plateau; their scatter (with stick–slip) sets the slope's error."""
TELLS = 0.002
"""Smallest preload that is reported, relative to the peak."""


@dataclass(frozen=True, kw_only=True)
class Start:
    """Start of a pull, in SI units.

    `onset` is the elongation, in the machine's coordinate, at which the straight rise meets the
    force before it (`baseline`); `slack` is the crosshead travel until then. Standard errors are
    from the scatter about line and baseline, or None. `seen` is False if the record begins on the
    rise; the baseline is then the force at its first samples.
    """

    onset: float
    onset_se: float | None
    slack: float
    baseline: float
    baseline_se: float | None
    seen: bool


@dataclass(frozen=True, kw_only=True)
class Steady:
    """Sliding part after the peak, in SI units: a straight line fitted to the force.

    `slope` [N per m of elongation] has a standard error, and `force` [N] is that in the middle;
    `start` and `end` are elongations from the pull's origin.
    """

    slope: float
    slope_se: float
    force: float
    start: float
    end: float


@brief
@dataclass(frozen=True, kw_only=True)
class PullSummary:
    """Features of one pull; `tared` is the force [N] subtracted on request.

    `teeth` are those of stick–slip, `ripple` those of the machine. `second_rise` is None if the
    force rises only once, `cycles` if the crosshead never pulls again. `as_ripple` is the summary
    to use if other records show its teeth to be ripple.
    """

    features: PullFeatures
    start: Start
    steady: Steady | None
    teeth: SawTeeth | None
    ripple: SawTeeth | None
    second_rise: SecondRise | None
    unloading: Unloading | None
    cycles: Cycles | None
    noise: float
    tared: float | None
    notes: tuple[str, ...]
    as_ripple: "PullSummary | None" = None

    @property
    def preload(self) -> float:
        """Force before the load rises [N]; a zero error of the load cell has the same effect."""
        return self.start.baseline

    def thinned(self, limit: int) -> "PullSummary":
        """Return the summary with at most `limit` samples of the curve, as means of neighbours."""
        size = -(-len(self.features.force) // limit)
        marks = self.teeth and evolve(
            self.teeth, peaks=self.teeth.peaks // size, troughs=self.teeth.troughs // size
        )
        ripple = self.as_ripple and self.as_ripple.thinned(limit)
        return evolve(self, features=self.features.thinned(limit), teeth=marks, as_ripple=ripple)


def pull_summary(trace: Trace, tare: bool = False) -> PullSummary:
    """Return slack, preload, onset, peak, slopes, stick–slip and unloading of one pull.

    With `tare`, the force before the onset is subtracted first, and the notes state its value.
    Raises FileError if the record has no rise or, with `tare`, no force before it.
    """
    trace, cycles = select_first_cycle(trace)
    tare_force = _find_tare(trace) if tare else None
    if tare_force is not None:
        trace = evolve(trace, force=trace.force - tare_force)
    features = pull_features(trace)
    start = _find_start(trace, features)
    noise = noise_sd(features.force)
    unloading = find_unloading(trace.elongation, trace.force, start.onset, start.baseline, noise)
    second_rise = find_second_rise(features.elongation, features.force)

    def make_summary(teeth: SawTeeth | None, ripple: SawTeeth | None) -> PullSummary:
        part = features if teeth is None else _limit_peak(features, teeth, noise)
        return PullSummary(
            features=part,
            start=start,
            steady=_fit_plateau(part),
            teeth=teeth,
            ripple=ripple,
            second_rise=second_rise,
            unloading=unloading,
            noise=noise,
            tared=tare_force,
            cycles=cycles,
            notes=(
                *([str(cycles)] if cycles else []),
                *_summary_notes(part, start, teeth, ripple, tare_force),
                *_note_unused_samples(trace, unloading),
            ),
        )

    teeth = _find_teeth(trace, features)
    if teeth is None:
        return make_summary(None, None)
    as_ripple = make_summary(None, teeth)
    # while sticking, a tooth rises with the pull's stiffness; a bent or a double rise does not
    certain = features.straight and second_rise is None
    if certain and teeth.stiffness < STUCK * features.stiffness:
        return as_ripple
    return evolve(make_summary(teeth, None), as_ripple=as_ripple)


def subtract_tare(trace: Trace) -> Trace:
    """Return the trace without the force before its rise; raises FileError if there is none."""
    return evolve(trace, force=trace.force - _find_tare(trace))


def _find_tare(trace: Trace) -> float:
    tare_force = find_raised_lead(*select_loading(trace))
    if tare_force is not None:
        return tare_force
    begin = _find_start(trace, pull_features(trace))
    if not begin.seen:
        raise FileError(
            trace.path, "starts during its rise: there is no earlier force to subtract (tare)"
        )
    return begin.baseline


def _find_start(trace: Trace, features: PullFeatures) -> Start:
    elongation, force = select_loading(trace)
    first = float(elongation[0])
    if not features.straight:
        return _find_bend_start(elongation, force)
    height, slope = float(features.peak_force), features.stiffness
    length = height / slope
    onset, baseline, error = features.origin, 0.0, 0.0
    is_at_rest = elongation <= first + 1e-9
    if is_at_rest[:FEWEST].all():  # the crosshead is at rest at first
        baseline = float(np.median(force[: int(np.argmin(is_at_rest)) or len(force)]))
        onset += baseline / slope
    for _ in range(4):
        margin = min(MARGIN * length, 0.3 * max(onset - first, 0.0))
        is_before = elongation < onset - margin
        is_before[int(np.argmax(elongation >= onset)) :] = False
        if is_at_rest[:FEWEST].all():
            is_before |= is_at_rest & (np.abs(force - baseline) < 0.1 * height)
        if is_before.sum() < FEWEST or _is_rising(elongation[is_before], force[is_before], slope):
            return _find_start_on_rise(elongation, force, features)
        quiet_force = force[is_before]
        baseline = float(quiet_force.mean())
        error = float(quiet_force.std(ddof=1)) / len(quiet_force) ** 0.5
        onset = features.origin + baseline / slope
    return Start(
        onset=onset,
        onset_se=float(np.hypot(error / slope, _line_error(elongation, force, features, onset))),
        slack=max(onset - first, 0.0),
        baseline=baseline,
        baseline_se=error,
        seen=True,
    )


def _is_rising(x: Array, y: Array, slope: float) -> bool:
    """Return whether the force already rises, by more than a tenth of the slope of the rise."""
    line = fit_line(x, y)
    return line is not None and line.slope - 3 * line.slope_se > 0.1 * slope


def _line_error(elongation: Array, force: Array, features: PullFeatures, crossing: float) -> float:
    """Return the standard error of the elongation [m] at which the line reaches a given force."""
    line = features.stiffness * (elongation - features.origin)
    in_range = (line >= LINEAR[0] * features.peak_force) & (line <= LINEAR[1] * features.peak_force)
    x = elongation[in_range]
    if len(x) < 3 or not np.ptp(x) > 0:
        return 0.0
    spread = features.stiffness_se * float(np.sqrt(((x - x.mean()) ** 2).sum()))
    distance_error = abs(float(x.mean()) - crossing) * features.stiffness_se
    return float(np.hypot(spread / len(x) ** 0.5, distance_error)) / features.stiffness


def _find_start_on_rise(elongation: Array, force: Array, features: PullFeatures) -> Start:
    """Return the start of a record that begins on its rise or at most a few samples before it.

    On the rise, the preload is the force of the line at the first samples or, if the measured force
    differs from it, the force of the first sample.
    """
    first, slope = float(elongation[0]), features.stiffness
    noise = noise_sd(force)
    noisy = noise > 1e-9 * abs(features.peak_force)
    lead = int(np.argmax(elongation >= features.origin)) - 1
    if lead >= LEAD:
        first_force, line = force[:lead], slope * (elongation[:lead] - features.origin)
        offset = float((first_force - line).mean())
        error = noise / lead**0.5
        # otherwise the line itself starts below zero, so the load cell has a zero error
        if offset > max(4 * error, TELLS * features.peak_force):
            onset = features.origin + float(first_force.mean()) / slope
            return Start(
                onset=onset,
                onset_se=_line_error(elongation, force, features, onset) if noisy else None,
                slack=max(onset - first, 0.0),
                baseline=float(first_force.mean()),
                baseline_se=error if noisy else None,
                seen=True,
            )
    begin = force[:FEWEST] - slope * (elongation[:FEWEST] - first)
    baseline, error = float(begin.mean()), noise / len(begin) ** 0.5
    if abs(baseline - float(force[0])) > 4 * noise + TELLS * features.peak_force:
        baseline, error = float(force[0]), noise  # the line does not pass through these samples
    return Start(
        onset=first,
        onset_se=_line_error(elongation, force, features, first) if noisy else None,
        slack=0.0,
        baseline=baseline,
        baseline_se=error if noisy else None,
        seen=False,
    )


def _find_bend_start(elongation: Array, force: Array) -> Start:
    """Return the start of a bent rise: where the force leaves the scatter of its first samples."""
    width = max(FEWEST, len(force) // 200)
    noise = noise_sd(force)
    baseline = float(force[:width].mean())
    smooth = running_mean(force, 9)
    limit = baseline + 6 * noise / 3 + 1e-3 * float(np.ptp(force))
    below_limit = np.flatnonzero(smooth[: int(np.argmax(smooth)) + 1] <= limit)
    onset = float(elongation[below_limit[-1]]) if len(below_limit) else float(elongation[0])
    return Start(
        onset=onset,
        onset_se=None,
        slack=onset - float(elongation[0]),
        baseline=baseline,
        baseline_se=noise / width**0.5,
        seen=onset - float(elongation[0]) > 0.01 * float(np.ptp(elongation)),
    )


def _find_teeth(trace: Trace, features: PullFeatures) -> SawTeeth | None:
    """Return the stick–slip after the first rise, with indices into the loading branch."""
    force = features.force
    near_peak = np.flatnonzero(force >= 0.8 * features.peak_force)
    begin = int(near_peak[0]) if len(near_peak) else 0
    time = None if trace.time is None else trace.time[: len(force)][begin:]
    teeth = find_saw_teeth(features.elongation[begin:], force[begin:], time).teeth
    if teeth is None:
        return None
    return evolve(teeth, peaks=teeth.peaks + begin, troughs=teeth.troughs + begin)


def _limit_peak(features: PullFeatures, teeth: SawTeeth, noise: float) -> PullFeatures:
    """Return the features with the maximum force before the first slip as their peak.

    The smooth law around a peak cannot be fitted to teeth.
    """
    before_slip = features.elongation <= features.peak_elongation + teeth.spacing / 2
    top = int(np.argmax(np.where(before_slip, features.force, -np.inf)))
    return evolve(
        features,
        peak_force=float(features.force[top]),
        peak_force_se=noise,
        peak_elongation=float(features.elongation[top]),
        peak_sample=float(features.force[top]),
        peak_misfit=0.0,
    )


def _fit_plateau(features: PullFeatures) -> Steady | None:
    """Return a line fitted to the force after the peak; None if too little of it was recorded."""
    if not features.has_peak:
        return None
    sliding_travel = float(features.elongation[-1]) - features.peak_elongation
    start, stop = (features.peak_elongation + part * sliding_travel for part in STEADY)
    is_inside = (features.elongation >= start) & (features.elongation <= stop)
    x, y = features.elongation[is_inside], features.force[is_inside]
    if len(x) < 3 * BLOCKS:
        return None
    # use block means, so that a feature within a block (a tooth, a patch of film) counts once
    blocks = [[part.mean() for part in np.array_split(values, BLOCKS)] for values in (x, y)]
    line = fit_line(np.array(blocks[0]), np.array(blocks[1]))
    if line is None:
        return None
    slope, error = line.slope, line.slope_se
    return Steady(slope=slope, slope_se=error, force=float(y.mean()), start=start, end=stop)


def find_baseline(trace: Trace, features: PullFeatures) -> float | None:
    """Return the force before the rise [N]: 0 if it may be zero, None if it was not recorded."""
    start = _find_start(trace, features) if features.straight else None
    if start is None or not start.seen:
        return None
    return start.baseline if is_off_zero(start, features) else 0.0


def is_off_zero(start: Start, features: PullFeatures) -> bool:
    """Return whether the force before the rise is large and not due to chance."""
    certain = abs(start.baseline) > 4 * (start.baseline_se or 0.0)
    return certain and abs(start.baseline) > TELLS * abs(features.peak_force)


def _summary_notes(
    features: PullFeatures,
    start: Start,
    teeth: SawTeeth | None,
    ripple: SawTeeth | None,
    tare_force: float | None,
) -> Iterator[str]:
    if tare_force is not None:
        yield f"{show(tare_force, 'N')} was subtracted from the force (tare)"
    if is_off_zero(start, features):
        moment = "before the load rises" if start.seen else "already at the first sample"
        ask = "; a preload, or the load cell's zero (--tare subtracts it)" if start.seen else ""
        yield f"the force is {show(start.baseline, 'N')} {moment}{ask}"
    if features.is_sparse:
        yield (
            f"only {count_text(features.rise_samples, 'sample')} between {LINEAR[0]:.0%} and "
            f"{LINEAR[1]:.0%} of the maximum force, too few to determine a stiffness: pull more "
            "slowly, or sample faster"
        )
    elif not features.straight:
        yield "the force curve bends long before its maximum: it has no linear rise"
    if not features.has_peak:
        yield "the force rises to the end: there is no peak and no part after it"
    if teeth is not None:
        yield (
            f"sticks and slips, {show(teeth.amplitude, 'N')} about its midpoint every "
            f"{show(teeth.spacing, 'm', 3)}; its peak is static friction at the first slip"
        )
    if ripple is not None:
        yield (
            f"a ripple of {show(ripple.amplitude, 'N')} about its midpoint every "
            f"{show(ripple.spacing, 'm', 3)} is not stick–slip, whose spacing is its "
            f"swing divided by the stiffness; likely cause: {CAUSE}"
        )


def _note_unused_samples(trace: Trace, unloading: Unloading | None) -> list[str]:
    """Return a notice about unused samples after the return or after the maximum elongation."""
    turn_index = len(trace) - 1 - int(np.argmax(trace.elongation[::-1]))
    used = (
        turn_index + 1
        if unloading is None
        else turn_index + int(np.argmin(trace.elongation[turn_index:])) + 1
    )
    unused = len(trace) - used
    if unused < FEWEST:
        return []
    limit_text = "its maximum elongation" if unloading is None else "the first return"
    last_elongation = show(float(trace.elongation[used - 1]), "m")
    return [f"{unused} samples after {limit_text}, {last_elongation}, are not used"]

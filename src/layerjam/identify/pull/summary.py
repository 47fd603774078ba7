"""What one measured pull shows: slack, preload, onset, peak, steady part, stick–slip, return."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from layerjam.errors import FileError
from layerjam.identify.pull.features import LINEAR, PullFeatures, loading_branch, pull_features
from layerjam.identify.stick_slip import SawTeeth, find_saw_teeth, noise_of, running_mean
from layerjam.identify.straight import StraightLine, straight_line
from layerjam.measure.trace import Array, Trace
from layerjam.units import show

MARGIN = 0.05
"""Part of the rise's length kept away from the onset where the baseline is taken."""
FEWEST = 5
"""Samples before the onset that make a baseline."""
LEAD = 2
"""Samples before the onset that show that the rise has not begun."""
STEADY = (0.25, 0.98)
"""Part of the way from the peak to the end of loading that is called steady."""
BLOCKS = 24
"""Means the steady part is cut into: their scatter gives the slope's error, teeth and all."""
TELLS = 0.002
"""A preload above this part of the peak is said."""
PART = (0.9, 0.2)
"""Of the force at the reversal: between them the stiffness is taken."""
LEAST_WAY_BACK = 0.02
"""A return shorter than this part of the pull is none."""
FEWEST_BACK = 8
"""Samples of a return that tell something."""


@dataclass(frozen=True, kw_only=True)
class Unloading:
    """The unloading branch of a pull, SI units.

    `stiffness` is the slope just after the reversal [N/m], None where fewer than 4 samples lie on
    it. `residual_force` is the mean force over the last hundredth of the return [N].
    `residual_elongation` is how far from the onset of the pull the force meets its baseline again
    along that slope [m], None with it. `work` goes in on the way out [J], `returned` comes back;
    `loop`, their difference, is what the brake kept: dissipated if the return leads to the onset
    (`closed`).
    """

    stiffness: float | None
    stiffness_se: float | None
    force_at_reversal: float
    elongation_at_reversal: float
    residual_force: float
    residual_elongation: float | None
    work: float
    returned: float
    loop: float
    loop_se: float
    closed: bool


def find_unloading(
    elongation: Array, force: Array, onset: float, baseline: float, noise: float
) -> Unloading | None:
    """The unloading of a whole record, arrays of shape (N,); None where it has none.

    `onset` is the elongation where the pull began [m], `baseline` the force there [N], `noise` one
    sample's standard deviation [N].
    """
    most, least = float(elongation.max()), float(elongation.min())
    turn = len(elongation) - 1 - int(np.argmax(elongation[::-1]))
    # the crosshead may stand there for a while
    first = int(np.argmax(elongation))
    back, fall = elongation[turn:], force[turn:]
    if len(back) < FEWEST_BACK or most - float(back.min()) < LEAST_WAY_BACK * (most - least):
        return None
    last = int(np.argmin(back)) + 1
    back, fall = back[:last], fall[:last]
    few = max(1, min(len(fall) // 50, 5))
    top = float(np.median(force[max(first - few, 0) : turn + 1]))
    steep = _steep(back, fall, top, baseline)
    out, pulled = elongation[: first + 1], force[: first + 1]
    work, returned = _area(out, pulled), -_area(back, fall)
    end = max(1, len(fall) // 100)
    return Unloading(
        stiffness=steep and steep.slope,
        stiffness_se=steep and steep.slope_se,
        force_at_reversal=top,
        elongation_at_reversal=most - onset,
        residual_force=float(fall[-end:].mean()),
        residual_elongation=None if steep is None else steep.meets(baseline) - onset,
        work=work,
        returned=returned,
        loop=work - returned,
        loop_se=noise * float(np.hypot(_weight(out), _weight(back))),
        closed=float(back[-1]) - onset <= 0.01 * (most - least),
    )


def _steep(back: Array, fall: Array, top: float, baseline: float) -> StraightLine | None:
    """The line through the beginning of the return; None where it has too few samples."""
    high, low = (baseline + part * (top - baseline) for part in PART)
    under, gone = np.flatnonzero(fall <= high), np.flatnonzero(fall <= low)
    if top <= baseline or not len(gone):
        return None
    part = slice(under[0], gone[0])
    line = straight_line(back[part], fall[part]) if gone[0] - under[0] >= 4 else None
    return line if line is not None and line.slope > 0 else None


def _area(x: Array, y: Array) -> float:
    return float(np.sum(np.diff(x) * (y[1:] + y[:-1])) / 2)


def _weight(x: Array) -> float:
    """Norm of the weights a trapezoidal sum gives its samples."""
    step = np.diff(x)
    return float(np.sqrt(np.sum((np.r_[step, 0.0] + np.r_[0.0, step]) ** 2))) / 2


@dataclass(frozen=True, kw_only=True)
class Start:
    """Where a pull begins, SI units.

    `onset` is the elongation where the straight rise meets the force before it (`baseline`),
    counted as the machine does; `slack` the crosshead's way until then. Standard errors rest on
    the scatter about line and baseline; None where nothing estimates them. `seen` is False where
    the record begins on the rise already: then the baseline is the force at its first samples.
    """

    onset: float
    onset_se: float | None
    slack: float
    baseline: float
    baseline_se: float | None
    seen: bool


@dataclass(frozen=True, kw_only=True)
class Steady:
    """The sliding part after the peak, SI units: a straight line through the force there.

    `slope` [N/m of elongation] with its standard error, `force` in the middle [N], `start` and
    `end` as elongations from the pull's origin.
    """

    slope: float
    slope_se: float
    force: float
    start: float
    end: float


@dataclass(frozen=True, kw_only=True)
class PullSummary:
    """Features of one pull; `tared` says what was subtracted from the force [N] on request."""

    features: PullFeatures
    start: Start
    steady: Steady | None
    teeth: SawTeeth | None
    unloading: Unloading | None
    noise: float
    tared: float | None
    notes: tuple[str, ...]

    @property
    def preload(self) -> float:
        """Force before the load rises [N]; the machine's zero error looks the same."""
        return self.start.baseline


def pull_summary(trace: Trace, tare: bool = False) -> PullSummary:
    """Slack, preload, onset, peak, slopes, stick-slip and unloading of one pull.

    With `tare` the force before the onset is subtracted first, and the notes say how much. Raises
    FileError where the record shows no rise, or with `tare` nothing before it.
    """
    tared = None
    if tare:
        begin = _start(trace, pull_features(trace))
        if not begin.seen:
            raise FileError(
                trace.path,
                "begins on its rise: it shows no force before the load to subtract (tare)",
            )
        tared = begin.baseline
        trace = replace(trace, force=trace.force - tared)
    features = pull_features(trace)
    start = _start(trace, features)
    noise = noise_of(features.force)
    teeth = _teeth(trace, features)
    if teeth is not None:
        features = _first_slip(features, teeth, noise)
    steady = _steady(features)
    unloading = find_unloading(trace.elongation, trace.force, start.onset, start.baseline, noise)
    return PullSummary(
        features=features,
        start=start,
        steady=steady,
        teeth=teeth,
        unloading=unloading,
        noise=noise,
        tared=tared,
        notes=(*_notes(features, start, teeth, tared), *_not_used(trace, unloading)),
    )


def _start(trace: Trace, features: PullFeatures) -> Start:
    elongation, force = loading_branch(trace)
    first = float(elongation[0])
    if not features.straight:
        return _bent_start(elongation, force)
    height, slope = float(features.peak_force), features.stiffness
    length = height / slope
    onset, baseline, error = features.origin, 0.0, 0.0
    still = elongation <= first + 1e-9
    for _ in range(4):
        margin = min(MARGIN * length, 0.3 * max(onset - first, 0.0))
        before = elongation < onset - margin
        before[int(np.argmax(elongation >= onset)) :] = False
        if still[:FEWEST].all():  # a rest before the crosshead starts
            before |= still & (np.abs(force - baseline) < 0.1 * height)
        if before.sum() < FEWEST or _rises(elongation[before], force[before], slope):
            return _no_slack(elongation, force, features)
        rest = force[before]
        baseline = float(rest.mean())
        error = float(rest.std(ddof=1)) / len(rest) ** 0.5
        onset = features.origin + baseline / slope
    return Start(
        onset=onset,
        onset_se=float(np.hypot(error / slope, _line_error(elongation, force, features, onset))),
        slack=max(onset - first, 0.0),
        baseline=baseline,
        baseline_se=error,
        seen=True,
    )


def _rises(x: Array, y: Array, slope: float) -> bool:
    """Whether the force rises already, by more than a tenth of the slope of the rise."""
    line = straight_line(x, y)
    return line is not None and line.slope - 3 * line.slope_se > 0.1 * slope


def _line_error(elongation: Array, force: Array, features: PullFeatures, at: float) -> float:
    """Standard error of the elongation [m] at which the line of the rise passes a given force."""
    line = features.stiffness * (elongation - features.origin)
    on = (line >= LINEAR[0] * features.peak_force) & (line <= LINEAR[1] * features.peak_force)
    x = elongation[on]
    if len(x) < 3 or not np.ptp(x) > 0:
        return 0.0
    spread = features.stiffness_se * float(np.sqrt(((x - x.mean()) ** 2).sum()))
    away = abs(float(x.mean()) - at) * features.stiffness_se
    return float(np.hypot(spread / len(x) ** 0.5, away)) / features.stiffness


def _no_slack(elongation: Array, force: Array, features: PullFeatures) -> Start:
    """A record that begins on its rise, or a few samples before it.

    On the rise, what the line shows at the first samples is the preload, unless the force there is
    another: then it is the first sample's.
    """
    first, slope = float(elongation[0]), features.stiffness
    noise = noise_of(force)
    noisy = noise > 1e-9 * abs(features.peak_force)
    lead = int(np.argmax(elongation >= features.origin)) - 1
    if lead >= LEAD:
        rest, line = force[:lead], slope * (elongation[:lead] - features.origin)
        off = float((rest - line).mean())
        error = noise / lead**0.5
        # else the line itself begins below zero: the load cell's zero is off
        if off > max(4 * error, TELLS * features.peak_force):
            onset = features.origin + float(rest.mean()) / slope
            return Start(
                onset=onset,
                onset_se=_line_error(elongation, force, features, onset) if noisy else None,
                slack=max(onset - first, 0.0),
                baseline=float(rest.mean()),
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


def _bent_start(elongation: Array, force: Array) -> Start:
    """A force that bends from the start has no line: where it leaves its first samples' scatter."""
    few = max(FEWEST, len(force) // 200)
    noise = noise_of(force)
    baseline = float(force[:few].mean())
    smooth = running_mean(force, 9)
    limit = baseline + 6 * noise / 3 + 1e-3 * float(np.ptp(force))
    under = np.flatnonzero(smooth[: int(np.argmax(smooth)) + 1] <= limit)
    at = float(elongation[under[-1]]) if len(under) else float(elongation[0])
    return Start(
        onset=at,
        onset_se=None,
        slack=at - float(elongation[0]),
        baseline=baseline,
        baseline_se=noise / few**0.5,
        seen=at - float(elongation[0]) > 0.01 * float(np.ptp(elongation)),
    )


def _teeth(trace: Trace, features: PullFeatures) -> SawTeeth | None:
    """Stick-slip of the loading branch from the end of its first rise, with indices into it."""
    force = features.force
    reached = np.flatnonzero(force >= 0.8 * features.peak_force)
    begin = int(reached[0]) if len(reached) else 0
    time = None if trace.time is None else trace.time[: len(force)][begin:]
    found = find_saw_teeth(features.elongation[begin:], force[begin:], time).teeth
    if found is None:
        return None
    return replace(found, peaks=found.peaks + begin, troughs=found.troughs + begin)


def _first_slip(features: PullFeatures, teeth: SawTeeth, noise: float) -> PullFeatures:
    """The features with the greatest force before the first slip as their peak.

    The smooth law fitted around a peak does not go through teeth.
    """
    near = features.elongation <= features.peak_elongation + teeth.spacing / 2
    top = int(np.argmax(np.where(near, features.force, -np.inf)))
    return replace(
        features,
        peak_force=float(features.force[top]),
        peak_force_se=noise,
        peak_elongation=float(features.elongation[top]),
    )


def _steady(features: PullFeatures) -> Steady | None:
    """A line through the force after the peak; None where too little of it was recorded."""
    if not features.has_peak:
        return None
    way = float(features.elongation[-1]) - features.peak_elongation
    start, stop = (features.peak_elongation + part * way for part in STEADY)
    inside = (features.elongation >= start) & (features.elongation <= stop)
    x, y = features.elongation[inside], features.force[inside]
    if len(x) < 3 * BLOCKS:
        return None
    # means over blocks: what is alike within a block (a tooth, a patch of film) counts once
    blocks = [[part.mean() for part in np.array_split(values, BLOCKS)] for values in (x, y)]
    line = straight_line(np.array(blocks[0]), np.array(blocks[1]))
    if line is None:
        return None
    slope, error = line.slope, line.slope_se
    return Steady(slope=slope, slope_se=error, force=float(y.mean()), start=start, end=stop)


def off_zero(start: Start, features: PullFeatures) -> bool:
    """Whether the force before the rise is certain, and more than a pull may have by chance."""
    certain = abs(start.baseline) > 4 * (start.baseline_se or 0.0)
    return certain and abs(start.baseline) > TELLS * abs(features.peak_force)


def _notes(
    features: PullFeatures, start: Start, teeth: SawTeeth | None, tared: float | None
) -> list[str]:
    """What a reader should know before using the numbers."""
    out = []
    if tared is not None:
        out.append(f"{show(tared, 'N')} was subtracted from the force, as asked (tare)")
    if off_zero(start, features):
        what = "before the load rises" if start.seen else "at the first sample already"
        ask = "; a preload, or the load cell's zero (--tare subtracts it)" if start.seen else ""
        out.append(f"the force is {show(start.baseline, 'N')} {what}{ask}")
    if features.sparse:
        out.append(
            f"{features.rise_samples} samples between {LINEAR[0]:.0%} and {LINEAR[1]:.0%} of the "
            "greatest force tell no stiffness: pull more slowly, or sample faster"
        )
    elif not features.straight:
        out.append("the force bends off long before its greatest value: no straight rise")
    if not features.has_peak:
        out.append("the force rises to the end: there is no peak and no part after it")
    if teeth is not None:
        out.append(
            f"sticks and slips, {show(teeth.amplitude, 'N')} about its middle every "
            f"{show(teeth.spacing, 'm', 3)}; its peak is static friction at the first slip"
        )
    return out


def _not_used(trace: Trace, unloading: Unloading | None) -> list[str]:
    """That samples follow the greatest elongation, or the return from it, which tell nothing."""
    turn = len(trace) - 1 - int(np.argmax(trace.elongation[::-1]))
    used = turn + 1 if unloading is None else turn + int(np.argmin(trace.elongation[turn:])) + 1
    rest = len(trace) - used
    if rest < FEWEST:
        return []
    after = "its greatest elongation" if unloading is None else "the first return"
    at = show(float(trace.elongation[used - 1]), "m")
    return [f"{rest} samples after {after}, {at}, are not used"]

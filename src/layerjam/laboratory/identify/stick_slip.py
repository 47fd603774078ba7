"""Stick–slip in a measured force: a sawtooth, as distinct from noise, texture and vibration.

While the films stick, the force rises at the stiffness of the pulling parts; when they slip, it
drops suddenly. Stick–slip therefore meets four conditions together: the swing exceeds the noise,
the teeth are regularly spaced, they rise for longer than they fall, and all rise equally fast. With
noise, a rough film or vibration, the force rises and falls for equal times.

A machine may also cause regular teeth, by motor steps, a screw or an alternating drive. Their
spacing does not depend on the swing; that of stick–slip is the swing divided by the stiffness.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from layerjam.core.errors import count_text
from layerjam.core.evolve import evolve
from layerjam.laboratory.identify.statistics import fit_line
from layerjam.laboratory.measure.noise import find_quantum, noise_sd, running_mean
from layerjam.laboratory.measure.trace import Array

Indices = np.ndarray[tuple[int], np.dtype[np.intp]]

LEAST_TEETH = 5
"""Smallest number of teeth; three are enough if they are large and similar."""
LEAST_SWING = 0.02
"""Smallest swing reported, relative to the midpoint force; smaller swings are left in the mean."""
LEAST_SHARE = 0.6
"""Smallest fraction of a tooth during which the force rises; 0.5 indicates a vibration."""
SUDDEN = 0.72
"""Smallest such fraction for dissimilar teeth or fewer than MANY_TEETH; rough films come close."""
MANY_TEETH, ALIKE = 15, 0.3
CLEAR = 4.0
"""Number of standard errors by which the rising fraction must exceed one half."""
MOST_UNLIKE = 0.5
"""Largest scatter of spacings and of rising slopes in stick–slip, relative to their medians."""
STANDS_OUT = 8.0
"""Swing that counts as a reversal, in standard deviations of the smoothed noise."""
SMOOTHINGS = (1, 5, 21, 63, 151)
"""Numbers of samples of the running means, tried until teeth are detected."""
MOST_SAMPLES = 60_000
STUCK = 0.8
"""Smallest stiffness of a tooth's rise while sticking, relative to the stiffness of the pull."""
EQUAL = 0.03
"""Largest relative difference between spacings that count as identical."""
GROWN = 1.5
"""Ratio of swings above which the spacings of stick–slip at one stiffness clearly differ."""
REGULAR = 0.2
"""Largest relative scatter of the spacing in a machine's ripple."""
SPREAD = 0.15
"""Smallest relative scatter of swings that can show whether the rises grow with them."""
LEAST_GROWTH = 0.3
"""Smallest exponent of the rises' growth with the swings in one record that counts as sticking."""
CAUSE = "motor steps, screw or drive of the machine"
"""Likely cause of a ripple of constant spacing."""


@dataclass(frozen=True, kw_only=True)
class SawTeeth:
    """Stick–slip in a section of a record, in SI units.

    `upper` and `lower` are the mean forces at which the teeth end and begin [N], with standard
    errors from their scatter. `spacing` is the crosshead travel between two slips [m], `period` the
    time [s], or None if the record has no time. `rising_share` is the rising fraction of a tooth,
    `irregularity` the relative scatter of the spacing. `growth` is the exponent of the rises'
    growth with the swings: 1 if the sheets stick, 0 for a machine's teeth, None if the teeth are
    too few or too similar. `peaks` and `troughs` are indices into the section.
    """

    upper: float
    lower: float
    upper_se: float
    lower_se: float
    spacing: float
    period: float | None
    teeth: int
    rising_share: float
    irregularity: float
    growth: float | None
    start: float
    end: float
    peaks: Indices = field(compare=False, repr=False)
    troughs: Indices = field(compare=False, repr=False)

    @property
    def amplitude(self) -> float:
        """Half of the swing [N]."""
        return (self.upper - self.lower) / 2

    @property
    def swing(self) -> float:
        """Mean drop in force during a slip [N]."""
        return self.upper - self.lower

    @property
    def stiffness(self) -> float:
        """Stiffness of the rises [N/m]: that of the pulling parts if the sheets really stick."""
        return self.swing / (self.rising_share * self.spacing)

    @property
    def middle(self) -> float:
        """Force midway between the envelopes [N]: the kinetic force if the slips are undamped."""
        return (self.upper + self.lower) / 2


def find_ripple(records: Sequence[SawTeeth | None]) -> list[bool]:
    """Return, for each record of one machine, whether its teeth are a ripple of that machine.

    They are if at least four records, or the teeth of one record, have one regular spacing but
    different swings, which no stiffness explains. Extreme swings do not count. None marks a record
    without teeth.
    """
    regular = [t for t in records if t is not None and t.irregularity <= REGULAR]

    def is_ripple(teeth: SawTeeth | None) -> bool:
        if teeth is None or teeth.irregularity > REGULAR:
            return False
        if teeth.growth is not None and teeth.growth < LEAST_GROWTH:
            return True
        swings = sorted(t.swing for t in regular if abs(t.spacing / teeth.spacing - 1) <= EQUAL)
        return len(swings) >= 4 and swings[-2] > GROWN * swings[1]

    return [is_ripple(teeth) for teeth in records]


class Search(NamedTuple):
    """Saw teeth, or None with the reason why there are none."""

    teeth: SawTeeth | None
    reason: str


def turning_points(values: Array, least: float) -> tuple[Indices, Indices]:
    """Return (peaks, troughs): alternating indices of turns by more than `least`."""
    step = np.diff(values)
    moving = np.flatnonzero(step)
    if not len(moving):
        return np.empty(0, np.intp), np.empty(0, np.intp)
    signs = np.sign(step[moving])
    bends = moving[:-1][signs[1:] != signs[:-1]] + 1
    places = [0, *bends.tolist(), len(values) - 1]
    turns: tuple[list[int], list[int]] = ([], [])
    high = low = places[0]
    up: bool | None = None
    heights = values[places].tolist()
    top = bottom = heights[0]
    for index, height in zip(places, heights, strict=True):
        if height > top:
            top, high = height, index
        if height < bottom:
            bottom, low = height, index
        if up is not False and top - height > least:
            turns[0].append(high)
            up, bottom, low = False, height, index
            top, high = height, index
        elif up is not True and height - bottom > least:
            turns[1].append(low)
            up, top, high = True, height, index
            bottom, low = height, index
    return np.array(turns[0], np.intp), np.array(turns[1], np.intp)


class _Stretch(NamedTuple):
    """A section of sliding, the noise of one sample [N], and the samples per smoothing window."""

    position: Array
    force: Array
    time: Array | None
    noise: float
    samples: int = 1


class _Turns(NamedTuple):
    """Whole teeth as indices: their peaks, starts and ends."""

    peaks: Indices
    starts: Indices
    ends: Indices


def find_saw_teeth(position: Array, force: Array, time: Array | None = None) -> Search:
    """Find saw teeth in a section of sliding: position [m], force [N], time [s], shape (N,).

    The position increases. Smoothings from none to 151 samples are tried, so that teeth smaller
    than the noise of one sample are detected if there are many samples per tooth.
    """
    if len(force) < 3 * LEAST_TEETH:
        return Search(None, f"only {count_text(len(force), 'sample')}")
    # keep single samples at regular intervals, because means would cut off the tips of the teeth
    coarse = max(1, -(-len(force) // MOST_SAMPLES))
    position, force = position[::coarse], force[::coarse]
    noise = max(noise_sd(force), find_quantum(force[:4000]) / 12**0.5)
    stretch = _Stretch(position, force, None if time is None else time[::coarse], noise)
    best, has_reason, reason = None, False, "no swing exceeds the noise"
    for samples in SMOOTHINGS:
        if 4 * samples > len(force):
            break
        smooth = running_mean(force, samples)
        smoothed_noise = noise / samples**0.5
        min_swing = max(STANDS_OUT * smoothed_noise, 0.3 * LEAST_SWING * abs(float(force.mean())))
        peaks, troughs = _find_large_turns(smooth, min_swing)
        teeth, explanation = _judge_turns(stretch._replace(samples=samples), smooth, peaks, troughs)
        if teeth is not None and (best is None or teeth.teeth > best.teeth):
            best, reason = teeth, explanation
        elif best is None and len(peaks) > LEAST_TEETH and not has_reason:
            reason, has_reason = explanation, True  # the reason given for the least smoothed record
        if best is not None and best.upper - best.lower > 2 * STANDS_OUT * smoothed_noise:
            # stop only now: until here, noise hid small teeth, which more smoothing reveals
            break
    if best is not None and coarse > 1:
        best = evolve(best, peaks=best.peaks * coarse, troughs=best.troughs * coarse)
    return Search(best, reason)


def _find_large_turns(smooth: Array, min_swing: float) -> tuple[Indices, Indices]:
    """Return the turning points of the swings above `min_swing`, without small ripples on them."""
    peaks, troughs = turning_points(smooth, min_swing)
    if min(len(peaks), len(troughs)) < 3:
        return peaks, troughs
    turns = np.sort(np.concatenate([peaks, troughs]))
    typical_swing = float(np.percentile(np.abs(np.diff(smooth[turns])), 80))
    return turning_points(smooth, max(min_swing, 0.4 * typical_swing))


def _robust_scatter(values: Array) -> float:
    middle = float(np.median(values))
    return 1.4826 * float(np.median(np.abs(values - middle))) / max(abs(middle), 1e-300)


def _judge_turns(stretch: _Stretch, smooth: Array, peaks: Indices, troughs: Indices) -> Search:
    """Return the teeth that turning points form, or the reason why they form none."""
    position, samples = stretch.position, stretch.samples
    # use whole teeth only (trough, peak, next trough), because the window may cut the first turn
    if len(troughs) and len(peaks):
        troughs = troughs[1:] if troughs[0] < peaks[0] else troughs
        peaks = peaks[1:]
    count = min(len(peaks), len(troughs) - 1)
    if count < 3:
        return Search(None, f"only {max(count, 0)} clear swings: too few to decide")
    peaks, starts, ends = peaks[:count], troughs[:count], troughs[1 : count + 1]
    rise, length = position[peaks] - position[starts], position[ends] - position[starts]
    if not (length > 0).all() or not (rise > 0).all():
        return Search(None, "the crosshead does not move while the force swings")
    share = rise / length
    spread = float(share.std(ddof=1)) / count**0.5
    mean_share = float(share.mean())
    swing = float(np.median(smooth[peaks] - smooth[starts]))
    irregular = _robust_scatter(np.diff(position[peaks]))
    slopes = _robust_scatter((smooth[peaks] - smooth[starts]) / rise)
    middle = float(np.median(smooth[peaks] + smooth[starts])) / 2
    clear = swing > 20 * stretch.noise / samples**0.5 and swing > 0.05 * abs(middle)
    large = clear and mean_share > 0.75 and slopes < 0.25
    if count < LEAST_TEETH and not large:
        return Search(None, f"only {count} clear swings: too few to decide")
    if np.median(np.diff(peaks)) < 4 * samples and samples > 1:
        return Search(None, "swings no longer than the smoothing window")
    is_regular = count >= MANY_TEETH and max(irregular, slopes) <= ALIKE
    least_share = LEAST_SHARE if is_regular else SUDDEN
    if mean_share < least_share or mean_share - 0.5 < CLEAR * spread:
        return Search(
            None,
            f"the force swings {count} times but rises for {mean_share:.0%} of each: a "
            "vibration or a rough film, not stick–slip",
        )
    if irregular > MOST_UNLIKE or slopes > MOST_UNLIKE:
        return Search(None, f"{count} swings without a regular spacing or slope: a rough film")
    teeth = _measure_teeth(stretch, _Turns(peaks, starts, ends))
    if teeth.upper - teeth.lower < LEAST_SWING * abs(teeth.middle):
        part = (teeth.upper - teeth.lower) / abs(teeth.middle)
        return Search(None, f"saw teeth of {part:.1%} of the force, too small to matter")
    return Search(
        teeth,
        f"{count} saw teeth, rising for {mean_share:.0%} of each, spacing within "
        f"{irregular:.0%} of its median",
    )


def _measure_teeth(stretch: _Stretch, turns: _Turns) -> SawTeeth:
    (position, force, time, noise, samples), (peaks, starts, ends) = stretch, turns
    tops, feet = _find_fall_ends(force, turns, samples)
    high, low = force[tops].astype(float), force[feet].astype(float)
    if float(np.median(high - low)) < 50 * noise:
        # the highest sample of a noisy tooth is too high, so use the ends of its straight rise
        for i, (a, b) in enumerate(zip(feet.tolist(), tops.tolist(), strict=True)):
            interior = slice(a + 1, b)
            line = fit_line(position[interior], force[interior]) if b - a > 4 else None
            if line is not None:
                low[i], high[i] = (line.value_at(float(position[k])) for k in (a, b))
    count = len(peaks)
    spacings = np.diff(position[peaks])
    samples_per_tooth = float(np.median(np.diff(peaks)))
    # a tooth ends somewhere between two samples, or within the smoothing window
    uncertainty = (samples / 2) * float(np.mean(high - low)) / samples_per_tooth
    return SawTeeth(
        upper=float(high.mean()),
        lower=float(low.mean()),
        upper_se=float(np.hypot(high.std(ddof=1) / count**0.5, uncertainty / 2)),
        lower_se=float(np.hypot(low.std(ddof=1) / count**0.5, uncertainty / 2)),
        spacing=float(np.median(spacings)),
        period=None if time is None else float(np.median(np.diff(time[peaks]))),
        teeth=count,
        rising_share=float(
            ((position[peaks] - position[starts]) / (position[ends] - position[starts])).mean()
        ),
        irregularity=_robust_scatter(spacings),
        growth=_growth_exponent(position[peaks] - position[starts], high - low, noise),
        start=float(position[starts[0]]),
        end=float(position[ends[-1]]),
        peaks=tops,
        troughs=feet,
    )


def _growth_exponent(rise: Array, swing: Array, noise: float) -> float | None:
    """Return the exponent of the rises versus the swings; `noise` is that of a force [N]."""
    if len(rise) < MANY_TEETH or not (swing > 0).all():
        return None
    spread = float(np.log(swing).var(ddof=1))
    if spread < max(SPREAD**2, 20 * (noise / float(np.median(swing))) ** 2):
        return None
    return float(np.cov(np.log(swing), np.log(rise))[0, 1]) / spread


def _find_fall_ends(force: Array, turns: _Turns, samples: int) -> tuple[Indices, Indices]:
    """Return (tops, feet) of the teeth; smoothing moves tops earlier and feet later.

    A fall is centred where the means over half a smoothing before and after it differ most.
    """
    peaks, starts, ends = turns
    if samples < 3:
        return peaks, starts
    half_window = samples // 2
    sums = np.cumsum(np.concatenate([[0.0], force]))
    last = len(force) - 1

    def find_fall(early: int, late: int) -> tuple[int, int]:
        places = np.arange(max(early, half_window), min(late, last - half_window) + 1)
        if not len(places):
            return early, late
        before = sums[places + 1] - sums[places + 1 - half_window]
        after = sums[places + 1 + half_window] - sums[places + 1]
        centre = int(places[np.argmax(before - after)])
        reach = max(late - early - samples, 0) // 2
        return max(centre - reach, 0), min(centre + 1 + reach, last)

    fall_ends = [find_fall(p, t) for p, t in zip(peaks.tolist(), ends.tolist(), strict=True)]
    tops = np.array([top for top, _ in fall_ends], np.intp)
    feet = np.array([starts[0], *(foot for _, foot in fall_ends[:-1])], np.intp)
    return np.maximum(tops, feet + 1), feet

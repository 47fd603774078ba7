"""Record of a friction test: its outward part, the zero and drift of its load cell, and its spikes.

A zero that drifts and a friction that changes along the film look the same within the window of the
kinetic mean. A record that goes on until the string is slack again shows which one it is.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from layerjam.core.errors import FileError
from layerjam.core.evolve import evolve
from layerjam.core.units import show
from layerjam.laboratory.identify.friction.breakaway import Inertia
from layerjam.laboratory.identify.friction.spikes import Spike, find_spikes, remove_spikes
from layerjam.laboratory.identify.load_cell import Zero, find_released_force, find_zero
from layerjam.laboratory.identify.statistics import fit_line
from layerjam.laboratory.identify.stick_slip import SawTeeth
from layerjam.laboratory.measure.noise import find_quantum, running_mean
from layerjam.laboratory.measure.saturation import Plateau, find_plateau
from layerjam.laboratory.measure.trace import Array, Trace

SLIDES = 0.8
"""Part of the sliding force at which the sled counts as sliding."""
BLOCKS = 24
"""Number of means over the window; their scatter sets the error of the slope, so that a patch of
the film counts once."""
LASTS = 0.9
"""Part of the record that a plateau must reach to count as steady sliding."""
CERTAIN = 3.0
"""Number of standard errors by which a drift must exceed zero."""


@dataclass(frozen=True, kw_only=True)
class SledRecord:
    """Outward part of a friction test without spikes, in SI units; arrays of shape (N,).

    `travel` is that of the crosshead from the first sample, `time` is None if unknown. `level` is
    the usual force while sliding. `zero` is the force before the load, None if the record does not
    show it, and `tare_force` the force that was subtracted. `end_force` is the force after the test
    with a slack string, None if it was not recorded. `quantum` is the resolution of the force.
    """

    travel: Array
    force: Array
    time: Array | None
    level: float
    zero: Zero | None
    tare_force: float | None
    end_force: float | None
    spikes: tuple[Spike, ...]
    plateau: Plateau | None
    quantum: float
    samples: int
    """Samples of the whole record, with the return stroke."""

    @property
    def sliding_from(self) -> float:
        """Travel at which the sled slides for the first time [m]."""
        base = 0.0 if self.zero is None else self.zero.force
        smooth = running_mean(self.force, 3)
        return float(self.travel[int(np.argmax(smooth >= base + SLIDES * (self.level - base)))])

    def without_curve(self) -> "SledRecord":
        """Return the record with empty arrays, so that long records need not stay in memory."""
        empty = np.empty(0)
        return evolve(self, travel=empty, force=empty, time=None)

    def notes(self) -> Iterator[str]:
        """Yield one note for each spike, and one for the force that was subtracted."""
        if self.tare_force is not None:
            yield f"{show(self.tare_force, 'N')} was subtracted from the force (tare)"
        for spike in self.spikes:
            place = show(float(self.travel[spike.start]), "m")
            if self.time is not None:
                place = f"{show(float(self.time[spike.start]), 's')} ({place} of travel)"
            samples = f"{spike.samples} sample{'s' * (spike.samples > 1)}"
            yield (
                f"a spike of {show(spike.height, 'N', 3)} over {samples} at {place} is faster than "
                "the string can stretch; it is left out"
            )

    def drift(self, is_inside: npt.NDArray[np.bool_]) -> tuple[float, float | None]:
        """Return (slope, levels): two estimates of the drift from the zero to a window [N].

        The slope in the window (mask `is_inside`) is extrapolated to the beginning of the record;
        it is 0 if it is due to chance. The levels before and after the test are interpolated; None
        if either is unknown.
        """
        place = np.flatnonzero(is_inside).astype(float)
        middle = float(place.mean())
        blocks = np.array_split(np.arange(len(place)), min(BLOCKS, len(place) // 2))
        force = self.force[is_inside]
        line = fit_line(
            np.array([place[b].mean() for b in blocks]), np.array([force[b].mean() for b in blocks])
        )
        slope = 0.0
        if line is not None and abs(line.slope) > CERTAIN * line.slope_se:
            slope = line.slope * middle
        if self.end_force is None or self.zero is None:
            return slope, None
        return slope, (self.end_force - self.zero.force) * middle / self.samples


@dataclass(frozen=True, kw_only=True)
class FrictionRepeat:
    """One repeat: coefficients [-], travel at the maximum force [m], and source.

    `kinetic` is None if the record shows stick–slip, unless the middle of the envelope was
    accepted. `mean` is the ratio of mean force to normal force over the travel `window` [m].
    `teeth` is the stick–slip there (forces in N), `ripple` that of the machine. `distinct` means
    that a standard's first maximum is clear, `synthetic` that a program generated the file.
    `record` is the test without its curve (see `SledRecord`). `limits` are the largest errors that
    the resolution causes in `static` and `kinetic`. `drift` is that of the force up to the window
    [N]: from the slope there, and from the levels before and after the test if they are known.
    """

    static: float
    kinetic: float | None
    mean: float
    static_at: float
    samples: int
    path: str
    window: tuple[float, float]
    speed: float | None = None
    distinct: bool = True
    teeth: SawTeeth | None = None
    ripple: SawTeeth | None = None
    inertia: Inertia | None = None
    warnings: tuple[str, ...] = ()
    synthetic: bool = False
    record: SledRecord = field(repr=False, compare=False)
    sliding_from: float
    limits: Mapping[str, float]
    drift: tuple[float, float | None]


def read_record(trace: Trace, tare: bool = False) -> SledRecord:
    """Return the outward part of a friction test, without spikes.

    With `tare` the force before the load is subtracted; FileError if the record does not show it.
    """
    travel = trace.elongation - trace.elongation[0]
    if travel[-1] < 0:
        travel = -travel
    last = len(travel) - int(np.argmax(travel[::-1]))
    travel, raw = travel[:last], trace.force[:last]
    level = float(np.median(raw[travel >= 0.5 * travel[-1]]))
    spikes = find_spikes(travel, raw, level)
    force = remove_spikes(raw, spikes)
    zero, tare_force = find_zero(force, level), None
    if tare:
        if zero is None:
            raise FileError(
                trace.path,
                "starts during its rise: there is no earlier force to subtract (tare)",
            )
        tare_force = zero.force
        force, level = force - tare_force, level - tare_force
        zero = Zero(force=0.0, error=zero.error)
    plateau = find_plateau(force)
    return SledRecord(
        travel=travel,
        force=force,
        time=None if trace.time is None else trace.time[:last],
        level=level,
        zero=zero,
        tare_force=tare_force,
        end_force=find_released_force(trace.force[last:] - (tare_force or 0.0), level),
        spikes=tuple(spikes),
        plateau=plateau if plateau is not None and plateau.end > LASTS * len(force) else None,
        quantum=find_quantum(raw),
        samples=len(trace),
    )


def crosshead_speed(trace: Trace) -> float | None:
    """Return the speed of the moving crosshead [m/s], from the record or else from its sidecar."""
    if trace.time is not None and len(trace) > 2:
        travel = np.abs(trace.elongation - trace.elongation[0])
        moving = (travel > 0.1 * travel.max()) & (travel < 0.9 * travel.max())
        clock = trace.time[moving]
        if moving.sum() > 2 and np.ptp(clock) > 0:
            return float(np.ptp(travel[moving]) / np.ptp(clock))
    return trace.facts.speed

"""A measured curve in SI units, and the checks that every curve must pass."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from layerjam.core.brief import brief
from layerjam.core.errors import FileError, QuantityError, UnknownNameError, explain_arguments
from layerjam.core.units import show
from layerjam.laboratory.measure.saturation import find_plateau
from layerjam.laboratory.measure.sidecar import Facts

Array = npt.NDArray[np.float64]

FEWEST_ROWS = 10
# no test machine exceeds these: a larger number means a damaged file; its square could overflow
_LARGEST = {"force": (1e8, "N"), "elongation": (1e3, "m"), "time": (1e11, "s")}


@brief
@explain_arguments
@dataclass(frozen=True, eq=False)
class Trace:
    """One pull or friction test as recorded by a machine, in SI units.

    `force` [N] and `elongation` [m] (with the machine's own origin) are float64 arrays of equal
    length with finite values, as is `time` [s], unless it is None. `format` names the machine's
    format, `understood` describes the interpretation of the columns, `warnings` lists anomalies,
    `facts` contains the metadata of the sidecar.
    """

    force: Array = field(repr=False)
    elongation: Array = field(repr=False)
    time: Array | None = field(repr=False)
    path: str
    format: str
    understood: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    facts: Facts = field(default_factory=Facts)
    specimen: str = ""
    """Name of the specimen, if the file has several."""
    start: float | None = None
    """Start of the test [s since 1970, UTC] that the file or its sidecar states, or None."""

    def __len__(self) -> int:
        return len(self.force)

    @property
    def travel(self) -> Array:
        """Return the elongation relative to the first sample [m]."""
        return self.elongation - self.elongation[0]

    @property
    def synthetic(self) -> bool:
        """Whether a program generated the file, according to its sidecar or to the file itself."""
        return self.facts.synthetic

    def between(
        self, start: float | None = None, end: float | None = None, *, over: str = "time"
    ) -> "Trace":
        """Return the samples from `start` to `end` in `over`: "time" [s] or "elongation" [m].

        None leaves an end open. Raises QuantityError if fewer than 10 samples remain.
        """
        if over not in ("time", "elongation"):
            raise UnknownNameError("over", over, ("time", "elongation"))
        clock = getattr(self, over)
        if clock is None:
            raise QuantityError(f"between: {self.path} contains no time; cut it by elongation")
        unit = "s" if over == "time" else "m"
        low, high = -np.inf if start is None else start, np.inf if end is None else end
        inside = (clock >= low) & (clock <= high)
        span = " ".join(
            f"{word} {show(v, unit)}" for word, v in (("from", start), ("to", end)) if v is not None
        )
        if inside.sum() < FEWEST_ROWS:
            raise QuantityError(
                f"between: {int(inside.sum())} samples of {self.path} lie within its {over} {span}"
                f"; at least {FEWEST_ROWS} are needed"
            )
        return replace(
            self,
            force=self.force[inside],
            elongation=self.elongation[inside],
            time=None if self.time is None else self.time[inside],
            understood=(*self.understood, f"cut to its {over} {span}"),
        )

    def thinned(self, most: int) -> "Trace":
        """Return the record reduced to at most `most` samples, as means of neighbours."""
        time = None if self.time is None else block_means(self.time, most)
        force, elongation = (block_means(a, most) for a in (self.force, self.elongation))
        return replace(self, force=force, elongation=elongation, time=time)


def block_means(values: Array, limit: int) -> Array:
    """Return at most `limit` means, each over the same number of neighbouring values."""
    size = -(-len(values) // limit)
    if size <= 1:
        return values
    starts = np.arange(0, len(values), size)
    count = np.diff(np.append(starts, len(values)))
    return np.asarray(np.add.reduceat(values, starts) / count)


def check_trace(trace: Trace, line: Callable[[int], int | None], *, turned: bool = False) -> Trace:
    """Return the trace with its warnings; raises FileError if it cannot be a tension test.

    `line` returns the line in the file for a row (0-based); `turned` means that the user changed
    the sign of the force. The check rejects fewer than 10 rows, and values that are not finite or
    exceed those of any test machine. It also rejects decreasing time, a force that never changes or
    is saturated, and signs of compression.
    """
    rows = len(trace)
    if rows < FEWEST_ROWS:
        raise FileError(
            trace.path, f"contains {rows} rows of numbers; at least {FEWEST_ROWS} are needed"
        )
    for name, (largest, unit) in _LARGEST.items():
        values = getattr(trace, name)
        if values is None:
            continue
        is_invalid = ~(np.abs(values) <= largest)
        if is_invalid.any():
            row = int(is_invalid.argmax())
            raise FileError(
                trace.path,
                f"{name} {show(float(values[row]), unit)} is beyond the range of any test "
                f"machine (at most {show(largest, unit)})",
                line(row),
            )
    warnings = [*trace.warnings, *_check_time(trace, line), *_check_signs(trace, turned)]
    _check_saturation(trace)
    _check_plateau(trace)
    return replace(trace, warnings=tuple(warnings))


def _check_time(trace: Trace, line: Callable[[int], int | None]) -> list[str]:
    if trace.time is None:
        return []
    step = np.diff(trace.time)
    if (step < 0).any():
        row = int((step < 0).argmax()) + 1
        before, after = float(trace.time[row - 1]), float(trace.time[row])
        raise FileError(
            trace.path, f"time runs backwards, from {before:.9g} s to {after:.9g} s", line(row)
        )
    repeats = int((step == 0).sum())
    if repeats == len(step):
        return [f"the time never changes; it stays at {float(trace.time[0]):.9g} s"]
    if repeats:
        return [f"{repeats} of {len(trace)} time stamps repeat the previous one"]
    return []


def _check_signs(trace: Trace, turned: bool) -> list[str]:
    force, travel = trace.force, trace.travel
    low, high, mean = float(force.min()), float(force.max()), float(force.mean())
    if low < 0 and -low > high and mean < 0:
        reason, hint = (
            (" once its sign is changed", "; omit --negative force")
            if turned
            else (
                ", as in compression; if this machine records tension as negative, specify this",
                " (--negative force)",
            )
        )
        largest = f"the force of largest magnitude is negative ({show(low, 'N')})"
        raise FileError(trace.path, largest + reason, how=hint, asks="force-sign")
    farthest, lowest = float(travel.max()), -float(travel.min())
    if lowest > 0 and farthest < 0.1 * lowest:
        raise FileError(
            trace.path,
            f"the elongation falls by {show(lowest, 'm')} and hardly ever rises; if this "
            "machine records elongation as negative, specify this",
            how=" (--negative elongation)",
            asks="elongation-sign",
        )
    if farthest == 0:
        raise FileError(trace.path, "the elongation never changes: nothing was pulled")
    if low < 0 and -low > 0.1 * high:
        return [
            (
                f"the force falls to {show(low, 'N')}: the brake was compressed, or the load cell "
                "was not zeroed"
            )
        ]
    return []


def _check_saturation(trace: Trace) -> None:
    """Reject a force that stays at its maximum while the crosshead keeps moving.

    A saturated load cell repeats one number; a real plateau has noise, so its maximum is rare. The
    force is rejected if the maximum occurs at least 20 times (fewer in short records). It must also
    occur ten times as often, in a row or in total, as any other value in the upper half. If no
    other value repeats, 20 times is enough. The factor of ten accepts smooth peaks of coarse
    resolution, whose top level is at most about five times as long as its neighbours. A hold with
    the crosshead at rest is not saturation.
    """
    force, rows = trace.force, len(trace)
    top = float(force.max())
    if float(force.min()) == top:
        raise FileError(
            trace.path,
            f"the force is {show(top, 'N')} in every row: the load cell did not measure",
        )
    min_count = int(min(20, max(8, rows // 10)))
    at_top = force >= top - 1e-9 * abs(top)
    stuck = int(at_top.sum())
    if top <= 0 or stuck < min_count:
        return
    if np.ptp(trace.elongation[at_top]) < 0.005 * np.ptp(trace.elongation):
        return
    if np.unique(force).size < 10:
        return  # the resolution is too coarse to tell whether the crosshead is at rest
    upper = (force > top / 2) & ~at_top
    _, counts = np.unique(force[upper], return_counts=True)
    often, longest = int(counts.max(initial=1)), _find_longest_run(upper, force)
    stuck_run = _find_longest_run(at_top, np.where(at_top, top, force))
    if _is_far_more(stuck, often, min_count) or _is_far_more(stuck_run, longest, min_count):
        raise FileError(
            trace.path,
            f"the load cell was saturated: {stuck} of {rows} samples are at exactly "
            f"{show(top, 'N', 6)} while the crosshead moves",
        )


def _check_plateau(trace: Trace) -> None:
    """Reject a force whose top is a plateau with noise, from which it falls while being pulled.

    A plateau that lasts to the end may be a steady friction force, so it is not rejected here.
    """
    end = int(np.argmax(trace.elongation)) + 1
    plateau = find_plateau(trace.force[:end])
    if plateau is None or not plateau.ends:
        return
    travel = float(np.ptp(trace.elongation[plateau.start : plateau.end]))
    if travel < 0.001 * float(np.ptp(trace.elongation)):
        return
    raise FileError(
        trace.path,
        f"the load cell was saturated: {plateau.count} samples in a row are at "
        f"{show(plateau.level, 'N')} within the noise of {show(plateau.noise, 'N', 2)} while the "
        "crosshead moves",
    )


def _is_far_more(stuck: int, typical_count: int, minimum: int) -> bool:
    """Return whether a count is ten times the others', or at least `minimum` if none repeats."""
    return stuck >= max(minimum, 10 * typical_count if typical_count > 1 else minimum)


def _find_longest_run(mask: npt.NDArray[np.bool_], force: Array) -> int:
    if not mask.any():
        return 0
    starts = np.flatnonzero(mask & np.r_[True, (np.diff(force) != 0) | ~mask[:-1]])
    ends = np.flatnonzero(mask & np.r_[(np.diff(force) != 0) | ~mask[1:], True])
    return int((ends - starts).max()) + 1

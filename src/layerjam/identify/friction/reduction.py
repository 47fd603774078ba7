"""Friction tests read as the paper does (section III-C), as ASTM D1894 or as ISO 8295.

The paper: static is the greatest force of a repeat, kinetic the mean over 40 to 100 mm of travel.
The standards: static is the first maximum, kinetic the mean over a travel that begins where the
films slide. Then mean, sample standard deviation and 95 % t interval over the repeats. A record
with stick–slip in it has no kinetic friction to be averaged: its envelope is reported instead.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from layerjam._version import __version__
from layerjam.device.file import BrakeFile, updated_text
from layerjam.device.mount import Site
from layerjam.errors import FileError, FitError, count_of
from layerjam.identify.friction.agreement import friction_checks
from layerjam.identify.friction.breakaway import Breakaway, Inertia, find_breakaway, inertia_of
from layerjam.identify.friction.standards import PAPER, Standard
from layerjam.identify.provenance import digests, marked, sha256
from layerjam.identify.repeats import OverRepeats, over_repeats
from layerjam.identify.stick_slip import SawTeeth, find_saw_teeth
from layerjam.measure.trace import Array, Trace
from layerjam.records.source import Source
from layerjam.units import show
from layerjam.verdict import Acceptance, Check

WINDOW = PAPER.window
GRAVITY = Site().gravity
SHORTEST = 0.5
"""Part of a standard's travel that a record must cover to be reduced at all (with a warning)."""
FEWEST = 10
"""Samples needed in the window."""


@dataclass(frozen=True, kw_only=True)
class FrictionRepeat:
    """One repeat: coefficients [-], where its maximum lies [m of travel], where it came from.

    `kinetic` is None where the record sticks and slips, unless the envelope's middle was accepted.
    `window` is the travel the mean was taken over [m], `teeth` the stick–slip in it (forces in N).
    `distinct`: a standard's first maximum stands out; `synthetic`: a program wrote the file.
    """

    static: float
    kinetic: float | None
    static_at: float
    samples: int
    path: str
    window: tuple[float, float]
    speed: float | None = None
    distinct: bool = True
    teeth: SawTeeth | None = None
    inertia: Inertia | None = None
    warnings: tuple[str, ...] = ()
    synthetic: bool = False


@dataclass(frozen=True, kw_only=True)
class StickSlip:
    """The envelope over the repeats that stick and slip, as coefficients [-].

    `period` [s] is None where a record has no time, `spacing` is in m of travel.
    """

    upper: float
    lower: float
    amplitude: float
    middle: float
    relative_amplitude: float
    period: float | None
    spacing: float
    files: tuple[str, ...]
    accepted: bool
    reason: str


@dataclass(frozen=True, kw_only=True)
class FrictionResult:
    """Coefficients [-] over all repeats, by kind ("static", "kinetic") what is known of the mean.

    The kinetic one is None where a repeat sticks and slips, unless the middle of the stick–slip was
    accepted; standard deviations between repeats are absolute, None for one repeat. `window` is the
    travel of the kinetic mean [m], on average over the repeats.
    """

    static: float
    static_sd: float | None
    kinetic: float | None
    kinetic_sd: float | None
    over: Mapping[str, OverRepeats | None]
    stick_slip: StickSlip | None
    repeats: tuple[FrictionRepeat, ...]
    normal_force: float
    window: tuple[float, float]
    warnings: tuple[str, ...]
    standard: Standard
    checks: tuple[Check, ...]

    @property
    def means(self) -> dict[str, OverRepeats]:
        """The coefficients that are known, by name."""
        return {name: over for name, over in self.over.items() if over is not None}

    def sources(self) -> dict[str, tuple[float, Source]]:
        """What to write into a brake file: {path: (value, Source)}; no kinetic if it is None."""
        files = ", ".join(Path(r.path).name + _digest(r.path) for r in self.repeats)
        start, end = (show(w, "m") for w in self.window)
        text = (
            f"friction test ({self.standard.title}), {files}; "
            f"normal force {show(self.normal_force, 'N')}"
        )
        mean = f"mean over {start} to {end}"
        if self.stick_slip is not None:
            mean = f"{mean}; middle of the stick–slip where it sticks and slips"
        first = "first maximum" if self.standard.first_maximum else "maximum"
        how = {"static": f"{first} of each repeat", "kinetic": mean}
        out = {}
        for name, over in self.means.items():
            spread = f"SD {over.sd:.4g}" if over.sd is not None else ""
            words = f"{text}; {how[name]}; {over.interval_words()}"
            sd = None if over.sd is None else round(over.sd / over.mean, 4)
            source = Source(kind="measured", text=words, spread=spread, sd=sd)
            out[f"film.{name}"] = (over.mean, source)
        return out


def _digest(path: str) -> str:
    """The file's SHA-256, its first digits; nothing for what is no file."""
    return f" (SHA-256 {sha256(path)[:16]})" if path and Path(path).is_file() else ""


def _outward(trace: Trace) -> tuple[Array, Array, Array | None]:
    """Travel [m] from the first sample, force [N] and time [s], without the return."""
    travel = trace.elongation - trace.elongation[0]
    if travel[-1] < 0:
        travel = -travel
    last = len(travel) - int(np.argmax(travel[::-1]))
    time = None if trace.time is None else trace.time[:last]
    return travel[:last], trace.force[:last], time


def speed_of(trace: Trace) -> float | None:
    """Speed of the moving crosshead [m/s], from the record or else its sidecar."""
    if trace.time is not None and len(trace) > 2:
        gone = np.abs(trace.elongation - trace.elongation[0])
        moving = (gone > 0.1 * gone.max()) & (gone < 0.9 * gone.max())
        clock = trace.time[moving]
        if moving.sum() > 2 and np.ptp(clock) > 0:
            return float(np.ptp(gone[moving]) / np.ptp(clock))
    return trace.facts.speed


def reduce_repeat(
    trace: Trace,
    normal_force: float,
    window: tuple[float, float] | None = None,
    standard: Standard = PAPER,
    accept_stick_slip: bool = False,
) -> FrictionRepeat:
    """One repeat's coefficients; `normal_force` [N].

    A `window` [m] counts travel from the record's first sample; without one the standard's holds.
    With `accept_stick_slip` the middle of the stick–slip's envelope serves as kinetic friction.
    Raises FileError where the record does not cover the window.
    """
    travel, force, time = _outward(trace)
    found = find_breakaway(travel, force) if standard.first_maximum else None
    span, warnings = _window(trace, travel, window, standard, found)
    inside = (travel >= span[0]) & (travel <= span[1])
    if inside.sum() < FEWEST:
        raise FileError(
            trace.path,
            f"only {count_of(int(inside.sum()), 'sample')} between {show(span[0], 'm')} and "
            f"{show(span[1], 'm')} of travel; at least {FEWEST} are needed",
        )
    mean = float(force[inside].mean())
    kinetic: float | None = mean / normal_force
    if mean <= 0:
        raise FileError(trace.path, f"the mean force in the window is {mean} N")
    clock = None if time is None else time[inside]
    teeth = find_saw_teeth(travel[inside], force[inside], clock).teeth
    if teeth is not None:
        kinetic = teeth.middle / normal_force if accept_stick_slip else None
    speed = speed_of(trace)
    inertia = None
    if found is None:
        top = int(np.argmax(force))
        static = float(force[top])
    else:
        top, static = found.at, found.force
        mass = normal_force / GRAVITY if standard.sled_mass is None else standard.sled_mass
        if speed is not None and found.distinct:
            inertia = inertia_of(travel, force, time, found, mass, speed)
        warnings += _of_breakaway(found, inertia, normal_force)
    warnings += _against(standard, speed, time, travel)
    return FrictionRepeat(
        static=static / normal_force,
        kinetic=kinetic,
        static_at=float(travel[top]),
        samples=len(trace),
        path=trace.path,
        window=span,
        speed=speed,
        distinct=found is None or found.distinct,
        teeth=teeth,
        inertia=inertia,
        warnings=tuple(warnings),
        synthetic=trace.synthetic,
    )


def _window(
    trace: Trace,
    travel: Array,
    given: tuple[float, float] | None,
    standard: Standard,
    found: Breakaway | None,
) -> tuple[tuple[float, float], list[str]]:
    """The travel of the kinetic mean [m], and what is odd about it."""
    far = float(travel.max())
    start, end = given or standard.window
    if given is None and found is not None and standard.from_sliding:
        begin, run = float(travel[found.sliding]), end - start
        if far - begin < SHORTEST * run:
            raise FileError(
                trace.path,
                f"the films slide over {show(far - begin, 'm')} only; {standard.title} takes the "
                f"kinetic friction over {show(run, 'm')} (another travel: --from, --to)",
            )
        if far - begin >= 0.99 * run:
            return (begin, min(begin + run, far)), []
        said = (
            f"the kinetic mean runs over {show(far - begin, 'm')} of sliding, "
            f"{standard.title} asks for {show(run, 'm')}"
        )
        # the rise is part of a machine's stated travel, so that a full test ends a little early
        return (begin, far), [said] if far < 0.99 * run else []
    if far < end - 0.01 * (end - start):
        raise FileError(
            trace.path,
            f"travel ends at {show(far, 'm')}; the kinetic window is {show(start, 'm')} to "
            f"{show(end, 'm')} (another one: --from, --to)",
        )
    return (start, end), []


def _of_breakaway(found: Breakaway, inertia: Inertia | None, normal_force: float) -> list[str]:
    """What the breakaway says against its static friction."""
    if not found.distinct:
        return [
            "no first maximum stands out: static is where the rise bends into sliding, the same "
            "as the kinetic level"
        ]
    if inertia is None or inertia.most < 0.01 * found.force:
        return []
    return [
        f"the sled's inertia may lift the first maximum by up to {show(inertia.most, 'N', 2)} "
        f"({inertia.most / normal_force:.2g} in the static "
        "coefficient): V sqrt(k m); pull slower or through a softer spring"
    ]


def _against(
    standard: Standard, speed: float | None, time: Array | None, travel: Array
) -> list[str]:
    """Where the record shows that the test was not done as the standard says."""
    out = []
    if speed is not None and abs(speed / standard.speed - 1) > standard.speed_tolerance + 0.005:
        out.append(
            f"pulled at {show(speed * 60e3, '1')} mm/min; {standard.title} at "
            f"{show(standard.speed * 60e3, '1')} mm/min"
        )
    if standard.dwell is not None:
        moved = np.flatnonzero(np.abs(travel) > 1e-5 + 1e-3 * float(travel.max()))
        rest = 0.0 if time is None or not len(moved) else float(time[moved[0]] - time[0])
        if rest < 0.9 * standard.dwell:
            out.append(
                f"the record does not show the {standard.dwell:g} s at rest before the pull, on "
                "which static friction depends"
            )
    return out


def reduce_friction(
    traces: Sequence[Trace],
    normal_force: float,
    window: tuple[float, float] | None = None,
    standard: Standard = PAPER,
    accept_stick_slip: bool = False,
) -> FrictionResult:
    """Static and kinetic friction from repeats; `normal_force` [N], `window` [m] of travel.

    Raises FitError without any trace, FileError for one that does not cover the window.
    """
    if not traces:
        raise FitError("friction: no repeat was given")
    if window is not None and not 0 <= window[0] < window[1]:
        raise FitError(
            f"friction: the window from {show(window[0], 'm')} to {show(window[1], 'm')} is empty"
        )
    repeats = [reduce_repeat(t, normal_force, window, standard, accept_stick_slip) for t in traces]
    said = [w for t in traces for w in t.warnings]
    return pooled(repeats, said, normal_force, window, standard, accept_stick_slip)


def pooled(
    repeats: Sequence[FrictionRepeat],
    said: Sequence[str],
    normal_force: float,
    window: tuple[float, float] | None,
    standard: Standard,
    accept_stick_slip: bool,
    expected: tuple[float, float] | None = None,
) -> FrictionResult:
    """Mean, scatter and interval over repeats that `reduce_repeat` made; `said` of their files.

    `expected` is the plausible range of the kinetic friction [-], None if the film is unknown.
    """
    values = {n: [getattr(r, n) for r in repeats] for n in ("static", "kinetic", "speed")}
    warnings = [*said, *_said_once(repeats), *(w for r in repeats for w in _odd_peak(r))]
    static = over_repeats(values["static"])
    kinetic = None if None in values["kinetic"] else over_repeats(values["kinetic"])
    over = {"static": static, "kinetic": kinetic}
    return FrictionResult(
        static=static.mean,
        static_sd=static.sd,
        kinetic=None if kinetic is None else kinetic.mean,
        kinetic_sd=None if kinetic is None else kinetic.sd,
        over=over,
        stick_slip=_stick_slip(repeats, normal_force, accept_stick_slip),
        repeats=tuple(repeats),
        normal_force=normal_force,
        window=window or _mean_span(repeats),
        warnings=tuple(dict.fromkeys(warnings)),
        standard=standard,
        checks=friction_checks([r.path for r in repeats], values, over, expected),
    )


def _stick_slip(
    repeats: Sequence[FrictionRepeat], normal_force: float, accepted: bool
) -> StickSlip | None:
    files = tuple(r.path for r in repeats if r.teeth is not None)
    teeth = [r.teeth for r in repeats if r.teeth is not None]
    if not teeth:
        return None

    def mean(name: str) -> float:
        return sum(getattr(t, name) for t in teeth) / len(teeth)

    upper, lower = (mean(name) / normal_force for name in ("upper", "lower"))
    kinetic = ": kinetic is the middle of its envelope"
    if not accepted:
        kinetic = ", so that kinetic is not reported"
    return StickSlip(
        upper=upper,
        lower=lower,
        amplitude=(upper - lower) / 2,
        middle=(upper + lower) / 2,
        relative_amplitude=(upper - lower) / (upper + lower),
        period=None if None in (t.period for t in teeth) else mean("period"),
        spacing=mean("spacing"),
        files=files,
        accepted=accepted,
        reason=f"stick–slip has no plain mean{kinetic}",
    )


def _said_once(repeats: Sequence[FrictionRepeat]) -> list[str]:
    """What the repeats have to say, with the files each sentence is about."""
    about: dict[str, list[str]] = {}
    for repeat in repeats:
        for sentence in repeat.warnings:
            about.setdefault(sentence, []).append(repeat.path)
    whole = {s: len(p) == len(repeats) > 1 for s, p in about.items()}
    return [
        f"{f'all {len(repeats)} repeats' if whole[s] else ', '.join(paths)}: {s}"
        for s, paths in about.items()
    ]


def _mean_span(repeats: Sequence[FrictionRepeat]) -> tuple[float, float]:
    """The travel of the kinetic mean [m], on average where the repeats' differ."""
    start, end = np.mean([*dict.fromkeys(r.window for r in repeats)], axis=0)
    return float(start), float(end)


def _odd_peak(repeat: FrictionRepeat) -> list[str]:
    if repeat.static_at <= repeat.window[0] or repeat.teeth is not None:
        return []
    return [
        f"{repeat.path}: the greatest force lies at {show(repeat.static_at, 'm')} of travel, "
        "inside the kinetic window; it may not be the static peak"
    ]


def with_friction(
    file: BrakeFile, result: FrictionResult, name: str, accepted: Sequence[Acceptance] = ()
) -> tuple[str, list[str]]:
    """(TOML text, warnings): the brake with measured friction and its scale factor back at 1.

    A scale factor belongs to the friction it was fitted with, so a new friction voids it. The
    [made_by] table names files with their SHA-256, standard, window and intervals. Raises FitError
    where stick–slip leaves the kinetic friction unknown.
    """
    if result.kinetic is None:
        raise FitError(
            "friction: the films stick and slip, so that there is no kinetic friction to write "
            "into the brake (--accept-stick-slip takes the middle of the stick–slip)"
        )
    blank = Source(kind="assumed", text="not calibrated with this friction yet")
    changes = {**result.sources(), "scale_factor": (1.0, blank)}
    warnings = []
    if file.brake.scale_factor != 1.0:
        warnings.append(
            f"the scale factor {file.brake.scale_factor:g} belonged to the old friction and is 1 "
            "now; run 'layerjam calibrate' next"
        )
    if file.brake.film.ageing is not None:
        warnings.append(
            "film.ageing and film.static_hold belonged to the old static friction; run "
            "'layerjam ageing' next"
        )
    if file.brake.amplification_held is not None:
        changes["amplification_held"] = (1.0, blank)
    made = _made_by(result, made_up := {r.path for r in result.repeats if r.synthetic})
    return updated_text(file, name, marked(changes, bool(made_up)), made, accepted), warnings


def _made_by(result: FrictionResult, synthetic: Collection[str]) -> dict[str, Any]:
    start, end = (show(w, "m") for w in result.window)
    means = (f"{name} {o.mean:.4g}, {o.interval_words()}" for name, o in result.means.items())
    sticking, middle = 0, ""
    if result.stick_slip is not None:
        sticking = len(result.stick_slip.files)
        middle = "; kinetic is the middle of its envelope"
    return {
        "program": f"layerjam {__version__} friction",
        "standard": result.standard.title,
        "window": f"{start} to {end} of travel",
        "interval": "; ".join(means),
        "stick_slip": f"in {sticking} of {len(result.repeats)} repeats{middle}",
        "files": digests((r.path for r in result.repeats), synthetic),
    }

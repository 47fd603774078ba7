"""Friction tests by the paper's rules (section III-C), ASTM D1894 or ISO 8295.

In the paper, static friction is from the maximum force of a repeat, and kinetic friction from the
mean over 40 to 100 mm of travel. In the standards, static friction is from the first maximum, and
kinetic friction from the mean over a travel that begins when the films slide. The result states the
mean, sample standard deviation and 95 % t interval over the repeats. A record with stick–slip has
no meaningful mean; its envelope is reported instead.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from layerjam._version import __version__
from layerjam.brake.device.brake_file import BrakeFile, updated_text
from layerjam.brake.device.mount import Site
from layerjam.core.brief import brief
from layerjam.core.errors import FileError, FitError, count_text
from layerjam.core.evolve import evolve
from layerjam.core.toml_files.source import Source
from layerjam.core.units import show
from layerjam.core.verdict import Check, Verdict
from layerjam.laboratory.identify.friction.agreement import Reference, check_friction
from layerjam.laboratory.identify.friction.breakaway import (
    Breakaway,
    Inertia,
    find_breakaway,
    inertia_effect,
)
from layerjam.laboratory.identify.friction.envelope import StickSlip, find_envelope
from layerjam.laboratory.identify.friction.outward import (
    FrictionRepeat,
    SledRecord,
    crosshead_speed,
    read_record,
)
from layerjam.laboratory.identify.friction.record_checks import check_records
from layerjam.laboratory.identify.friction.standards import PAPER, Standard, list_deviations
from layerjam.laboratory.identify.material_evidence import make_friction_evidence
from layerjam.laboratory.identify.provenance import digest_files, mark_sources, sha256
from layerjam.laboratory.identify.statistics import OverRepeats, summarise_repeats
from layerjam.laboratory.identify.stick_slip import CAUSE, find_ripple, find_saw_teeth
from layerjam.laboratory.measure.noise import rounding_limit
from layerjam.laboratory.measure.trace import Array, Trace

WINDOW = PAPER.window
GRAVITY = Site().gravity
SHORTEST = 0.5
"""Smallest fraction of a standard's travel that a record may cover (with a warning)."""
FEWEST = 10
"""Minimum number of samples in the window."""


@brief
@dataclass(frozen=True, kw_only=True)
class FrictionResult:
    """Coefficients [-] over all repeats, with statistics for "static" and "kinetic".

    The kinetic coefficient is None if a repeat shows stick–slip, unless the middle of the envelope
    was accepted. Standard deviations between repeats are absolute, and None for one repeat.
    `window` is the travel of the kinetic mean [m], averaged over the repeats.
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
    reference: Reference

    @property
    def means(self) -> dict[str, OverRepeats]:
        """Return the known coefficients by name."""
        return {name: mean for name, mean in self.over.items() if mean is not None}

    def sources(self) -> dict[str, tuple[float, Source]]:
        """Return {path: (value, Source)} for a brake file; kinetic friction only if known."""
        files = ", ".join(Path(r.path).name + _format_digest(r.path) for r in self.repeats)
        start, end = (show(w, "m") for w in self.window)
        text = (
            f"friction test ({self.standard.title}), {files}; "
            f"normal force {show(self.normal_force, 'N')}"
        )
        if any(repeat.record.tare_force is not None for repeat in self.repeats):
            text += "; force before the load subtracted"
        mean = f"mean over {start} to {end}"
        if self.stick_slip is not None:
            mean = f"{mean}; midpoint of the stick–slip where there is any"
        first = "first maximum" if self.standard.first_maximum else "maximum"
        rules = {"static": f"{first} of each repeat", "kinetic": mean}
        out = {}
        for name, coefficient in self.means.items():
            spread = f"SD {coefficient.sd:.4g}" if coefficient.sd is not None else ""
            words = f"{text}; {rules[name]}; {coefficient.describe_interval()}"
            sd = None if coefficient.sd is None else round(coefficient.sd / coefficient.mean, 4)
            source = Source(kind="measured", text=words, spread=spread, sd=sd)
            out[f"film.{name}"] = (coefficient.mean, source)
        return out


def _format_digest(path: str) -> str:
    return f" (SHA-256 {sha256(path)[:16]})" if path and Path(path).is_file() else ""


def reduce_repeat(
    trace: Trace,
    normal_force: float,
    window: tuple[float, float] | None = None,
    standard: Standard = PAPER,
    accept_stick_slip: bool = False,
    tare: bool = False,
) -> FrictionRepeat:
    """Reduce one repeat; `normal_force` is in N.

    A `window` [m] is travel from the record's first sample; the default is that of the standard.
    With `accept_stick_slip`, the middle of the stick–slip envelope is the kinetic friction. With
    `tare`, the force before the load is subtracted. Raises FileError if the record does not cover
    the window or, with `tare`, has no force before the load.
    """
    record = read_record(trace, tare)
    travel, force, time = record.travel, record.force, record.time
    breakaway = find_breakaway(travel, force) if standard.first_maximum else None
    span, warnings = _find_mean_window(trace, travel, window, standard, breakaway)
    is_inside = (travel >= span[0]) & (travel <= span[1])
    if is_inside.sum() < FEWEST:
        raise FileError(
            trace.path,
            f"only {count_text(int(is_inside.sum()), 'sample')} between {show(span[0], 'm')} and "
            f"{show(span[1], 'm')} of travel; at least {FEWEST} are needed",
        )
    mean = float(force[is_inside].mean())
    kinetic: float | None = mean / normal_force
    if mean <= 0:
        raise FileError(trace.path, f"the mean force in the window is {mean} N")
    clock = None if time is None else time[is_inside]
    teeth = find_saw_teeth(travel[is_inside], force[is_inside], clock).teeth
    if teeth is not None:
        kinetic = teeth.middle / normal_force if accept_stick_slip else None
    speed = crosshead_speed(trace)
    top, static, inertia = _find_static(record, breakaway, normal_force, standard, speed)
    if breakaway is not None:
        warnings += _breakaway_warnings(breakaway, inertia, normal_force)
    warnings += [*list_deviations(standard, speed, time, travel), *record.notes()]
    limits = {
        "static": record.quantum / 2 / normal_force,
        "kinetic": rounding_limit(force[is_inside], record.quantum) / normal_force,
    }
    return FrictionRepeat(
        static=static / normal_force,
        kinetic=kinetic,
        mean=mean / normal_force,
        static_at=float(travel[top]),
        samples=len(trace),
        path=trace.path,
        window=span,
        speed=speed,
        distinct=breakaway is None or breakaway.distinct,
        teeth=teeth,
        inertia=inertia,
        warnings=tuple(warnings),
        synthetic=trace.synthetic,
        record=record.without_curve(),
        sliding_from=record.sliding_from,
        limits=limits,
        drift=record.drift(is_inside),
    )


def _find_static(
    record: SledRecord,
    breakaway: Breakaway | None,
    normal_force: float,
    standard: Standard,
    speed: float | None,
) -> tuple[int, float, Inertia | None]:
    """Return index and force [N] of static friction, and the effect of the sled's inertia."""
    if breakaway is None:
        top = int(np.argmax(record.force))
        return top, float(record.force[top]), None
    inertia = None
    mass = normal_force / GRAVITY if standard.sled_mass is None else standard.sled_mass
    if speed is not None and breakaway.distinct:
        inertia = inertia_effect(record.travel, record.force, record.time, breakaway, mass, speed)
    return breakaway.index, breakaway.force, inertia


def _find_mean_window(
    trace: Trace,
    travel: Array,
    window: tuple[float, float] | None,
    standard: Standard,
    breakaway: Breakaway | None,
) -> tuple[tuple[float, float], list[str]]:
    """Return the travel range of the kinetic mean [m], and notes on it."""
    last = float(travel.max())
    start, end = window or standard.window
    if window is None and breakaway is not None and standard.from_sliding:
        begin, run = float(travel[breakaway.sliding]), end - start
        if last - begin < SHORTEST * run:
            raise FileError(
                trace.path,
                f"the films slide over only {show(last - begin, 'm')}; {standard.title} "
                f"defines kinetic friction over {show(run, 'm')} (change the travel with "
                "--from and --to)",
            )
        if last - begin >= 0.99 * run:
            return (begin, min(begin + run, last)), []
        note = (
            f"the kinetic mean covers {show(last - begin, 'm')} of sliding; "
            f"{standard.title} requires {show(run, 'm')}"
        )
        # the rise is part of the machine's stated travel, so a full test ends slightly early
        return (begin, last), [note] if last < 0.99 * run else []
    if last < end - 0.01 * (end - start):
        raise FileError(
            trace.path,
            f"travel ends at {show(last, 'm')}; the kinetic window is {show(start, 'm')} to "
            f"{show(end, 'm')} (change it with --from and --to)",
        )
    return (start, end), []


def _breakaway_warnings(
    breakaway: Breakaway, inertia: Inertia | None, normal_force: float
) -> list[str]:
    if not breakaway.distinct:
        return [
            "no clear first maximum: static friction is read where the rise levels off into "
            "sliding, at the kinetic level"
        ]
    if inertia is None or inertia.bound < 0.01 * breakaway.force:
        return []
    return [
        f"the sled's inertia may raise the first maximum by up to {show(inertia.bound, 'N', 2)} "
        f"({inertia.bound / normal_force:.2g} in the static "
        "coefficient): V sqrt(k m); pull more slowly, or through a softer spring"
    ]


def reduce_friction(
    traces: Sequence[Trace],
    normal_force: float,
    window: tuple[float, float] | None = None,
    standard: Standard = PAPER,
    accept_stick_slip: bool = False,
    tare: bool = False,
) -> FrictionResult:
    """Reduce repeats to static and kinetic friction; `normal_force` is in N, `window` in m.

    Raises FitError if no trace is given, FileError for one that does not cover the window.
    """
    if not traces:
        raise FitError("friction: no repeat was given")
    if window is not None and not 0 <= window[0] < window[1]:
        raise FitError(
            f"friction: the window from {show(window[0], 'm')} to {show(window[1], 'm')} is empty"
        )
    repeats = [
        reduce_repeat(t, normal_force, window, standard, accept_stick_slip, tare) for t in traces
    ]
    warnings = [w for t in traces for w in t.warnings]
    return pool(repeats, warnings, normal_force, window, standard, accept_stick_slip)


def pool(
    repeats: Sequence[FrictionRepeat],
    file_warnings: Sequence[str],
    normal_force: float,
    window: tuple[float, float] | None,
    standard: Standard,
    accept_stick_slip: bool,
    reference: Reference | None = None,
) -> FrictionResult:
    """Return the mean, scatter and interval over the repeats, with the warnings about their files.

    `reference` is the friction to compare with, None if the film is unknown.
    """
    ripples = find_ripple([r.teeth for r in repeats])
    repeats = [_replace_by_mean(r) if x else r for r, x in zip(repeats, ripples, strict=True)]
    values = {n: [getattr(r, n) for r in repeats] for n in ("static", "kinetic", "speed")}
    peaks = (w for r in repeats for w in _warn_of_late_peak(r))
    warnings = [*file_warnings, *_group_warnings(repeats), *peaks]
    limits = {n: max(r.limits[n] for r in repeats) for n in ("static", "kinetic")}
    static = summarise_repeats(values["static"], limit=limits["static"])
    kinetic = None
    if None not in values["kinetic"]:
        kinetic = summarise_repeats(values["kinetic"], limit=limits["kinetic"])
    means = {"static": static, "kinetic": kinetic}
    reference = reference or Reference()
    return FrictionResult(
        static=static.mean,
        static_sd=static.sd,
        kinetic=None if kinetic is None else kinetic.mean,
        kinetic_sd=None if kinetic is None else kinetic.sd,
        over=means,
        stick_slip=find_envelope(
            [(r.path, r.teeth) for r in repeats if r.teeth is not None],
            normal_force,
            accept_stick_slip,
        ),
        repeats=tuple(repeats),
        normal_force=normal_force,
        window=window or _average_span(repeats),
        warnings=tuple(dict.fromkeys(warnings)),
        standard=standard,
        checks=(
            *check_friction([r.path for r in repeats], values, means, reference),
            *check_records(repeats, normal_force, window or standard.window),
        ),
        reference=reference,
    )


def _replace_by_mean(repeat: FrictionRepeat) -> FrictionRepeat:
    """Return the repeat with its plain mean: other repeats show that the machine made its teeth."""
    note = f"saw teeth of equal spacing at every force are not stick–slip; likely cause: {CAUSE}"
    return evolve(
        repeat,
        kinetic=repeat.mean,
        teeth=None,
        ripple=repeat.teeth,
        warnings=(*repeat.warnings, note),
    )


def _group_warnings(repeats: Sequence[FrictionRepeat]) -> list[str]:
    """Return each warning about the repeats once, with the files to which it applies."""
    paths_of: dict[str, list[str]] = {}
    for repeat in repeats:
        for sentence in repeat.warnings:
            paths_of.setdefault(sentence, []).append(repeat.path)
    of_all = {s: len(p) == len(repeats) > 1 for s, p in paths_of.items()}
    return [
        f"{f'all {len(repeats)} repeats' if of_all[s] else ', '.join(paths)}: {s}"
        for s, paths in paths_of.items()
    ]


def _average_span(repeats: Sequence[FrictionRepeat]) -> tuple[float, float]:
    start, end = np.mean([*dict.fromkeys(r.window for r in repeats)], axis=0)
    return float(start), float(end)


def _warn_of_late_peak(repeat: FrictionRepeat) -> list[str]:
    if repeat.static_at <= repeat.window[0] or repeat.teeth is not None:
        return []
    return [
        f"{repeat.path}: the maximum force lies at {show(repeat.static_at, 'm')} of travel, "
        "inside the kinetic window; it may not be the static peak"
    ]


def add_friction(
    file: BrakeFile, result: FrictionResult, name: str, verdict: Verdict | None = None
) -> tuple[str, list[str]]:
    """Return (TOML text, warnings) of the brake with measured friction and a scale factor of 1.

    A scale factor is valid only for the friction with which it was fitted, so a new friction resets
    it. The [made_by] table lists files with their SHA-256, standard, window and intervals. Raises
    FitError if stick–slip leaves the kinetic friction unknown.
    """
    if result.kinetic is None:
        error = FitError(
            "friction: the films stick and slip, so there is no kinetic friction to "
            "write into the brake (--accept-stick-slip uses the midpoint of the stick–slip)"
        )
        error.notice = "no-kinetic-friction"
        raise error
    blank = Source(kind="assumed", text="not yet calibrated with this friction")
    changes = {**result.sources(), "scale_factor": (1.0, blank)}
    warnings = []
    if file.brake.scale_factor != 1.0:
        warnings.append(
            f"the scale factor {file.brake.scale_factor:g} was fitted with the old "
            "friction and is now 1; run 'layerjam calibrate' next"
        )
    if file.brake.film.ageing is not None:
        warnings.append(
            "film.ageing and film.static_hold were fitted with the old static friction; "
            "run 'layerjam ageing' next"
        )
    if file.brake.amplification_held is not None:
        changes["amplification_held"] = (1.0, blank)
    record = _origin_table(result, synthetic := {r.path for r in result.repeats if r.synthetic})
    marked_changes = mark_sources(changes, bool(synthetic))
    speeds = [repeat.speed for repeat in result.repeats if repeat.speed]
    evidence = make_friction_evidence(file, result.means, speeds, marked_changes)
    return updated_text(file, name, marked_changes, record, verdict, evidence), warnings


def _origin_table(result: FrictionResult, synthetic: Collection[str]) -> dict[str, Any]:
    start, end = (show(w, "m") for w in result.window)
    means = (f"{name} {o.mean:.4g}, {o.describe_interval()}" for name, o in result.means.items())
    sticking, middle = 0, ""
    if result.stick_slip is not None:
        sticking = len(result.stick_slip.files)
        middle = "; kinetic friction is the middle of its envelope"
    return {
        "program": f"layerjam {__version__} friction",
        "standard": result.standard.title,
        "window": f"{start} to {end} of travel",
        "interval": "; ".join(means),
        "stick_slip": f"in {sticking} of {len(result.repeats)} repeats{middle}",
        "files": digest_files((r.path for r in result.repeats), synthetic),
    }

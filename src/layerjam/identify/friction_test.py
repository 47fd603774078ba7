"""Friction tests as the paper reduces them (section III-C, after ASTM D1894).

Static: the greatest force of a repeat; kinetic: the mean over a window of travel, 40 to 100 mm
unless told otherwise; then mean and sample standard deviation over the repeats.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from layerjam.device.file import BrakeFile, updated_text
from layerjam.device.source import Source
from layerjam.errors import FileError, FitError
from layerjam.identify.trace import Trace
from layerjam.units import show

WINDOW = (0.040, 0.100)


@dataclass(frozen=True, kw_only=True)
class FrictionRepeat:
    """One repeat: coefficients [-], where its maximum lies [m of travel], where it came from."""

    static: float
    kinetic: float
    static_at: float
    samples: int
    path: str


@dataclass(frozen=True, kw_only=True)
class FrictionResult:
    """Coefficients [-] over all repeats; the SDs are absolute and None for one repeat."""

    static: float
    kinetic: float
    static_sd: float | None
    kinetic_sd: float | None
    repeats: tuple[FrictionRepeat, ...]
    normal_force: float
    window: tuple[float, float]
    warnings: tuple[str, ...]

    def sources(self) -> dict[str, tuple[float, Source]]:
        """What to write into a brake file: {path: (value, Source)}."""
        files = ", ".join(r.path.rsplit("/", 1)[-1] for r in self.repeats)
        start, end = (show(w, "m") for w in self.window)
        text = f"friction test, {files}; normal force {show(self.normal_force, 'N')}"
        how = {"static": "maximum of each repeat", "kinetic": f"mean over {start} to {end}"}
        out = {}
        for name, sd in (("static", self.static_sd), ("kinetic", self.kinetic_sd)):
            spread = f"SD {sd:.4g}" if sd is not None else ""
            source = Source(kind="measured", text=f"{text}; {how[name]}", spread=spread)
            out[f"film.{name}"] = (getattr(self, name), source)
        return out


def reduce_repeat(trace: Trace, normal_force: float, window: tuple[float, float]) -> FrictionRepeat:
    """One repeat's coefficients; travel counts from the record's first sample.

    Raises FileError where the record does not cover the window [m].
    """
    travel = trace.elongation - trace.elongation[0]
    if travel[-1] < 0:
        travel = -travel
    start, end = window
    far = float(travel.max())
    if far < end - 0.01 * (end - start):
        raise FileError(
            trace.path,
            f"travel ends at {show(far, 'm')}; the kinetic window is {show(start, 'm')} to "
            f"{show(end, 'm')} (another one: --from, --to)",
        )
    inside = (travel >= start) & (travel <= end)
    if inside.sum() < 10:
        raise FileError(
            trace.path,
            f"only {int(inside.sum())} samples lie between {show(start, 'm')} and "
            f"{show(end, 'm')} of travel; at least 10 are needed",
        )
    top = int(np.argmax(trace.force))
    kinetic = float(trace.force[inside].mean()) / normal_force
    if kinetic <= 0:
        raise FileError(trace.path, f"the mean force in the window is {kinetic * normal_force} N")
    return FrictionRepeat(
        static=float(trace.force[top]) / normal_force,
        kinetic=kinetic,
        static_at=float(travel[top]),
        samples=len(travel),
        path=trace.path,
    )


def reduce_friction(
    traces: Sequence[Trace], normal_force: float, window: tuple[float, float] = WINDOW
) -> FrictionResult:
    """Static and kinetic friction from repeats; `normal_force` [N], `window` [m] of travel.

    Raises FitError without any trace, FileError for one that does not cover the window.
    """
    if not traces:
        raise FitError("friction: no repeat was given")
    if not 0 <= window[0] < window[1]:
        raise FitError(
            f"friction: the window from {show(window[0], 'm')} to {show(window[1], 'm')} is empty"
        )
    repeats = tuple(reduce_repeat(t, normal_force, window) for t in traces)
    static = np.array([r.static for r in repeats])
    kinetic = np.array([r.kinetic for r in repeats])
    several = len(repeats) > 1
    warnings = [w for t in traces for w in t.warnings]
    if not 0.02 <= float(kinetic.mean()) <= 1.5:
        warnings.append(
            f"a kinetic friction of {float(kinetic.mean()):.3g} is unusual for films: check the "
            f"normal force, {show(normal_force, 'N')}"
        )
    for r in repeats:
        if r.static_at > window[0]:
            warnings.append(
                f"{r.path}: the greatest force lies at {show(r.static_at, 'm')} of travel, inside "
                "the kinetic window; it may not be the static peak"
            )
    return FrictionResult(
        static=float(static.mean()),
        kinetic=float(kinetic.mean()),
        static_sd=float(static.std(ddof=1)) if several else None,
        kinetic_sd=float(kinetic.std(ddof=1)) if several else None,
        repeats=repeats,
        normal_force=normal_force,
        window=window,
        warnings=tuple(dict.fromkeys(warnings)),
    )


def with_friction(file: BrakeFile, result: FrictionResult, name: str) -> tuple[str, list[str]]:
    """(TOML text, warnings): the brake with measured friction and its scale factor back at 1.

    A scale factor belongs to the friction it was fitted with, so a new friction voids it.
    """
    changes: Mapping[str, tuple[float, Source]] = {
        **result.sources(),
        "scale_factor": (
            1.0,
            Source(kind="assumed", text="not calibrated with this friction yet"),
        ),
    }
    warnings = []
    if file.brake.scale_factor != 1.0:
        warnings.append(
            f"the scale factor {file.brake.scale_factor:g} belonged to the old friction and is 1 "
            "now; run 'layerjam calibrate' next"
        )
    return updated_text(file, name, dict(changes)), warnings

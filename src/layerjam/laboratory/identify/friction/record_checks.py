"""Checks of the records of friction tests: zero, drift, resolution, saturation and slack."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

from layerjam.core.units import show
from layerjam.core.verdict import Check, check
from layerjam.laboratory.identify.friction.outward import FrictionRepeat
from layerjam.laboratory.identify.load_cell import (
    NOTICED,
    check_drift,
    check_resolution,
    check_zero,
)
from layerjam.laboratory.measure.saturation import Plateau

SAME_LEVEL = 5.0
"""Number of standard errors within which plateaus of different tests have the same level."""
MARGIN = 4e-3
"""Distance [m] from the beginning of sliding to a window that starts after it."""


def check_records(
    repeats: Sequence[FrictionRepeat], normal_force: float, window: tuple[float, float]
) -> Iterator[Check]:
    """Yield the checks of the load cell and the rig; `window` [m] is that of the kinetic mean."""
    tests = _name_repeats(repeats)
    yield check_zero(
        {
            name: (show(zero.force, "N"), zero.effect(repeat.mean * normal_force))
            for name, repeat in tests.items()
            if (zero := repeat.record.zero) is not None
        },
        "kinetic friction",
    )
    yield _check_drift(tests, normal_force)
    effects = {
        f"{kind} friction": max(r.limits[kind] / getattr(r, kind) for r in repeats)
        for kind in ("static", "kinetic")
        if all(getattr(r, kind) for r in repeats)
    }
    yield check_resolution(effects, show(max(r.record.quantum for r in repeats), "N", 3))
    yield _check_saturation({n: p for n, r in tests.items() if (p := r.record.plateau)})
    yield _check_slack(tests, window)


def _name_repeats(repeats: Sequence[FrictionRepeat]) -> dict[str, FrictionRepeat]:
    """Return the repeats by file name, with their number if names are missing or equal."""
    names = [Path(repeat.path).name for repeat in repeats]
    out = {}
    for place, (name, repeat) in enumerate(zip(names, repeats, strict=True), 1):
        unique = name if names.count(name) == 1 else f"{name} (repeat {place})".strip()
        out[unique or f"repeat {place}"] = repeat
    return out


def _check_drift(repeats: dict[str, FrictionRepeat], normal_force: float) -> Check:
    """Return the check that neither the zero nor friction drifts during a test.

    The levels before and after a test show a drift of the zero. Without them, a slope within the
    window may be that drift. With them, it is a change of friction, which is a warning at most.
    """
    effects: dict[str, tuple[float, bool]] = {}
    for name, repeat in repeats.items():
        slope, levels = (d and d / (repeat.mean * normal_force) for d in repeat.drift)
        known = levels is not None and abs(levels) > NOTICED
        effects[name] = (levels or 0.0, True) if known else (slope or 0.0, levels is None)
    worst = max(effects, key=lambda name: abs(effects[name][0]))
    effect, may_be_zero = effects[worst]
    cause = "a zero that drifts, a rig that is not level, or a film that wears"
    if not may_be_zero:
        cause = "a rig that is not level, or a film that wears; the zero returns after the test"
    return check_drift(worst, effect, "kinetic friction", cause, may_be_zero)


def _check_saturation(plateaus: dict[str, Plateau]) -> Check:
    """Return the check that no test slides at a force that does not vary at all.

    One such test may be that of a very even film. In several tests, its friction would differ.
    """
    if not plateaus:
        return check("saturation", True, "the force varies while the films slide")
    levels = {name: plateau.level for name, plateau in plateaus.items()}
    tolerance = SAME_LEVEL * math.sqrt(2) * max(plateau.error for plateau in plateaus.values())
    is_same_level = len(levels) > 1 and max(levels.values()) - min(levels.values()) <= tolerance
    name, level = next(iter(levels.items()))
    sentence = f"the force in {name} stays at {show(level, 'N')} but for noise"
    if is_same_level:
        sentence = (
            f"the force stays at the same {show(level, 'N')} but for noise in {', '.join(levels)}"
        )
    advice = ": the load cell may be saturated; test it with a larger load"
    return check("saturation", False, sentence, advice, "failed" if is_same_level else "warning")


def _check_slack(repeats: dict[str, FrictionRepeat], window: tuple[float, float]) -> Check:
    """Return the check that the sled slides before the window of the kinetic mean begins."""
    late = {name: r.sliding_from for name, r in repeats.items() if r.sliding_from > r.window[0]}
    if not late:
        return check("slack", True, "the sled slides before the kinetic window begins")
    file = max(late, key=lambda name: late[name])
    sentence = (
        f"the sled in {file} slides only from {show(late[file], 'm')}, inside the kinetic window"
    )
    start = math.ceil((late[file] + MARGIN) * 1e3)
    advice = ": remove the slack of the string"
    if start * 1e-3 < window[1] - MARGIN:
        advice += f", or start the window later (--from {start}mm)"
    return check("slack", False, sentence, advice, "failed")

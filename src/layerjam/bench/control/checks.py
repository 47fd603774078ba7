"""Checks of a controller in closed loop: whether it holds the vacuum and, if not, why."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from layerjam.bench.control import law
from layerjam.bench.control.settings import Regulator
from layerjam.core.units import show
from layerjam.core.verdict import Check, check

if TYPE_CHECKING:
    from layerjam.bench.control.closed_loop import ClosedLoop

RIPPLE = 2.0
"""Allowed ripple of a held vacuum, as a multiple of the controller's own band (`idle_band`)."""
SWING = 0.25
"""Ripple above which the check fails whatever the band, as a fraction of the target."""


def idle_band(regulator: Regulator) -> float:
    """Return the width [Pa] of the range of errors in which neither pump nor vent acts."""
    if regulator.kind == "bang-bang":
        return 2 * regulator.half_band
    return regulator.half_band + regulator.vent_threshold


def shortest_moves(regulator: Regulator, vacuum: float) -> dict[str, float]:
    """Return {cause: change of the vacuum [Pa]} for the shortest runs of the pump and of the vent.

    A bang-bang controller runs its pump at full command, other kinds at their minimum command.
    """
    plant, sample = regulator.plant, regulator.sample_time
    share = 1.0 if regulator.kind == "bang-bang" else regulator.least_command
    run, vent = max(sample, regulator.minimum_on), max(sample, regulator.minimum_vent)
    move_times = {
        _describe_duration("pump", run, sample): share * float(plant.rise(vacuum)) * run,
        _describe_duration("vent", vent, sample): float(plant.fall(vacuum)) * vent,
    }
    return dict(sorted(move_times.items(), key=lambda move: -move[1]))


def _describe_duration(actor: str, time: float, sample: float) -> str:
    if time > sample:
        return f"the shortest run of the {actor}, {show(time, 's')},"
    return f"one sample ({show(sample, 's')}) of the {actor}"


def step_check(regulator: Regulator, target: float) -> Check:
    """Return the check that the pump's shortest run changes the vacuum by less than the band."""
    cause, move = next(
        item for item in shortest_moves(regulator, target).items() if "pump" in item[0]
    )
    limit = RIPPLE * idle_band(regulator)
    sentence = f"{cause} moves the vacuum by {show(move, 'Pa')} at {show(target, 'Pa')}"
    advice = f", more than {show(limit, 'Pa')}, {RIPPLE:g} times the controller's band"
    return check(
        "ripple", move <= limit, sentence, advice + _find_fix(regulator, move, target), "failed"
    )


def regulation_checks(regulator: Regulator, target: float, loop: "ClosedLoop") -> Iterator[Check]:
    """Yield the checks of a fault-free closed loop that should hold `target` [Pa].

    They pass if the vacuum is reached and held. They fail on a false fault, a missed target, or a
    ripple above a multiple of the controller's own band.
    """
    sentence = f"the detectors report {loop.outcome}"
    wrong = f" after {show(loop.fault_time, 's')}, although nothing is broken"
    yield check("fault", loop.outcome == "HEALTHY", sentence, wrong, "failed")
    settings, ends = regulator.pack()[0], float(loop.time[-1])
    noise = 3 * regulator.sensor.noise + regulator.sensor.resolution
    reached = math.isfinite(loop.rise_time) and any(
        law.is_reached(settings, reading, target, noise) for reading in loop.measured.tolist()
    )
    sentence = "the vacuum reaches its target"
    if not reached:
        sentence = f"the vacuum does not reach {show(target, 'Pa')} within {show(ends, 's')}"
    yield check("target", reached, sentence, ": simulate longer (--duration)", "failed")
    if reached:
        yield _check_ripple(regulator, target, loop.ripple)


def _check_ripple(regulator: Regulator, target: float, ripple: float) -> Check:
    band = idle_band(regulator)
    is_small = ripple <= RIPPLE * band and ripple <= SWING * target
    sentence = (
        f"the vacuum swings by {show(ripple, 'Pa')}, {ripple / target:.0%} of the target and "
        f"{ripple / band:.2g} times the controller's own band of {show(band, 'Pa')}"
    )
    if is_small:
        return check("ripple", True, sentence)
    cause, move = next(iter(shortest_moves(regulator, target).items()))
    advice = "; the gains, or the lag of sensor and tube, cause the oscillation"
    if move > 0.25 * ripple:
        advice = f": {cause} moves the vacuum by {show(move, 'Pa')}" + _find_fix(
            regulator, move, target
        )
    return check("ripple", False, sentence, advice, "failed")


def _find_fix(regulator: Regulator, move: float, target: float) -> str:
    """Return the setting changes that reduce a step of the vacuum [Pa] to the allowed size."""
    sample, limit = regulator.sample_time, min(idle_band(regulator), 0.5 * SWING * target)
    changes = "pi instead of bang-bang, " if regulator.kind == "bang-bang" else ""
    if max(regulator.minimum_on, regulator.minimum_vent) > sample:
        return f": use {changes}a shorter minimum run, a smaller pump or a larger volume"
    if move > limit:
        digit = 10.0 ** math.floor(math.log10(sample * limit / move))
        shorter = digit * math.floor(sample * limit / move / digit)
        changes += f"a sample time of {show(shorter, 's')}, "
    return f": use {changes}a smaller pump or valve, or a larger volume"

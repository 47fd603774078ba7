"""Rehabilitation of elbow or finger flexion (paper, Fig. 13d): a resistance prescribed by angle.

A cord on a pulley about the joint draws the brakes out in flexion. The resistance wanted is a
torque over the angle, plus one in proportion to speed; a regulator makes the vacuum for it, by the
inverse law of the brake. In extension nothing is wanted: the cord only pulls, the vacuum goes, and
the enclosure draws the brakes back as far as the friction under the remaining vacuum lets it; what
stays drawn out is slack at the next flexion. The body's own torques, the cord's stretch and the
compliance of the brace are left out.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from layerjam.control.follow import MARGIN, Following, follow, slew, targets_for
from layerjam.control.plant import plant_of
from layerjam.control.settings import Regulator
from layerjam.errors import QuantityError, count_of
from layerjam.fluid.line import Sensor
from layerjam.mechanics.friction import at_speed
from layerjam.mechanics.limits import self_closing_vacuum
from layerjam.mechanics.pull import force_limits
from layerjam.studies.machines.ankle_clutch import fall_time, last_before
from layerjam.studies.machines.readiness import line_for
from layerjam.studies.machines.scenario import Array, declared
from layerjam.studies.machines.verdict import Machine, Result
from layerjam.units import show

SPEEDS = np.radians(np.concatenate([np.arange(0.25, 10, 0.25), np.arange(10, 181, 1.0)]))
"""Mean speeds tried [rad/s]."""
FINE = 512
"""Samples of a flexion on which it is judged what can be followed."""


class Session(NamedTuple):
    """The exercise at the regulator's samples, shape (N,)."""

    time: Array
    angle: Array
    speed: Array
    torque: Array
    """Wanted [N m]; 0 in extension."""
    flexing: np.ndarray[Any, np.dtype[np.bool_]]
    """True in flexion."""


class Record(NamedTuple):
    """For the pictures."""

    session: Session
    followed: Following
    given: Array
    """Torque given in flexion [N m], NaN elsewhere."""
    shares: Array
    """Part of a flexion that can be followed, at each of SPEEDS."""
    reachable: Array
    """Torque of all brakes at full vacuum over the angle, and the angle, shape (2, M)."""


@declared("rehabilitation")
class Rehabilitation(Machine):
    """Everything of the scenario."""

    def together(self) -> None:
        """Angles, curve and travel fit together."""
        super().together()
        exercise, angle, torque = self.exercise, self.resistance.angle, self.resistance.torque
        if len(angle) != len(torque) or (np.diff(angle) <= 0).any():
            raise QuantityError.of(
                "resistance.angle",
                f"{len(angle)} angles and {len(torque)} torques; they are rows of "
                "one length, and the angles rise",
            )
        if exercise.end <= exercise.start:
            raise QuantityError.of(
                "exercise.end",
                f"{show(exercise.end, 'rad')} is not above exercise.start, "
                f"{show(exercise.start, 'rad')}",
            )
        if angle[0] > exercise.start + 1e-9 or angle[-1] < exercise.end - 1e-9:
            raise QuantityError.of(
                "resistance.angle",
                "must reach from exercise.start to exercise.end; it goes from "
                f"{show(float(angle[0]), 'rad')} to {show(float(angle[-1]), 'rad')}",
            )
        drawn = self.orthosis.pulley * (exercise.end - exercise.start)
        overlap = self.brake.brake.sheets.overlap * self.brakes.series
        if drawn >= overlap:
            raise QuantityError.of(
                "orthosis.pulley",
                f"the cord runs {show(drawn, 'm')}, and the sheets of the brakes "
                f"overlap by {show(overlap, 'm')}; a smaller pulley or angle will do",
            )
        if self.brakes.series != 1:
            raise QuantityError.of(
                "brakes.series",
                "brakes in a row slip one after the other, so that no one slip gives "
                "their force; this machine takes 1",
            )

    def session(self, speed: float, repetitions: int, dt: float) -> Session:
        """Rest, flexion, hold, extension, as often as asked; turns are half a cosine each."""
        exercise = self.exercise
        turn = max(round((exercise.end - exercise.start) / speed / dt), 2)
        hold, rest = round(exercise.hold / dt), round(exercise.rest / dt)
        ease = (1 - np.cos(np.pi * np.arange(turn) / turn)) / 2
        one = np.concatenate([np.zeros(rest), ease, np.ones(hold), 1 - ease])
        flexes = np.concatenate([np.zeros(rest), np.ones(turn), np.zeros(hold + turn)]) > 0
        ready = np.concatenate([np.ones(rest), np.ones(turn), np.zeros(hold + turn)]) > 0
        part, flexing = np.tile(one, repetitions), np.tile(flexes, repetitions)
        angle = exercise.start + (exercise.end - exercise.start) * part
        pace = np.gradient(angle, dt)
        torque = np.where(np.tile(ready, repetitions), self.wanted_at(angle, pace), 0.0)
        time = np.asarray(np.arange(len(angle)) * dt, np.float64)
        return Session(time, angle, pace, torque, flexing)

    def regulator(self) -> Regulator:
        """The regulator on the line with the volume of all brakes, its plant right at up to 60 kPa.

        Raises QuantityError for a line that cannot vent, and without a safe state.
        """
        line = line_for(self.line.line, self.brakes.parallel)
        at = 0.6 * min(self.brakes.vacuum, line.site.atmosphere)
        plant = plant_of(line, vacuum=at)
        return Regulator(
            plant=plant,
            sensor=Sensor(range=self.control.sensor_range, noise=self.control.noise),
            kind=self.control.regulator,
            safe_state=self.safe_state,
            sample_time=self.control.sample_time,
            reversible=line.valve is None,
            tuned_at=at,
        )

    def followed_at(self, regulator: Regulator, speed: float) -> tuple[float, list[str]]:
        """(part of one flexion at a mean speed [rad/s] that can be followed, why not the rest).

        On FINE samples whatever the speed, so that the laws are compiled once.
        """
        exercise, r = self.exercise, self.orthosis.pulley
        part = np.linspace(0.0, 1.0, FINE)
        span = exercise.end - exercise.start
        length = span / speed
        angle = exercise.start + span * (1 - np.cos(np.pi * part)) / 2
        pace = span * np.pi / 2 / length * np.sin(np.pi * part)
        force = self.wanted_at(angle, pace) / (r * self.brakes.parallel)
        most = MARGIN * regulator.plant.reach
        targets, held, few = targets_for(
            force, r * (angle - exercise.start), self.brake.brake, most, r * pace
        )
        fine, slow = slew(targets, length / (FINE - 1), regulator.plant)
        return float((held & fine).mean()), [*few, *slow]

    def wanted_at(self, angle: Array, pace: Array) -> Array:
        """Torque wanted [N m] at angles [rad] and speeds [rad/s], shape (N,)."""
        made = np.interp(angle, self.resistance.angle, self.resistance.torque)
        return made + self.exercise.viscosity * np.maximum(pace, 0.0)

    def analyse(self) -> Result:
        """The torque given beside the one wanted, what cannot be followed, and the way back."""
        brakes, r = self.brakes, self.orthosis.pulley
        exercise, brake = self.exercise, self.brake.brake
        made = self.regulator()
        asked = self.session(exercise.speed, exercise.repetitions, made.sample_time)
        slip, arm = r * (asked.angle - exercise.start), r * brakes.parallel
        done = follow(made, brake, asked.torque / arm, slip)
        given = np.where(asked.flexing, done.force * arm, np.nan)
        error = (given - asked.torque)[asked.flexing]
        share, reasons = self.followed_at(made, exercise.speed)
        shares = np.array([self.followed_at(made, float(s))[0] for s in SPEEDS])
        left = _vacuum_left(asked, done)
        grid = np.linspace(exercise.start, exercise.end, 101)
        turning = at_speed(r * exercise.speed, brake)
        high = np.asarray(force_limits(r * (grid - exercise.start), turning)[1]) * r
        wanted = self.wanted_at(grid, np.full_like(grid, exercise.speed))
        needed = math.ceil(float(np.max(wanted / high)) - 1e-9)
        line = line_for(self.line.line, brakes.parallel)
        loop, greatest = done.loop, float(asked.torque.max())
        rms, release = float(np.sqrt(np.mean(error**2))), self.safe_state == "release"
        reach = np.stack([grid, high * brakes.parallel])
        found = Result(scenario=self, record=Record(asked, done, given, shares, reach))
        found.add("N m", greatest_torque=greatest, rms_error=rms)
        found.add("N m", greatest_error=float(np.abs(error).max()))
        found.add("N m", reachable_torque=float(high.min()) * brakes.parallel)
        found.add("1", possible=share, reasons=reasons)
        found.add("rad/s", fastest_speed=last_before(SPEEDS, shares >= self.limits.followed))
        found.add("m", slip=float(slip.max()))
        found.add("Pa", vacuum_left=left, greatest_vacuum=float(loop.vacuum.max()))
        found.add("rad", lost_angle=self.lost_angle(left, float(slip.max())))
        found.add("s", release_time=fall_time(made.plant.reach * MARGIN, line))
        found.add("1", outcome=loop.outcome, safe_state=self.safe_state)
        found.add("1", pump_switches=loop.pump_switches, vent_switches=loop.vent_switches)
        found.bound("1", share_of_error=rms / greatest, yes=1.0, lets_go=float(release))
        found.bound("m", usable_travel=brake.sheets.usable_travel)
        if not release:
            found.warnings.append(
                "safe_state hold: a fault of the sensor or the pump locks the arm where it is"
            )
        if line.valve is None:
            found.warnings.append("the line has no valve: a fault of the pump leaves the arm held")
        found.judge()
        found.brakes_needed = needed
        found.needed = self.needed(needed, found.own)
        return found

    def lost_angle(self, vacuum: float, slip: float) -> float:
        """Angle [rad] by which the brakes stay drawn out: to where friction holds the enclosure."""
        at = np.linspace(0.0, slip, 400)[1:]
        closes = np.asarray(self_closing_vacuum(at, at_speed(0.0, self.brake.brake))) > vacuum
        held = 0.0 if closes.all() else float(at[np.flatnonzero(~closes)[-1]])
        return held / float(self.orthosis.pulley)

    def needed(self, needed: int, own: dict[str, Any]) -> str:
        """What it would take, in sentences."""
        words = (
            f"The torque takes {count_of(needed, 'brake')} at full vacuum; there "
            f"{'is one' if self.brakes.parallel == 1 else f'are {self.brakes.parallel}'}. "
        )
        if own["fastest_speed"] == 0:
            words += "This line follows the profile at no speed that was tried."
        else:
            words += (
                f"This line follows it up to {math.degrees(own['fastest_speed']):.3g} degrees a "
                f"second; {math.degrees(self.exercise.speed):.3g} are asked."
            )
        if own["release_time"] > self.limits.release:
            words += " A vent valve would let go in time."
        return words


def _vacuum_left(asked: Session, done: Following) -> float:
    """Least vacuum of the last extension [Pa]."""
    starts = np.flatnonzero(asked.flexing)
    after = done.loop.vacuum[int(starts[-1]) + 1 :]
    # a pump run backwards may push a breath above the atmosphere
    return max(float(after.min()), 0.0)

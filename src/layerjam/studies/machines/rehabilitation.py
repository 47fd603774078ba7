"""Rehabilitation of elbow or finger flexion (paper, Fig. 13d): resistance prescribed by angle.

A cord on a pulley about the joint extends the brakes in flexion. The target resistance is a torque
that depends on the angle, plus one proportional to speed. A controller sets the corresponding
vacuum by the inverse law of the brake. In extension the target is zero: the cord only pulls, the
vacuum is released, and the enclosure retracts the brakes as far as the remaining friction allows.
Any remaining extension is slack in the next flexion. The body's own torques, the stretch of the
cord and the compliance of the brace are ignored.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from layerjam.bench.control.follow import MARGIN, Following, check_slew, follow, target_vacuums
from layerjam.bench.control.plant import linearise_line
from layerjam.bench.control.settings import Regulator
from layerjam.brake.fluid.line import Sensor
from layerjam.brake.mechanics.limits import self_closing_vacuum
from layerjam.brake.mechanics.pull import force_limits
from layerjam.brake.mechanics.speed_effects import fix_speed
from layerjam.core.errors import QuantityError, count_text
from layerjam.core.units import show
from layerjam.studies.machines.ankle_clutch import fall_time, last_acceptable
from layerjam.studies.machines.readiness import scale_line
from layerjam.studies.machines.scenario import Array, declare_fields
from layerjam.studies.machines.verdict import Machine, Result

SPEEDS = np.radians(np.concatenate([np.arange(0.25, 10, 0.25), np.arange(10, 181, 1.0)]))
"""Mean angular speeds examined [rad/s]."""
FINE = 512
"""Number of samples per flexion, for the fraction that can be followed."""


class Session(NamedTuple):
    """The exercise at the sampling times of the controller, shape (N,)."""

    time: Array
    angle: Array
    speed: Array
    torque: Array
    """Target torque [N m]; 0 in extension."""
    flexing: np.ndarray[Any, np.dtype[np.bool_]]
    """True in flexion."""


class Record(NamedTuple):
    """Data for the pictures."""

    session: Session
    followed: Following
    given: Array
    """Torque produced in flexion [N m], NaN elsewhere."""
    shares: Array
    """Fraction of a flexion that can be followed at each of SPEEDS."""
    reachable: Array
    """Angle, and torque of all brakes there at full vacuum, shape (2, M)."""


@declare_fields("rehabilitation")
class Rehabilitation(Machine):
    """Rehabilitation device with all data of its scenario."""

    def together(self) -> None:
        """Check that angles, curve and travel are consistent."""
        super().together()
        exercise, angle, torque = self.exercise, self.resistance.angle, self.resistance.torque
        if len(angle) != len(torque) or (np.diff(angle) <= 0).any():
            raise QuantityError.of(
                "resistance.angle",
                f"{len(angle)} angles and {len(torque)} torques; they must "
                "have the same length, and the angles must increase",
            )
        if exercise.end <= exercise.start:
            raise QuantityError.of(
                "exercise.end",
                f"{show(exercise.end, 'rad')} does not exceed exercise.start, "
                f"{show(exercise.start, 'rad')}",
            )
        if angle[0] > exercise.start + 1e-9 or angle[-1] < exercise.end - 1e-9:
            raise QuantityError.of(
                "resistance.angle",
                "must cover exercise.start to exercise.end; it covers "
                f"{show(float(angle[0]), 'rad')} to {show(float(angle[-1]), 'rad')}",
            )
        cord_length = self.orthosis.pulley * (exercise.end - exercise.start)
        overlap = self.brake.brake.sheets.overlap * self.brakes.series
        if cord_length >= overlap:
            raise QuantityError.of(
                "orthosis.pulley",
                f"the cord travels {show(cord_length, 'm')}, but the sheets of the brakes "
                f"overlap by only {show(overlap, 'm')}; use a smaller pulley or angle",
            )
        if self.brakes.series != 1:
            raise QuantityError.of(
                "brakes.series",
                "brakes in series slip one after another, so no single slip gives their "
                "force; this machine supports 1",
            )

    def make_session(self, speed: float, repetitions: int, dt: float) -> Session:
        """Return repetitions of rest, flexion, hold and extension; each move is half a cosine."""
        exercise = self.exercise
        turn_samples = max(round((exercise.end - exercise.start) / speed / dt), 2)
        hold, rest_samples = round(exercise.hold / dt), round(exercise.rest / dt)
        ease = (1 - np.cos(np.pi * np.arange(turn_samples) / turn_samples)) / 2
        repetition = np.concatenate([np.zeros(rest_samples), ease, np.ones(hold), 1 - ease])
        counts = rest_samples, turn_samples, hold + turn_samples
        flexes = np.repeat([False, True, False], counts)
        ready = np.repeat([True, True, False], counts)
        part, flexing = np.tile(repetition, repetitions), np.tile(flexes, repetitions)
        angle = exercise.start + (exercise.end - exercise.start) * part
        pace = np.gradient(angle, dt)
        torque = np.where(np.tile(ready, repetitions), self.target_torque(angle, pace), 0.0)
        time = np.asarray(np.arange(len(angle)) * dt, np.float64)
        return Session(time, angle, pace, torque, flexing)

    def make_controller(self) -> Regulator:
        """Return the controller, up to 60 kPa, for the vacuum line with the volume of all brakes.

        Raises QuantityError if the line cannot vent or there is no safe state.
        """
        line = scale_line(self.line.line, self.brakes.parallel)
        design_vacuum = 0.6 * min(self.brakes.vacuum, line.site.atmosphere)
        plant = linearise_line(line, vacuum=design_vacuum)
        return Regulator(
            plant=plant,
            sensor=Sensor(range=self.control.sensor_range, noise=self.control.noise),
            kind=self.control.regulator,
            safe_state=self.safe_state,
            sample_time=self.control.sample_time,
            reversible=line.valve is None,
            tuned_at=design_vacuum,
        )

    def followed_fraction(self, regulator: Regulator, speed: float) -> tuple[float, list[str]]:
        """Return (fraction of a flexion at a mean speed [rad/s] that can be followed, reasons).

        FINE samples are used at every speed, so that the laws are compiled only once.
        """
        exercise, r = self.exercise, self.orthosis.pulley
        part = np.linspace(0.0, 1.0, FINE)
        span = exercise.end - exercise.start
        length = span / speed
        angle = exercise.start + span * (1 - np.cos(np.pi * part)) / 2
        pace = span * np.pi / 2 / length * np.sin(np.pi * part)
        force = self.target_torque(angle, pace) / (r * self.brakes.parallel)
        limit = MARGIN * regulator.plant.reach
        targets, reachable_, reasons = target_vacuums(
            force, r * (angle - exercise.start), self.brake.brake, limit, r * pace
        )
        can_follow, slew_reasons = check_slew(targets, length / (FINE - 1), regulator.plant)
        return float((reachable_ & can_follow).mean()), [*reasons, *slew_reasons]

    def target_torque(self, angle: Array, pace: Array) -> Array:
        """Return the target torque [N m] at angles [rad] and speeds [rad/s], shape (N,)."""
        torque = np.interp(angle, self.resistance.angle, self.resistance.torque)
        return torque + self.exercise.viscosity * np.maximum(pace, 0.0)

    def analyse(self) -> Result:
        """Compare the torque with its target; report unreachable ranges and the return stroke."""
        brakes, r = self.brakes, self.orthosis.pulley
        exercise, brake = self.exercise, self.brake.brake
        controller = self.make_controller()
        session = self.make_session(exercise.speed, exercise.repetitions, controller.sample_time)
        slip, arm = r * (session.angle - exercise.start), r * brakes.parallel
        run = follow(controller, brake, session.torque / arm, slip)
        torque = np.where(session.flexing, run.force * arm, np.nan)
        error = (torque - session.torque)[session.flexing]
        share, reasons = self.followed_fraction(controller, exercise.speed)
        shares = np.array([self.followed_fraction(controller, float(s))[0] for s in SPEEDS])
        lowest_vacuum = _find_lowest_vacuum(session, run)
        grid = np.linspace(exercise.start, exercise.end, 101)
        turning = fix_speed(r * exercise.speed, brake)
        high = np.asarray(force_limits(r * (grid - exercise.start), turning)[1]) * r
        target = self.target_torque(grid, np.full_like(grid, exercise.speed))
        count = math.ceil(float(np.max(target / high)) - 1e-9)
        line = scale_line(self.line.line, brakes.parallel)
        loop, peak_torque = run.loop, float(session.torque.max())
        rms, release = float(np.sqrt(np.mean(error**2))), self.safe_state == "release"
        reach = np.stack([grid, high * brakes.parallel])
        result = Result(scenario=self, record=Record(session, run, torque, shares, reach))
        result.add("N m", greatest_torque=peak_torque, rms_error=rms)
        result.add("N m", greatest_error=float(np.abs(error).max()))
        result.add("N m", reachable_torque=float(high.min()) * brakes.parallel)
        result.add("1", possible=share, reasons=reasons)
        result.add("rad/s", fastest_speed=last_acceptable(SPEEDS, shares >= self.limits.followed))
        result.add("m", slip=float(slip.max()))
        result.add("Pa", vacuum_left=lowest_vacuum, greatest_vacuum=float(loop.vacuum.max()))
        result.add("rad", lost_angle=self.lost_angle(lowest_vacuum, float(slip.max())))
        result.add("s", release_time=fall_time(controller.plant.reach * MARGIN, line))
        result.add("1", outcome=loop.outcome, safe_state=self.safe_state)
        result.add("1", pump_switches=loop.pump_switches, vent_switches=loop.vent_switches)
        result.add_bounds("1", share_of_error=rms / peak_torque, yes=1.0, lets_go=float(release))
        result.add_bounds("m", usable_travel=brake.sheets.usable_travel)
        if not release:
            result.warnings.append(
                "safe_state hold: a fault of the sensor or the pump locks the arm where it is"
            )
        if line.valve is None:
            result.warnings.append("the line has no valve: if the pump fails, the arm stays held")
        result.add_limits()
        result.brakes_needed = count
        result.needed = self.describe_need(count, result.own)
        return result

    def lost_angle(self, vacuum: float, slip: float) -> float:
        """Return the angle [rad] by which friction prevents the enclosure from retracting fully."""
        slips = np.linspace(0.0, slip, 400)[1:]
        is_self_closing = (
            np.asarray(self_closing_vacuum(slips, fix_speed(0.0, self.brake.brake))) > vacuum
        )
        held_slip = (
            0.0 if is_self_closing.all() else float(slips[np.flatnonzero(~is_self_closing)[-1]])
        )
        return held_slip / float(self.orthosis.pulley)

    def describe_need(self, brakes: int, numbers: dict[str, Any]) -> str:
        """Describe the requirements in sentences."""
        words = (
            f"The torque requires {count_text(brakes, 'brake')} at full vacuum; the "
            f"device has {'one' if self.brakes.parallel == 1 else self.brakes.parallel}. "
        )
        if numbers["fastest_speed"] == 0:
            words += "This line cannot follow the profile at any tested speed."
        else:
            words += (
                f"This line can follow it up to {math.degrees(numbers['fastest_speed']):.3g} "
                f"degrees per second; {math.degrees(self.exercise.speed):.3g} are required."
            )
        if numbers["release_time"] > self.limits.release:
            words += " A vent valve would release the torque in time."
        return words


def _find_lowest_vacuum(session: Session, run: Following) -> float:
    """Return the lowest vacuum during the last extension [Pa]."""
    starts = np.flatnonzero(session.flexing)
    last_vacuums = run.loop.vacuum[int(starts[-1]) + 1 :]
    # a pump that runs backwards may raise the pressure slightly above atmospheric
    return max(float(last_vacuums.min()), 0.0)

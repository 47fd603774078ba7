"""Ankle exoskeleton (paper, Fig. 13c): a spring at the calf, with brakes as its clutch.

The clutch closes at some point in the stride. Dorsiflexion of the ankle then stretches the spring
in series with the brakes, which must not slip, and plantarflexion recovers the energy. Before the
next stride the vacuum must be released; otherwise, the clutch pulls the foot down during swing.
When the clutch closes, the vacuum rises from zero at full pump power. The brakes are assumed to
resist with their kinetic friction; the additional static friction is not counted.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from layerjam.brake.fluid.closed_forms import (
    fall_by_pump,
    fall_by_valve,
    pumping_time,
    reachable_vacuum,
)
from layerjam.brake.fluid.line import Line
from layerjam.brake.fluid.vacuum_energy import jam_work
from layerjam.brake.mechanics.ageing import aged_holding_force
from layerjam.brake.mechanics.arrays import scan, xp
from layerjam.brake.mechanics.effects import require_linear
from layerjam.brake.mechanics.friction import holding_force
from layerjam.brake.mechanics.law import compiled
from layerjam.brake.mechanics.speed_effects import remove_idle_speed_law
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.core.errors import QuantityError
from layerjam.core.units import show
from layerjam.studies.machines import restraint
from layerjam.studies.machines.readiness import scale_line
from layerjam.studies.machines.restraint import Strap
from layerjam.studies.machines.scenario import Array, declare_fields
from layerjam.studies.machines.verdict import Machine, Result

SAMPLES = 1200
"""Number of samples in a stride."""
RATES = np.geomspace(2e-3, 6.0, 400)
"""Stride rates examined [Hz]."""


class Stride(NamedTuple):
    """A stride that starts when the clutch closes; shape (N,), or (N, B) for B stride rates."""

    force: Array
    slip: Array
    hold: Array
    """Holding force of the clutch at the current vacuum [N]."""
    vacuum: Array


class Record(NamedTuple):
    """Data for the pictures."""

    part: Array
    """Phase of the stride; values above 1 belong to the next stride."""
    angle: Array
    stride: Stride
    ready: Stride
    """The same stride if the vacuum is present from the start."""
    slips: Array
    """Largest slip at each of RATES [m]."""
    window: tuple[float, float]
    """Phases of the stride at which the clutch closes and the spring becomes slack again."""


@declare_fields("ankle-clutch")
class AnkleClutch(Machine):
    """Ankle clutch with all data of its scenario."""

    def together(self) -> None:
        """Check that the gait's curves have the same length."""
        super().together()
        part, angle, moment = self.gait.part, self.gait.angle, self.gait.moment
        if not len(part) == len(angle) == len(moment):
            raise QuantityError.of(
                "gait.part",
                f"{len(part)} values, {len(angle)} of gait.angle and {len(moment)} of "
                "gait.moment; they must have the same length",
            )
        if part[0] != 0 or part[-1] != 1 or (np.diff(part) <= 0).any():
            raise QuantityError.of("gait.part", "must rise from 0 to 100 % of the stride")

    def stretch_spring(self) -> tuple[Array, Array, Array, tuple[float, float]]:
        """Return (phase of the stride, angle, payout, window), starting when the clutch closes.

        The payout [m] is measured from the angle at which the clutch closes; it ends when the ankle
        returns to that angle. The phase continues past 1 into the next stride.
        """
        part = self.gait.close + np.arange(SAMPLES + 1) / SAMPLES
        angle = np.interp(part % 1.0, self.gait.part, self.gait.angle)
        reach = np.maximum(self.spring.lever * (angle - angle[0]), 0.0)
        returns = np.flatnonzero((reach[1:] == 0) & (np.cumsum(reach[:-1] > 0) > 0))
        end = int(returns[0]) + 1 if len(returns) else SAMPLES
        payout = np.where(np.arange(SAMPLES + 1) <= end, reach, 0.0)
        return part, angle, payout, (float(part[0]), float(part[end]))

    def simulate_stride(self, rate: Any, line: Line | None) -> Stride:
        """Return a stride at rates [Hz]; without a line, the vacuum is present from the start."""
        part, _, payout, _ = self.stretch_spring()
        brakes, time = self.brakes, np.divide.outer(part - part[0], rate)
        vacuum = np.full_like(time, brakes.vacuum)
        if line is not None:
            vacuum = pumped_vacuum(time, brakes.vacuum, line)
        brake = require_linear(remove_idle_speed_law(self.brake.brake), "the ankle clutch")
        straps: Strap = restraint.make_strap(
            brakes.parallel, brakes.series, vacuum, self.spring.stiffness, brake
        )
        payouts = np.broadcast_to(payout, vacuum.T.shape).T
        step = 1 / (SAMPLES * xp.asarray(rate))
        slip, force = (np.asarray(a) for a in _slip_and_force(xp.asarray(payouts), step, straps))
        return Stride(force, slip, np.asarray(straps.onset), vacuum)

    def analyse(self) -> Result:
        """Analyse the holding force, readiness, returned energy and speed of the clutch."""
        brakes, brake, rate = self.brakes, self.brake.brake, self.gait.stride_rate
        line = scale_line(self.line.line, brakes.count)
        part, angle, payout, window = self.stretch_spring()
        stride, ready = self.simulate_stride(rate, line), self.simulate_stride(rate, None)
        slips = self.simulate_stride(RATES, line).slip.max(axis=0)
        fastest = last_acceptable(RATES, slips <= self.limits.slip)
        chain = brakes.series / (brakes.parallel * float(working_stiffness(brake)))
        largest_force = float(payout.max()) / (1 / self.spring.stiffness + chain)
        hold, top = float(ready.hold[0]), int(np.argmax(payout))
        brakes_needed = (
            math.ceil(self.limits.margin * largest_force / (hold / brakes.parallel)) * brakes.series
        )
        put_in, returned_work, lost_work = compute_energies(payout, stride)
        full_in, full_given, _ = compute_energies(payout, ready)
        moment = np.interp(part % 1.0, self.gait.part, self.gait.moment) * self.gait.body_mass
        result = Result(scenario=self, record=Record(part, angle, stride, ready, slips, window))
        result.add("Hz", stride_rate=rate, fastest_stride_rate=fastest)
        result.add("1", holding_margin=hold / largest_force if largest_force else math.inf)
        result.add("1", flow_factor=rate / fastest if fastest else math.inf)
        static = float(holding_force(brakes.vacuum, brake)) * brakes.parallel
        result.add("N", spring_force=largest_force, holding_force=hold, static_holding_force=static)
        if brake.film.ageing is not None:
            # force at breakaway after the load has risen with the sheets at rest
            aged_force = float(aged_holding_force(top / SAMPLES / rate, brakes.vacuum, brake))
            result.add("N", aged_holding_force=aged_force * brakes.parallel)
        torque = largest_force * self.spring.lever
        result.add("N m", spring_torque=torque, ankle_moment=float(moment.max()))
        result.add("m", stretch=float(payout.max()), slip=float(stride.slip.max()))
        swing = (window[0] + 1 - window[1]) / rate
        result.add("s", release_time=fall_time(brakes.vacuum, line), swing_time=swing)
        result.add("s", loading_time=top / SAMPLES / rate)
        result.add("Pa", vacuum_at_peak=float(stride.vacuum[top]))
        result.add(
            "J",
            energy_stored=put_in - lost_work,
            energy_returned=returned_work,
            energy_lost=lost_work,
        )
        result.add("J", energy_stored_if_ready=full_in, energy_returned_if_ready=full_given)
        result.add("J", pump_work=jam_work(brakes.vacuum, line))
        result.warnings += [
            (
                "the gait is assumed unchanged by the device, although people walk "
                "differently with one"
            ),
            f"pump_work is the work of an ideal pump for one jam of {brakes.count} brakes",
        ]
        result.add_limits()
        result.brakes_needed = brakes_needed
        result.needed = self.describe_need(brakes_needed, result.own)
        return result

    def describe_need(self, brakes: int, numbers: dict[str, Any]) -> str:
        """Describe the requirements in sentences."""
        fastest, rate = numbers["fastest_stride_rate"], numbers["stride_rate"]
        words = (
            f"Holding the spring needs {brakes} brakes ({show(brakes * self.mass, 'kg')}) once the "
            f"vacuum is present; with this line the clutch follows up to {show(fastest, 'Hz', 3)}."
        )
        if fastest < rate:
            times = (
                f"{numbers['flow_factor']:.3g} times the pump's flow" if fastest else "another line"
            )
            words += f" {show(rate, 'Hz', 3)} would need {times}, or a tank evacuated beforehand."
        if numbers["release_time"] > numbers["swing_time"]:
            words += (
                f" It releases in {show(numbers['release_time'], 's', 3)}, but the swing lasts "
                f"{show(numbers['swing_time'], 's', 3)}: it needs a vent valve."
            )
        return words


@compiled
def _slip_and_force(payout: Any, step: Any, straps: Strap) -> tuple[Any, Any]:
    """Return (slip, force) along a stride; payout and strap values have shape (N,) or (N, B).

    `step` [s] is the time between two samples; it is unused without a speed law.
    """
    brake = straps.paced_brake

    def advance(before: tuple[Any, Any], inputs: tuple[Any, Strap]) -> tuple[Any, tuple[Any, Any]]:
        (slip_before, pace), (reach, strap) = before, inputs
        if brake is None:
            slip = restraint.chain_slip(reach, slip_before, strap)
        else:
            slip = restraint.paced_slip(brake, reach, slip_before, pace, step, strap)
            pace = (slip - slip_before) / step
        return (slip, pace), (slip, restraint.tension(reach, slip, strap))

    zero, rows = xp.zeros_like(payout[0]), (payout, straps._replace(paced_brake=None))
    rows_out: tuple[Any, Any] = scan(advance, (zero, None if brake is None else zero), rows)[1]
    return rows_out


def pumped_vacuum(time: Array, limit: float, line: Line) -> Array:
    """Return the vacuum [Pa] at a time [s] after pumping starts from zero, up to `limit` [Pa].

    The closed form is inverted by interpolation between 2000 pressures.
    """
    a = line.site.atmosphere
    top = min(limit, reachable_vacuum(line) * (1 - 1e-9))
    levels = top * (1 - np.geomspace(1, 1e-6, 2000))
    levels[0] = 0.0
    levels = np.append(levels, top)
    times = [pumping_time(a, a - float(v), line) or 0.0 for v in levels]
    return np.interp(time, times, levels)


def compute_energies(payout: Array, stride: Stride) -> tuple[float, float, float]:
    """Return the energies [J] stored, returned and lost to slip in a stride (trapezoidal rule)."""
    mean = (stride.force[1:] + stride.force[:-1]) / 2
    travel = np.diff(payout)
    slip_work = float(np.sum(mean * np.diff(stride.slip)))
    returned_work = -float(np.sum(np.where(travel < 0, mean * travel, 0.0)))
    return float(np.sum(np.where(travel > 0, mean * travel, 0.0))), returned_work, slip_work


def fall_time(vacuum: float, line: Line) -> float:
    """Return the fall time [s], from 90 to 10 % of a vacuum [Pa], by valve or by reversed pump."""
    if line.valve is not None:
        return fall_by_valve(vacuum, line)
    time = fall_by_pump(vacuum, line)
    return math.inf if time is None else time


def last_acceptable(values: Array, is_acceptable: Any) -> float:
    """Return the largest of ascending values before the first unacceptable one, or 0."""
    if not is_acceptable[0]:
        return 0.0
    return float(values[-1] if is_acceptable.all() else values[int(np.argmin(is_acceptable)) - 1])

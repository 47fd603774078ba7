"""Ankle exoskeleton (paper, Fig. 13c): a spring beside the calf, held by brakes as its clutch.

The clutch closes at a point of the stride; from there on the ankle's dorsiflexion stretches the
spring behind the brakes, which must not slip, and plantarflexion takes the energy back. Before the
next stride the vacuum must have gone, or the clutch pulls the foot down in swing. The vacuum rises
from none, pump full on, from the moment the clutch closes; the brakes hold with their kinetic
friction (static friction is more: a margin that is not counted).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from layerjam.errors import QuantityError
from layerjam.fluid.closed_forms import fall_by_pump, fall_by_valve, pumping_time, reachable
from layerjam.fluid.energy import jam_work
from layerjam.fluid.line import Line
from layerjam.mechanics.ageing import aged_holding_force
from layerjam.mechanics.fan import straight
from layerjam.mechanics.friction import holding_force
from layerjam.mechanics.stiffness import working_stiffness
from layerjam.simulate.speed import counted
from layerjam.studies.machines import restraint
from layerjam.studies.machines.readiness import line_for
from layerjam.studies.machines.restraint import Strap
from layerjam.studies.machines.scenario import Array, declared
from layerjam.studies.machines.verdict import Machine, Result
from layerjam.units import show

SAMPLES = 1200
"""Of a stride."""
RATES = np.geomspace(2e-3, 6.0, 400)
"""Stride rates tried [Hz]."""


class Stride(NamedTuple):
    """A stride from the clutch's closing on: (N,), or at stride rates of shape (B,) (N, B)."""

    force: Array
    slip: Array
    hold: Array
    """What the clutch holds at the vacuum of the moment [N]."""
    vacuum: Array


class Record(NamedTuple):
    """For the pictures."""

    part: Array
    """Of the stride; it runs on past 1 into the next."""
    angle: Array
    stride: Stride
    ready: Stride
    """The same with the vacuum standing from the start."""
    slips: Array
    """Greatest slip at each of RATES [m]."""
    window: tuple[float, float]
    """Parts of the stride: closing, and where the spring is slack again."""


@declared("ankle-clutch")
class AnkleClutch(Machine):
    """Everything of the scenario."""

    def together(self) -> None:
        """The gait's curves fit together."""
        super().together()
        part, angle, moment = self.gait.part, self.gait.angle, self.gait.moment
        if not len(part) == len(angle) == len(moment):
            raise QuantityError.of(
                "gait.part",
                f"{len(part)} values beside {len(angle)} of gait.angle and {len(moment)} of "
                "gait.moment; they are rows of one length",
            )
        if part[0] != 0 or part[-1] != 1 or (np.diff(part) <= 0).any():
            raise QuantityError.of("gait.part", "must rise from 0 to 100 % of the stride")

    def stretched(self) -> tuple[Array, Array, Array, tuple[float, float]]:
        """(part of the stride, angle, payout, window) at SAMPLES from the clutch's closing on.

        The payout [m] counts from the angle at which the clutch closes and ends where the ankle is
        back there; the part runs on past 1 into the next stride.
        """
        part = self.gait.close + np.arange(SAMPLES + 1) / SAMPLES
        angle = np.interp(part % 1.0, self.gait.part, self.gait.angle)
        reach = np.maximum(self.spring.lever * (angle - angle[0]), 0.0)
        back = np.flatnonzero((reach[1:] == 0) & (np.cumsum(reach[:-1] > 0) > 0))
        end = int(back[0]) + 1 if len(back) else SAMPLES
        payout = np.where(np.arange(SAMPLES + 1) <= end, reach, 0.0)
        return part, angle, payout, (float(part[0]), float(part[end]))

    def walked(self, rate: Any, line: Line | None) -> Stride:
        """A stride at rates [Hz]; without a line the vacuum stands from the start."""
        part, _, payout, _ = self.stretched()
        brakes, time = self.brakes, np.divide.outer(part - part[0], rate)
        vacuum = np.full_like(time, brakes.vacuum)
        if line is not None:
            vacuum = vacuum_after(time, brakes.vacuum, line)
        brake = straight(counted(self.brake.brake), "the ankle clutch")
        straps: Strap = restraint.strap_of(
            brakes.parallel, brakes.series, vacuum, self.spring.stiffness, brake
        )
        wide = np.broadcast_to(payout, vacuum.T.shape).T
        step = 1 / (SAMPLES * jnp.asarray(rate))
        slip, force = (np.asarray(a) for a in _drawn(jnp.asarray(wide), step, straps))
        return Stride(force, slip, np.asarray(straps.onset), vacuum)

    def analyse(self) -> Result:
        """Whether the clutch holds, is there in time, what it gives back, and how fast."""
        brakes, brake, rate = self.brakes, self.brake.brake, self.gait.stride_rate
        line = line_for(self.line.line, brakes.count)
        part, angle, payout, window = self.stretched()
        stride, ready = self.walked(rate, line), self.walked(rate, None)
        slips = self.walked(RATES, line).slip.max(axis=0)
        fastest = last_before(RATES, slips <= self.limits.slip)
        chain = brakes.series / (brakes.parallel * float(working_stiffness(brake)))
        most = float(payout.max()) / (1 / self.spring.stiffness + chain)
        hold, top = float(ready.hold[0]), int(np.argmax(payout))
        needed = math.ceil(self.limits.margin * most / (hold / brakes.parallel)) * brakes.series
        put_in, given, lost = energies(payout, stride)
        full_in, full_given, _ = energies(payout, ready)
        moment = np.interp(part % 1.0, self.gait.part, self.gait.moment) * self.gait.body_mass
        found = Result(scenario=self, record=Record(part, angle, stride, ready, slips, window))
        found.add("Hz", stride_rate=rate, fastest_stride_rate=fastest)
        found.add("1", holding_margin=hold / most if most else math.inf)
        found.add("1", flow_factor=rate / fastest if fastest else math.inf)
        static = float(holding_force(brakes.vacuum, brake)) * brakes.parallel
        found.add("N", spring_force=most, holding_force=hold, static_holding_force=static)
        if brake.film.ageing is not None:
            # what breaks away after the rise of the load, for which the sheets rest
            rested = float(aged_holding_force(top / SAMPLES / rate, brakes.vacuum, brake))
            found.add("N", aged_holding_force=rested * brakes.parallel)
        torque = most * self.spring.lever
        found.add("N m", spring_torque=torque, ankle_moment=float(moment.max()))
        found.add("m", stretch=float(payout.max()), slip=float(stride.slip.max()))
        swing = (window[0] + 1 - window[1]) / rate
        found.add("s", release_time=fall_time(brakes.vacuum, line), swing_time=swing)
        found.add("s", loading_time=top / SAMPLES / rate)
        found.add("Pa", vacuum_at_peak=float(stride.vacuum[top]))
        found.add("J", energy_stored=put_in - lost, energy_returned=given, energy_lost=lost)
        found.add("J", energy_stored_if_ready=full_in, energy_returned_if_ready=full_given)
        found.add("J", pump_work=jam_work(brakes.vacuum, line))
        found.warnings += [
            "the gait is taken as it is without the device; people walk otherwise with one",
            f"pump_work is the least an ideal pump spends on one jam of {brakes.count} brakes",
        ]
        found.judge()
        found.brakes_needed = needed
        found.needed = self.needed(needed, found.own)
        return found

    def needed(self, needed: int, own: dict[str, Any]) -> str:
        """What it would take, in sentences."""
        fastest, rate = own["fastest_stride_rate"], own["stride_rate"]
        words = (
            f"Holding the spring takes {needed} brakes ({show(needed * self.mass, 'kg')}) once the "
            f"vacuum stands; with this line the clutch follows up to {show(fastest, 'Hz', 3)}."
        )
        if fastest < rate:
            times = f"{own['flow_factor']:.3g} times the pump's flow" if fastest else "another line"
            words += (
                f" {show(rate, 'Hz', 3)} would take {times}, or a vacuum vessel emptied beforehand."
            )
        if own["release_time"] > own["swing_time"]:
            words += (
                f" It lets go in {show(own['release_time'], 's', 3)} and has "
                f"{show(own['swing_time'], 's', 3)}: it needs a vent valve."
            )
        return words


@jax.jit
def _drawn(payout: Any, step: Any, straps: Strap) -> tuple[Any, Any]:
    """(slip, force) along a stride; payout (N,) or (N, B), the strap's leaves as long.

    `step` [s] lies between two samples; without a speed law it does not count.
    """
    law = straps.law

    def on(before: tuple[Any, Any], now: tuple[Any, Strap]) -> tuple[Any, tuple[Any, Any]]:
        (slipped, pace), (reach, strap) = before, now
        if law is None:
            slip = restraint.drawn(reach, slipped, strap)
        else:
            slip = restraint.paced(law, reach, slipped, pace, step, strap)
            pace = (slip - slipped) / step
        return (slip, pace), (slip, restraint.tension(reach, slip, strap))

    zero, rows = jnp.zeros_like(payout[0]), (payout, straps._replace(law=None))
    made: tuple[Any, Any] = jax.lax.scan(on, (zero, None if law is None else zero), rows)[1]
    return made


def vacuum_after(time: Array, most: float, line: Line) -> Array:
    """Vacuum [Pa] a time [s] after the pump started from none, up to `most` [Pa].

    The closed form's inverse, interpolated on 2000 pressures.
    """
    a = line.site.atmosphere
    top = min(most, reachable(line) * (1 - 1e-9))
    levels = top * (1 - np.geomspace(1, 1e-6, 2000))
    levels[0] = 0.0
    levels = np.append(levels, top)
    times = [pumping_time(a, a - float(v), line) or 0.0 for v in levels]
    return np.interp(time, times, levels)


def energies(payout: Array, made: Stride) -> tuple[float, float, float]:
    """(put in, given back, lost in slip) of a stride [J]: trapezoids of the force."""
    mean = (made.force[1:] + made.force[:-1]) / 2
    way = np.diff(payout)
    lost = float(np.sum(mean * np.diff(made.slip)))
    given = -float(np.sum(np.where(way < 0, mean * way, 0.0)))
    return float(np.sum(np.where(way > 0, mean * way, 0.0))), given, lost


def fall_time(vacuum: float, line: Line) -> float:
    """From 90 to 10 % of a vacuum [Pa] by valve, or else by the pump run backwards [s]."""
    if line.valve is not None:
        return fall_by_valve(vacuum, line)
    made = fall_by_pump(vacuum, line)
    return math.inf if made is None else made


def last_before(values: Array, fine: Any) -> float:
    """The greatest of rising values before the first that is not fine; 0 where none is."""
    if not fine[0]:
        return 0.0
    return float(values[-1] if fine.all() else values[int(np.argmin(fine)) - 1])

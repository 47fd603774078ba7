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

from layerjam.device.brake import Brake
from layerjam.errors import QuantityError
from layerjam.fluid.closed_forms import fall_by_pump, fall_by_valve, pumping_time, reachable
from layerjam.fluid.energy import jam_work
from layerjam.fluid.line import Line
from layerjam.mechanics.friction import holding_force
from layerjam.mechanics.stiffness import working_stiffness
from layerjam.studies.machines import restraint
from layerjam.studies.machines.readiness import line_for
from layerjam.studies.machines.restraint import Strap
from layerjam.studies.machines.scenario import Array, Brakes, Curve, Kind, Scenario
from layerjam.studies.machines.verdict import Bound, Facts, Result
from layerjam.units import nested, quantity, record, show

SAMPLES = 1200
"""Of a stride."""
RATES = np.geomspace(2e-3, 6.0, 400)
"""Stride rates tried [Hz]."""


@record
class Gait:
    """How the person walks."""

    stride_rate: float = quantity("Hz", "strides a second", lo=0.01, hi=10)
    body_mass: float = quantity("kg", "mass of the person", lo=1, hi=500)
    close: float = quantity("1", "part of the stride at which the clutch closes", hi=0.99)


@record
class Spring:
    """The spring in series with the clutch."""

    stiffness: float = quantity("N/m", "stiffness of the spring", lo=1, hi=1e7)
    lever: float = quantity("m", "lever arm about the ankle", lo=1e-3, hi=0.5)


@record
class ClutchLimits:
    """What it must do."""

    slip: float = quantity("m", "slip of the clutch in a stride", open_lo=True, hi=0.1)
    margin: float = quantity("1", "holding force over the spring's greatest force", lo=1, hi=10)
    mass: float = quantity("kg", "mass of all brakes", open_lo=True, hi=100)


@record
class AnkleClutch:
    """Everything of the scenario."""

    gait: Gait = nested(Gait)
    spring: Spring = nested(Spring)
    brakes: Brakes = nested(Brakes)
    limits: ClutchLimits = nested(ClutchLimits)


def _together(scenario: Scenario) -> None:
    """The gait's curves fit together."""
    part, angle = scenario.curves["gait.part"], scenario.curves["gait.angle"]
    moment = scenario.curves["gait.moment"]
    if not len(part) == len(angle) == len(moment):
        raise QuantityError.of(
            "gait.part",
            f"{len(part)} values beside {len(angle)} of gait.angle and {len(moment)} of "
            "gait.moment; they are rows of one length",
        )
    if part[0] != 0 or part[-1] != 1 or (np.diff(part) <= 0).any():
        raise QuantityError.of("gait.part", "must rise from 0 to 100 % of the stride")


KIND = Kind(
    numbers=AnkleClutch,
    curves={
        "gait.part": Curve(unit="1", text="parts of the stride, from heel strike on", hi=1),
        "gait.angle": Curve(unit="rad", text="ankle angle, dorsiflexion above zero", lo=-2, hi=2),
        "gait.moment": Curve(
            unit="N m/kg",
            text="moment of the ankle over body mass, plantarflexing above zero",
            lo=-10,
            hi=10,
        ),
    },
    together=_together,
)


class Stride(NamedTuple):
    """A stride at one rate; arrays of shape (N,)."""

    part: Array
    angle: Array
    payout: Array
    """Stretch of spring and clutch since it closed [m]."""
    force: Array
    slip: Array
    hold: Array
    """What the clutch holds at the vacuum of the moment [N]."""
    vacuum: Array
    torque: Array
    """Of the exoskeleton about the ankle [N m]."""
    moment: Array
    """The ankle's own need [N m]."""


class Record(NamedTuple):
    """For the pictures."""

    stride: Stride
    ready: Stride
    """The same with the vacuum standing from the start."""
    rates: Array
    slips: Array
    """Greatest slip at each rate [m]."""
    limits: ClutchLimits
    window: tuple[float, float]
    """Parts of the stride: closing, and where the spring is slack again."""


@jax.jit
def _drawn(payout: Any, straps: Strap) -> tuple[Any, Any]:
    """(slip, force) along a stride; payout (N,) or (N, B), the strap's leaves as long."""

    def on(slipped: Any, now: tuple[Any, Strap]) -> tuple[Any, tuple[Any, Any]]:
        reach, strap = now
        slip = restraint.drawn(reach, slipped, strap)
        return slip, (slip, restraint.tension(reach, slip, strap))

    return jax.lax.scan(on, jnp.zeros_like(payout[0]), (payout, straps))[1]  # type: ignore[no-any-return]


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


def stretched(scenario: Scenario) -> tuple[Array, Array, Array, tuple[float, float]]:
    """(part of the stride, angle, payout, window) at SAMPLES from the clutch's closing on.

    The payout counts from the angle at which the clutch closes and ends where the ankle is back
    there; the part runs on past 1 into the next stride.
    """
    numbers: AnkleClutch = scenario.numbers
    part = numbers.gait.close + np.arange(SAMPLES + 1) / SAMPLES
    angle = np.interp(part % 1.0, scenario.curves["gait.part"], scenario.curves["gait.angle"])
    reach = np.maximum(numbers.spring.lever * (angle - angle[0]), 0.0)
    back = np.flatnonzero((reach[1:] == 0) & (np.cumsum(reach[:-1] > 0) > 0))
    end = int(back[0]) + 1 if len(back) else SAMPLES
    payout = np.where(np.arange(SAMPLES + 1) <= end, reach, 0.0)
    return part, angle, payout, (float(part[0]), float(part[end]))


def straps_at(vacuum: Array, numbers: AnkleClutch, brake: Brake) -> Strap:
    """Spring and brakes at every vacuum [Pa]."""
    made: Strap = restraint.strap_of(
        numbers.brakes.parallel, numbers.brakes.series, vacuum, numbers.spring.stiffness, brake
    )
    return made


def walked(scenario: Scenario, rate: float, line: Line | None) -> Stride:
    """A stride at a rate [Hz]; without a line the vacuum stands from the start."""
    numbers: AnkleClutch = scenario.numbers
    part, angle, payout, _ = stretched(scenario)
    vacuum = np.full_like(part, numbers.brakes.vacuum)
    if line is not None:
        vacuum = vacuum_after((part - part[0]) / rate, numbers.brakes.vacuum, line)
    straps = straps_at(vacuum, numbers, scenario.brake.brake)
    slip, force = (np.asarray(a) for a in _drawn(jnp.asarray(payout), straps))
    own = np.interp(part % 1.0, scenario.curves["gait.part"], scenario.curves["gait.moment"])
    hold, torque = np.asarray(straps.onset), force * numbers.spring.lever
    moment = own * numbers.gait.body_mass
    return Stride(part, angle, payout, force, slip, hold, vacuum, torque, moment)


def slips(scenario: Scenario, line: Line, rates: Array) -> Array:
    """Greatest slip [m] at stride rates [Hz], shape (B,)."""
    numbers: AnkleClutch = scenario.numbers
    part, _, payout, _ = stretched(scenario)
    time = (part - part[0])[:, None] / rates[None, :]
    vacuum = vacuum_after(time, numbers.brakes.vacuum, line)
    straps = straps_at(vacuum, numbers, scenario.brake.brake)
    wide = np.broadcast_to(payout[:, None], vacuum.shape)
    return np.asarray(_drawn(jnp.asarray(wide), straps)[0]).max(axis=0)


def energies(made: Stride) -> tuple[float, float, float]:
    """(put in, given back, lost in slip) of a stride [J]: trapezoids of the force."""
    mean = (made.force[1:] + made.force[:-1]) / 2
    way = np.diff(made.payout)
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


def analyse(scenario: Scenario) -> Result:
    """Whether the clutch holds, whether it is there in time, what it gives back, and how fast."""
    numbers: AnkleClutch = scenario.numbers
    brakes, limits, brake = numbers.brakes, numbers.limits, scenario.brake.brake
    rate = numbers.gait.stride_rate
    line = line_for(scenario.known_line.line, brakes.count)
    stride, ready = walked(scenario, rate, line), walked(scenario, rate, None)
    _, _, payout, window = stretched(scenario)
    slipped = slips(scenario, line, RATES)
    fastest = last_before(RATES, slipped <= limits.slip)
    chain = brakes.series / (brakes.parallel * float(working_stiffness(brake)))
    most = float(payout.max()) / (1 / numbers.spring.stiffness + chain)
    hold, top = float(ready.hold[0]), int(np.argmax(payout))
    needed = math.ceil(limits.margin * most / (hold / brakes.parallel)) * brakes.series
    put_in, given, lost = energies(stride)
    full_in, full_given, _ = energies(ready)
    own = Facts(scenario)
    own.add("Hz", stride_rate=rate, fastest_stride_rate=fastest)
    own.add("1", holding_margin=hold / most if most else math.inf)
    own.add("1", flow_factor=rate / fastest if fastest else math.inf)
    static = float(holding_force(brakes.vacuum, brake)) * brakes.parallel
    own.add("N", spring_force=most, holding_force=hold, static_holding_force=static)
    torque = most * numbers.spring.lever
    own.add("N m", spring_torque=torque, ankle_moment=float(stride.moment.max()))
    own.add("m", stretch=float(payout.max()), slip=float(stride.slip.max()))
    swing = (window[0] + 1 - window[1]) / rate
    own.add("s", release_time=fall_time(brakes.vacuum, line), swing_time=swing)
    own.add("s", loading_time=top / SAMPLES / rate)
    own.add("Pa", vacuum_at_peak=float(stride.vacuum[top]))
    own.add("J", energy_stored=put_in - lost, energy_returned=given, energy_lost=lost)
    own.add("J", energy_stored_if_ready=full_in, energy_returned_if_ready=full_given)
    own.add("J", pump_work=jam_work(brakes.vacuum, line))
    return own.result(
        own.limits(BOUNDS),
        brakes_needed=needed,
        needed=_needed(scenario, needed, own.values),
        warnings=[
            "the gait is taken as it is without the device; people walk otherwise with one",
            f"pump_work is the least an ideal pump spends on one jam of {brakes.count} brakes",
        ],
        record=Record(stride, ready, RATES, slipped, limits, window),
    )


BOUNDS = (
    Bound(
        "holding force over the spring's greatest, vacuum standing",
        "holding_margin",
        "margin",
        least=True,
    ),
    Bound("slip of the clutch in a stride", "slip", "slip"),
    Bound("stride rate the vacuum can follow", "fastest_stride_rate", "stride_rate", least=True),
    Bound("time to let go", "release_time", "swing_time"),
    Bound("mass of the brakes", "mass", "mass"),
)


def _needed(scenario: Scenario, needed: int, own: dict[str, Any]) -> str:
    """What it would take, in sentences."""
    fastest, rate = own["fastest_stride_rate"], own["stride_rate"]
    words = (
        f"Holding the spring takes {needed} brakes ({show(needed * scenario.mass, 'kg')}) once the "
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

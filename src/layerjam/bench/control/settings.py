"""Settings of a controller: quantities with units and bounds, packed into tuples for the law."""

import math
from dataclasses import dataclass

import numpy as np

from layerjam.bench.control import law
from layerjam.bench.control.passage import Owed, owed_rise
from layerjam.bench.control.plant import Plant, check_target
from layerjam.bench.control.tolerances import Tolerances
from layerjam.bench.control.tuning import Gains, simc_gains
from layerjam.brake.fluid.line import Sensor
from layerjam.core.brief import brief
from layerjam.core.errors import QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.units import check, quantity, show

KINDS = {
    "bang-bang": "pump full on or off, with hysteresis",
    "pi": "proportional-integral with feed-forward",
    "scheduled": (
        "proportional-integral, with a gain that rises with the vacuum as the pump's effect falls"
    ),
}
SAFE_STATES = {"release": "pump off, vent open", "hold": "pump off, vent closed"}
FAULTS = {
    law.HEALTHY: "HEALTHY",
    law.NOT_A_NUMBER: "NOT_A_NUMBER",
    law.OUT_OF_RANGE: "SENSOR_OUT_OF_RANGE",
    law.STUCK: "SENSOR_STUCK",
    law.OFFSET: "SENSOR_OFFSET",
    law.NO_VACUUM: "NO_VACUUM",
    law.WEAK_PUMP: "WEAK_PUMP",
    law.BLOCKED: "LINE_BLOCKED",
    law.LOST: "VACUUM_LOST",
}
SLOWEST = 0.1
"""Longest duration of a sample, relative to the line's time constant."""
CLEAR_OF_NOISE = 20.0
"""Smallest decision step of a detector, in standard deviations of a reading."""
CLEAR_OF_ZERO = 5.0
"""Distance from the largest zero error to the offset limit, in standard deviations of a reading."""
FADES = 6.0
"""Time after which a closed vent no longer affects the reading, in sensor lags."""
AT_START = 2.5
"""Smallest ratio of a decision step to the part of the rise that a tube delays."""
SAFELY = 1.3
"""Smallest ratio of a blocked line's rise to that of any healthy line."""
_NEVER = 1e15

LawSettings = tuple[tuple[float, ...], tuple[float, ...]]


@brief
@dataclass(frozen=True, kw_only=True)
class Regulator:
    """Settings of the law; those not given are calculated from plant and sensor.

    Raises QuantityError for an unknown kind or safe state, or if no safe state is given, because
    that depends on the load on the brake.
    """

    plant: Plant
    sensor: Sensor
    kind: str = "pi"
    safe_state: str = ""
    tolerances: Tolerances = Tolerances()
    """Differences from `plant` and `sensor` that the detectors allow."""
    sample_time: float = quantity("s", "time between two samples", lo=1e-5, hi=10, default=0.01)
    hysteresis: float | None = quantity(
        "Pa",
        "bang-bang: hysteresis between switching on and off",
        hi=1e5,
        open_lo=True,
        default=None,
    )
    dead_band: float | None = quantity(
        "Pa", "PI: half-width of the error's dead band", hi=1e5, default=None
    )
    vent_band: float | None = quantity(
        "Pa", "excess over the target at which the vent opens", hi=1.2e5, open_lo=True, default=None
    )
    gain: float | None = quantity(
        "1/Pa", "PI: pump command per unit error; `scheduled`: at no vacuum", hi=1e3, default=None
    )
    integral_time: float | None = quantity(
        "s", "PI: integral time", hi=1e6, open_lo=True, default=None
    )
    tuned_at: float | None = quantity(
        "Pa", "PI: vacuum at which it is tuned; half of `top` if left out", hi=1.2e5, default=None
    )
    feed_forward: bool = True
    reversible: bool = False
    """Whether the pump can run backwards to lower the vacuum; the vent opens only to release."""
    least_command: float = quantity(
        "1", "PI: command below which the pump stops", lo=1e-6, hi=1, default=0.02
    )
    minimum_on: float = quantity("s", "minimum run time of the pump", hi=1e4, default=0.0)
    minimum_off: float = quantity("s", "minimum off time of the pump", hi=1e4, default=0.0)
    minimum_vent: float = quantity("s", "minimum time between vent switchings", hi=1e4, default=0.0)
    confirm: int = quantity(
        "1",
        "consecutive samples out of range that indicate a fault",
        lo=1,
        hi=1e6,
        whole=True,
        default=3,
    )
    decision_step: float | None = quantity(
        "Pa", "shortfall in rise that indicates a dead pump", hi=1e5, open_lo=True, default=None
    )
    no_vacuum_ratio: float = quantity(
        "1", "fraction of expected rise below which there is no vacuum", lo=0.01, hi=1, default=0.2
    )
    weak_ratio: float = quantity(
        "1", "fraction of expected rise below which the pump is weak", lo=0.01, hi=0.9, default=0.5
    )
    blocked_ratio: float = quantity(
        "1",
        ("multiple of the expected rise that indicates a blocked line"),
        lo=3,
        hi=1e3,
        default=4.0,
    )
    lost_band: float | None = quantity(
        "Pa",
        "drop below a reached target that indicates a loss of vacuum",
        hi=1e5,
        open_lo=True,
        default=None,
    )
    lost_time: float = quantity("s", "minimum duration of that drop", hi=1e4, default=1.0)
    stuck_time: float = quantity(
        "s", "longest time that a noisy sensor may show a constant reading", hi=1e6, default=1.0
    )
    offset_limit: float | None = quantity(
        "Pa", "highest reading accepted as zero when vented", hi=1e5, open_lo=True, default=None
    )
    settle_time: float | None = quantity(
        "s",
        "time after which an open vent must have removed the vacuum",
        hi=1e4,
        open_lo=True,
        default=None,
    )
    floor: float | None = quantity(
        "Pa", "reading below which the sensor is out of range", lo=-1e6, hi=0, default=None
    )

    def __post_init__(self) -> None:
        for name, choices in (("kind", KINDS), ("safe_state", SAFE_STATES)):
            value = getattr(self, name)
            if value not in choices:
                fault = f"'{value}' is not allowed" if value else "required"
                choice = " or ".join(f"'{key}' ({text})" for key, text in choices.items())
                raise QuantityError(f"{name}: {fault}; write {choice}")

    @property
    def half_band(self) -> float:
        """Half of the hysteresis of a bang-bang controller, or the dead band of others [Pa]."""
        if self.kind != "bang-bang":
            return self.sensor.resolution if self.dead_band is None else self.dead_band
        noise_limit = 0.5 * CLEAR_OF_NOISE * self.sensor.noise + self.sensor.resolution
        band = max(0.01 * self.plant.top, noise_limit)
        return 0.5 * (band if self.hysteresis is None else self.hysteresis)

    @property
    def vent_threshold(self) -> float:
        """Excess over the target at which the vent opens [Pa]."""
        noise_limit = 2 * self.half_band + 12 * self.sensor.noise + 2 * self.sensor.resolution
        plant, tube = self.plant, self.plant.passage
        if tube is not None:
            # gas still flows into the emptied tube, so a small excess need not be vented
            noise_limit += max(tube.rise_after_stop(tube.vacuum, plant.rate, plant.top), 0.0)
        return max(0.01 * self.plant.top, noise_limit) if self.vent_band is None else self.vent_band

    @property
    def detection_threshold(self) -> float:
        """Return the shortfall in rise [Pa] at which a dead pump is detected."""
        noise_limit = CLEAR_OF_NOISE * self.greatest_noise + 2 * self.sensor.resolution
        band, tube = max(0.02 * self.plant.top, noise_limit), self.plant.passage
        if tube is not None:
            delayed_rise = tube.delayed_rise(
                self.plant.rate, self.owed_rise, self.kind == "bang-bang"
            )
            band = max(band, AT_START * delayed_rise)
        return band if self.decision_step is None else self.decision_step

    @property
    def greatest_noise(self) -> float:
        """Return the standard deviation of a reading [Pa] at the upper limit of its tolerance."""
        return self.tolerances.noise * self.sensor.noise

    @property
    def zero_error(self) -> float:
        """Return the largest zero error of the sensor, of either sign [Pa]."""
        return self.tolerances.zero * self.sensor.range

    @property
    def longest_lag(self) -> float:
        """Longest lag of the sensor [s]."""
        return max(self.tolerances.lag, self.sensor.lag)

    @property
    def total_lag(self) -> float:
        """Longest lag of sensor and tube together [s]."""
        return self.longest_lag + self.plant.tube_lag

    zero, decision, lag = zero_error, detection_threshold, total_lag  # former names

    @property
    def vent_fade_time(self) -> float:
        """Time after which a closed vent no longer affects the reading [s]."""
        return FADES * self.longest_lag + 8 * self.mixing_time

    @property
    def mixing_time(self) -> float:
        """Return the time constant with which the pressures of chamber and tube equalise [s]."""
        tube = self.plant.passage
        return 0.0 if tube is None else tube.exchange_time(tube.vacuum)

    @property
    def loss_time(self) -> float:
        """Time for which the vacuum must be too low before its loss is reported [s].

        It is longer with a tube, because the gas in the tube must be pumped out.
        """
        plant, tube = self.plant, self.plant.passage
        if tube is None:
            return self.lost_time
        fast_vent, slow_pump = 1 + self.tolerances.vent, 1 - self.tolerances.pump
        let_in = -tube.rise_after_stop(tube.vacuum, fast_vent * plant.vent, 0.0)
        rise = slow_pump * float(plant.rise(tube.vacuum))
        return self.lost_time + 8 * self.mixing_time + (let_in / rise if rise > 0 else 0.0)

    @property
    def owed_rise(self) -> Owed:
        """Return the rise that is expected of a healthy pump, before the leak is subtracted."""
        plant, tube = self.plant, self.plant.passage
        if tube is None:
            return Owed(plant.rate, plant.top, plant.weight)
        return owed_rise(tube, plant.rate, plant.top, self.kind == "bang-bang")

    @property
    def blocked_limit(self) -> float:
        """Return the multiple of the expected rise that indicates a blocked line.

        With a tube, whose gas remains in front of a blockage, it is half of the factor by which the
        blockage increases the rise at full command.
        """
        plant, tube = self.plant, self.plant.passage
        if tube is None:
            return self.blocked_ratio
        smaller, vacuum = 2 * self.blocked_ratio, np.linspace(0.0, tube.vacuum, 50)
        blocked_tube = evolve(tube, volume=smaller * tube.volume, passes=smaller * tube.passes)
        ratio = blocked_tube.rise(vacuum, smaller * plant.rate, plant.top) / self.owed_rise.rise_at(
            vacuum
        )
        ratio_limit = min(self.blocked_ratio, 0.5 * float(ratio.min()))
        return max(self.healthy_ratio, ratio_limit)

    @property
    def healthy_ratio(self) -> float:
        """Return the largest ratio of a healthy line's rise to the expected rise, with a margin."""
        return max(SAFELY, 1.05 * (1 + self.tolerances.pump)) * self.owed_rise.ratio

    @property
    def blocked_excess(self) -> float:
        """Excess [Pa] over `blocked_limit` times the expected rise that reveals a blocked line."""
        noise_limit = 0.5 * CLEAR_OF_NOISE * self.greatest_noise + 2 * self.sensor.resolution
        tube, band = self.plant.passage, max(0.5 * self.detection_threshold, noise_limit)
        if tube is None:
            return band
        # gas that the tube delays while the pump slows down is not an excess
        return max(
            band, 2 * tube.delayed_rise(self.plant.rate, self.owed_rise, self.kind == "bang-bang")
        )

    @property
    def loss_margin(self) -> float:
        """Distance below the target at which the vacuum counts as lost [Pa]."""
        noise_limit = 3 * self.half_band + 12 * self.sensor.noise + 2 * self.sensor.resolution
        return max(0.05 * self.plant.top, noise_limit) if self.lost_band is None else self.lost_band

    @property
    def largest_zero(self) -> float:
        """Highest reading accepted as zero when vented [Pa]."""
        noise = CLEAR_OF_ZERO * self.greatest_noise + self.sensor.resolution
        noise_limit = self.zero_error + max(0.01 * self.plant.top, noise)
        return noise_limit if self.offset_limit is None else self.offset_limit

    @property
    def settling_time(self) -> float:
        """Time after which an open vent has removed nearly all of the vacuum [s].

        Less than half of the distance from the sensor's zero to `largest_zero` then remains.
        """
        if self.settle_time is not None:
            return self.settle_time
        plant = self.plant.lumped_plant
        slow_vent, tube = 1 - self.tolerances.vent, self.plant.passage
        decay = slow_vent * plant.vent + plant.leak
        residual = max(self.largest_zero - self.zero_error, 1.0)
        lasting = max(math.log(2 * plant.top / residual), 0.0)
        # through a tube, the decay ends as an exponential that starts at twice the vacuum
        through = 0.0 if tube is None else (lasting + math.log(2)) * tube.filling_time(0.0)
        return lasting / decay + through + 8 * self.longest_lag + self.sample_time

    @property
    def is_noisy(self) -> bool:
        """Return whether noise changes every healthy reading; a constant one is then a fault."""
        return self.sensor.noise > 0 and self.sensor.noise >= 0.5 * self.sensor.resolution

    @property
    def lowest_reading(self) -> float:
        """Reading below which the sensor is out of range [Pa]."""
        return -0.05 * self.sensor.range if self.floor is None else self.floor

    def gains(self) -> Gains:
        """Return the gains, tuned at zero vacuum for `scheduled`, at `tuned_at` for `pi`."""
        tuning_vacuum = 0.5 * self.plant.top if self.tuned_at is None else self.tuned_at
        vacuum = tuning_vacuum if self.kind == "pi" else 0.0
        tube = self.plant.passage
        lag = self.sensor.lag + (tube.exchange_time(max(vacuum, tube.vacuum)) if tube else 0.0)
        return simc_gains(
            self.plant.lumped_plant, sample_time=self.sample_time, lag=lag, vacuum=vacuum
        )

    def samples(self, time: float) -> float:
        """Return the number of whole samples that together last at least `time` [s]."""
        return float(math.ceil(time / self.sample_time - 1e-9))

    def pack(self) -> LawSettings:
        """Return the tuples that `law.step` accepts as settings."""
        plant, gains, dt = self.plant.lumped_plant, self.gains(), self.sample_time
        owed = self.owed_rise
        gain = gains.gain if self.gain is None else self.gain
        lasting = gains.integral_time if self.integral_time is None else self.integral_time
        feed = 1.0 if self.feed_forward and self.kind != "bang-bang" else 0.0
        lag = self.total_lag
        regulator = (
            float(list(KINDS).index(self.kind)), gain, gain * dt / lasting, self.half_band,
            self.vent_threshold, -1.0 if self.reversible else 0.0,
            1.0 if self.kind == "bang-bang" else self.least_command,
            self.samples(self.minimum_on), self.samples(self.minimum_off),
            self.samples(self.minimum_vent), feed * plant.leak / plant.rate,
            feed / (plant.rate * dt), plant.top, plant.weight,
            1.0 if self.safe_state == "release" else 0.0,
        )  # fmt: skip
        watch = (
            owed.rate * dt, owed.top, owed.weight, self.plant.leak * dt,
            -math.expm1(-dt / lag) if lag else 1.0, self.lowest_reading, self.sensor.range,
            float(self.confirm), self.detection_threshold, self.no_vacuum_ratio, self.weak_ratio,
            self.blocked_limit, self.loss_margin, self.samples(self.loss_time),
            max(self.samples(self.stuck_time), 50.0) if self.is_noisy else _NEVER,
            self.samples(self.settling_time), self.largest_zero,
            self.samples(self.vent_fade_time), owed.most * dt, owed.less * dt, owed.bend * dt,
            self.healthy_ratio, self.blocked_excess, self.zero_error,
        )  # fmt: skip
        return regulator, watch

    packed = pack  # former name


def validate(regulator: Regulator, target: float) -> None:
    """Raise QuantityError if a controller cannot bring its line to `target` [Pa]."""
    check(regulator)
    check(regulator.tolerances, "tolerances.")
    plant, sensor, dt = regulator.plant, regulator.sensor, regulator.sample_time
    check_target(plant, target)
    if plant.passage is not None and target > plant.passage.vacuum * (1 + 1e-9):
        raise QuantityError(
            f"target: {show(target, 'Pa')} is not allowed; the detectors allow for the tube only "
            f"up to {show(plant.passage.vacuum, 'Pa')}; build the plant for the highest target, "
            "plant_of(line, vacuum=...)"
        )
    line = 1.0 / (plant.rate + plant.leak)
    if dt > SLOWEST * line:
        raise QuantityError(
            f"sample_time: {show(dt, 's')} is not allowed; the line's time constant is "
            f"{show(line, 's')}, and a sample may last a tenth of it, {show(line / 10, 's')}"
        )
    highest = target + regulator.half_band + 3 * regulator.greatest_noise + sensor.resolution
    if not highest < sensor.range:
        raise QuantityError(
            f"sensor.range: {show(sensor.range, 'Pa')} is not allowed; to hold a target "
            f"of {show(target, 'Pa')} the range must exceed {show(highest, 'Pa')}"
        )
    if regulator.reversible and not plant.backwards:
        raise QuantityError("reversible: the plant's pump cannot run backwards (plant.backwards)")
    _check_noise(regulator)
    top = target + regulator.half_band
    if regulator.kind == "bang-bang" and top >= plant.reach:
        raise QuantityError(
            f"hysteresis: {show(2 * regulator.half_band, 'Pa')} is not allowed; around a target of "
            f"{show(target, 'Pa')} it extends to {show(top, 'Pa')}, but the pump "
            f"reaches only {show(plant.reach, 'Pa')}"
        )
    if regulator.no_vacuum_ratio > regulator.weak_ratio:
        raise QuantityError(
            f"no_vacuum_ratio: {regulator.no_vacuum_ratio:g} is not allowed; it must not exceed "
            f"weak_ratio, {regulator.weak_ratio:g}"
        )


def _check_noise(regulator: Regulator) -> None:
    """Raise QuantityError if noise or a zero error alone could switch the pump or cause a fault."""
    sensor, noise_sd, zero = regulator.sensor, regulator.greatest_noise, regulator.zero_error
    nominal = f"noise of {show(sensor.noise, 'Pa')}"
    worst = f"noise of up to {show(noise_sd, 'Pa')} and a zero error of up to {show(zero, 'Pa')}"
    switching = 8.0 * sensor.noise if regulator.kind == "bang-bang" else 0.0
    for name, value, noise, error in (
        ("hysteresis", 2 * regulator.half_band, switching, nominal),
        ("vent_band", regulator.vent_threshold - regulator.half_band, 8.0 * sensor.noise, nominal),
        ("decision_step", regulator.detection_threshold, CLEAR_OF_NOISE * noise_sd, worst),
        ("lost_band", regulator.loss_margin - regulator.half_band, 8.0 * sensor.noise, nominal),
        ("offset_limit", regulator.largest_zero, zero + CLEAR_OF_ZERO * noise_sd, worst),
        ("floor", -regulator.lowest_reading, zero + CLEAR_OF_ZERO * noise_sd, worst),
    ):
        lower_bound = noise + (sensor.resolution if noise else 0.0)
        if value < lower_bound * (1 - 1e-9):
            raise QuantityError(
                f"{name}: {show(value, 'Pa')} is too small for a sensor with {error}; at "
                f"least {show(lower_bound, 'Pa')} is needed"
            )

"""Faults that can be injected, by name, to test detectors."""

import math
from dataclasses import dataclass

from layerjam.bench.control.exact import Rates
from layerjam.bench.control.plant import Plant
from layerjam.bench.control.settings import Regulator
from layerjam.core.errors import UnknownNameError
from layerjam.core.units import show

PROVOKED = {
    "pump-dead": "the pump delivers no flow",
    "pump-weak": "the pump delivers half of the flow below which it is considered weak",
    "line-blocked": (
        "the line is blocked: the pump evacuates little more than the tube up to the blockage"
    ),
    "leak": "a leak opens; at full power the pump holds only half the target",
    "sensor-nan": "the sensor gives no reading",
    "sensor-stuck": "the sensor reading is frozen",
    "sensor-offset": (
        "the sensor reads too high by 2.5 times the highest vented reading accepted as zero"
    ),
}
OFFSET = 2.5
"""Ratio of injected offset to the highest reading accepted as zero; from 2 it must be reported."""


@dataclass(frozen=True, kw_only=True)
class FaultInjection:
    """Fault that begins at time `at` [s]: changes to the plant, or a state of the sensor.

    `pump` multiplies the pump's flow, `leak` [1/s] is added to the leak, `volume` multiplies the
    volume (a blocked line leaves a small one), `vent` multiplies the vent's flow. `sensor` is one
    of "nan", "stuck", "rail" (it shows `value`), "offset" (it reads `value` too high) [Pa].
    """

    at: float = math.inf
    pump: float = 1.0
    leak: float = 0.0
    volume: float = 1.0
    vent: float = 1.0
    sensor: str = ""
    value: float = 0.0

    def break_plant(self, plant: Plant) -> Rates:
        """Return the parameters of the faulty plant for the compiled loop."""
        tube = plant.passage
        return Rates(
            rate=plant.rate * self.pump / self.volume,
            top=plant.top,
            weight=plant.weight,
            leak=(plant.leak + self.leak) / self.volume,
            vent=plant.vent * self.vent / self.volume,
            backwards=plant.backwards * self.pump / self.volume,
            side=0.0 if tube is None else tube.volume / self.volume,
            passes=0.0 if tube is None else tube.passes / self.volume,
            atmosphere=0.0 if tube is None else tube.atmosphere,
        )


def make_injection(
    fault: str, start: float, regulator: Regulator, target: float
) -> tuple[FaultInjection, str]:
    """Return the fault to inject from `start` [s] while `target` [Pa] is held, and its description.

    Sizes are the smallest that the controller's detectors always report (`detection_times`). An
    injected leak is laminar and needs a target above zero. Raises UnknownNameError.
    """
    if fault not in PROVOKED:
        raise UnknownNameError("fault", fault, PROVOKED)
    plant = regulator.plant
    if fault == "pump-dead":
        return FaultInjection(at=start, pump=0.0), PROVOKED[fault]
    if fault == "pump-weak":
        share = regulator.weak_ratio / 2
        return FaultInjection(at=start, pump=share), f"the pump delivers {share:.0%} of its flow"
    if fault == "line-blocked":
        remaining_share = 1 / (2 * regulator.blocked_ratio)
        return FaultInjection(
            at=start, volume=remaining_share
        ), f"the line is blocked; {remaining_share:.1%} of its volume remains"
    if fault == "leak":
        half_target = target / 2
        total = plant.rate * (plant.top - plant.weight * half_target) / half_target
        extra_leak = max(total - plant.leak, 0.0)
        return FaultInjection(at=start, leak=extra_leak), (
            f"a leak opens; at full power the pump holds only {show(half_target, 'Pa')}"
        )
    if fault == "sensor-offset":
        value = OFFSET * regulator.largest_zero
        return FaultInjection(at=start, sensor="offset", value=value), (
            f"the sensor reads {show(value, 'Pa')} too high"
        )
    return FaultInjection(at=start, sensor=fault.removeprefix("sensor-")), PROVOKED[fault]

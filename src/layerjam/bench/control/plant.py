"""Plant of the controller: vacuum in a constant volume, solved exactly between samples.

    dv/dt = u k (top - w v) - (leak + vent) v,    w = 1 for air, 0 for water,

with v the vacuum and u the pump command, held between samples. For air in a constant volume V with
the exponent n, k = n Q/V and top = atmosphere - ultimate pressure (mechanics, section 5; leak and
vent are laminar, and their throughputs are proportional to v). For water with compliance C, k top =
Q/C, and the vacuum does not exceed top. For air, a tube between pump and chamber adds a second
volume (`passage.py`).
"""

from dataclasses import dataclass
from typing import Any

from layerjam.bench.control.passage import Passage, balance_vacuum
from layerjam.brake.fluid.flow import NORMAL, VAPOUR, leak_throughput, tube_conductance
from layerjam.brake.fluid.line import Leak, Line, Valve, validate, water_compliance
from layerjam.brake.fluid.pump import (
    displacement_at_pressure,
    lowest_pressure,
    require_known_water_flow,
)
from layerjam.brake.fluid.tube import tube_area
from layerjam.core.errors import QuantityError
from layerjam.core.evolve import assemble, evolve
from layerjam.core.units import check, quantity, show


@dataclass(frozen=True, kw_only=True)
class Plant:
    """Pump, volume, leak and vent as four rates; see the equation at the top of this module."""

    rate: float = quantity("1/s", "rate at full pump power", hi=1e4, open_lo=True, symbol="k")
    """Ratio of flow to volume for air, ratio of rise to `top` for water."""
    top: float = quantity("Pa", "vacuum the pump reaches without a leak", lo=10, hi=1.2e5)
    leak: float = quantity("1/s", "decay of the vacuum with the pump off", hi=1e3, default=0.0)
    vent: float = quantity("1/s", "additional decay with the vent open", hi=1e5, open_lo=True)
    backwards: float = quantity(
        "Pa/s",
        ("decay with the pump run backwards; 0 if it cannot run backwards"),
        hi=1e9,
        default=0.0,
    )
    water: bool = False
    """Whether water fills the volume: the rise then does not decrease with the vacuum."""
    passage: Passage | None = None
    """Tube between the chamber and the side with pump and vent."""

    @property
    def weight(self) -> float:
        """Return the coefficient w in the equation at the top of this module."""
        return 0.0 if self.water else 1.0

    @property
    def reach(self) -> float:
        """Return the vacuum [Pa] at which the pump at full power and the leak balance."""
        if self.passage is not None:
            return balance_vacuum(self.passage, self.rate, self.top, self.leak)
        if not self.water:
            return self.top * self.rate / (self.rate + self.leak)
        return min(self.top, self.top * self.rate / self.leak) if self.leak else self.top

    @property
    def lumped_plant(self) -> "Plant":
        """Return the plant with the tube's gas added to the chamber, for slow changes."""
        if self.passage is None:
            return self
        gas = 1 + self.passage.volume
        return evolve(
            self,
            rate=self.rate / gas,
            leak=self.leak / gas,
            vent=self.vent / gas,
            backwards=self.backwards / gas,
            passage=None,
        )

    joined = lumped_plant  # former name

    @property
    def tube_lag(self) -> float:
        """Return the time constant [s] after which full pump power acts on a vented chamber."""
        tube = self.passage
        return 0.0 if tube is None else float(tube.pump_lag(self.rate, tube.atmosphere))

    def tune_up_to(self, vacuum: float) -> "Plant":
        """Return the plant with detectors tuned up to `vacuum` [Pa], which matters with a tube."""
        if self.passage is None:
            return self
        return evolve(self, passage=evolve(self.passage, vacuum=vacuum))

    def rise(self, vacuum: Any) -> Any:
        """Return the rise of the vacuum [Pa/s] at full pump power, including the leak."""
        gross = (
            self.rate * (self.top - self.weight * vacuum)
            if self.passage is None
            else self.passage.rise(vacuum, self.rate, self.top)
        )
        return gross - self.leak * vacuum

    def fall(self, vacuum: Any) -> Any:
        """Return the fall of the vacuum [Pa/s] with the vent open, after its delay."""
        if self.passage is None:
            return (self.vent + self.leak) * vacuum
        # an open vent acts on the tube like a pump whose lowest pressure is the atmosphere
        return self.leak * vacuum - self.passage.rise(vacuum, self.vent, 0.0)

    def time_constant(self, vacuum: float) -> float:
        """Return the time constant [s] of the line with its tube at a vacuum [Pa]."""
        if self.passage is None:
            return 1 / (self.rate + self.leak)
        plant = self.lumped_plant
        return 1 / (plant.rate + plant.leak) + self.passage.filling_time(vacuum)


def linearise_line(line: Line, *, vacuum: float, water: bool = False) -> Plant:
    """Return the plant of a fluid line, with leak and valve linearised at `vacuum` [Pa].

    A pump with a flow curve is linearised too. The plant is exact for a leak-free line whose pump
    has a constant displacement. A valve's choked flow is used at all pressures, so the plant is too
    fast late in a release. Without a valve, the vent command means that the driver must run the
    pump backwards. Such a line cannot be released after a pump fault. In air, a tube is included
    without pressure waves, and the detectors are tuned to it up to `vacuum`. The reservoir's valve
    stays closed. Slip and shrinking are ignored, and a water line is assumed to be leak-free.
    Raises QuantityError if the line has no means of venting.
    """
    pump, chamber, atmosphere = line.pump, line.chamber, line.site.atmosphere
    passage, n = None, line.polytropic
    volume = chamber.volume
    flow = displacement_at_pressure(atmosphere - vacuum, pump, atmosphere) * pump.count
    reverse_flow = pump.backwards * pump.count
    vent = line.valve.conductance * NORMAL / volume if line.valve else 0.0
    if not vent and not reverse_flow:
        raise QuantityError(
            "line: nothing can release the vacuum: add a valve or a reversible pump"
        )
    if not water:
        leak = leak_throughput(
            atmosphere - vacuum, atmosphere, line.leak.laminar, line.leak.orifice
        )
        leak, rate = n * (leak / (volume * vacuum)), n * (flow / volume)
        top = atmosphere - lowest_pressure(pump, atmosphere)
        vent = n * (vent or reverse_flow * atmosphere / (volume * vacuum))
        backwards = n * (reverse_flow * atmosphere / volume)
        if line.tube is not None:
            passage = Passage(
                volume=tube_area(line.tube) * line.tube.length / volume,
                passes=n * tube_conductance(line.tube.length, line.tube.bore) / volume,
                atmosphere=atmosphere,
                vacuum=vacuum,
            )
    else:
        compliance = water_compliance(line)
        require_known_water_flow(pump)
        top, leak = atmosphere - max(pump.ultimate, VAPOUR), 0.0
        rate, backwards = flow / compliance / top, reverse_flow / compliance
        vent = (vent * volume or reverse_flow) / (compliance * top)
    plant = Plant(
        rate=rate,
        top=top,
        leak=leak,
        vent=vent,
        backwards=backwards,
        water=water,
        passage=passage,
    )
    check(plant, "plant.")
    return plant


def match_line(line: Line, plant: Plant, *, vacuum: float) -> Line:
    """Return the line with parts whose linearised plant at `vacuum` [Pa], in air, is `plant`.

    `plant` has no passage: a tube's gas counts as in `Plant.lumped_plant`. The new pump has a
    displacement, and the leak is laminar. Raises QuantityError if there are no such parts.
    """
    site, chamber, tube = line.site.atmosphere, line.chamber.volume, 0.0
    if line.tube is not None:
        tube = tube_area(line.tube) * line.tube.length
    # throughput [Pa m^3/s] per unit of rate [1/s] and pressure [Pa]
    volume = (chamber + tube) / line.polytropic
    pressure = site - vacuum
    laminar = plant.leak * volume * vacuum / leak_throughput(pressure, site, 1.0, 0.0)
    flow = plant.rate * volume / line.pump.count
    valve = line.valve or assemble(Valve, conductance=1.0)
    matched_line = evolve(
        line,
        pump=evolve(line.pump, flow=flow, curve=None, ultimate=max(site - plant.top, 0.0)),
        valve=evolve(valve, conductance=plant.vent * volume / NORMAL),
        leak=Leak(laminar=laminar),
    )
    validate(matched_line)
    return matched_line


def check_target(plant: Plant, target: float, name: str = "target") -> None:
    """Raise QuantityError if `target` [Pa] is above the vacuum that the pump reaches."""
    if not 0.0 <= target < plant.reach:
        note = f" against its leak (without it, {show(plant.top, 'Pa')})" if plant.leak else ""
        raise QuantityError(
            f"{name}: {show(target, 'Pa')} is not allowed; the pump reaches "
            f"{show(plant.reach, 'Pa')}{note}, and a target must be zero or more and below that"
        )

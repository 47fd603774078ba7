"""A vacuum line: chamber, tube, pumps, vent valve, reservoir, leak and sensor (mechanics, 5).

A flow is a volume per time at the inlet pressure. A throughput q is pressure times volume per time
[Pa m^3/s], which is a measure of gas at one temperature.
"""

from layerjam.brake.device.mount import Site
from layerjam.brake.fluid.pump_curve import CURVE, Curve
from layerjam.core.errors import QuantityError, explain_arguments
from layerjam.core.toml_files.changes import Change, with_changes
from layerjam.core.toml_files.values import value
from layerjam.core.units import check, nested, quantity, record, show


@record
class Chamber:
    """Evacuated volume: V = V0 + A_s slip - C_w vacuum for air, C vacuum for water."""

    volume: float = quantity(
        "m^3", "gas in brake and fittings at zero vacuum and slip", lo=1e-9, hi=1, symbol="V_0"
    )
    volume_per_slip: float = quantity(
        "m^2",
        "gas volume gained per unit slip as the enclosure stretches",
        hi=1,
        symbol="A_s",
        default=0.0,
    )
    shrink: float = quantity(
        "m^3/Pa",
        "gas volume lost per unit vacuum as the enclosure is drawn in",
        hi=1e-6,
        symbol="C_w",
        default=0.0,
    )
    compliance: float | None = quantity(
        "m^3/Pa",
        "volume drawn out per unit vacuum when filled with water",
        lo=1e-15,
        hi=1e-6,
        symbol="C",
        default=None,
    )


@record
class Tube:
    """Tube between pump and brake; unless it has cells, its gas is counted on the pump's side."""

    length: float = quantity("m", "length of the tube", lo=1e-3, hi=100)
    bore: float = quantity("m", "inner diameter of the tube", lo=1e-4, hi=0.1)
    cells: int = quantity(
        "1",
        "number of cells in the tube, to model pressure waves; 0 for none",
        hi=60,
        whole=True,
        default=0,
    )


@record
class Pump:
    """One of `count` identical pumps in parallel, with a displacement or a flow curve (`pump.py`).

    A displacement gives q = flow (p - ultimate) for each pump; a curve replaces both values.
    """

    flow: float | None = quantity(
        "m^3/s",
        "volume that one pump displaces per unit time: the inlet flow if ultimate is zero",
        lo=1e-12,
        hi=1,
        symbol="Q",
        default=None,
    )
    curve: Curve | None = value(CURVE, default=None)
    """Points (vacuum, flow of free air) of a data-sheet curve, from zero vacuum to zero flow."""
    count: int = quantity("1", "pumps in parallel", lo=1, hi=100, whole=True, default=1)
    ultimate: float = quantity(
        "Pa", "lowest absolute pressure the pump reaches", hi=1.2e5, symbol="p_u", default=0.0
    )
    backwards: float = quantity(
        "m^3/s",
        "flow of one pump run backwards, at atmospheric pressure; 0 if it cannot run backwards",
        hi=1,
        default=0.0,
    )
    power: float | None = quantity("W", "electric power of one pump", hi=1e5, default=None)


@record
class Valve:
    """A valve that lets in air from the atmosphere, modelled by ISO 6358."""

    conductance: float = quantity(
        "m^3/(s Pa)",
        "sonic conductance: volume flow per unit upstream pressure",
        lo=1e-15,
        hi=1e-3,
        symbol="C",
    )
    critical_ratio: float = quantity(
        "1", "pressure ratio below which the flow is choked", hi=0.999, symbol="b", default=0.528
    )
    delay: float = quantity("s", "time from the command until it is open", hi=10, default=0.0)


@record
class Leak:
    """Leak into the line: laminar, through an orifice, or both."""

    laminar: float = quantity(
        "m^3/s",
        "laminar conductance G: q = G (p_atm^2 - p^2) / 2 p_atm",
        hi=1e-2,
        symbol="G",
        default=0.0,
    )
    orifice: float = quantity(
        "m^3/s",
        "orifice: q = G p_atm while choked, as volume flow of atmospheric air",
        hi=1e-2,
        default=0.0,
    )


@record
class Reservoir:
    """A vessel that is evacuated beforehand; a valve connects it to the chamber."""

    volume: float = quantity("m^3", "volume of the reservoir", lo=1e-7, hi=10)
    conductance: float = quantity(
        "m^3/(s Pa)", "sonic conductance of its valve and tube", lo=1e-15, hi=1e-3
    )
    delay: float = quantity("s", "time from the command until it is open", hi=10, default=0.0)


@record
class Sensor:
    """A pressure sensor; its values are vacuums relative to the atmosphere."""

    range: float = quantity("Pa", "highest vacuum that the sensor measures", lo=1, hi=1e7)
    lag: float = quantity("s", "time constant of its first-order lag", hi=100, default=0.0)
    noise: float = quantity("Pa", "standard deviation of a reading", hi=1e6, default=0.0)
    resolution: float = quantity("Pa", "resolution of the readings", hi=1e6, default=0.0)
    offset: float = quantity("Pa", "zero error of the sensor", lo=-1e6, hi=1e6, default=0.0)


@record
class Line:
    """The complete line; without a valve, it is vented by a reversible pump."""

    chamber: Chamber = nested(Chamber)
    pump: Pump = nested(Pump)
    tube: Tube | None = nested(Tube, default=None)
    valve: Valve | None = nested(Valve, default=None)
    leak: Leak = nested(Leak, default=Leak())
    reservoir: Reservoir | None = nested(Reservoir, default=None)
    sensor: Sensor | None = nested(Sensor, default=None)
    polytropic: float = quantity(
        "1",
        "polytropic exponent of the gas: 1 isothermal, 1.4 adiabatic",
        lo=1,
        hi=1.4,
        symbol="n",
        default=1.0,
    )
    site: Site = nested(Site, default=Site())

    @explain_arguments
    def with_(self, **changes: Change) -> "Line":
        """Return the line with values changed by name: chamber_volume="8 mL", flow="2 L/min".

        The values are checked as in `Brake.with_`; raises UnknownNameError or QuantityError.
        """
        line = with_changes(self, changes)
        validate(line)
        return line

    def validate(self) -> None:
        """Raise QuantityError for values that are out of bounds or contradict each other."""
        validate(self)


def validate(line: Line) -> None:
    """Raise QuantityError for values that are out of bounds or contradict each other."""
    check(line)
    atmosphere, chamber = line.site.atmosphere, line.chamber
    if (line.pump.flow is None) == (line.pump.curve is None):
        raise QuantityError.of(
            "pump.flow",
            "a pump needs either a flow or a flow curve, pump.curve; "
            + ("neither is given" if line.pump.flow is None else "both are given"),
        )
    if line.pump.curve is not None and line.pump.ultimate:
        raise QuantityError.of(
            "pump.ultimate",
            ("a flow curve already ends at the lowest pressure; give only one of the two"),
        )
    if line.pump.ultimate >= atmosphere:
        raise QuantityError.of(
            "pump.ultimate",
            f"{show(line.pump.ultimate, 'Pa')} is not below atmospheric pressure, "
            f"{show(atmosphere, 'Pa')}",
        )
    if chamber.volume - chamber.shrink * atmosphere <= 0:
        raise QuantityError.of(
            "chamber.shrink",
            f"{show(chamber.shrink * atmosphere, 'm^3')} would be lost at full vacuum; "
            f"the chamber has only {show(chamber.volume, 'm^3')}",
        )


def water_compliance(line: Line) -> float:
    """Return the volume of water removed per vacuum [m^3/Pa]; QuantityError if it is unknown."""
    if line.chamber.compliance is None:
        raise QuantityError.of(
            "chamber.compliance",
            "not given, so the water drawn out by a vacuum is unknown",
        )
    return line.chamber.compliance

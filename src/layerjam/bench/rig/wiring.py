"""Wiring of a board: a TOML file of its pins and devices, and the table for the firmware."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, Self

from layerjam.brake.fluid.line import Sensor
from layerjam.brake.simulate.accelerometer import Accelerometer
from layerjam.core.errors import QuantityError
from layerjam.core.toml_files.changes import RecordFile
from layerjam.core.toml_files.reader import Reader
from layerjam.core.toml_files.shipped import load_text, shipped_files
from layerjam.core.toml_files.values import Entry, TextSpec, entries, value
from layerjam.core.units import check as bounded
from layerjam.core.units import get_spec, like, nested, quantity, record

FIRST_ADC, LAST_ADC = 26, 29
"""GP numbers of the first and the last pin of the RP2040's converter."""


def gp_field(text: str) -> Any:
    """Return a dataclass field for the GP number of a pin."""
    return quantity("1", f"GP number of {text}", hi=LAST_ADC, whole=True)


@record
class Pins:
    """GP number of each function's pin; these differ from the pin numbers of the socket."""

    pump_gate: int = gp_field("the pump's transistor")
    pump_back_gate: int = gp_field("the second side of an H-bridge, for a reversible pump")
    vent_gate: int = gp_field("the vent valve's transistor")
    estop_sense: int = gp_field(
        "the sense line of the emergency stop, high while the stop passes power"
    )
    sync_out: int = gp_field("the marker output to a test machine")
    trigger_in: int = gp_field("the contact that starts a capture")
    led_out: int = gp_field("the indicator lamp")
    supply_adc: int = gp_field("the divided supply voltage of the pump and the valve")
    spi_miso: int = gp_field("the sensor's data line")
    spi_cs: int = gp_field("the sensor's chip select")
    spi_sck: int = gp_field("the sensor's clock")
    spi_mosi: int = gp_field("the data output, which the sensor ignores")
    sensor_adc: int = gp_field("the analogue output of a sensor")
    accelerometer_adc: int = gp_field("the accelerometer")


@record
class Wiring:
    """Pins of a board, and the devices on them."""

    pump_frequency: float = quantity("Hz", "switching frequency of the pump", lo=10, hi=1e5)
    reference_voltage: float = quantity("V", "full scale of the converter", lo=1.0, hi=3.6)
    supply_ratio: float = quantity("1", "ratio of supply to converter voltage", lo=1, hi=20)
    least_supply: float = quantity("V", "minimum supply voltage of pump and valve", lo=1.0, hi=30)
    sensor_kind: str = value(TextSpec(text="kind of pressure sensor", choices=("hsc", "adc")))
    sensor_range: float = like(get_spec(Sensor, "range"))
    sensor_zero: float | None = quantity(
        "1", "output of an analogue sensor at zero vacuum, as a fraction of the converter's range",
        hi=1, default=None,
    )  # fmt: skip
    sensor_full: float | None = quantity(
        "1", "output at sensor_range, as a fraction of the converter's range", hi=1, default=None
    )
    accelerometer_zero: float | None = quantity(
        "1", "output of the accelerometer at 0 g, as a fraction of the converter's range",
        hi=1, default=None,
    )  # fmt: skip
    accelerometer_full: float | None = quantity(
        "1", "output at accelerometer_range, as a fraction of the converter's range",
        hi=1, default=None,
    )  # fmt: skip
    accelerometer_range: float | None = like(get_spec(Accelerometer, "range"), default=None)
    pins: Pins = nested(Pins)


def validate(wiring: Wiring) -> None:
    """Raise QuantityError for a value out of bounds, a pin used twice or an incomplete sensor."""
    bounded(wiring)
    used_pins: dict[int, str] = {}
    for f in fields(Pins):
        number = getattr(wiring.pins, f.name)
        name = f"pins.{f.name}"
        if number in used_pins:
            raise QuantityError.of(name, f"GP{number} is already used by {used_pins[number]}")
        used_pins[number] = name
        if f.name.endswith("_adc") and number < FIRST_ADC:
            raise QuantityError.of(
                name, f"GP{number} has no converter; GP{FIRST_ADC} to GP{LAST_ADC} have one"
            )
    zero, full = wiring.sensor_zero, wiring.sensor_full
    if wiring.sensor_kind == "adc" and (zero is None or full is None or zero == full):
        raise QuantityError.of(
            "sensor_full", "an analogue sensor needs different sensor_zero and sensor_full"
        )
    numbers = (wiring.accelerometer_zero, wiring.accelerometer_full, wiring.accelerometer_range)
    if numbers != (None, None, None) and (None in numbers or numbers[0] == numbers[1]):
        raise QuantityError.of(
            "accelerometer_full",
            "an accelerometer needs accelerometer_zero, a different accelerometer_full, and "
            "accelerometer_range",
        )


@dataclass(frozen=True, kw_only=True)
class WiringFile(RecordFile[Wiring]):
    """A wiring with its name, and the source of each of its values."""

    wiring: Wiring

    fields: ClassVar[Mapping[str, Entry]] = MappingProxyType(dict(entries(Wiring)))
    holds: ClassVar[str] = "wiring"
    heading: ClassVar[str] = "Connections of a board's pins."
    kind: ClassVar[type] = Wiring
    check = staticmethod(validate)

    @classmethod
    def read(cls, text: str, path: object) -> Self:
        """Return the file from its TOML text; if it is invalid, raises FileError with the line."""
        reader = Reader(text, path, cls.fields)
        reader.read_all()
        return cls.build_from_reader(reader)

    def firmware_pins(self) -> dict[str, Any]:
        """Return the firmware's flat table, in SI units, without values that are not given."""
        rows = ((path.rpartition(".")[2], v) for path, v in self.known_values.items())
        return {"name": self.title or self.name, **{key: v for key, v in rows if v is not None}}


def list_boards() -> list[str]:
    """Return the names of the boards whose wiring is part of the package."""
    return list(shipped_files("layerjam.bench.rig", "boards"))


def load_wiring(board: str | Path) -> WiringFile:
    """Return a wiring, given a board's name or the path of the wiring's TOML file.

    Raises UnknownNameError (with the nearest names) or FileError.
    """
    return WiringFile.read(
        *load_text("board", board, shipped_files("layerjam.bench.rig", "boards"))
    )

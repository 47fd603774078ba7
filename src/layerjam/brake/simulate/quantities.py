"""Quantities shared by simulations, measured files, designs and commands.

`replace` changes the meaning or example of a quantity, `units.like` makes it a field.
"""

from collections.abc import Mapping

from layerjam.brake.device.mount import Site
from layerjam.core.units import QuantitySpec, get_spec

VACUUM = QuantitySpec(
    "Pa",
    "vacuum, atmospheric pressure minus the pressure inside,",
    hi=get_spec(Site, "atmosphere").hi,
    example="94.5kPa",
    symbol="P",
    unlikely_below=200.0,
)
SLIP = QuantitySpec("m", "slip of the sheets", example="20mm", symbol="x")
FORCE = QuantitySpec("N", "force", example="100N", symbol="F")
AREA = QuantitySpec("m^2", "area", lo=1e-9, hi=1.0, example="625mm^2")
NORMAL_FORCE = QuantitySpec("N", "normal force", lo=1e-4, hi=1e5, example="2.45N")
MASS = QuantitySpec("kg", "moving mass", lo=1e-6, hi=1e6, example="1kg", symbol="M")
ARRIVAL_SPEED = QuantitySpec(
    "m/s", "speed when the rope becomes taut", lo=1e-6, hi=1e4, example="2.5m/s", symbol="v"
)
CROSSHEAD_SPEED = QuantitySpec("m/s", "speed of the crosshead", lo=1e-7, hi=100, example="13mm/s")
STOP_TRAVEL = QuantitySpec(
    "m", "slip within which to stop", lo=1e-6, hi=100, example="40mm", symbol="d"
)
ELONGATION = QuantitySpec("m", "final elongation", lo=1e-6, hi=10, example="40mm", symbol="u")
DURATION = QuantitySpec("s", "time to simulate", open_lo=True, hi=1e5, example="20s")
LEAK_TIME = QuantitySpec(
    "s",
    "time constant of a laminar leak, volume / conductance",
    lo=1e-3,
    hi=1e7,
    example="500s",
)
HELD = QuantitySpec("s", "time from line shut-off until the rope is taut", hi=1e7, example="60s")
SEED = QuantitySpec("1", "seed of the random number generator", hi=2**63 - 1, whole=True)
CONFIDENCE = QuantitySpec(
    "1",
    "share of tests, scatter of friction and mounting included, that the safe vacuum covers",
    lo=0.5,
    hi=0.999,
    example="95%",
)


def check_inputs(values: Mapping[str, float | None], limits: Mapping[str, QuantitySpec]) -> None:
    """Raise QuantityError for a number outside its limits; None is allowed."""
    for name, value in values.items():
        if value is not None:
            limits[name].check(value, name.replace("_", " "))

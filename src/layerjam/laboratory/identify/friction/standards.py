"""Rules of the friction standards for a test and for its record.

The standards are sold, not freely published. This module is based on the paper's description of its
own test (section III-C), the publishers' abstracts and web pages of laboratories. D1894 uses a 200
g sled, 63.5 mm square, at 150 mm/min; its scope, note 2, warns against a direct comparison with ISO
8295. ISO 8295 states a time at rest, because static friction grows with it. No clause is quoted
here, so compare this table with the current edition before signing a report.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from layerjam.core.errors import UnknownNameError
from layerjam.core.units import show
from layerjam.laboratory.measure.trace import Array


@dataclass(frozen=True, kw_only=True)
class Standard:
    """Rules of one friction test, in SI units.

    `window` is the travel of the kinetic mean [m]. It starts at the record's first sample or, with
    `from_sliding`, where the films slide after the static peak. With `first_maximum` the static
    force is the first maximum, otherwise the maximum of the record. `sled_mass` [kg] is None if
    each test states its own; `dwell` [s] is the time at rest before the pull.
    """

    name: str
    title: str
    area: float
    speed: float
    window: tuple[float, float]
    speed_tolerance: float = 0.2
    sled_mass: float | None = 0.200
    from_sliding: bool = True
    first_maximum: bool = True
    dwell: float | None = None


PAPER = Standard(
    name="paper",
    title="Choi 2018, section III-C",
    area=0.025**2,
    speed=2.5e-3,
    window=(0.040, 0.100),
    sled_mass=None,
    from_sliding=False,
    first_maximum=False,
)
D1894 = Standard(
    name="d1894", title="ASTM D1894", area=0.0635**2, speed=150e-3 / 60, window=(0.0, 0.130)
)
ISO8295 = Standard(
    name="iso8295",
    title="ISO 8295",
    area=40e-4,
    speed=100e-3 / 60,
    window=(0.0, 0.060),
    speed_tolerance=0.1,
    dwell=15.0,
)
STANDARDS = {s.name: s for s in (PAPER, D1894, ISO8295)}


def find_standard(name: str) -> Standard:
    """Return the standard of the given name; raises UnknownNameError."""
    if name not in STANDARDS:
        raise UnknownNameError("standard", name, STANDARDS)
    return STANDARDS[name]


def list_deviations(
    standard: Standard, speed: float | None, time: Array | None, travel: Array
) -> Iterator[str]:
    """Yield notes on how a test differs from a standard: its speed, and the time at rest."""
    if speed is not None and abs(speed / standard.speed - 1) > standard.speed_tolerance + 0.005:
        yield (
            f"pulled at {show(speed * 60e3, '1')} mm/min; {standard.title} requires "
            f"{show(standard.speed * 60e3, '1')} mm/min"
        )
    if standard.dwell is not None:
        moving = np.flatnonzero(np.abs(travel) > 1e-5 + 1e-3 * float(travel.max()))
        dwell = 0.0 if time is None or not len(moving) else float(time[moving[0]] - time[0])
        if dwell < 0.9 * standard.dwell:
            yield (
                f"the record does not show the {standard.dwell:g} s at rest before the pull, on "
                "which static friction depends"
            )

"""What the friction standards prescribe and how each reads a record.

The standards' texts are sold, not published. What stands here is what the paper says of its own
test (section III-C) and what the publishers' abstracts and laboratories' pages state: D1894 a sled
of 200 g and 63.5 mm square at 150 mm/min (its scope, note 2, says that results of the two cannot
be compared directly); ISO 8295 a stated time at rest, since static friction grows with it. No
clause is quoted; whoever signs a report compares this table with the edition in force.
"""

from __future__ import annotations

from dataclasses import dataclass

from layerjam.errors import UnknownNameError


@dataclass(frozen=True, kw_only=True)
class Standard:
    """One way to do and to read a friction test, SI units.

    `window` is the travel of the kinetic mean [m]: of the crosshead, from the record's first
    sample, or (`from_sliding`) from where the films slide and the static peak is over.
    `first_maximum` takes the static force there, else it is the greatest of the record.
    `sled_mass` [kg] is None where the test's own weight counts; `dwell` [s] is the rest before.
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


def standard_named(name: str) -> Standard:
    """The standard of that name; UnknownNameError otherwise."""
    if name not in STANDARDS:
        raise UnknownNameError("standard", name, STANDARDS)
    return STANDARDS[name]

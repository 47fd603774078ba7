"""What to build where the vacuum does not come in time: reservoir, its valve, standing vacuum.

Every size is the root of the same model of the line, bracketed, at constant vacuum during the stop
(a sleeve that is stretched draws a little more, which is on the safe side).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from layerjam.control.plan import before_the_stop
from layerjam.fluid.closed_forms import reachable
from layerjam.fluid.line import Line, Reservoir
from layerjam.units import show, spec_of

CV = 4.0
"""Sonic conductance in L/(s bar) of a valve with a flow coefficient Cv of 1, rough."""
ASSUMED_CONDUCTANCE = 2e-9
ASSUMED_DELAY = 0.01
ASSUMED_RATIO = 20.0
"""A reservoir that the line does not have: 0.2 L/(s bar), 10 ms, 20 times the chamber's volume."""
CLOSE = 1e-6
"""Relative error of a size."""
LONGEST = 1e5
"""Warning time after which the search ends [s]."""
LARGEST = {"volume": 1.0, "conductance": 1e-6}
"""Where the search ends: 1 m^3, and 100 L/(s bar), about a Cv of 25."""


@dataclass(frozen=True)
class Size:
    """A size that does it, or why there is none."""

    value: float | None
    reason: str | None = None


@dataclass(frozen=True, kw_only=True)
class Build:
    """What would do, each with all else as it is (or assumed)."""

    warning: Size
    """Warning time [s]."""
    reservoir: Size
    """Volume [m^3] at `conductance_used`."""
    conductance: Size
    """Of its valve [m^3/(s Pa)] at `volume_used`."""
    standing: Size
    """Vacuum held while waiting [Pa]."""
    conductance_used: float
    volume_used: float
    delay_used: float
    assumed: tuple[str, ...] = ()


def valve_cv(conductance: float) -> float:
    """Flow coefficient Cv of a sonic conductance [m^3/(s Pa)], C [L/(s bar)] about 4 Cv, rough."""
    return conductance * 1e8 / CV


def least(excess: Callable[[float], float], low: float, high: float) -> float | None:
    """Least x in [low, high] from which `excess` is not negative; None where it is up to `high`.

    Grows by fours from `low`, then Brent's method on log x.
    """
    from scipy.optimize import brentq

    if excess(low) >= 0:
        return low
    before, x = low, low
    while x < high:
        before, x = x, min(4 * x, high)
        if excess(x) >= 0:
            root = brentq(
                lambda s: excess(math.exp(s)), math.log(before), math.log(x), xtol=CLOSE / 4
            )
            return float(math.exp(root + CLOSE / 2))
    return None


def reached(
    line: Line, warning: float, standing: float, stored: float | None, water: bool
) -> float:
    """Vacuum at the end of the warning [Pa]."""
    return float(before_the_stop(line, warning, standing, stored, water, samples=2).vacuum[-1])


def what_to_build(
    line: Line, needed: float, warning: float, standing: float = 0.0,
    stored: float | None = None, water: bool = False,
) -> Build:  # fmt: skip
    """Sizes with which a vacuum [Pa] is there after the warning [s]."""
    tank, chamber = line.reservoir, line.chamber
    conductance = ASSUMED_CONDUCTANCE if tank is None else tank.conductance
    volume = ASSUMED_RATIO * chamber.volume if tank is None else tank.volume
    delay = ASSUMED_DELAY if tank is None else tank.delay

    def with_tank(size: float, flow: float) -> float:
        other = replace(line, reservoir=Reservoir(volume=size, conductance=flow, delay=delay))
        return reached(other, warning, standing, stored, water) - needed

    assumed = () if tank is not None or water else (
        f"no reservoir in the line: its volume is sized at {show(conductance, 'm^3/(s Pa)')} and "
        f"its valve at {show(volume, 'm^3')}, with {show(delay, 's')} to open; assumed, not "
        "measured",
    )  # fmt: skip
    if water:
        no = Size(None, "a reservoir of gas is not part of a line filled with water")
        sizes = (no, no)
    else:
        sizes = (
            _tank(lambda x: with_tank(x, conductance), "volume", "m^3", "reservoir of"),
            _tank(
                lambda x: with_tank(volume, x), "conductance", "m^3/(s Pa)",
                f"valve on {show(volume, 'm^3')} of",
            ),
        )  # fmt: skip
    return Build(
        warning=_warning(line, needed, standing, stored, water),
        reservoir=sizes[0], conductance=sizes[1],
        standing=_standing(line, needed, warning, stored, water),
        conductance_used=conductance, volume_used=volume, delay_used=delay, assumed=assumed,
    )  # fmt: skip


def _tank(excess: Callable[[float], float], name: str, unit: str, what: str) -> Size:
    low, high = spec_of(Reservoir, name).lo, LARGEST[name]
    found = least(excess, low, high)
    if found is not None:
        return Size(found)
    short = -excess(high)
    return Size(None, f"even a {what} {show(high, unit)} is {show(short, 'Pa')} short in that time")


def _warning(line: Line, needed: float, standing: float, stored: float | None, water: bool) -> Size:
    if needed <= standing:
        return Size(0.0)
    if needed >= reachable(line, water):
        return Size(None, _never(line, needed, water))
    time = least(
        lambda t: reached(line, t, standing, stored, water) - needed, 1e-6, LONGEST
    )  # fmt: skip
    if time is not None:
        return Size(time)
    return Size(None, f"the pump takes more than {show(LONGEST, 's')} to {show(needed, 'Pa')}")


def _standing(line: Line, needed: float, warning: float, stored: float | None, water: bool) -> Size:
    from scipy.optimize import brentq

    def excess(vacuum: float) -> float:
        return reached(line, warning, vacuum, stored, water) - needed

    if excess(0.0) >= 0:
        return Size(0.0)
    top = min(needed, reachable(line, water))
    if excess(top) < -1e-6 * needed:
        return Size(None, _never(line, needed, water))
    if excess(top) <= 0:
        return Size(top)
    return Size(float(brentq(excess, 0.0, top, xtol=CLOSE * needed)))


def _never(line: Line, needed: float, water: bool) -> str:
    low = reachable(line, water)
    return (
        f"the line never holds {show(needed, 'Pa')}: its pump comes to {show(low, 'Pa')} in the end"
    )

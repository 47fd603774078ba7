"""Remedies if the vacuum is not reached in time: more warning, a reservoir, or an idle vacuum.

Each size is found by bracketed root finding with the same line model. The vacuum is assumed
constant during the stop; a stretched enclosure increases it slightly, which is on the safe side.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

from layerjam.bench.control.standby import Standby
from layerjam.brake.fluid.closed_forms import reachable_vacuum
from layerjam.brake.fluid.line import Reservoir
from layerjam.core.evolve import evolve
from layerjam.core.units import get_spec, show

CV = 4.0
"""Approximate sonic conductance in L/(s bar) of a valve with a flow coefficient Cv of 1."""
ASSUMED_CONDUCTANCE = 2e-9
ASSUMED_DELAY = 0.01
ASSUMED_RATIO = 20.0
"""Reservoir assumed if the line has none: 0.2 L/(s bar), 10 ms, 20 times the chamber's volume."""
CLOSE = 1e-6
"""Relative tolerance of a size."""
LONGEST = 1e5
"""Longest warning time that the search tries [s]."""
LARGEST = {"volume": 1.0, "conductance": 1e-6}
"""Limits of the search: 1 m^3, and 100 L/(s bar), which is a Cv of about 25."""


@dataclass(frozen=True)
class Size:
    """The smallest sufficient size, or the reason why no size is sufficient."""

    value: float | None
    reason: str | None = None


@dataclass(frozen=True, kw_only=True)
class Build:
    """Sufficient sizes, each for a change of nothing else; missing values are assumed."""

    warning: Size
    """Warning time [s]."""
    reservoir: Size
    """Volume [m^3] at `conductance_used`."""
    conductance: Size
    """Conductance of its valve [m^3/(s Pa)] at `volume_used`."""
    standing: Size
    """Vacuum held while waiting [Pa]."""
    conductance_used: float
    volume_used: float
    delay_used: float
    assumed: tuple[str, ...] = ()


def valve_cv(conductance: float) -> float:
    """Return the approximate flow coefficient Cv of a sonic conductance [m^3/(s Pa)]: C is 4 Cv."""
    return conductance * 1e8 / CV


def least_root(excess: Callable[[float], float], low: float, high: float) -> float | None:
    """Return the smallest x in [low, high] from which `excess` is no longer negative.

    Return None if `excess` is negative up to `high`.

    The search quadruples x from `low`, then uses Brent's method on log x.
    """
    from scipy.optimize import brentq

    if excess(low) >= 0:
        return low
    before, x = low, low
    while x < high:
        before, x = x, min(4 * x, high)
        if excess(x) >= 0:
            ends = math.log(before), math.log(x)
            root = brentq(lambda s: excess(math.exp(s)), *ends, xtol=CLOSE / 4)
            return float(math.exp(root + CLOSE / 2))
    return None


def suggest_sizes(standby: Standby, vacuum: float, warning: float) -> Build:
    """Return sizes with which the line reaches a vacuum [Pa] within the warning time [s]."""
    line = standby.line
    tank = line.reservoir or Reservoir(
        volume=ASSUMED_RATIO * line.chamber.volume,
        conductance=ASSUMED_CONDUCTANCE,
        delay=ASSUMED_DELAY,
    )
    flow, size = show(tank.conductance, "m^3/(s Pa)"), show(tank.volume, "m^3")
    notes: tuple[str, ...] = ()
    reservoir = conductance = Size(None, "a line filled with water has no gas reservoir")
    if not standby.water:
        reservoir = _size_tank(standby, tank, vacuum, warning, "volume", "reservoir of")
        conductance = _size_tank(
            standby, tank, vacuum, warning, "conductance", f"reservoir of {size} with a valve of"
        )
        if line.reservoir is None:
            notes = (
                f"the line has no reservoir: its volume is sized for a valve of {flow}, and "
                f"its valve for {size}, opening in {show(tank.delay, 's')}; all three are assumed",
            )
    return Build(
        warning=_size_warning(standby, vacuum),
        reservoir=reservoir,
        conductance=conductance,
        standing=_size_standby(standby, vacuum, warning),
        conductance_used=tank.conductance,
        volume_used=tank.volume,
        delay_used=tank.delay,
        assumed=notes,
    )


def _size_tank(
    standby: Standby, tank: Reservoir, vacuum: float, warning: float, name: str, phrase: str
) -> Size:
    """Return the smallest volume or conductance of a reservoir, with everything else unchanged."""

    def pressure_excess(value: float) -> float:
        line = evolve(standby.line, reservoir=evolve(tank, **{name: value}))
        return evolve(standby, line=line).vacuum_after(warning) - vacuum

    spec, high = get_spec(Reservoir, name), LARGEST[name]
    root = least_root(pressure_excess, spec.lo, high)
    if root is not None:
        return Size(root)
    shortfall, limit = show(-pressure_excess(high), "Pa"), show(high, spec.unit)
    return Size(None, f"even a {phrase} {limit} falls {shortfall} short in that time")


def _size_warning(standby: Standby, vacuum: float) -> Size:
    if vacuum <= standby.vacuum:
        return Size(0.0)
    if vacuum >= reachable_vacuum(standby.line, standby.water):
        return Size(None, _explain_unreachable(standby, vacuum))
    time = least_root(lambda t: standby.vacuum_after(t) - vacuum, 1e-6, LONGEST)
    if time is not None:
        return Size(time)
    return Size(
        None, (f"the pump needs more than {show(LONGEST, 's')} to reach {show(vacuum, 'Pa')}")
    )


def _size_standby(standby: Standby, target: float, warning: float) -> Size:
    from scipy.optimize import brentq

    def excess(vacuum: float) -> float:
        return evolve(standby, vacuum=vacuum).vacuum_after(warning) - target

    if excess(0.0) >= 0:
        return Size(0.0)
    top = min(target, reachable_vacuum(standby.line, standby.water))
    if excess(top) < -1e-6 * target:
        return Size(None, _explain_unreachable(standby, target))
    if excess(top) <= 0:
        return Size(top)
    # add half of the tolerance, so that the size is certainly sufficient
    root = float(brentq(excess, 0.0, top, xtol=CLOSE * target / 4))
    return Size(min(root + CLOSE * target / 2, top))


def _explain_unreachable(standby: Standby, vacuum: float) -> str:
    low = show(reachable_vacuum(standby.line, standby.water), "Pa")
    return f"the line cannot hold {show(vacuum, 'Pa')}: its pump reaches only {low}"

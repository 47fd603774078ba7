"""A pump's flow curve as in data sheets: points of free-air flow versus vacuum.

The flow is that of free air at the pump's atmosphere; the flow at an inlet at p is larger by the
factor p_atm/p. Vacuums are differences from `STANDARD`. The curve is linear between points, so
that it never rises between falling points, and pumping down has a closed form.
"""

from bisect import bisect_right
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from layerjam.brake.device.mount import Site
from layerjam.core.errors import QuantityError, count_text
from layerjam.core.toml_files.values import AsItIs
from layerjam.core.units import exact_text, parse, show

Curve = tuple[tuple[float, float], ...]
"""Points (vacuum [Pa], flow of free air [m^3/s])."""
STANDARD = Site().atmosphere
"""Atmospheric pressure to which data sheets refer vacuum and free air [Pa]."""
MOST_POINTS = 200
MOST_FLOW = 1.0


def check_curve(points: Curve, name: str) -> Curve:
    """Return the points; QuantityError unless they start at zero vacuum and fall to zero flow."""
    if len(points) < 2:
        raise QuantityError.of(name, f"has {count_text(len(points), 'point')}; give at least two")
    if len(points) > MOST_POINTS:
        raise QuantityError.of(name, f"{len(points)} points; at most {MOST_POINTS} are allowed")
    for vacuum, flow in points:
        if not (0 <= vacuum <= STANDARD and 0 <= flow <= MOST_FLOW):
            raise QuantityError.of(
                name,
                f"{_show_point(vacuum, flow)} is not allowed; vacuums lie between zero and "
                f"{show(STANDARD, 'Pa', 6)}, flows between zero and {show(MOST_FLOW, 'm^3/s')}",
            )
    if points[0][0] != 0:
        raise QuantityError.of(
            name, f"starts at {show(points[0][0], 'Pa')}; its first point must be at zero vacuum"
        )
    for first, second in pairwise(points):
        if not second[0] > first[0]:
            raise QuantityError.of(
                name,
                f"the vacuum does not rise from {show(first[0], 'Pa')} to "
                f"{show(second[0], 'Pa')}; list the points in order of rising vacuum",
            )
        if not second[1] < first[1]:
            raise QuantityError.of(
                name,
                f"the flow does not fall from {_show_point(*first)} to {_show_point(*second)}; the "
                "free-air flow of a pump must fall strictly with vacuum",
            )
    if points[-1][1] != 0:
        raise QuantityError.of(
            name,
            (
                f"ends with {_show_point(*points[-1])}; its last point must be the highest "
                "vacuum, with zero flow"
            ),
        )
    return points


def _show_point(vacuum: float, flow: float) -> str:
    return f"{show(flow, 'm^3/s')} at {show(vacuum, 'Pa')}"


def free_flow(vacuum: float, points: Curve) -> float:
    """Return the flow of free air [m^3/s] at a vacuum [Pa] below `STANDARD`.

    It is zero beyond the last point. Above atmospheric pressure, the inlet flow is constant.
    """
    if vacuum <= 0:
        return points[0][1] * (1 - vacuum / STANDARD)
    if vacuum >= points[-1][0]:
        return 0.0
    i = bisect_right(points, (vacuum, float("inf")))
    (low, flow_before), (high, flow_after) = points[i - 1], points[i]
    return flow_before + (flow_after - flow_before) * (vacuum - low) / (high - low)


@dataclass(frozen=True)
class CurveSpec(AsItIs):
    """Flow curve in a file: `[["0 kPa", "10 L/min"], ...]`."""

    text: str = "free-air flow versus vacuum, point by point"
    unit: str = "m^3/s"
    """Unit of the flows; vacuums are in Pa."""

    def limits(self) -> str:
        """Return a phrase that describes the form of the points."""
        return "points (vacuum, flow), from zero vacuum to zero flow"

    def read(self, text: object, name: str) -> Any:
        """Return the points in SI; raises QuantityError if they are not a flow curve."""
        if not (isinstance(text, list) and all(isinstance(p, list) and len(p) == 2 for p in text)):
            raise QuantityError.of(
                name, 'is not a list such as [["0 kPa", "10 L/min"], ["60 kPa", "0 L/min"]]'
            )
        curve = tuple((parse(v, "Pa", name), parse(f, "m^3/s", name)) for v, f in text)
        return check_curve(curve, name)

    def check(self, value: Any, name: str) -> Any:
        """Return the points; raises QuantityError if they are not a flow curve."""
        return check_curve(value, name)

    def to_toml(self, value: Any) -> object:
        """Return the points as pairs of texts."""
        return [[exact_text(v, "Pa"), exact_text(f, "m^3/s")] for v, f in value]


CURVE = CurveSpec()

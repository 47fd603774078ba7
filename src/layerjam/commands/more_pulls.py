"""How many more pulls, and at which vacuum, until a calibration is as sure as is wanted."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any

from layerjam.commands.declare import Help
from layerjam.units import QuantitySpec

if TYPE_CHECKING:
    from layerjam.identify.calibration.record import Calibration

WITHIN = QuantitySpec("1", "half of a 95 % interval over its value", lo=1e-5, hi=1, example="1%")
ALIKE = 1.001
"""Where the widest interval after one more pull is at most this times the narrowest."""
Within = Annotated[
    float | None,
    WITHIN,
    Help("Say how many more pulls narrow each interval to plus or minus this."),
]


def more_pulls(found: Calibration, within: float | None) -> dict[str, Any] | None:
    """{value: its half width now and after one more pull of each condition, and pulls needed}.

    None where nothing was asked; a value is None where the pulls at hand give no interval. Widths
    are over the value.
    """
    if within is None:
        return None
    made: dict[str, Any] = {}
    for name, one in (found.further or {}).items():
        made[name] = one and {
            "within": within,
            "half_width": float(one.half_width()),
            "after_one": one.after_one(),
            **asdict(one.needed(within)),
        }
    return made


def more_lines(asked: Mapping[str, Any]) -> Iterator[str]:
    """For each value: its interval now, and what it takes."""
    if asked:
        yield ""
    for name, row in asked.items():
        value = name.replace("_", " ")
        if row is None:
            yield f"{value}: the pulls at hand give no interval; repeat one of them first"
            continue
        yield f"{value} is known to ± {row['half_width']:.2%}; {_needed(row)}"


def _needed(row: Mapping[str, Any]) -> str:
    wanted, where, widths = f"± {row['within']:.2%}", row["condition"], row["after_one"]
    if row["likely"] == 0:
        return f"within {wanted} already"
    if row["likely"] is None:
        return f"no 1000 further pulls bring it to {wanted}"
    alike = max(widths.values()) <= ALIKE * widths[where]
    place = "any of these vacuums" if alike and len(widths) > 1 else where
    after = f"one more pull at {place}: ± {widths[where]:.2%}"
    sure = "more than 1000" if row["sure"] is None else f"{row['sure']}"
    return (
        f"{after}; for {wanted} {row['likely']} more at that scatter, {sure} to be sure of it in "
        "four of five cases"
    )

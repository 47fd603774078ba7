"""Checks of whether sheets, clamp and cap bear the maximum force (C7 to C9), in N, mm and MPa."""

import math
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.workshop import Build
from layerjam.core.units import show
from layerjam.workshop.fabricate.cap import pin_hole_diameter
from layerjam.workshop.fabricate.lengths import Lengths, mm
from layerjam.workshop.fabricate.verdicts import Check

PROOF = 580e6
"""Proof stress of a steel screw of class 8.8 (ISO 898-1) [Pa]."""
SHARE = 0.75
"""Fraction of the proof stress to which a screw is usually tightened."""
SHEAR = 1 / math.sqrt(3)
"""Ratio of allowed shear stress to tensile strength (von Mises)."""


def screw_preload(force: float, brake: Brake, lengths: Lengths) -> float:
    """Return the screw force [N] at which friction alone holds the sheets, F/(2 mu m).

    Coulomb's law applies to the two outer faces of the clamped stack. One rubs on the shelf, the
    other on the plate, which passes its half of the force on through screw and nut, by friction of
    steel on plastic. Friction between the layers adds nothing, because the force that a sheet
    transfers to a spacer must also leave the stack.
    """
    return force / (2 * brake.film.kinetic * lengths.screws)


def screw_torque(force: float, brake: Brake, build: Build, lengths: Lengths) -> float:
    """Return the torque [N m] that produces the force of `screw_preload`."""
    return build.nut_factor * screw_preload(force, brake, lengths) * lengths.thread.size * 1e-3


def strength_checks(
    force: Any, brake: Brake, build: Build, lengths: Lengths, friction_source: str = ""
) -> Iterator[Check]:
    """Yield C7, C8 and C9 at a force [N] on the brake."""
    clamp = _clamp_check(force, brake, build, lengths, friction_source)
    yield from _sheet_check(force, brake, lengths, clamp.margin())
    yield clamp
    yield from _cap_check(force, screw_preload(force, brake, lengths), build, lengths)


def _sheet_check(force: Any, brake: Brake, lengths: Lengths, clamp: Any) -> Iterator[Check]:
    """Yield C7: the sheets on the side with fewer sheets, at the screw holes.

    A sheet with its hole is a lug on a pin. The stressed areas are the section next to the holes,
    the holes' projection, and two shear planes from each hole to the sheet's end. The shear planes
    are assumed to be as short as the strip behind the hole, and to bear 1/sqrt(3) of the strength
    (von Mises). The section carries the force on either load path. The other two areas carry it
    only if clamp friction, whose margin is `clamp`, does not.
    """
    grip = clamp >= 1
    sheets, screws, hole = lengths.count // 2, lengths.screws, lengths.hole
    net = lengths.width - screws * hole
    shorter = np.minimum(lengths.left.clamped, lengths.right.clamped)
    # a hole that reaches the end of the sheet tears out immediately
    strip = np.maximum((shorter - hole) / 2, 0.0)
    areas = {
        "net section": sheets * net * lengths.thickness,
        "bearing on the screw": sheets * screws * hole * lengths.thickness,
        "tearing out at the end": 2 * sheets * screws * strip * lengths.thickness,
    }
    for place, area in areas.items():
        with np.errstate(divide="ignore"):
            stress = np.divide(force * 1e6, area)
        strength, _ = _allowed_stress(brake.film.strength, place)
        yield Check(
            code="C7",
            key=f"sheet-{place.split()[0]}",
            words=partial(_sheet_text, place, stress, brake.film.strength, grip),
            value=stress,
            limit=strength,
            unit="Pa",
            otherwise="failed",
            applies=True if place == "net section" else ~np.asarray(grip),
            fallback=clamp,
        )


def _sheet_text(place: str, stress: float, film: float | None, grip: Any, ok: bool | None) -> str:
    strength, kind = _allowed_stress(film, place)
    text = f"sheets, {place}: {_format_pascals(stress)}"
    if strength is None:
        text += "; the film's strength is unknown (film.strength)"
    else:
        text += f" (film strength{kind}: {_format_pascals(strength)})"
    if place == "net section":
        text += ", whether friction in the clamp or the screw carries the load"
        remedy = ": use more or thicker sheets, less overlap, or fewer screws (mount.screws)"
    elif grip:
        return text + (
            "; does not apply, because friction in the clamp carries the load (C8). "
            "The stress given is without that friction"
        )
    else:
        text += "; the screw carries the load, because friction in the clamp does not (C8)"
        remedy = ": use more or thicker sheets, more screws (mount.screws), or a longer clamp"
    return text + (remedy if ok is False else "")


def _allowed_stress(strength: Any, place: str) -> tuple[Any, str]:
    """Return the allowed stress for a tensile strength, and " in shear" for a shear stress."""
    if strength is None or "tearing" not in place:
        return strength, ""
    return strength * SHEAR, " in shear"


def _clamp_check(force: Any, brake: Brake, build: Build, lengths: Lengths, source: str) -> Check:
    """Return C8: the preload for holding by friction, and whether a class 8.8 screw can provide it.

    If not, the screw carries the load; C7 checks that load path if the film's strength is known.
    """
    need = screw_preload(force, brake, lengths)
    available = SHARE * PROOF * lengths.thread.stress_area * 1e-6
    torque = screw_torque(force, brake, build, lengths)

    return Check(
        code="C8",
        key="clamp-preload",
        words=partial(_describe_clamp, force, need, available, torque, brake, lengths, source),
        value=need,
        limit=available,
        unit="N",
        otherwise="failed" if brake.film.strength is None else "warning",
    )


def _describe_clamp(
    force: float,
    limit: float,
    available: float,
    turn: float,
    brake: Brake,
    lengths: Lengths,
    source: str,
    ok: bool | None,
) -> str:
    return (
        f"tighten each {lengths.thread.name} to {show(turn, 'N m', 2)}: a preload of "
        f"at least {show(limit, 'N', 3)} holds {show(force, 'N')} by friction (film on film, "
        f"{brake.film.kinetic:.3g}, in place of film on plastic; {source}); a screw of class "
        f"8.8 allows {show(available, 'N', 3)}"
        + ("" if ok else ": use more screws (mount.screws), or a larger mount.screw_hole")
    )


def cap_stresses(force: float, clamp: float, build: Build, lengths: Lengths) -> dict[str, float]:
    """Return the maximum stresses [MPa] in the printed parts; `clamp` is a screw's preload [N].

    The tray's stress is from `tray_factor`. The neck's section is the one at its groove, minus the
    air bore. The head is a lug on the dowel pin, with two shear planes as short as the wall behind
    the pin's hole. The seat is below the screw's head or above its nut, whichever is smaller.
    """
    depth, bore = mm(build.tie_depth), mm(build.air_bore)
    neck = math.pi * ((lengths.neck_a - depth) * (lengths.neck_b - depth) - bore**2 / 4)
    hole, thread = pin_hole_diameter(build), lengths.thread
    lug = lengths.head - hole
    seat = min(math.pi / 4 * thread.head**2, math.sqrt(3) / 2 * thread.nut**2)
    seat -= math.pi / 4 * thread.clearance**2
    return {
        "tray": force * tray_factor(build, lengths),
        "neck": force / neck,
        "pin, net section": force / (lug * lengths.head_height),
        "pin, tearing out": force / (lug * lengths.head_height),
        "seat of head and nut": clamp / seat,
    }


def _cap_check(force: Any, screw_force: Any, build: Build, lengths: Lengths) -> Iterator[Check]:
    """Yield C9: stresses in the cap, with a limit only if the strength of the plastic is given."""
    for place, stress in cap_stresses(force, screw_force, build, lengths).items():
        yield Check(
            code="C9",
            key=f"cap-{place.replace(', ', '-').replace(' ', '-')}",
            words=partial(_describe_cap, place, stress, build.print_strength),
            value=stress * 1e6,
            limit=_allowed_stress(build.print_strength, place)[0],
            unit="Pa",
            otherwise="failed",
        )


_CAP_REMEDIES = {
    "tray": "build.cheek or build.floor",
    "neck": "build.neck_stretch",
    "pin, net section": "build.pin_wall",
    "pin, tearing out": "build.pin_wall",
    "seat of head and nut": "mount.screws or mount.screw_hole",
}
"""{part of a cap: inputs that strengthen it}."""


def _describe_cap(place: str, stress: float, strength: float | None, ok: bool | None) -> str:
    limit, kind = _allowed_stress(strength, place)
    text = f"cap, {place}: {_format_pascals(stress * 1e6)}"
    if limit is None:
        return text + "; build.print_strength is not given"
    text += f" (strength of the plastic{kind}: {_format_pascals(limit)})"
    return text + ("" if ok else f": use a larger {_CAP_REMEDIES[place]}, or a stronger plastic")


def tray_factor(build: Build, lengths: Lengths) -> float:
    """Return the ratio of the tray's maximum stress to the force [1/mm²], from tension and bending.

    The force acts in the middle of the stack. The section is a U without nut pockets and with sharp
    edges, which changes the result by 4 %.
    """
    low, high = -lengths.stack / 2 - lengths.shelf_height, lengths.stack / 2 + lengths.plate_height
    floor = -lengths.stack / 2
    pocket = low + lengths.shelf_height - lengths.floor
    nuts = lengths.screws * (lengths.thread.nut + mm(build.fit))
    pieces = [
        (lengths.tray_width, low, high),
        (-lengths.slot, floor, high),
        (-nuts, low, pocket),
    ]
    area = sum(w * (b - a) for w, a, b in pieces)
    middle = sum(w * (b * b - a * a) / 2 for w, a, b in pieces) / area
    # multiply, because NumPy's powers of arrays are slow, and a sweep draws many brakes
    inertia = sum(w * (b * b * b - a * a * a) / 3 for w, a, b in pieces) - area * middle * middle
    ends = (high - middle, low - middle)
    return 1 / area + np.maximum(*(-middle * end for end in ends)) / inertia


def _format_pascals(stress: float) -> str:
    return show(stress, "Pa", 3) if math.isfinite(stress) else "infinite"

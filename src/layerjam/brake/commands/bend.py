"""`bend`: bending stiffness of a brake, free and jammed, and its friction over a joint."""

import math
from typing import TYPE_CHECKING, Annotated

from layerjam.brake.commands.arguments import (
    Atmosphere,
    BrakeInput,
    OtherFilm,
    Slip,
    Vacuum,
    check_vacuum,
    slip_notices,
)
from layerjam.brake.device.brake import Brake
from layerjam.core.command.declare import Help, command
from layerjam.core.command.results import Figure, Result, number, result
from layerjam.core.errors import Notice, QuantityError
from layerjam.core.units import QuantitySpec, show

if TYPE_CHECKING:
    from layerjam.brake.device.brake_file import BrakeFile

ANGLE = QuantitySpec("rad", "angle between the caps", open_lo=True, hi=math.pi, example="90deg")
RADIUS = QuantitySpec("m", "radius of the joint", lo=1e-3, hi=10, example="40mm")
LIMB = QuantitySpec("1", "friction of the enclosure on the limb", lo=0, hi=5, example="0.5")

FAN_WHEN_BENT = Notice(
    "to first order, bending does not amplify the friction of sheets without spacers: the pressure "
    "added on one side of the middle is lost on the other; fanning makes the free lengths softer",
    "fan-when-bent",
)
LEAST_OVER_JOINT = Notice(
    "sheets without spacers also press on each other where they leave the overlap. Over the joint "
    "this is neglected: friction and stress are lower bounds, and the amplification is relative to "
    "the friction of flat sheets",
    "no-fan-over-joint",
)


@result
class Bend(Result):
    """A brake bent between its caps; `record` is (BrakeFile, vacuum, angle, slip, radius).

    The numbers of a joint are None if no radius is given.
    """

    record: "tuple[BrakeFile, float, float, float, float | None]"
    bending_stiffness_free: float = number("N m^2", "bending stiffness without vacuum")
    bending_stiffness_jammed: float = number("N m^2", "bending stiffness before slip")
    stiffness_ratio: float = number("1", "ratio of jammed to free stiffness")
    turning_stiffness_free: float = number("N m/rad", "rotational stiffness without vacuum")
    turning_stiffness_jammed: float = number("N m/rad", "rotational stiffness before slip")
    moment_free: float = number("N m", "moment at this angle without vacuum")
    moment: float = number("N m", "moment at this angle and vacuum")
    slip_moment: float = number("N m", "additional friction moment once all interfaces slip")
    slip_angle: float = number(
        "rad",
        "angle at which the initial slope would reach the moment of full slip",
        shown=lambda angle: f"{math.degrees(angle):.4g}°",
    )
    buckling_moment: float | None = number(
        "N m", "moment at which a compressed sheet buckles; null if none is compressed"
    )
    shear_at_first_slip: float = number(
        "N", "transverse force at which the innermost interfaces slip"
    )
    shear_at_full_slip: float = number("N", "transverse force above which all interfaces slip")
    least_radius: float | None = number(
        "m", "smallest radius to which a film bends without permanent curl"
    )
    straight_friction: float = number("N", "friction of the sheets in a straight pull")
    joint_friction: float | None = number("N", "friction of the sheets in a pull over the joint")
    joint_friction_off: float | None = number("N", "friction over the joint without vacuum")
    amplification: float | None = number(
        "1", "ratio of the friction over the joint to that in a straight pull"
    )
    sheet_stress: float | None = number("Pa", "maximum stress in a sheet over the joint")
    end_force_ratio: float | None = number("1", "ratio of the forces at the two caps")

    def draw(self) -> Figure:
        """Return the figure of moment versus angle, and of friction versus the joint's angle."""
        from layerjam.brake.figures import force_figures

        return force_figures.draw_bend(*self.record)


@command("predict")
def bend(
    brake: BrakeInput,
    *,
    vacuum: Vacuum,
    angle: Annotated[float, ANGLE],
    slip: Slip = 0.0,
    radius: Annotated[
        float | None, RADIUS, Help("Radius of the joint over which the brake is pulled.")
    ] = None,
    limb_friction: Annotated[
        float | None, LIMB, Help("Friction coefficient of the enclosure on the surface below it.")
    ] = None,
    atmosphere: Atmosphere = None,
    film: OtherFilm = None,
) -> Bend:
    """Bend a brake between its caps, and compute its stiffness, free and jammed.

    The caps rotate by `angle` relative to each other and may move closer. With the `radius` of a
    joint, also compute the friction of the sheets where the pull presses them together, with the
    outer face of the enclosure at its tension for that slip. `limb_friction` determines how much
    the forces at the two caps differ when the brake slides on the limb.
    """
    from layerjam.brake.mechanics.joint import capstan_ratio

    device = brake.brake
    check_vacuum(vacuum, device)
    notices = [*brake.warnings(), *slip_notices(slip, device)]
    if slip >= device.sheets.overlap:
        raise QuantityError.of("slip", f"{show(slip, 'm')} leaves no overlap to bend")
    if limb_friction is not None and radius is None:
        raise QuantityError("limb friction: it acts on a joint; give --radius too")
    if device.mount.spacers is False:
        notices.append(FAN_WHEN_BENT)
    numbers = _bending_results(device, vacuum, angle, slip)
    notices += _buckling_notices(numbers["moment"], numbers["buckling_moment"])
    joint = {}
    if radius is not None:
        joint = _joint_results(device, vacuum, angle, slip, radius)
        notices += _joint_notices(device, angle, slip, radius, joint)
    if limb_friction is not None:
        joint["end_force_ratio"] = float(capstan_ratio(angle, limb_friction))
    material = device.film
    curl = None
    if material.strength is not None:
        curl = material.modulus * device.sheets.thickness / (2 * material.strength)
    return Bend.create(
        numbers,
        joint,
        least_radius=curl,
        warnings=notices,
        record=(brake, vacuum, angle, slip, radius),
    )


def _bending_results(device: Brake, vacuum: float, angle: float, slip: float) -> dict[str, float]:
    from layerjam.brake.mechanics import bending
    from layerjam.brake.mechanics.friction import sheet_friction

    free = float(bending.bending_stiffness_free(device))
    jammed_stiffness = float(bending.bending_stiffness_jammed(device))
    free_stiffness = float(bending.turning_stiffness_free(slip, device))
    stiff = float(bending.turning_stiffness_jammed(slip, device))
    greatest_moment = float(bending.slip_moment(slip, vacuum, device))
    return {
        "bending_stiffness_free": free,
        "bending_stiffness_jammed": jammed_stiffness,
        "stiffness_ratio": jammed_stiffness / free,
        "turning_stiffness_free": free_stiffness,
        "turning_stiffness_jammed": stiff,
        "moment_free": free_stiffness * angle,
        "moment": float(bending.turning_moment(angle, slip, vacuum, device)),
        "slip_moment": greatest_moment,
        "slip_angle": greatest_moment / (stiff - free_stiffness),
        "buckling_moment": float(bending.buckling_moment(slip, device)),
        "shear_at_first_slip": float(bending.shear_at_first_slip(vacuum, device)),
        "shear_at_full_slip": float(bending.shear_at_full_slip(vacuum, device)),
        "straight_friction": float(sheet_friction(slip, vacuum, device)),
    }


def _buckling_notices(moment: float, buckling: float) -> list[Notice]:
    """Return a notice if compressed sheets buckle before the moment is reached."""
    if moment <= buckling:
        return []
    text = (
        f"above {show(buckling, 'N m')}, unsupported compressed sheets buckle in the free lengths: "
        f"the moment of {show(moment, 'N m')} is an upper bound"
    )
    return [Notice(text, "compressed-sheets-buckle")]


def _joint_results(
    device: Brake, vacuum: float, angle: float, slip: float, radius: float
) -> dict[str, float]:
    """Return the friction and stress of a pull over the joint, with and without vacuum."""
    from layerjam.brake.mechanics.effects import remove_slip_effects
    from layerjam.brake.mechanics.enclosure import enclosure_force
    from layerjam.brake.mechanics.friction import sheet_friction
    from layerjam.brake.mechanics.joint import joint_friction, joint_sheet_force
    from layerjam.brake.mechanics.stiffness import sheet_section

    def stress_at_pressure(pressure: float) -> float:
        return float(enclosure_force(slip, pressure, device)) / 2

    case = (slip, vacuum, angle, radius, stress_at_pressure(vacuum), device)
    force = float(joint_friction(*case))
    # self-amplification at a joint is unknown, so both values ignore it
    straight = float(sheet_friction(slip, vacuum, remove_slip_effects(device)))
    numbers = {
        "joint_friction": force,
        "joint_friction_off": float(
            joint_friction(slip, 0.0, angle, radius, stress_at_pressure(0.0), device)
        ),
        "sheet_stress": float(joint_sheet_force(*case)) / sheet_section(device),
    }
    return numbers | ({"amplification": force / straight} if straight else {})


def _joint_notices(
    device: Brake, angle: float, slip: float, radius: float, joint: dict[str, float]
) -> list[Notice]:
    out, overlap = [], device.sheets.overlap - slip
    if device.mount.spacers is False:
        out.append(LEAST_OVER_JOINT)
    if radius * angle > overlap:
        out.append(
            Notice(
                f"the joint's arc of {show(radius * angle, 'm')} is longer than the overlap of "
                f"{show(overlap, 'm')}: only the overlap is counted",
                "arc-beyond-overlap",
            )
        )
    strength = device.film.strength
    if strength is not None:
        curl = device.film.modulus * device.sheets.thickness / (2 * radius)
        if joint["sheet_stress"] + curl > strength:
            out.append(
                Notice(
                    f"a sheet pulled over this joint bears {show(joint['sheet_stress'], 'Pa')} "
                    f"and {show(curl, 'Pa')} of bending, more than the film's "
                    f"{show(strength, 'Pa')}",
                    "joint-overloads-film",
                )
            )
    return out

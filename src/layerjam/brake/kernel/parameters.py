"""The eight numbers that describe a brake to the C kernel."""

from typing import Any, NamedTuple

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.mechanics.effects import list_effects, pressure_on_sheets, require_linear
from layerjam.brake.mechanics.enclosure import face_constants
from layerjam.brake.mechanics.friction import friction_per_contact
from layerjam.brake.mechanics.speed_effects import ignore_speed
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.core.brief import brief
from layerjam.core.errors import QuantityError
from layerjam.core.evolve import evolve


@brief
class Parameters(NamedTuple):
    """Fields of `lj_brake` in `layerjam.h`, in the order and with the names of that struct."""

    contact: float
    """Friction of the sheets per unit of vacuum and overlap, a mu_k (n-1) W [m]."""
    overlap: float
    """Overlap at rest [m]."""
    stiffness: float
    """Stiffness of brake, mount and rope in series [N/m]."""
    enclosure_stiffness: float
    """Tensile stiffness EA of one face of the enclosure [N]."""
    enclosure_contact: float
    """Friction of one face of the enclosure per unit of vacuum and length, mu_e W [m]."""
    reach: float
    """Half the free length of the enclosure [m]."""
    exponent: float
    """Exponent of the friction coefficient versus pressure; 0 if friction is proportional to it."""
    test_pressure: float
    """Vacuum to which the exponent refers [Pa]."""


UNITS = dict(zip(Parameters._fields, ("m", "m", "N/m", "N", "m", "m", "1", "Pa"), strict=True))
"""{parameter: SI unit}."""


def check_exportable(brake: Brake | BrakeFile) -> Brake:
    """Return the brake for the kernel; raises QuantityError for a law that the kernel lacks.

    Spacers are omitted, because without fanning they affect only the scale factor.
    """
    brake = brake.brake if isinstance(brake, BrakeFile) else brake
    for effect in list_effects(brake):
        if not effect.in_kernel and effect.is_active(brake):
            raise effect.refuse("the exported law")
    return require_linear(ignore_speed(brake), "the exported law")


def parameters(brake: Brake | BrakeFile, rope_stiffness: float | None = None) -> Parameters:
    """Return the kernel's numbers, with a rope [N/m] in series with the brake.

    `contact` and `test_pressure` include the fraction of the vacuum that presses the sheets. Raises
    QuantityError for laws that the kernel lacks: sheets that fan out, a speed law, a hyperelastic
    enclosure.
    """
    brake = check_exportable(brake)
    face, face_contact, reach = face_constants(brake)
    stiffness = float(working_stiffness(brake))
    if rope_stiffness is not None:
        if not rope_stiffness > 0:
            raise QuantityError.of(
                "rope_stiffness", f"{rope_stiffness:g} N/m is not allowed; it must be above zero"
            )
        stiffness = 1 / (1 / stiffness + 1 / rope_stiffness)
    exponent: Any = brake.pressure_exponent
    # for friction that grows with a power of the pressure: its value at the test pressure
    proportional = evolve(brake, pressure_exponent=None)
    share = pressure_on_sheets(1.0, brake)
    return Parameters(
        contact=float(friction_per_contact(1.0, proportional)),
        overlap=float(brake.sheets.overlap),
        stiffness=stiffness,
        enclosure_stiffness=float(face),
        enclosure_contact=float(face_contact),
        reach=float(reach),
        exponent=0.0 if exponent is None else float(exponent),
        test_pressure=1.0 if exponent is None else float(brake.test_pressure or 1.0) / share,
    )

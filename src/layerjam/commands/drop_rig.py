"""A mass on the brake of a bench, as options: whether its accelerometer is recorded, what falls."""

from dataclasses import fields
from typing import TYPE_CHECKING, Annotated, Any

from layerjam.commands.declare import Help, options
from layerjam.commands.quantities import RopeStiffness
from layerjam.device.file import BrakeFile
from layerjam.errors import QuantityError
from layerjam.rig.trigger import LEVEL
from layerjam.simulate.quantities import ARRIVAL_SPEED, MASS

if TYPE_CHECKING:
    from layerjam.rig.shots import DropRig


@options
class DropRigOptions:
    """What falls on the brake during a run, and whether its accelerometer is recorded."""

    shot: Annotated[
        bool, Help("Record the accelerometer of a mass that falls on the brake in a hold.")
    ] = False
    mass: Annotated[
        float | None, MASS, Help("Mass that falls; on a virtual board it does in each hold.")
    ] = None
    speed: Annotated[float | None, ARRIVAL_SPEED, Help("Speed with which it arrives.")] = None
    rope_stiffness: RopeStiffness | None = None
    trigger_level: Annotated[
        float | None, LEVEL, Help("Acceleration that triggers, in g; 5 unless given.")
    ] = None

    def rig(self, brake: BrakeFile) -> "DropRig | None":
        """The drop rig, None where no shot is asked for; QuantityError for what needs one."""
        from layerjam.rig.shots import DropRig

        if not self.shot:
            stated = (f.name for f in fields(self) if getattr(self, f.name) not in (None, False))
            if (name := next(stated, None)) is not None:
                raise QuantityError.of(name.replace("_", " "), "it belongs to a drop; add --shot")
            return None
        capture: dict[str, Any] = {}
        if self.trigger_level is not None:
            capture["level"] = self.trigger_level
        return DropRig(
            capture=capture,
            file=brake,
            mass=self.mass,  # type: ignore[arg-type]
            speed=self.speed,  # type: ignore[arg-type]
            rope_stiffness=self.rope_stiffness,  # type: ignore[arg-type]
        )

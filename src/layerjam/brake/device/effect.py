"""An effect on the forces of a brake, as an object that answers what solvers and exports ask."""

from typing import Any, ClassVar

from layerjam.core.errors import QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.toml_files.plugin_tables import name_table

GROUP = "layerjam.effects"
"""Entry points: record classes of the tables [effects.NAME]."""


class Effect:
    """An effect on the friction of the sheets, such as that of humidity.

    A package adds one by a class with `@record` whose fields are its quantities. An entry point of
    the group `layerjam.effects` names it: `humidity = "my_package:Humidity"`. A brake file then
    sets the fields in a table, [effects.humidity]. The answers below apply to every brake with the
    effect; a class replaces those that differ. Each question gets the `Brake`.
    """

    is_proportional: ClassVar[bool] = False
    """Whether the friction stays proportional to the vacuum."""
    depends_on_slip: ClassVar[bool] = False
    """Whether the friction is no longer proportional to the remaining overlap."""
    depends_on_speed: ClassVar[bool] = False
    """Whether the friction depends on the sliding speed."""
    changes_enclosure: ClassVar[bool] = False
    """Whether the enclosure no longer has a single modulus."""
    in_kernel: ClassVar[bool] = False
    """Whether the C kernel applies the effect. It can for a factor that is the same everywhere."""
    in_fmu: ClassVar[bool] = False
    """Whether an FMU has parameters for the effect."""

    @property
    def table(self) -> str:
        """Table or key of a brake file that states the effect, for errors."""
        return name_table("effects", GROUP, type(self))

    def is_active(self, brake: Any) -> bool:
        """Return whether the numbers of a brake, which has the effect, let it change a force."""
        return True

    def friction_factor(self, vacuum: Any, brake: Any) -> Any:
        """Return the friction coefficient at a vacuum [Pa], relative to that without the effect."""
        return 1.0

    def sheet_pressure(self, pressure: Any, brake: Any) -> Any:
        """Return the pressure on the sheets [Pa], given that without the effect."""
        return pressure

    def growth(self, speed: Any, brake: Any) -> Any:
        """Return the friction at a sliding speed [m/s], relative to that in its test."""
        return 1.0

    def remove(self, brake: Any) -> Any:
        """Return the brake without the effect."""
        return evolve(brake, effects=tuple(e for e in brake.effects if e is not self))

    def refuse(self, caller: str) -> QuantityError:
        """Return the error that a `caller` raises, such as "the exported law"."""
        return QuantityError.of(
            self.table, f"{caller} does not have this effect; use the brake without [{self.table}]"
        )

"""An effect on the forces of a brake, as an object that answers what solvers and exports ask."""

import math
from typing import Any, ClassVar, NamedTuple

from layerjam.core.errors import QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.toml_files.plugin_tables import name_table

GROUP = "layerjam.effects"
"""Entry points: record classes of the tables [effects.NAME]."""


class SlipShape(NamedTuple):
    """Factor of an effect on the friction along the slip, as the solvers ask for it."""

    effect: Any
    brake: Any

    def factor(self, slip: Any) -> Any:
        """Return the factor at a slip [m]."""
        return self.effect.slip_factor(slip, self.brake)

    def fall_over(self, left: Any, slip: Any) -> Any:
        """Return the decrease of the factor along its tangent, over a further slip `left` [m]."""
        return -left * self.effect.slip_slope(slip, self.brake)

    def gain(self, slip: Any) -> Any:
        """Return the slope of ln(factor) versus that of the friction coefficient: none."""
        return 0.0

    def scale(self, factor: Any) -> "SlipShape":
        """Return the shape with `factor` times the friction coefficient: the same."""
        return self

    @property
    def length(self) -> Any:
        """Return the slip [m] within which the factor changes."""
        return self.effect.slip_length(self.brake)

    def amplify_middle(self, stress: Any) -> Any:
        """Return a stress in the middle sheet at rest: with the factor of all sheets."""
        return stress * self.factor(0.0)

    def interface_factors(self, slip: Any) -> tuple[Any, Any]:
        """Return the factor of each interface at its slip [m], and its fall [1/m]: (n - 1,)."""
        return self.factor(slip), self.fall_over(1.0, slip)


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
    """Whether the friction grows with the sliding speed, as `growth` and `growth_slope` state."""
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

    def growth_slope(self, speed: Any, brake: Any) -> Any:
        """Return the slope of ln(growth) versus the speed [s/m]: above 0 if it grows with speed."""
        return 0.0

    def rest_speed(self, brake: Any) -> Any:
        """Return the speed [m/s] far below which `growth` no longer changes."""
        return math.inf

    def test_speed(self, brake: Any) -> float:
        """Return the speed [m/s] at which `growth` is 1."""
        return 0.0

    def fastest_speed(self, brake: Any) -> float:
        """Return the highest speed [m/s] at which `growth` was measured; infinite if unknown."""
        return math.inf

    def slip_factor(self, slip: Any, brake: Any) -> Any:
        """Return the friction at a slip [m], relative to friction proportional to the overlap."""
        return 1.0

    def slip_slope(self, slip: Any, brake: Any) -> Any:
        """Return the slope of `slip_factor` versus slip [1/m]; the friction must still fall."""
        return 0.0

    def slip_length(self, brake: Any) -> Any:
        """Return the slip [m] within which `slip_factor` changes."""
        return brake.sheets.overlap

    def make_shape(self, factor: Any, brake: Any) -> Any:
        """Return the factor along the slip, for `factor` times the film's friction coefficient."""
        return SlipShape(self, brake)

    def remove(self, brake: Any) -> Any:
        """Return the brake without the effect."""
        return evolve(brake, effects=tuple(e for e in brake.effects if e is not self))

    def refuse(self, caller: str) -> QuantityError:
        """Return the error that a `caller` raises, such as "the exported law"."""
        return QuantityError.of(
            self.table, f"{caller} does not have this effect; use the brake without [{self.table}]"
        )

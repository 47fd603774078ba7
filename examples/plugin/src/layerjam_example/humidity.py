"""Effect of the humidity of the air on the friction of the sheets."""

from typing import Any, ClassVar

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.effect import Effect
from layerjam.core.units import quantity, record


@record
class Humidity(Effect):
    """Friction that changes linearly with the relative humidity, at every vacuum."""

    humidity: float = quantity("1", "relative humidity of the air", hi=1)
    slope: float = quantity("1", "relative change of friction from dry to saturated air", lo=-0.9)
    test_humidity: float = quantity(
        "1", "relative humidity of the friction test", hi=1, default=0.5
    )

    is_proportional: ClassVar[bool] = True
    in_kernel: ClassVar[bool] = True

    def friction_factor(self, vacuum: Any, brake: Brake) -> Any:
        """Return the friction coefficient relative to that in the friction test."""
        return 1 + self.slope * (self.humidity - self.test_humidity)

"""The effects on a brake, as objects: those that the keys of a brake file state, and further ones.

Solvers, exports and commands ask the objects, not the keys. An object answers by which factor it
changes the friction, whether the friction depends on slip or speed, and whether the C kernel has
the effect. One object serves all brakes, because it gets the brake with each question.
"""

import math
from abc import ABC, abstractmethod
from typing import Any, ClassVar

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.effect import Effect
from layerjam.brake.mechanics.arrays import xp
from layerjam.brake.mechanics.fan import make_fan
from layerjam.core.errors import QuantityError
from layerjam.core.evolve import evolve


class BuiltInEffect(Effect, ABC):
    """An effect that is stated by keys of a brake file, outside [effects]."""

    table: ClassVar[str] = ""  # type: ignore[misc]
    title: ClassVar[str]
    condition: ClassVar[str]
    """Keys of a brake file that state the effect, for the docs."""
    law: ClassVar[str]
    """Equation, for the docs."""
    rejected_by: ClassVar[tuple[str, ...]] = ()
    """Calculations that do not have the effect, for the docs."""
    is_fitted: ClassVar[bool] = False
    """Whether a calibration fits the effect."""
    is_proportional: ClassVar[bool] = True

    @abstractmethod
    def is_stated(self, brake: Brake) -> bool:
        """Return whether a brake states the effect, by numbers that may be traced."""


class PressureExponent(BuiltInEffect):
    """Friction coefficient that changes with a power of the pressure on the sheets (ours)."""

    table = "pressure_exponent"
    title = "[Dependence on pressure](#friction-of-the-sheets)"
    condition = "`pressure_exponent`, `test_pressure`"
    law = r"$\mu (P/P_\text{test})^m$"
    is_fitted = True
    is_proportional = False
    in_kernel = in_fmu = True

    def is_stated(self, brake: Brake) -> bool:
        """Return whether the brake states an exponent."""
        return brake.pressure_exponent is not None

    def friction_factor(self, vacuum: Any, brake: Brake) -> Any:
        """Return (P/P_test)^m for the pressure P on the sheets, constant below `lowest_pressure`.

        It is the friction coefficient at a vacuum [Pa], relative to that at the test pressure.
        """
        test: Any = brake.test_pressure
        pressure = xp.where(vacuum > 0, pressure_on_sheets(vacuum, brake), test)
        if brake.lowest_pressure is not None:
            pressure = xp.maximum(pressure, brake.lowest_pressure)
        return (pressure / test) ** brake.pressure_exponent

    def remove(self, brake: Brake) -> Brake:
        """Return the brake with the friction of the test pressure at every pressure."""
        return evolve(brake, pressure_exponent=None, test_pressure=None)


class VacuumShare(BuiltInEffect):
    """Vacuum that does not reach the middle of the stack (ours)."""

    table = "vacuum_share"
    title = "[Share of the vacuum](#friction-of-the-sheets)"
    condition = "`vacuum_share`"
    law = "$s P$ instead of $P$ on the sheets"
    in_kernel = in_fmu = True

    def is_stated(self, brake: Brake) -> bool:
        """Return whether the brake states a share."""
        return brake.vacuum_share is not None

    def sheet_pressure(self, pressure: Any, brake: Brake) -> Any:
        """Return the share of the pressure [Pa]."""
        return brake.vacuum_share * pressure

    def remove(self, brake: Brake) -> Brake:
        """Return the brake with the full vacuum on the sheets."""
        return evolve(brake, vacuum_share=None)


class SpeedDependence(BuiltInEffect):
    """Kinetic friction that depends on the sliding speed (ours)."""

    table = "speed_law"
    title = "[Dependence on speed](#friction-of-the-sheets)"
    condition = "`[speed_law]` with a power above 0"
    law = r"$\mu_\text{k} ((v_0 + v)/(v_0 + v_\text{test}))^n$"
    rejected_by = ("a stretched hyperelastic enclosure", "`calibrate --depth bayesian`")
    is_fitted = True
    depends_on_speed = True

    def is_stated(self, brake: Brake) -> bool:
        """Return whether the brake states a law, of any power."""
        return brake.speed_law is not None

    def is_active(self, brake: Brake) -> Any:
        """Return whether the power of the law is above 0."""
        law: Any = brake.speed_law
        return law.power > 0

    def growth(self, speed: Any, brake: Brake) -> Any:
        """Return the friction at a speed [m/s], relative to that at the test speed."""
        law: Any = brake.speed_law
        return ((law.rest_speed + speed) / (law.rest_speed + law.test_speed)) ** law.power

    def growth_slope(self, speed: Any, brake: Brake) -> Any:
        """Return n/(v_0 + v), the slope of the logarithm of that growth [s/m]."""
        law: Any = brake.speed_law
        return law.power / (law.rest_speed + speed)

    def rest_speed(self, brake: Brake) -> Any:
        """Return the law's rest speed v_0 [m/s]."""
        law: Any = brake.speed_law
        return law.rest_speed

    def test_speed(self, brake: Brake) -> float:
        """Return the law's test speed [m/s]."""
        law: Any = brake.speed_law
        return float(law.test_speed)

    def fastest_speed(self, brake: Brake) -> float:
        """Return the highest speed [m/s] of the measurement; infinite if it is not stated."""
        law: Any = brake.speed_law
        return math.inf if law.fastest is None else float(law.fastest)

    def remove(self, brake: Brake) -> Brake:
        """Return the brake with the friction of the test speed at every speed."""
        return evolve(brake, speed_law=None)

    def refuse(self, caller: str) -> QuantityError:
        """Return the error of a `caller` that knows no speed."""
        return QuantityError.of(
            self.table,
            f"{caller} depends on the path, not on speed; without [speed_law] friction "
            "keeps its value at the speed at which it was measured",
        )


class Ageing(BuiltInEffect):
    """Static friction that grows while the sheets rest (ours)."""

    table = "film.ageing"
    title = "[Ageing](#friction-of-the-sheets)"
    condition = "`film.ageing`, `film.static_hold`"
    law = r"$\mu_\text{s} + B \log_{10}(t/t_0)$, static friction only"
    in_kernel = in_fmu = True

    def is_stated(self, brake: Brake) -> bool:
        """Return whether the film states its ageing."""
        return brake.film.ageing is not None

    def remove(self, brake: Brake) -> Brake:
        """Return the brake with the same static friction after every hold."""
        return evolve(brake, film=evolve(brake.film, ageing=None, static_hold=None))


class Rubber(BuiltInEffect):
    """Enclosure with a hyperelastic law instead of a single modulus (ours)."""

    table = "hyperelastic"
    title = "[Hyperelastic enclosure](#a-hyperelastic-enclosure)"
    condition = "`[hyperelastic]`"
    law = r"$x/2 = W^\ast(N)/q$"
    rejected_by = (
        "a vacuum that falls or changes during a stop", "damping of the rope", "`tune`", "`vacuum`",
        "`stick-slip`", "a speed law", "`tensile --model stack`", "`calibrate`",
    )  # fmt: skip
    changes_enclosure = True

    def is_stated(self, brake: Brake) -> bool:
        """Return whether the brake states a law of its rubber."""
        return brake.hyperelastic is not None

    def remove(self, brake: Brake) -> Brake:
        """Return the brake with the single modulus of its enclosure."""
        return evolve(brake, hyperelastic=None)

    def refuse(self, caller: str) -> QuantityError:
        """Return the error of a `caller` that needs a single modulus."""
        return QuantityError.of(
            self.table,
            f"{caller} needs an enclosure with a single modulus; use the brake "
            "without [hyperelastic]. That law is supported for force, work, pulls and "
            "returns at a vacuum that does not fall, and for a stop at constant vacuum",
        )


class Softening(Rubber):
    """Rubber that is softer after its first loading (Ogden and Roxburgh 1999)."""

    table = "hyperelastic.softening_r"
    title = "[Softening](#a-hyperelastic-enclosure)"
    condition = "`softening_r`, `softening_m`, `softening_beta` in `[hyperelastic]`"
    changes_enclosure = False  # the rubber law includes it
    law = r"stress times $1 - \text{erf}((W_\text{max} - W)/(m + \beta W_\text{max}))/r$"

    def is_stated(self, brake: Brake) -> bool:
        """Return whether the law of the rubber includes its softening."""
        rubber = brake.hyperelastic
        return rubber is not None and rubber.softening_r is not None

    def remove(self, brake: Brake) -> Brake:
        """Return the brake with rubber that returns along its first loading."""
        names = ("softening_r", "softening_m", "softening_beta")
        rubber = evolve(brake.hyperelastic, **dict.fromkeys(names))
        return evolve(brake, hyperelastic=rubber)


class FanOut(BuiltInEffect):
    """Sheets without spacers, which press on each other (after Alarcon et al. 2016)."""

    table = "mount.spacers"
    title = "[Sheets without spacers](#sheets-without-spacers-hold-themselves)"
    condition = "`spacers = false` in `[mount]`"
    law = r"$M = \int_0^1 e^{\alpha (1 - y^2)} \text{d}y$"
    rejected_by = ("`stick-slip`", "`stribeck`", "`scenario seat-belt`", "`scenario ankle-clutch`")
    depends_on_slip = True

    def is_stated(self, brake: Brake) -> bool:
        """Return whether the brake states if it has spacers."""
        return brake.mount.spacers is not None

    def is_active(self, brake: Brake) -> Any:
        """Return whether there are no spacers."""
        return not brake.mount.spacers

    def make_shape(self, factor: Any, brake: Brake) -> Any:
        """Return the fan of the sheets."""
        return make_fan(brake, factor)

    def remove(self, brake: Brake) -> Brake:
        """Return the brake with flat sheets: its scale factor without the effect of a fan."""
        factor: Any = brake.scale_factor
        reference = brake.amplification_held
        if reference is not None:
            # a design may contain NaN
            factor = factor / xp.where(xp.asarray(reference) > 0, reference, 1.0)
        mount = evolve(brake.mount, spacers=None)
        return evolve(brake, scale_factor=factor, amplification_held=None, mount=mount)

    def refuse(self, caller: str) -> QuantityError:
        """Return the error of a `caller` that needs friction linear in slip."""
        return QuantityError.of(
            self.table,
            f"{caller} does not support the self-amplified friction of sheets without "
            "spacers; if spacers is true or not stated, friction is computed without it",
        )


BUILT_IN: tuple[BuiltInEffect, ...] = (
    PressureExponent(), VacuumShare(), SpeedDependence(), FanOut(), Ageing(), Rubber(), Softening(),
)  # fmt: skip
"""Effects that the keys of a brake file state, in the order of the docs."""


_KEPT = "_effects"


class _Factor(Effect):
    """A further effect whose class has only the method `friction_factor`."""

    def __init__(self, effect: Any) -> None:
        self._effect = effect

    @property
    def table(self) -> str:
        """Return "effects": a file cannot state the effect."""
        return "effects"

    def friction_factor(self, vacuum: Any, brake: Brake) -> Any:
        """Return the factor of the effect."""
        return self._effect.friction_factor(vacuum, brake)


def list_effects(brake: Brake) -> tuple[Effect, ...]:
    """Return the effects that a brake states, by its keys and by [effects].

    They are kept in the record, which cannot change, with the record's identity, which a copy that
    is changed does not have.
    """
    effects: tuple[Effect, ...]
    owner, effects = brake.__dict__.get(_KEPT, (0, ()))
    if owner != id(brake):
        built_in = [effect for effect in BUILT_IN if effect.is_stated(brake)]
        further = [e if isinstance(e, Effect) else _Factor(e) for e in brake.effects]
        effects = (*built_in, *further)
        brake.__dict__[_KEPT] = id(brake), effects
    return effects


def pressure_on_sheets(vacuum: Any, brake: Brake) -> Any:
    """Return the pressure on the sheets [Pa] if the gauge reads a vacuum [Pa].

    It is lower than the vacuum if the vacuum does not reach the middle of the stack. The enclosure
    is pressed by the full vacuum, because the atmosphere acts on its other side.
    """
    for effect in list_effects(brake):
        vacuum = effect.sheet_pressure(vacuum, brake)
    return vacuum


def friction_factor(vacuum: Any, brake: Brake) -> Any:
    """Return the friction coefficient at a vacuum [Pa] with all effects, relative to the film's."""
    factor: Any = 1.0
    for effect in list_effects(brake):
        factor = factor * effect.friction_factor(vacuum, brake)
    return factor


def is_proportional(brake: Brake) -> bool:
    """Return whether the friction is known to be proportional to the vacuum."""
    effects = list_effects(brake)
    return not effects or all(effect.is_proportional for effect in effects)


def is_linear(brake: Brake) -> bool:
    """Return whether a stop has the closed form of the plain law.

    The friction is then proportional to vacuum and overlap and the same at every speed, and the
    enclosure has a single modulus.
    """
    return not any(
        effect.depends_on_slip or effect.depends_on_speed or effect.changes_enclosure
        for effect in list_effects(brake)
    ) and is_proportional(brake)


def depends_on_slip(brake: Brake) -> bool:
    """Return whether the brake states an effect that changes how friction falls with slip."""
    effects = list_effects(brake)
    return bool(effects) and any(effect.depends_on_slip for effect in effects)


def list_shapes(factor: Any, brake: Brake) -> tuple[Any, ...]:
    """Return how effects change the fall of friction with slip; `factor` is `friction_factor`."""
    effects = (effect for effect in list_effects(brake) if effect.depends_on_slip)
    return tuple(effect.make_shape(factor, brake) for effect in effects)


def require_linear(brake: Brake, caller: str) -> Brake:
    """Return the brake without a fan, for a `caller` that needs friction linear in slip.

    With spacers, the fan of a different brake is removed from the scale factor. Raises
    QuantityError for an effect that changes how friction falls with slip.
    """
    for effect in list_effects(brake):
        if effect.depends_on_slip and effect.is_active(brake):
            raise effect.refuse(caller)
    return remove_slip_effects(brake)


def remove_slip_effects(brake: Brake) -> Brake:
    """Return the brake with friction linear in slip: its scale factor without that of a fan.

    A brake that does not state whether it has spacers is unchanged.
    """
    for effect in list_effects(brake):
        if effect.depends_on_slip:
            brake = effect.remove(brake)
    return brake


def has_single_modulus(brake: Brake) -> bool:
    """Return whether the enclosure has a single modulus."""
    effects = list_effects(brake)
    return not effects or not any(effect.changes_enclosure for effect in effects)


def remove_fitted(brake: Brake) -> Brake:
    """Return the brake without the effects that a calibration fits."""
    for effect in list_effects(brake):
        if isinstance(effect, BuiltInEffect) and effect.is_fitted:
            brake = effect.remove(brake)
    return brake


def use_single_modulus(brake: Brake) -> Brake:
    """Return the brake with the single modulus of its enclosure."""
    for effect in list_effects(brake):
        if effect.changes_enclosure:
            brake = effect.remove(brake)
    return brake

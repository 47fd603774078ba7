"""Layout of a brake's stack: differences between interfaces, misaligned sheets, a housing."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import map_leaves
from layerjam.brake.mechanics.effects import list_effects
from layerjam.brake.mechanics.enclosure import enclosure_law
from layerjam.brake.mechanics.fan import is_flat
from layerjam.brake.mechanics.friction import friction_per_contact, sheet_law, static_law
from layerjam.brake.mechanics.stack.solve import Stack
from layerjam.brake.mechanics.stiffness import sheet_section, stiffness_sliding
from layerjam.core.errors import QuantityError, explain_arguments

Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True)
class FannedFriction:
    """Friction of interfaces between sheets that fan out; arrays of shape (n - 1,).

    Together the interfaces have the factor of the lumped law.
    The stack model needs friction that falls linearly with the slip. Each increment therefore uses
    the tangent to an interface's own friction at its current slip.
    """

    flat: Array
    """Kinetic friction at rest without fanning [N]."""
    length: Array
    """Overlap at rest [m]."""
    ratio: float
    """Ratio of static to kinetic friction of the film."""
    kinetic: tuple[Any, ...]
    """Effects of the slip on each interface (`SlipShape`)."""
    static: tuple[Any, ...]
    """The same under static friction."""

    def tangents(self, slip: Any) -> tuple[Array, Array, Array]:
        """Return friction [N] and length [m] of the tangents at a slip [m], and a ratio.

        A tangent is friction (1 - slip/length); the ratio is that of static to kinetic friction.
        """
        slip = np.clip(slip, 0.0, self.length * (1 - 1e-12))
        factor, shrink = _multiply_factors(self.kinetic, slip)
        overlap = self.length - slip
        unit = self.flat / self.length
        steep = factor + overlap * shrink
        reach = slip + overlap * factor / steep
        if self.ratio > 1:
            static_factor = _multiply_factors(self.static, slip)[0]
            return unit * steep * reach, reach, self.ratio * static_factor / factor
        return unit * steep * reach, reach, np.ones_like(reach)

    def apply_to_stack(self, slip: Any, stack: Stack) -> bool:
        """Write the tangents at a slip [m] into the stack's arrays, except the walls of a housing.

        `slip` has an entry for every interface of the stack. Returns False once no sheets overlap.
        """
        first, last = stack.ends
        friction, length, ratio = self.tangents(slip[first:last])
        stack.friction[first:last], stack.length[first:last] = friction, length
        if self.ratio > 1:
            stack.ratio[first:last] = ratio
        return bool((slip[first:last] < self.length * (1 - 1e-9)).any())

    put, lines = apply_to_stack, tangents  # former names


def _multiply_factors(shapes: tuple[Any, ...], slip: Array) -> tuple[Array, Array]:
    """Return the factor of each interface at its slip [m], and its decrease per metre of slip."""
    total, fall = np.ones_like(slip), np.zeros_like(slip)
    for shape in shapes:
        factor, shrink = shape.interface_factors(slip)
        total, fall = total * factor, fall * factor + total * shrink
    return total, fall


def add_fanning(
    brake: Brake, vacuum: float, flat: Array, length: Array, static: bool
) -> FannedFriction | None:
    """Return the friction of interfaces that carry `flat` [N] over `length` [m] without fanning.

    Returns None if the brake does not state whether it has spacers. Scatter and missing vacuum
    change an interface's own friction, but not the pressure from its neighbours. Raises
    QuantityError for sheets that fan out by more than 45 degrees.
    """
    kinetic, still = sheet_law(vacuum, brake).shapes, static_law(vacuum, brake).shapes
    if not kinetic:
        return None
    if not bool(is_flat(brake)):
        raise QuantityError.of("mount.spacers", "the sheets fan out by more than 45 degrees")
    ratio = float(brake.film.static / brake.film.kinetic) if static else 1.0
    plain, at_rest = map_leaves(np.float64, (kinetic, still))
    return FannedFriction(flat, length, ratio, plain, at_rest if static else plain)


@explain_arguments
@dataclass(frozen=True, kw_only=True)
class Interfaces:
    """Differences between the n - 1 interfaces; each entry is one number or one per interface.

    `friction` multiplies the friction of each interface, `vacuum` the vacuum that reaches it;
    `extra_overlap` [m] is added to its overlap. Combine several with ``dataclasses.replace``.
    """

    friction: float | Array = 1.0
    vacuum: float | Array = 1.0
    extra_overlap: float | Array = 0.0

    @classmethod
    def misaligned(cls, shifts: Array) -> "Interfaces":
        """Return the interfaces of sheets that protrude too far by `shifts` [m], shape (n,).

        An interface gains the overlap of both of its sheets. Free lengths are unchanged, because
        the parts of a sheet that stretch next to a neighbour's end are not modelled separately.
        """
        shifts = np.asarray(shifts, float)
        return cls(extra_overlap=shifts[:-1] + shifts[1:])

    @classmethod
    def missing_vacuum(cls, count: int, middle: float) -> "Interfaces":
        """Return the interfaces of `count` sheets, with a fraction `middle` of the vacuum midway.

        The fraction falls parabolically from 1 at the outermost interfaces (assumed: the effect of
        a uniform leak through sheets of the same resistance). The vacuum in an interface presses
        its sheets together, because the total pressure across the stack equals atmospheric
        pressure.
        """
        if not 0 <= middle <= 1:
            raise QuantityError(f"middle: {middle!r} is not a fraction; 0 to 1 is allowed")
        place = np.linspace(-1, 1, count - 1) if count > 2 else np.zeros(1)
        return cls(vacuum=1 - (1 - middle) * (1 - place**2))


@explain_arguments
@dataclass(frozen=True, kw_only=True)
class Housing:
    """Stiff housing that rubs on the outer side of the outermost sheets (layerjam's assumption).

    Each wall is fixed to the cap opposite to that of the sheet on which it rubs; on the sheet's own
    cap it would move with the sheet and only share its stretch. `friction` [N] of a wall at rest,
    one number or (first, last), has not been measured. Over the wall's
    `contact` length [m] it falls to zero as the sheet is drawn out; without a length (a lip, a
    guide) it is constant. `stiffness` [N/m] is that of a wall, by default a hundred times a
    sheet's.
    """

    friction: float | tuple[float, float]
    contact: float = np.inf
    stiffness: float = 1e8


def _expand_per_interface(values: float | Array, count: int, name: str) -> Array:
    array = np.asarray(values, float)
    if array.shape not in ((), (count,)):
        raise QuantityError(f"{name} has shape {array.shape}; use a number or {count} values")
    if not np.isfinite(array).all():
        raise QuantityError(f"{name}: every number must be finite")
    return np.broadcast_to(array, count).copy()


def make_stack(
    brake: Brake,
    vacuum: float,
    *,
    interfaces: Interfaces | None = None,
    housing: Housing | None = None,
    static: bool = False,
    one_by_one: bool = False,
    enclosure: bool = True,
    mount: float | None = None,
) -> Stack:
    """Return the stack of a brake at a vacuum [Pa].

    `static` uses table I's static friction before an interface moves; the paper and the lumped
    brake use kinetic friction throughout, and that of a housing is unknown. With `one_by_one`,
    interfaces that a breakaway overloads slip one at a time, the most overloaded first; otherwise,
    they slip together. `mount` [N/m] is by default such that the stack is as stiff as measured
    before onset, infinite if not measured. Raises QuantityError for interfaces or a housing that do
    not fit the brake, and for `one_by_one` without `static`.
    """
    if one_by_one and not static:
        raise QuantityError.of(
            "one_by_one", "without static friction no interface breaks away; set static too"
        )
    sheets, film = brake.sheets, brake.film
    count = int(sheets.count)
    layout = interfaces or Interfaces()
    right = np.arange(count) % 2 == 1
    free = np.where(right, sheets.free_right, sheets.free_left)
    springs = film.modulus * float(sheet_section(brake)) / free
    friction, length = _resting_interfaces(brake, vacuum, layout)
    face = enclosure_law(vacuum, brake)
    if mount is None:
        mount = np.inf
        if brake.stiffness_measured is not None:
            compliance = 1 / brake.stiffness_measured - 1 / float(stiffness_sliding(0.0, brake))
            mount = 1 / compliance if compliance > 0 else np.inf
    values = [float(face.stiffness), float(face.friction), float(face.reach)]
    stack = Stack(
        springs=springs,
        right=right,
        friction=friction.copy(),
        ratio=np.full(count - 1, film.static / film.kinetic if static else 1.0),
        length=length.copy(),
        mount=float(mount),
        ends=np.array([0, count - 1]),
        face=np.array(values if enclosure else [0.0, 0.0, 1.0]),
        one_by_one=one_by_one,
    )
    fan = add_fanning(brake, vacuum, friction, length, static)
    if fan is not None:
        fan.apply_to_stack(np.zeros(count - 1), stack)
    return stack if housing is None else _add_walls(stack, housing)


def make_fanned_friction(
    brake: Brake, vacuum: float, interfaces: Interfaces | None, static: bool
) -> FannedFriction | None:
    """Return friction of the interfaces that decreases with slip, or None if it is linear."""
    if not any(
        effect.depends_on_slip and effect.is_active(brake) for effect in list_effects(brake)
    ):
        return None
    friction, length = _resting_interfaces(brake, vacuum, interfaces or Interfaces())
    return add_fanning(brake, vacuum, friction, length, static)


def _resting_interfaces(brake: Brake, vacuum: float, layout: Interfaces) -> tuple[Array, Array]:
    """Return kinetic friction [N] and overlap [m] of the interfaces at rest, without fanning."""
    count = int(brake.sheets.count)
    pressure = vacuum * _expand_per_interface(layout.vacuum, count - 1, "interfaces.vacuum")
    share = _expand_per_interface(layout.friction, count - 1, "interfaces.friction")
    if (pressure < 0).any() or (share < 0).any():
        raise QuantityError("interfaces: friction and vacuum must not be negative")
    extra = _expand_per_interface(layout.extra_overlap, count - 1, "interfaces.extra_overlap")
    length = brake.sheets.overlap + extra
    if (length <= 0).any():
        raise QuantityError("interfaces.extra_overlap: some sheets would not overlap at all")
    friction = share * np.asarray(friction_per_contact(pressure, brake)) / (count - 1) * length
    return friction, length


def _add_walls(stack: Stack, housing: Housing) -> Stack:
    """Return the stack with a wall on either side; the enclosure stays on the sheets."""
    rub = np.broadcast_to(np.asarray(housing.friction, float), 2)
    if not (np.isfinite(rub).all() and (rub >= 0).all()):
        raise QuantityError(f"housing.friction: {housing.friction!r} N; 0 or more is allowed")
    if not (housing.contact > 0 and 0 < housing.stiffness < np.inf):
        raise QuantityError("housing: contact must be above 0; stiffness above 0 and finite")

    def surround(inner: Any, first: float, last: float) -> Any:
        return np.concatenate([[first], inner, [last]]).astype(inner.dtype)

    return stack._replace(
        springs=surround(stack.springs, housing.stiffness, housing.stiffness),
        right=surround(stack.right, not stack.right[0], not stack.right[-1]),
        friction=surround(stack.friction, *rub),
        ratio=surround(stack.ratio, 1.0, 1.0),
        length=surround(stack.length, housing.contact, housing.contact),
        ends=stack.ends + 1,
    )


fan_of_stack, stack_of, fanned_friction = make_fanned_friction, make_stack, add_fanning  # former

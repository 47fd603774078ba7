"""How a brake's stack is put together: interfaces that differ, misaligned sheets, a housing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from layerjam.device.brake import Brake
from layerjam.errors import QuantityError
from layerjam.mechanics.enclosure import enclosure_at
from layerjam.mechanics.fan import Fan, is_flat
from layerjam.mechanics.friction import friction_per_contact, sheets_at, static_at
from layerjam.mechanics.law import in_double_precision
from layerjam.mechanics.stack.solve import Stack
from layerjam.mechanics.stiffness import sheet_section, stiffness_sliding

Array = np.ndarray[Any, np.dtype[np.float64]]
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True)
class FannedFriction:
    """Interfaces between sheets that fan out; arrays of shape (n - 1,).

    The middle interfaces are pressed most: each has the mean of exp(alpha (1 - s^2)) over its share
    of the stack's half height s, so that all together have the factor of the lumped law. The stack
    model takes friction that falls along a straight line with the slip; it is given, increment by
    increment, the line that touches the interface's own friction where it has slipped to.
    """

    rest: Array
    """Kinetic friction at rest without a fan [N]."""
    length: Array
    """Overlap at rest [m]."""
    ratio: float
    """Static over kinetic friction, of the film."""
    kinetic: Fan
    static: Fan
    """The same fan under static friction."""

    def lines(self, slip: Any) -> tuple[Array, Array, Array]:
        """Friction [N] and length [m] of the lines that touch it at a slip [m], and static/kinetic.

        A line is friction (1 - slip/length).
        """
        slip = np.clip(slip, 0.0, self.length * (1 - 1e-12))
        factor, shrink = _of_interfaces(slip, self.kinetic)
        factor, shrink = factor / self.kinetic.held, shrink / self.kinetic.held
        left = self.length - slip
        unit = self.rest / self.length
        steep = factor + left * shrink
        reach = slip + left * factor / steep
        if self.ratio > 1:
            most = _of_interfaces(slip, self.static)[0] / self.static.held
            return unit * steep * reach, reach, self.ratio * most / factor
        return unit * steep * reach, reach, np.ones_like(reach)

    def put(self, slip: Any, stack: Stack) -> bool:
        """The lines at a slip [m] into the stack's arrays; a housing's walls keep theirs.

        `slip` has an entry for every interface of the stack. False once no sheets overlap.
        """
        first, last = stack.ends
        friction, length, ratio = self.lines(slip[first:last])
        stack.friction[first:last], stack.length[first:last] = friction, length
        if self.ratio > 1:
            stack.ratio[first:last] = ratio
        return bool((slip[first:last] < self.length * (1 - 1e-9)).any())


def _of_interfaces(slip: Array, fan: Fan) -> tuple[Array, Array]:
    """The factor of each interface at its slip [m], and what of it each metre of slip takes."""
    count = len(slip)
    middle = (2 * np.arange(count) + 1) / count - 1
    depth = 1 - (middle[:, None] + _NODES / count) ** 2
    left, right = fan.left + slip, fan.right + slip
    alpha = fan.strength * (1 / left + 1 / right)
    fades = fan.strength * (1 / left**2 + 1 / right**2)
    each = np.exp(alpha[:, None] * depth)
    return (each * _WEIGHTS).sum(1) / 2, fades * (each * depth * _WEIGHTS).sum(1) / 2


def fanned_friction(
    brake: Brake, vacuum: float, rest: Array, length: Array, static: bool
) -> FannedFriction | None:
    """The friction of interfaces that hold `rest` [N] over `length` [m] without a fan.

    None for a brake that does not say whether it has spacers. Scatter and missing vacuum change an
    interface's own friction, not how its neighbours press it. Raises QuantityError for a fan
    steeper than 45 degrees.
    """
    kinetic, still = sheets_at(vacuum, brake).fan, static_at(vacuum, brake).fan
    if kinetic is None or still is None:
        return None
    if not bool(is_flat(brake)):
        raise QuantityError.of("mount.spacers", "the sheets leave their caps at over 45 degrees")
    ratio = float(brake.film.static / brake.film.kinetic) if static else 1.0
    plain, most = (Fan(*map(float, fan)) for fan in (kinetic, still))
    return FannedFriction(rest, length, ratio, plain, most if static else plain)


@dataclass(frozen=True, kw_only=True)
class Interfaces:
    """How the n - 1 interfaces differ; each entry is one number or one an interface.

    `friction` multiplies the friction of each, `vacuum` the vacuum that reaches it, `extra_overlap`
    [m] is added to its overlap. For several at once: ``dataclasses.replace``.
    """

    friction: float | Array = 1.0
    vacuum: float | Array = 1.0
    extra_overlap: float | Array = 0.0

    @classmethod
    def misaligned(cls, shifts: Array) -> Interfaces:
        """Sheets that sit `shifts` [m], shape (n,), further out of their caps than they should.

        An interface overlaps by what both of its sheets are shifted; free lengths stay (the parts
        of a sheet that stretch beside a neighbour's end are not told apart).
        """
        shifts = np.asarray(shifts, float)
        return cls(extra_overlap=shifts[:-1] + shifts[1:])

    @classmethod
    def missing_vacuum(cls, count: int, middle: float) -> Interfaces:
        """A thick stack of `count` sheets whose middle gets only the share `middle` of the vacuum.

        The share falls like a parabola from 1 at the outermost interfaces (assumed: what a uniform
        leak through sheets that resist alike would leave). An interface is pressed by the vacuum
        in it, because the stack's pressure is the atmosphere all through.
        """
        if not 0 <= middle <= 1:
            raise QuantityError(f"middle: {middle!r} is not a share; 0 to 1 is allowed")
        place = np.linspace(-1, 1, count - 1) if count > 2 else np.zeros(1)
        return cls(vacuum=1 - (1 - middle) * (1 - place**2))


@dataclass(frozen=True, kw_only=True)
class Housing:
    """A stiff housing that rubs on the outer side of the outermost sheets (ours, assumed).

    Either wall hangs on the cap opposite to the sheet it rubs on; on the sheet's own cap it would
    move with the sheet and only share its stretch. `friction` [N] is what a wall holds at rest, one
    number or (first, last); nobody has measured it. Over the wall's `contact` length [m] it falls
    to zero as the sheet is drawn out; without one (a lip, a guide) it stays. `stiffness` [N/m] is a
    wall's own; the default is a hundred times a sheet's.
    """

    friction: float | tuple[float, float]
    contact: float = np.inf
    stiffness: float = 1e8


def _each(values: float | Array, count: int, name: str) -> Array:
    """One number an interface."""
    array = np.asarray(values, float)
    if array.shape not in ((), (count,)):
        raise QuantityError(f"{name}: {array.shape} numbers for {count} interfaces")
    if not np.isfinite(array).all():
        raise QuantityError(f"{name}: not all are finite numbers")
    return np.broadcast_to(array, count).copy()


@in_double_precision
def stack_of(
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
    """The stack of a brake at a vacuum [Pa].

    `static` takes table I's static friction before an interface moves (the paper and the lumped
    brake use the kinetic one throughout; of a housing it is not known). With `one_by_one` too the
    interfaces that a break overloads let go one by one, the most overloaded first, and otherwise
    together. `mount` [N/m] is by default what makes the stack as stiff as measured before onset;
    infinite where nothing was measured. Raises QuantityError for interfaces or a housing that do
    not fit the brake, and for `one_by_one` without `static`.
    """
    if one_by_one and not static:
        raise QuantityError.of(
            "one_by_one", "without static friction no interface breaks away; give static too"
        )
    sheets, film = brake.sheets, brake.film
    count = int(sheets.count)
    each = interfaces or Interfaces()
    right = np.arange(count) % 2 == 1
    free = np.where(right, sheets.free_right, sheets.free_left)
    springs = film.modulus * float(sheet_section(brake)) / free
    friction, length = _at_rest(brake, vacuum, each)
    face = enclosure_at(vacuum, brake)
    if mount is None:
        mount = np.inf
        if brake.stiffness_measured is not None:
            rest = 1 / brake.stiffness_measured - 1 / float(stiffness_sliding(0.0, brake))
            mount = 1 / rest if rest > 0 else np.inf
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
    fanned = fanned_friction(brake, vacuum, friction, length, static)
    if fanned is not None:
        fanned.put(np.zeros(count - 1), stack)
    return stack if housing is None else _housed(stack, housing)


def fan_of_stack(
    brake: Brake, vacuum: float, interfaces: Interfaces | None, static: bool
) -> FannedFriction | None:
    """How the friction of the interfaces goes on falling with their slip; None for a line."""
    if brake.mount.spacers is None or brake.mount.spacers:
        return None
    friction, length = _at_rest(brake, vacuum, interfaces or Interfaces())
    return fanned_friction(brake, vacuum, friction, length, static)


def _at_rest(brake: Brake, vacuum: float, each: Interfaces) -> tuple[Array, Array]:
    """Kinetic friction [N] and overlap [m] of the interfaces at rest, without a fan."""
    count = int(brake.sheets.count)
    pressure = vacuum * _each(each.vacuum, count - 1, "interfaces.vacuum")
    share = _each(each.friction, count - 1, "interfaces.friction")
    if (pressure < 0).any() or (share < 0).any():
        raise QuantityError("interfaces: friction and vacuum must not be negative")
    extra = _each(each.extra_overlap, count - 1, "interfaces.extra_overlap")
    length = brake.sheets.overlap + extra
    if (length <= 0).any():
        raise QuantityError("interfaces.extra_overlap: some interfaces would not overlap at all")
    friction = share * np.asarray(friction_per_contact(pressure, brake)) / (count - 1) * length
    return friction, length


def _housed(stack: Stack, housing: Housing) -> Stack:
    """The stack with a wall as one more sheet on either side; the enclosure stays on the sheets."""
    rub = np.broadcast_to(np.asarray(housing.friction, float), 2)
    if not (np.isfinite(rub).all() and (rub >= 0).all()):
        raise QuantityError(f"housing.friction: {housing.friction!r} N; 0 or more is allowed")
    if not (housing.contact > 0 and 0 < housing.stiffness < np.inf):
        raise QuantityError("housing: contact and stiffness must be above 0, stiffness finite")

    def around(inner: Any, first: float, last: float) -> Any:
        return np.concatenate([[first], inner, [last]]).astype(inner.dtype)

    return stack._replace(
        springs=around(stack.springs, housing.stiffness, housing.stiffness),
        right=around(stack.right, not stack.right[0], not stack.right[-1]),
        friction=around(stack.friction, *rub),
        ratio=around(stack.ratio, 1.0, 1.0),
        length=around(stack.length, housing.contact, housing.contact),
        ends=stack.ends + 1,
    )

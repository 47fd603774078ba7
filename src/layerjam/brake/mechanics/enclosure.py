"""The enclosure: elastic strips over the stack (paper, eq. 5, with x inside the root).

Two faces carry the force. A pull stretches a strip of stiffness EA against the friction q = mu_e W
P per unit length. The moving parts grow from both ends until they meet in the middle (saturation).
"""

from typing import Any, NamedTuple

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import xp
from layerjam.brake.mechanics.effects import has_single_modulus, list_effects
from layerjam.brake.mechanics.hyperelastic import FirstLoading, Strip, make_strip
from layerjam.brake.mechanics.law import keep_if, law, safe_sqrt


class EnclosureLaw(NamedTuple):
    """One face with a single modulus at a vacuum; the methods describe both in first loading.

    `hyperelastic.Strip` does the same for rubber. The coordinate w is the square root of the slip.
    """

    stiffness: Any
    """EA = E_e W w_e [N]."""
    friction: Any
    """q = mu_e W P [N/m]."""
    reach: Any
    """Half the free length l = (L1 + L2 + L3)/2 [m]."""
    root: Any
    """e = 2 sqrt(EA q) of both faces [N/sqrt(m)]."""
    saturation: Any
    """x* = q l^2/EA [m], the slip at which the whole face moves."""

    def force(self, slip: Any) -> Any:
        """Return f(x) [N] at a slip [m]: 2 sqrt(EA q x), then EA x/l + q l."""
        return first_loading(slip, self)

    def work(self, slip: Any) -> Any:
        """Return the integral of the force from 0 to a slip [J]."""
        start = xp.minimum(slip, self.saturation)
        spread = self.root * start * safe_sqrt(start) * (2 / 3)
        linear = self.stiffness * (slip + start) / (2 * self.reach)
        return spread + (linear + self.friction * self.reach) * (slip - start)

    def stored_energy(self, slip: Any) -> Any:
        """Return the elastic energy at a slip [J].

        It is a third of f x, which is half of the work, while part of the face rests. Beyond
        saturation it follows from the tension F - q s along the half length, s from 0 to l.
        """
        spread = self.root * slip * safe_sqrt(slip) / 3
        face, push = self.force(slip) / 2, self.friction * self.reach
        linear = 2 * self.reach * (face**2 - face * push + push**2 / 3) / self.stiffness
        return xp.where(slip < self.saturation, spread, linear)

    def slipped_area(self, slip: Any) -> Any:
        """Return the integral of slip along both faces [m^2].

        It is half of the work divided by q while part of the face rests. Beyond saturation every
        point moves with the cap, which adds l (x - x*).
        """
        start = xp.minimum(slip, self.saturation)
        q = xp.where(self.friction > 0, self.friction, 1.0)
        return self.root * start * safe_sqrt(start) / (3 * q) + self.reach * (slip - start)

    def heat(self, slip: Any) -> Any:
        """Return the friction heat at a slip [J], by integration."""
        return self.friction * self.slipped_area(slip)

    def stretch(self, slip: Any) -> Any:
        """Return the strain at the ends of the faces [-]."""
        return self.force(slip) / 2 / self.stiffness

    def find_slip(self, drive: Any, spring: Any) -> Any:
        """Return x >= 0 with spring x + f(x) = drive [N]; 0 for drive <= 0.

        Every segment of a pull solves this equation, on any branch of the enclosure.
        """
        root = spread_root(drive, spring, self)
        linear = xp.maximum(drive, 0.0) - self.friction * self.reach
        linear = linear / (spring + self.stiffness / self.reach)
        return xp.where(root**2 < self.saturation, root**2, xp.maximum(linear, 0.0))

    @property
    def limit(self) -> Any:
        """Return the largest valid coordinate."""
        return xp.inf

    @property
    def kink(self) -> Any:
        """Return the coordinate above which the whole enclosure moves; the slopes jump there."""
        return safe_sqrt(self.saturation)

    def find_place(self, slip: Any) -> Any:
        """Return the coordinate at a slip [m]; NaN beyond `limit`."""
        return safe_sqrt(slip)

    def point_at(self, w: Any) -> FirstLoading:
        """Return the enclosure at a coordinate, with slopes."""
        slip, linear = w**2, 2 * w * self.stiffness / self.reach
        slope = xp.where(slip < self.saturation, self.root, linear)
        elastic, heat = self.stored_energy(slip), self.heat(slip)
        return FirstLoading(slip, self.force(slip), elastic, heat, 2 * w, slope)


def enclosure_law(vacuum: Any, brake: Brake) -> EnclosureLaw:
    """Return the enclosure's constants at a vacuum [Pa]; QuantityError for a hyperelastic one."""
    stiffness, contact, reach = face_constants(brake)
    return make_enclosure(stiffness, contact * vacuum, reach)


def face_constants(brake: Brake) -> tuple[Any, Any, Any]:
    """Return EA [N], friction per unit of vacuum and length mu_e W [m], half the free length l [m].

    Raises QuantityError for a hyperelastic enclosure.
    """
    check_modulus(brake)
    sheets = brake.sheets
    stiffness = brake.enclosure.modulus * sheets.width * brake.enclosure.wall
    reach = (sheets.free_left + sheets.overlap + sheets.free_right) / 2
    return stiffness, brake.film.friction_on_silicone * sheets.width, reach


def check_modulus(brake: Brake) -> None:
    """Raise QuantityError for a brake whose enclosure is hyperelastic."""
    for effect in list_effects(brake):
        if effect.changes_enclosure:
            raise effect.refuse("this result")


def make_enclosure(stiffness: Any, friction: Any, reach: Any) -> EnclosureLaw:
    """Return an enclosure with EA [N], friction q [N/m] and half its free length l [m]."""
    root = 2 * safe_sqrt(stiffness * friction)
    return EnclosureLaw(stiffness, friction, reach, root, friction * reach**2 / stiffness)


def brake_enclosure(vacuum: Any, brake: Brake) -> EnclosureLaw | Strip:
    """Return the enclosure of a brake at a vacuum [Pa], by the law that the brake states."""
    return (enclosure_law if has_single_modulus(brake) else make_strip)(vacuum, brake)


def first_loading(slip: Any, enclosure: EnclosureLaw) -> Any:
    """Return the force [N] of both faces at a slip [m]; see `EnclosureLaw.force`."""
    spread = enclosure.root * safe_sqrt(slip)
    linear = enclosure.stiffness * slip / enclosure.reach + enclosure.friction * enclosure.reach
    return xp.where(slip < enclosure.saturation, spread, xp.where(slip > 0, linear, 0.0))


def spread_root(drive: Any, spring: Any, enclosure: EnclosureLaw) -> Any:
    """Return the square root of the slip of `find_slip` while part of the enclosure rests."""
    push = xp.maximum(drive, 0.0)
    divisor = enclosure.root + safe_sqrt(enclosure.root**2 + 4 * spring * push)
    return 2 * push / xp.where(divisor > 0, divisor, 1.0)


@law(of_points=True)
def enclosure_force(slip: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the enclosure's first-loading force [N] at a slip [m], vacuum [Pa] (corrected eq. 5).

    It is 2 sqrt(E A P mu W x) up to `saturation_slip`, and linear beyond (our "assumed closure").
    Its slope at zero slip is infinite; the gradient there is taken as zero. NaN for a negative slip
    or vacuum. With `[hyperelastic]` that law applies; NaN beyond the fitted strain.
    """
    return keep_if((slip >= 0) & (vacuum >= 0), brake_enclosure(vacuum, brake).force(slip))


@law
def saturation_slip(vacuum: Any, brake: Brake) -> Any:
    """Return the slip [m] above which the whole enclosure moves at a vacuum [Pa]."""
    return keep_if(vacuum >= 0, enclosure_law(vacuum, brake).saturation)


@law
def enclosure_stretch(slip: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the stretch [-] at the enclosure's end at a slip [m] and vacuum [Pa]: F/(EA) per face.

    It is 5.5 at 40 mm and full vacuum, but the modulus is stated at 1, so the law is used far
    outside its range.
    """
    domain = (slip >= 0) & (vacuum >= 0)
    return keep_if(domain, brake_enclosure(vacuum, brake).stretch(slip))

"""The enclosure: elastic strips over the stack (paper, eq. 5, with x inside the root).

Two faces carry the force. A pull stretches a strip of stiffness EA against the friction q = mu_e W
P per unit length. The moving parts grow from both ends until they meet in the middle (saturation).
"""

from typing import Any, NamedTuple

import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.errors import QuantityError
from layerjam.mechanics.hyperelastic import load_to_slip
from layerjam.mechanics.law import fuse, keep_if, law, safe_sqrt


class EnclosureLaw(NamedTuple):
    """Constants of the force law of one face of the enclosure at a vacuum."""

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
    if brake.hyperelastic is not None:
        raise QuantityError.of(
            "hyperelastic",
            "this result needs an enclosure with a single modulus; use the brake "
            "without [hyperelastic]. That law is supported for force, work, pulls and "
            "returns at a vacuum that does not fall, and for a stop at constant vacuum",
        )


def make_enclosure(stiffness: Any, friction: Any, reach: Any) -> EnclosureLaw:
    """Return an enclosure with EA [N], friction q [N/m] and half its free length l [m]."""
    root = 2 * safe_sqrt(stiffness * friction)
    return EnclosureLaw(stiffness, friction, reach, root, friction * reach**2 / stiffness)


@fuse
def backbone(slip: Any, enclosure: EnclosureLaw) -> Any:
    """Return f(x) [N] of both faces in first loading: 2 sqrt(EA q x), then EA x/l + q l."""
    spread = enclosure.root * safe_sqrt(slip)
    linear = enclosure.stiffness * slip / enclosure.reach + enclosure.friction * enclosure.reach
    return jnp.where(slip < enclosure.saturation, spread, jnp.where(slip > 0, linear, 0.0))


@fuse
def backbone_work(slip: Any, enclosure: EnclosureLaw) -> Any:
    """Return the integral of `backbone` from 0 to slip [J]."""
    start = jnp.minimum(slip, enclosure.saturation)
    spread = enclosure.root * start * safe_sqrt(start) * (2 / 3)
    rest_slip = slip - start
    linear = enclosure.stiffness * (slip + start) / (2 * enclosure.reach)
    linear = (linear + enclosure.friction * enclosure.reach) * rest_slip
    return spread + linear


@fuse
def backbone_stored(slip: Any, enclosure: EnclosureLaw) -> Any:
    """Return the elastic energy in both faces after first loading to slip [J].

    It is a third of f x, which is half of the work, while part of the face rests. Beyond saturation
    it follows from the tension F - q s along the half length, s from 0 to l.
    """
    spread = enclosure.root * slip * safe_sqrt(slip) / 3
    face = backbone(slip, enclosure) / 2
    q, reach = enclosure.friction, enclosure.reach
    linear = 2 * reach * (face**2 - face * q * reach + (q * reach) ** 2 / 3) / enclosure.stiffness
    return jnp.where(slip < enclosure.saturation, spread, linear)


@fuse
def slipped_area(slip: Any, enclosure: EnclosureLaw) -> Any:
    """Return the integral of slip along both faces [m^2] after first loading to slip.

    It is half of the work divided by q while part of the face rests. Beyond saturation every point
    moves with the cap, which adds l (x - x*).
    """
    start = jnp.minimum(slip, enclosure.saturation)
    q = jnp.where(enclosure.friction > 0, enclosure.friction, 1.0)
    return enclosure.root * start * safe_sqrt(start) / (3 * q) + enclosure.reach * (slip - start)


def backbone_dissipated(slip: Any, enclosure: EnclosureLaw) -> Any:
    """Return the friction heat of both faces in first loading to slip [J], by integration."""
    return enclosure.friction * slipped_area(slip, enclosure)


@fuse
def inverse_backbone(force: Any, enclosure: EnclosureLaw) -> Any:
    """Return the slip at which first loading carries `force` [N]."""
    at_saturation = 2 * enclosure.friction * enclosure.reach
    linear = (force - enclosure.friction * enclosure.reach) * enclosure.reach / enclosure.stiffness
    square = jnp.where(enclosure.root > 0, enclosure.root, 1.0) ** 2
    return jnp.where(force < at_saturation, force**2 / square, linear)


def first_loading(slip: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the first-loading force [N] of both faces at a slip [m] and vacuum [Pa]; any law."""
    if brake.hyperelastic is None:
        return backbone(slip, enclosure_law(vacuum, brake))
    return load_to_slip(slip, vacuum, brake)[1].force


def first_loading_energy(slip: Any, vacuum: Any, brake: Brake) -> tuple[Any, Any]:
    """Return work and heat [J] of both faces in first loading to a slip [m], by any law."""
    if brake.hyperelastic is None:
        enclosure = enclosure_law(vacuum, brake)
        return backbone_work(slip, enclosure), backbone_dissipated(slip, enclosure)
    loading = load_to_slip(slip, vacuum, brake)[1]
    return loading.stored + loading.heat, loading.heat


@law
def enclosure_force(slip: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the enclosure's first-loading force [N] at a slip [m], vacuum [Pa] (corrected eq. 5).

    It is 2 sqrt(E A P mu W x) up to `saturation_slip`, and linear beyond (our "assumed closure").
    Its slope at zero slip is infinite; the gradient there is taken as zero. NaN for a negative slip
    or vacuum. With `[hyperelastic]` that law applies; NaN beyond the fitted strain.
    """
    return keep_if((slip >= 0) & (vacuum >= 0), first_loading(slip, vacuum, brake))


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
    if brake.hyperelastic is not None:
        return keep_if((slip >= 0) & (vacuum >= 0), load_to_slip(slip, vacuum, brake)[0])
    enclosure = enclosure_law(vacuum, brake)
    return keep_if((slip >= 0) & (vacuum >= 0), backbone(slip, enclosure) / 2 / enclosure.stiffness)

"""Hyperelastic law of the enclosure's rubber, used instead of a single modulus."""

from collections.abc import Mapping
from typing import Any

from layerjam.core.conversion import Quantity
from layerjam.core.errors import QuantityError
from layerjam.core.units import quantity, record

_LIMIT = 1e9
_STEEPEST = 20.0


@record
class Hyperelastic:
    """W = C10 (I1 - 3) + C01 (I2 - 3) + C20 (I1 - 3)^2 + C30 (I1 - 3)^3 + Ogden's terms.

    An Ogden term is mu/alpha (l1^alpha + l2^alpha + l3^alpha - 3). Missing terms are zero. The
    rubber is incompressible; the law is valid in tension up to the fitted strain. It describes
    first loading; softer reloading follows Ogden and Roxburgh's eta = 1 - erf((W_max - W)/(m + beta
    W_max))/r (1999, Proc. R. Soc. Lond. A 455, 2861).
    """

    strain: Quantity[float] = quantity(
        "1", "largest strain that was fitted; the law is not used beyond it", lo=1e-3, hi=30
    )
    c10: Quantity[float | None] = quantity(
        "Pa", "coefficient of I1 - 3", lo=-_LIMIT, hi=_LIMIT, symbol="C10", default=None
    )
    c01: Quantity[float | None] = quantity(
        "Pa", "coefficient of I2 - 3", lo=-_LIMIT, hi=_LIMIT, symbol="C01", default=None
    )
    c20: Quantity[float | None] = quantity(
        "Pa", "coefficient of (I1 - 3)^2", lo=-_LIMIT, hi=_LIMIT, symbol="C20", default=None
    )
    c30: Quantity[float | None] = quantity(
        "Pa", "coefficient of (I1 - 3)^3", lo=-_LIMIT, hi=_LIMIT, symbol="C30", default=None
    )
    mu1: Quantity[float | None] = quantity(
        "Pa", "stress of the first Ogden term", lo=-_LIMIT, hi=_LIMIT, default=None
    )
    alpha1: Quantity[float | None] = quantity(
        "1", "exponent of the first Ogden term", lo=-_STEEPEST, hi=_STEEPEST, default=None
    )
    mu2: Quantity[float | None] = quantity(
        "Pa", "stress of the second Ogden term", lo=-_LIMIT, hi=_LIMIT, default=None
    )
    alpha2: Quantity[float | None] = quantity(
        "1", "exponent of the second Ogden term", lo=-_STEEPEST, hi=_STEEPEST, default=None
    )
    softening_r: Quantity[float | None] = quantity(
        "1",
        "softening after the first loading: 1/r is the largest loss of stress",
        lo=1.001,
        hi=1e6,
        symbol="r",
        default=None,
    )
    softening_m: Quantity[float | None] = quantity(
        "Pa", "energy density at which the stress has softened", lo=1, hi=_LIMIT, default=None
    )
    softening_beta: Quantity[float | None] = quantity(
        "1", "fraction of the largest previous energy that is added to m", hi=100, default=None
    )


NAMES: Mapping[str, Mapping[str, str]] = {
    "neo-hookean": {"C1": "c10"},
    "mooney-rivlin": {"C1": "c10", "C2": "c01"},
    "ogden-1": {"mu1": "mu1", "alpha1": "alpha1"},
    "yeoh": {"C1": "c10", "C2": "c20", "C3": "c30"},
    "ogden-2": {"mu1": "mu1", "alpha1": "alpha1", "mu2": "mu2", "alpha2": "alpha2"},
}
"""{model that `layerjam enclosure` fits: {its parameter: field}}, fewest parameters first."""
_STEPS = 2000
_SOFTENING = ("softening_r", "softening_m", "softening_beta")


def validate_hyperelastic(rubber: Hyperelastic) -> None:
    """Raise QuantityError for an incomplete Ogden term or softening law, or a falling stress."""
    for term in "12":
        mu, alpha = getattr(rubber, f"mu{term}"), getattr(rubber, f"alpha{term}")
        if (mu is None) != (alpha is None):
            raise QuantityError.of(
                f"hyperelastic.mu{term}", f"give it together with alpha{term}, or give neither"
            )
        if alpha == 0:
            raise QuantityError.of(f"hyperelastic.alpha{term}", "must not be zero")
    missing = [name for name in _SOFTENING if getattr(rubber, name) is None]
    if 0 < len(missing) < len(_SOFTENING):
        raise QuantityError.of(
            f"hyperelastic.{missing[0]}", f"give all of {', '.join(_SOFTENING)}, or none of them"
        )
    import numpy as np

    strains = rubber.strain * np.arange(_STEPS + 1) / _STEPS
    with np.errstate(all="ignore"):
        stresses = uniaxial_stress(strains, rubber, np)
        is_rising = np.isfinite(stresses[1:]) & (np.diff(stresses) > 0)
    if not is_rising.all():
        strain = strains[is_rising.argmin()]
        raise QuantityError.of(
            "hyperelastic",
            f"its stress does not rise at a strain of {strain:.3g}; it must rise up to "
            f"strain = {rubber.strain:g}",
        )


def uniaxial_stress(strain: Any, rubber: Hyperelastic, xp: Any) -> Any:
    """Return the engineering stress [Pa] in uniaxial tension, accurate also at small strains [-].

    `xp` is the library for the computation: NumPy or `jax.numpy`.
    """
    stretch, shear = 1 + strain, 0.0
    excess = strain**2 * (stretch + 2) / stretch
    for coefficient, term in (
        (rubber.c10, 1.0),
        (rubber.c01, 1 / stretch),
        (rubber.c20, 2 * excess),
        (rubber.c30, 3 * excess**2),
    ):
        if coefficient is not None:
            shear = shear + coefficient * term
    total = 2 * strain * (stretch**2 + stretch + 1) / stretch**2 * shear
    log = xp.log1p(strain)
    for mu, alpha in ogden_terms(rubber):
        total = total + mu * xp.exp(-(alpha / 2 + 1) * log) * xp.expm1(1.5 * alpha * log)
    return total


def uniaxial_slope(strain: Any, rubber: Hyperelastic, xp: Any) -> Any:
    """Return the slope of `uniaxial_stress` versus strain [Pa]."""
    stretch, shear, bend = 1 + strain, 0.0, 0.0
    excess = strain**2 * (stretch + 2) / stretch
    rise = 2 * strain * (stretch**2 + stretch + 1) / stretch**2  # slope of the excess
    for coefficient, term, steep in (
        (rubber.c10, 1.0, 0.0),
        (rubber.c01, 1 / stretch, -1 / stretch**2),
        (rubber.c20, 2 * excess, 2 * rise),
        (rubber.c30, 3 * excess**2, 6 * excess * rise),
    ):
        if coefficient is not None:
            shear, bend = shear + coefficient * term, bend + coefficient * steep
    total = 2 * (1 + 2 / stretch**3) * shear + rise * bend
    log = xp.log1p(strain)
    for mu, alpha in ogden_terms(rubber):
        side = (alpha - 1) * xp.exp((alpha - 2) * log)
        total = total + mu * (side + (alpha / 2 + 1) * xp.exp(-(alpha / 2 + 2) * log))
    return total


def ogden_terms(rubber: Hyperelastic) -> list[tuple[Any, Any]]:
    """Return (stress [Pa], exponent) for each Ogden term of the law."""
    terms = ((rubber.mu1, rubber.alpha1), (rubber.mu2, rubber.alpha2))
    return [(mu, alpha) for mu, alpha in terms if mu is not None]

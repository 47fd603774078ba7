"""Hyperelastic laws of an incompressible rubber in uniaxial tension: fits and selection.

Stretch λ = 1 + strain, engineering stress σ = dW/dλ, I1 = λ² + 2/λ:

    neo-hookean    W = C1 (I1 - 3)
    mooney-rivlin  W = C1 (I1 - 3) + C2 (I2 - 3)
    yeoh           W = C1 (I1 - 3) + C2 (I1 - 3)² + C3 (I1 - 3)³
    ogden-n        W = Σ μi/αi (λ1^αi + λ2^αi + λ3^αi - 3)

so that Young's modulus at rest is 6 C1, 6 (C1 + C2), 6 C1 and 3/2 Σ μi αi (Ogden 1972; Yeoh 1993).
Ogden's terms are fitted with μi αi ≥ 0, which makes them stable in every mode; without that bound,
two terms of opposite sign can cancel to any curve. The others are unbounded and checked.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from layerjam.brake.device.hyperelastic import NAMES, Hyperelastic, uniaxial_stress
from layerjam.core.brief import brief
from layerjam.core.errors import FitError, UnknownNameError
from layerjam.laboratory.measure.trace import Array

PARAMETERS = {model: tuple(names) for model, names in NAMES.items()}
"""{model: its parameters}, simplest first; C and mu are in Pa, alpha is dimensionless."""
FOLDS = 8
BINS = 400
_EXPONENTS = np.concatenate([np.arange(-10.0, 0.0, 0.5), np.arange(0.5, 14.1, 0.5)])
_LIMITS = (-15.0, 20.0)


@brief
@dataclass(frozen=True, kw_only=True)
class Fit:
    """One model fitted to a curve.

    `rmse` [Pa] is that of the whole curve, `cv_rmse` [Pa] that of blocks of strain excluded in turn
    (geometric mean over the blocks). `stable_to` is the strain in each mode up to which Drucker's
    condition holds in the fitted range, `error_at_100` the relative error at 100 % strain, or None.
    """

    model: str
    parameters: Mapping[str, float]
    initial_modulus: float
    rmse: float
    aicc: float
    cv_rmse: float
    cv_blocks: tuple[float, ...]
    stable: bool
    stable_to: Mapping[str, float]
    strain_range: tuple[float, float]
    error_at_100: float | None = None


def stress_basis(model: str, stretch: Array, exponents: Sequence[float] | Array = ()) -> Array:
    """Return the engineering stress per unit of each linear parameter, shape (N, parameters)."""
    strain = np.asarray(stretch)[..., None] - 1
    if model.startswith("ogden"):
        alpha: Any = np.asarray(exponents)
        return np.asarray(uniaxial_stress(strain, Hyperelastic(strain=1, mu1=1, alpha1=alpha), np))
    if model not in NAMES:
        raise UnknownNameError("hyperelastic model", model, PARAMETERS)
    units = [Hyperelastic(strain=1, **{name: 1}) for name in NAMES[model].values()]
    return np.concatenate([uniaxial_stress(strain, unit, np) for unit in units], axis=-1)


def stress(model: str, parameters: Mapping[str, float], strain: object) -> Array:
    """Return the engineering stress [Pa] at strains of any shape in uniaxial tension."""
    if model not in PARAMETERS:
        raise UnknownNameError("hyperelastic model", model, PARAMETERS)
    rubber = {parameter: parameters[name] for name, parameter in NAMES[model].items()}
    law = Hyperelastic(strain=1, **rubber)
    return np.asarray(uniaxial_stress(np.asarray(strain, float), law, np))


def initial_modulus(model: str, parameters: Mapping[str, float]) -> float:
    """Return Young's modulus at rest [Pa], three times the shear modulus."""
    if model.startswith("ogden"):
        count = len(parameters) // 2
        return 1.5 * sum(
            parameters[f"mu{i}"] * parameters[f"alpha{i}"] for i in range(1, count + 1)
        )
    return 6 * (parameters["C1"] + (parameters["C2"] if model == "mooney-rivlin" else 0.0))


def stability_limits(
    model: str, parameters: Mapping[str, float], top: float, points: int = 400
) -> dict[str, float]:
    """Return {mode: strain [-], at most `top`, up to which Drucker's condition holds}.

    That is, dτ:dε > 0 for every strain increment at constant volume: the second derivatives of W by
    the logarithmic strains (h1, h2; h3 = -h1 - h2) are positive definite. Modes: uniaxial tension,
    planar tension (h2 = 0) and equibiaxial tension (h2 = h1), each up to the same largest stretch.
    """
    h = np.log1p(np.linspace(0, top, points))
    out = {}
    for mode, second in (("uniaxial", -h / 2), ("planar", 0 * h), ("equibiaxial", h)):
        a, b, c = _energy_curvature(model, parameters, h, second)
        is_stable = (a > 0) & (c > 0) & (a * c - b * b > 0)
        first_bad = int(np.argmin(is_stable)) if not is_stable.all() else points
        out[mode] = float(np.expm1(h[first_bad - 1])) if first_bad else 0.0
    return out


def _energy_curvature(
    model: str, parameters: Mapping[str, float], h1: Array, h2: Array
) -> tuple[Array, Array, Array]:
    """Return W11, W12 and W22, the energy's second derivatives with respect to log strains."""

    def stretch_powers(a: float) -> tuple[Array, Array, Array]:
        return np.exp(a * h1), np.exp(a * h2), np.exp(-a * (h1 + h2))

    def term(weight: float | Array, a: float) -> tuple[Array, Array, Array]:
        e1, e2, e3 = stretch_powers(a)
        return weight * a * a * (e1 + e3), weight * a * a * e3, weight * a * a * (e2 + e3)

    p = parameters
    if model.startswith("ogden"):
        parts = [
            term(p[f"mu{i}"] / p[f"alpha{i}"], p[f"alpha{i}"]) for i in range(1, len(p) // 2 + 1)
        ]
    elif model == "mooney-rivlin":
        parts = [term(p["C1"], 2.0), term(p["C2"], -2.0)]
    else:
        e1, e2, e3 = stretch_powers(2.0)
        excess = e1 + e2 + e3 - 3
        c1, c2, c3 = p["C1"], p.get("C2", 0.0), p.get("C3", 0.0)
        bend = 2 * c2 + 6 * c3 * excess
        g1, g2 = 2 * (e1 - e3), 2 * (e2 - e3)
        parts = [
            term(c1 + 2 * c2 * excess + 3 * c3 * excess**2, 2.0),
            (bend * g1 * g1, bend * g1 * g2, bend * g2 * g2),
        ]
    a, b, c = (np.sum([part[i] for part in parts], axis=0) for i in range(3))
    return a, b, c


def _solve_linear(columns: Array, stress: Array) -> Array:
    """Return the linear parameters by least squares, scaled because powers of λ vary widely."""
    size = np.linalg.norm(columns, axis=0)
    return np.asarray(np.linalg.lstsq(columns / size, stress, rcond=None)[0] / size)


def _solve_nonnegative(exponents: Array, columns: Array, stress: Array) -> Array:
    """Return one or two of Ogden's mu, with mu times alpha not negative.

    `columns` of shape (N, exponents) are the stresses per unit of each mu.
    """
    columns = columns * np.sign(exponents)
    size = np.linalg.norm(columns, axis=0)
    columns = columns / size
    project = columns.T @ stress
    weights = np.maximum(project, 0.0)
    if len(weights) == 2:
        cross = float(columns[:, 0] @ columns[:, 1])
        pair_weights = (project - cross * project[::-1]) / max(1 - cross**2, 1e-14)
        single_weights = weights * (weights >= weights.max())
        weights = pair_weights if (pair_weights >= 0).all() else single_weights
    return np.asarray(weights / size * np.sign(exponents))


def least_squares(
    model: str, strain: Array, stress: Array, guess: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Return the parameters that minimise the squared residuals of engineering stress.

    Ogden's exponents are first searched over a grid, because the sum of squares has several minima.
    They are then refined; each step solves for linear parameters. `guess` replaces the grid.
    """
    stretch = 1 + strain
    if not model.startswith("ogden"):
        values = _solve_linear(stress_basis(model, stretch), stress)
        return dict(zip(PARAMETERS[model], map(float, values), strict=True))
    from scipy.optimize import least_squares as refine

    terms = int(model[-1])

    def residual(exponents: Array) -> Array:
        columns = stress_basis(model, stretch, exponents)
        return columns @ _solve_nonnegative(exponents, columns, stress) - stress

    starts = _list_exponents(stretch, stress, terms)
    if guess is not None:
        starts = [np.array([guess[f"alpha{i + 1}"] for i in range(terms)])]
    tolerances = {"xtol": 1e-10, "ftol": 1e-12, "gtol": 1e-14, "max_nfev": 60}
    minima = [
        refine(residual, start, bounds=_LIMITS, x_scale=1.0, **tolerances) for start in starts
    ]
    best = min(minima, key=lambda one: float(one.cost))
    order = np.argsort(best.x)
    exponents = best.x[order]
    linear = _solve_nonnegative(exponents, stress_basis(model, stretch, exponents), stress)
    return {
        name: float(value)
        for i in range(terms)
        for name, value in ((f"mu{i + 1}", linear[i]), (f"alpha{i + 1}", exponents[i]))
    }


def _list_exponents(stretch: Array, stress: Array, terms: int, count: int = 3) -> list[Array]:
    """Return the best few grid points of exponents, with mu times alpha not negative."""
    columns = stress_basis("ogden-n", stretch, list(_EXPONENTS)) * np.sign(_EXPONENTS)
    columns = columns / np.linalg.norm(columns, axis=0)
    project = columns.T @ stress
    if terms == 1:
        return [_EXPONENTS[[i]] for i in np.argsort(-project)[:count]]
    gram = columns.T @ columns
    i, j = np.triu_indices(len(_EXPONENTS), 2)
    cross, first, second = gram[i, j], project[i], project[j]
    independent = np.maximum(1 - cross**2, 1e-9)
    is_positive = (first - cross * second >= 0) & (second - cross * first >= 0)
    pair = (first**2 + second**2 - 2 * cross * first * second) / independent
    gain = np.where(is_positive, pair, np.maximum(first, second).clip(0) ** 2)
    order = np.argsort(-gain)[:count]
    return [_EXPONENTS[[i[k], j[k]]] for k in order]


def bin_by_strain(strain: Array, stress: Array, bins: int = BINS) -> tuple[Array, Array]:
    """Return means over at most `bins` equal parts of strain, whatever their sampling density."""
    order = np.argsort(strain, kind="stable")
    strain, stress = strain[order], stress[order]
    if len(strain) <= bins:
        return strain, stress
    edges = np.linspace(strain[0], strain[-1], bins + 1)
    part = np.clip(np.searchsorted(edges, strain, side="right") - 1, 0, bins - 1)
    count = np.bincount(part, minlength=bins)
    kept = count > 0
    return (
        np.bincount(part, strain, bins)[kept] / count[kept],
        np.bincount(part, stress, bins)[kept] / count[kept],
    )


def fit_model(model: str, strain: Array, stress_measured: Array) -> Fit:
    """Fit one model to a curve of shape (N,), N at least 20, with ascending strain.

    Raises FitError for fewer samples. The corrected Akaike criterion assumes independent residuals,
    but those of a misfit never are. It is reported, but cross-validation determines the choice.
    """
    if len(strain) < 20:
        raise FitError(f"a hyperelastic fit needs at least 20 samples; there are {len(strain)}")
    x, y = bin_by_strain(strain, stress_measured)
    parameters = least_squares(model, x, y)
    residuals = stress(model, parameters, x) - y
    n, k = len(x), len(PARAMETERS[model]) + 1
    blocks = []
    for part in np.array_split(np.arange(n), FOLDS):
        kept_indices = np.delete(np.arange(n), part)
        fold_fit = least_squares(model, x[kept_indices], y[kept_indices], parameters)
        blocks.append(float(np.sqrt(np.mean((stress(model, fold_fit, x[part]) - y[part]) ** 2))))
    top = float(x[-1])
    stable_to = stability_limits(model, parameters, top)
    floor = 1e-12 * float(np.max(np.abs(y)))
    mean_square = max(float(np.mean(residuals**2)), floor**2)
    error_at_100 = None
    if x[0] <= 1 <= top:
        stress_at_100 = float(np.interp(1.0, x, y))
        error_at_100 = (
            float(stress(model, parameters, 1.0)) / stress_at_100 - 1 if stress_at_100 else None
        )
    return Fit(
        model=model,
        parameters=parameters,
        initial_modulus=initial_modulus(model, parameters),
        rmse=float(np.sqrt(np.mean(residuals**2))),
        aicc=float(n * np.log(mean_square) + 2 * k + 2 * k * (k + 1) / (n - k - 1)),
        cv_rmse=float(np.exp(np.mean(np.log(np.maximum(blocks, floor))))),
        cv_blocks=tuple(blocks),
        stable=stable_to["uniaxial"] >= top * (1 - 1e-9),
        stable_to=stable_to,
        strain_range=(float(x[0]), top),
        error_at_100=error_at_100,
    )


def fit_models(strain: Array, stress_measured: Array) -> dict[str, Fit]:
    """Fit every model to one curve, in order of the number of parameters."""
    return {model: fit_model(model, strain, stress_measured) for model in PARAMETERS}


def choose_model(fits: Mapping[str, Fit]) -> tuple[str, str]:
    """Return (model, reason): the simplest stable model that predicts excluded blocks well.

    That is, log(error/error of the best) averages less than two standard errors over the blocks.
    """
    usable = {m: f for m, f in fits.items() if f.stable} or dict(fits)
    floor = 1e-9 * max(f.cv_rmse for f in usable.values()) + 1e-300
    best = min(usable, key=lambda m: usable[m].cv_rmse)
    for model in usable:
        ratio = np.log(
            np.maximum(usable[model].cv_blocks, floor) / np.maximum(usable[best].cv_blocks, floor)
        )
        if model == best or ratio.mean() <= 2 * ratio.std(ddof=1) / np.sqrt(len(ratio)):
            break
    unstable = [m for m, f in fits.items() if not f.stable]
    reason = (
        f"{model} has the lowest cross-validation error ({FOLDS} blocks of strain)"
        if model == best
        else f"{model} is the simplest model whose cross-validation error ({FOLDS} blocks of "
        f"strain) is within two standard errors of the lowest, that of {best}"
    )
    if unstable and len(unstable) < len(fits):
        reason += f"; excluded because unstable in tension over the curve: {', '.join(unstable)}"
    elif unstable:
        reason += "; no model is stable in tension over the whole curve"
    return model, reason

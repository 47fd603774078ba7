"""Evidence of a calibration for a brake's file: uncertainty, scatter and tested range."""

import math
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

import numpy as np
import numpy.typing as npt

from layerjam.brake.device.brake_file import BrakeFile, updated_text
from layerjam.brake.device.evidence import Evidence, Matrix, Part, as_tuples, state_fitted
from layerjam.brake.device.spread import EXPONENT_SD, PRIOR_DEGREES, REPEAT_SD
from layerjam.core.toml_files.source import Source
from layerjam.laboratory.identify.calibration.law_spread import LawSpread
from layerjam.laboratory.identify.calibration.mountings import FEWEST, SCATTER
from layerjam.laboratory.identify.calibration.result import Calibration
from layerjam.laboratory.identify.shape import SHAPE

Array = npt.NDArray[np.float64]
Changes = Mapping[str, tuple[Any, Source] | None]
SHAPE_NAMES = ("scale_factor", "stiffness_measured", "enclosure_force")
"""Names in the evidence of the parameters `SHAPE`."""
EXPONENT = "pressure_exponent"
FEWEST_LEVERAGE = 1e-4
"""Sum of squares of the deviations of ln(vacuum) below which pulls show no exponent."""
PRIOR_TEST = np.diag([REPEAT_SD["kinetic"] ** 2, REPEAT_SD["kinetic"] ** 2, 0.0])
"""Assumed scatter of pulls of one mounting."""
# the enclosure's force is uncertain, but does not change with the mounting
PRIOR_MOUNTING = np.diag([SCATTER[SHAPE[0]] ** 2, SCATTER[SHAPE[1]] ** 2, 0.0])
"""Assumed scatter of mountings."""
Parts = list[tuple[str, Array, float]]
"""Rows of (of, covariance, degrees of freedom), as in `Part`."""


def make_calibration_evidence(
    file: BrakeFile, calibration: Calibration, changes: Changes, date: str | None = None
) -> Evidence:
    """Return the evidence of pulls of a brake; `changes` are the values written into its file.

    A further pull scatters like the pulls about their law. A further mounting scatters like the
    stated mountings if there are enough, otherwise by the scatter that is assumed between them.
    """
    spread = LawSpread.from_calibration(calibration)
    names: tuple[str, ...]
    if spread is None:
        names, parts = SHAPE_NAMES, _assume_parts(calibration)
    else:
        names = (*SHAPE_NAMES, *(name for name in spread.names if name == EXPONENT))
        parts = _find_parts(calibration, spread)
    labels = [c.mounting for c in calibration.curves]
    return Evidence(
        command="calibrate",
        date=date or datetime.now(UTC).date().isoformat(),
        tests=len(calibration.curves),
        mountings=len(set(labels)) if None not in labels else None,
        names=names,
        parts=tuple(Part(part, _pad(matrix, len(names)), nu) for part, matrix, nu in parts),
        exponent_sd=None if EXPONENT in names else _open_exponent(calibration, parts),
        reference_pressure=None if spread is None else _finite_or_none(spread.reference_pressure),
        ranges=_find_ranges(file, calibration),
        fitted=state_fitted("calibrate", file.known_values, changes),
    )


def apply_calibration(file: BrakeFile, calibration: Calibration) -> BrakeFile:
    """Return the file as `calibrate` writes it: with the fitted numbers and their evidence."""
    changes = calibration.sources
    evidence = make_calibration_evidence(file, calibration, changes)
    return BrakeFile.read(updated_text(file, file.name, changes, evidence=evidence), file.name)


def _assume_parts(calibration: Calibration) -> Parts:
    """Return the parts if the pulls show no scatter, because there is only one."""
    common = np.diag([calibration.common_errors.get(name, 0.0) ** 2 for name in SHAPE])
    # with a stronger enclosure, the sheets carry a smaller part of the same peak
    sleeve = calibration.contributions[1]
    common[2, 2] = (sleeve.standard or 0.0) ** 2
    common[0, 2] = common[2, 0] = sleeve.sensitivity * common[2, 2]
    return [
        ("mean", PRIOR_TEST, PRIOR_DEGREES),
        *_split_common(common, 1),
        ("test", PRIOR_TEST, PRIOR_DEGREES),
        ("mounting", PRIOR_MOUNTING, PRIOR_DEGREES),
    ]


def _split_common(common: Array, mountings: int | None) -> Parts:
    """Return the errors that all pulls share, with those of assumed mountings apart.

    `mountings` is the number of mountings of the pulls if too few to show their scatter.
    """
    if mountings is None:
        return [("mean", _keep_positive(common), math.inf)]
    assumed = np.zeros_like(common)
    for place in range(2):
        assumed[place, place] = min(PRIOR_MOUNTING[place, place] / mountings, common[place, place])
    return [
        ("mean", _keep_positive(common - assumed), math.inf),
        ("mean", assumed, PRIOR_DEGREES),
    ]


def _pool(matrix: Array, degrees: float, prior: Array) -> tuple[Array, float]:
    """Return a scatter with its degrees of freedom, pooled with the one that is assumed."""
    total = degrees + PRIOR_DEGREES
    return (degrees * matrix + PRIOR_DEGREES * prior) / total, total


def _find_parts(calibration: Calibration, spread: LawSpread) -> Parts:
    """Return the parts of the uncertainty that pulls show, and that of assumed mountings."""
    indices = [0, 1, 2, *(place for place, name in enumerate(spread.names) if name == EXPONENT)]
    scales = np.ones(len(indices))
    scales[2] = 1 / spread.estimate[2]  # the enclosure in the file already includes the factor
    covariance = spread.covariance[np.ix_(indices, indices)] * np.outer(scales, scales)
    total = spread.scatter * np.outer(scales[:3], scales[:3])
    # errors that all pulls share, such as the enclosure's and the load cell's, are stated
    common = np.zeros_like(covariance)
    for place, name in enumerate(SHAPE):
        common[place, place] = calibration.common_errors.get(name, 0.0) ** 2
    if calibration.fit is None:
        common[:, 2], common[2, :] = covariance[:, 2], covariance[2, :]
    free = len(indices) - 2
    count, groups = len(calibration.curves), calibration.mountings
    labels = {c.mounting for c in calibration.curves}
    is_assumed = None in labels or len(labels) < FEWEST
    mean_scatter = _keep_positive(covariance - common)
    mean_degrees = float(max(len(groups) - free, 1))
    if free > 1:
        interval = calibration.intervals.get(EXPONENT)
        mean_degrees = mean_degrees if interval is None else interval.degrees_of_freedom
    else:
        prior = PRIOR_TEST / count + (0.0 if is_assumed else PRIOR_MOUNTING / len(labels))
        mean_scatter, mean_degrees = _pool(mean_scatter, mean_degrees, prior)
    mountings = (1 if None in labels else len(labels)) if is_assumed else None
    parts = [("mean", mean_scatter, mean_degrees), *_split_common(common, mountings)]
    degrees = float(max(count - free, 1))
    if is_assumed:
        return [
            *parts,
            ("test", *_pool(total, degrees, PRIOR_TEST)),
            ("mounting", PRIOR_MOUNTING, PRIOR_DEGREES),
        ]
    return [*parts, *_split_scatter(calibration, total, degrees)]


def _split_scatter(calibration: Calibration, total: Array, degrees: float) -> Parts:
    """Return the scatter within and between stated mountings.

    If each pull has its mean_scatter mounting, the scatter of pulls includes that of mountings.
    """
    groups, count = calibration.mountings, len(calibration.curves)
    joint_part: Parts = [("test", *_pool(total, degrees, PRIOR_TEST + PRIOR_MOUNTING))]
    fits = {fit.pull.path: fit for fit in calibration.fits}
    if len(groups) == count or len(groups) < FEWEST or len(fits) < count:
        return joint_part
    pull_fits = [fits[curve.path] for curve in calibration.curves if curve.path in fits]
    logs = np.array([(fit.scale_factor, fit.stiffness or math.nan) for fit in pull_fits])
    if len(pull_fits) < count or not np.isfinite(logs).all():
        return joint_part
    logs = np.log(logs)
    means = np.array([logs[list(group)].mean(axis=0) for group in groups])
    inner_deviations = np.concatenate(
        [logs[list(g)] - m for g, m in zip(groups, means, strict=True)]
    )
    freedom = count - len(groups)
    test_scatter, mounting_scatter = np.zeros((3, 3)), np.zeros((3, 3))
    # the mean of m pulls contains 1/m of the scatter within a mounting
    test_scatter[:2, :2] = (inner_deviations.T @ inner_deviations) / freedom
    mounting_scatter[:2, :2] = np.cov(means.T)
    test_scatter, test_degrees = _pool(test_scatter, float(freedom), PRIOR_TEST)
    part = len(groups) / count
    prior = PRIOR_MOUNTING + part * PRIOR_TEST
    return [
        ("test", (1 - part) * test_scatter, test_degrees),
        ("mounting", *_pool(mounting_scatter, float(len(groups) - 1), prior)),
    ]


def _keep_positive(matrix: Array) -> Array:
    """Return the nearest covariance to a matrix that rounding or a difference made indefinite."""
    values, axes = np.linalg.eigh((matrix + matrix.T) / 2)
    return np.asarray((axes * np.maximum(values, 0.0)) @ axes.T)


def _open_exponent(calibration: Calibration, parts: Parts) -> float | None:
    """Return the SD about zero of a pressure exponent, after pulls at several vacuums.

    The law has none, so what the pulls show of one counts as an error, like what they leave open.
    """
    fits = [fit for fit in calibration.fits if fit.vacuum > 0]
    if not fits:
        return None
    vacuums = np.log([fit.vacuum for fit in fits])
    vacuums -= vacuums.mean()
    leverage = float(vacuums @ vacuums)
    if leverage < FEWEST_LEVERAGE:
        return None
    slope = float(vacuums @ np.log([fit.scale_factor for fit in fits])) / leverage
    variances = {kind: _sum_variances(parts, kind) for kind in ("test", "mounting")}
    mounting_of = {curve.path: curve.mounting for curve in calibration.curves}
    sums: dict[int | None, float] = {}
    for fit, vacuum in zip(fits, vacuums, strict=True):
        label = mounting_of.get(fit.pull.path)
        sums[label] = sums.get(label, 0.0) + float(vacuum)
    shares = sum(total**2 for total in sums.values())
    error = variances["test"] / leverage + variances["mounting"] * shares / leverage**2
    weight = EXPONENT_SD**2 / (EXPONENT_SD**2 + error)
    return math.hypot(math.sqrt(weight * error), weight * slope)


def _sum_variances(parts: Parts, kind: str) -> float:
    return sum(float(matrix[0, 0]) for part, matrix, _ in parts if part == kind)


def _find_ranges(file: BrakeFile, calibration: Calibration) -> dict[str, tuple[float, float]]:
    curves = calibration.curves
    slips = [float(np.max(c.elongation - c.force / calibration.stiffness)) for c in curves]
    speeds = [float(c.speed) for c in curves if c.speed is not None]
    share = 1.0 if file.brake.vacuum_share is None else file.brake.vacuum_share
    ranges = {
        "vacuum": [share * c.vacuum for c in curves],
        "slip": [0.0, max([0.0, *slips])],
        "force": [0.0, *(float(c.force.max()) for c in curves)],
        **({"speed": speeds} if speeds else {}),
    }
    return {name: (float(min(values)), float(max(values))) for name, values in ranges.items()}


def _finite_or_none(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _pad(matrix: Array, size: int) -> Matrix:
    square = np.zeros((size, size))
    square[: len(matrix), : len(matrix)] = matrix
    return as_tuples(square)

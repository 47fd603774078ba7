"""Scatter of a run that no law solves: repeated with a few numbers changed, and interpolated."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import map_leaves
from layerjam.brake.simulate.prediction import Deviations, Prediction, change_numbers

Array = npt.NDArray[np.float64]
FRICTION_LEVELS = (0.005, 0.025, 0.5, 0.975, 0.995)
"""Quantiles of the friction at which a run is repeated."""
LEVELS = (0.025, 0.5, 0.975)
"""Quantiles of stiffness, enclosure force and static friction at which it is repeated."""


def interpolate_samples(
    prediction: Prediction,
    run: Callable[[Brake], Mapping[str, float]],
    has_static: bool = False,
    law_samples: Mapping[str, Array] | None = None,
) -> dict[str, Array]:
    """Return the numbers of all samples from runs with a few values of each uncertain number.

    `run` returns the numbers {key: value in SI} of a brake, infinite if the run has none. Friction,
    stiffness and enclosure force each change while the others have their median, and the changes
    add up. With `has_static`, the ratio of static to kinetic friction changes too. `law_samples`
    are the numbers of all samples by a law of kinetic friction; then only that ratio changes.
    """
    base, moves = prediction.device or prediction.file.brake, prediction.deviations
    logs = {
        "scale_factor": moves.scale_factor + moves.kinetic,
        "stiffness_measured": moves.stiffness_measured,
        "enclosure_force": moves.enclosure_force,
        "static": (moves.static - moves.kinetic) * has_static,
    }
    changes = logs if law_samples is None else {"static": logs["static"]}
    middle = {name: float(np.median(values)) for name, values in logs.items()}

    def find_numbers(changes: Mapping[str, float]) -> Mapping[str, float]:
        sample_brake = change_numbers(base, Deviations(**changes, kinetic=0.0))
        return run(map_leaves(_to_float, sample_brake))

    usual = find_numbers(middle)
    totals = {
        key: np.full(prediction.samples, value) if law_samples is None else law_samples[key].copy()
        for key, value in usual.items()
    }
    for name, values in changes.items():
        levels = FRICTION_LEVELS if name == "scale_factor" else LEVELS
        nodes = np.unique(prediction.quantiles(values, levels))
        if np.ptp(nodes) == 0:
            continue
        runs = [
            usual if node == middle[name] else find_numbers({**middle, name: float(node)})
            for node in nodes
        ]
        for key in usual:
            row = [numbers[key] for numbers in runs]
            change = np.interp(values, nodes, row) - np.interp(middle[name], nodes, row)
            totals[key] += change
    return {key: np.nan_to_num(total, nan=np.inf) for key, total in totals.items()}


def _to_float(value: Any) -> Any:
    """Return a number of NumPy as one of Python, for which programs are already compiled."""
    return float(value) if isinstance(value, np.floating) else value

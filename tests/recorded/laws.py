"""Recorded numbers of the public laws: random brakes of each family, and histories."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from types import FrameType
from typing import Any

import numpy as np

from law_cases import FAMILIES, LAWS, MARCHING, cases, on_numpy
from layerjam import laws
from layerjam.brake.mechanics import arrays
from layerjam.core.errors import QuantityError
from strategies import KAPTON

BRAKES = 6
SMALL = 1e-9
"""Sizes relative to the largest of an array, below which a number may be rounding."""
TURNS = (0.0, 9e-3, 6e-3, 8e-3, 2e-3, 15e-3, 11e-3, 20e-3, 0.0)
TIMES, FALLING = np.array([0.0, 4e-3, 60e-3]), np.array([7e4, 6e4, 1e4])


def list_law_numbers(family: str) -> dict[str, float | str]:
    """Return the recorded numbers of all laws for one family of brakes, or for histories."""
    if family == "marches":
        return {f"{name}.{key}": value for name, array in marches() for key, value in totals(array)}
    return dict(family_laws(family))


def family_laws(family: str) -> Iterator[tuple[str, float]]:
    """Yield totals of the columns of each law, and the steps of its loops."""
    seed = list(FAMILIES).index(family)
    brakes, count = FAMILIES[family](seed), 2 if "rubber" in family else BRAKES
    for name in LAWS:
        if (family, name) not in MARCHING:
            try:
                with count_steps() as steps:
                    columns = on_numpy(name, cases(name, seed), brakes, count)
            except QuantityError:  # it does not apply to this family
                continue
            yield f"{name}.steps", float(len(steps))
            for place, column in enumerate(columns):
                yield from ((f"{name}.{place}.{key}", value) for key, value in totals(column))


@contextlib.contextmanager
def count_steps() -> Iterator[list[None]]:
    """Yield a list with an item for each step of a loop of the laws: slower searches have more."""
    steps: list[None] = []
    loops = {arrays.repeat.__code__, arrays.repeat_while.__code__}

    def count(frame: FrameType, event: str, _: object) -> None:
        if event == "call" and frame.f_back is not None and frame.f_back.f_code in loops:
            steps.append(None)

    before = sys.getprofile()
    sys.setprofile(count)
    try:
        yield steps
    finally:
        sys.setprofile(before)


def marches() -> Iterator[tuple[str, np.ndarray]]:
    """Histories and a stop under a vacuum that changes."""
    path = np.interp(np.arange(64), np.linspace(0, 63, len(TURNS)), TURNS)
    vacuum = np.interp(np.arange(64), [0, 20, 40, 50, 63], [5e4, 5e4, 3e4, 6e4, 2e4])
    results: dict[str, Any] = {
        "brake_cycle": laws.brake_cycle(path, vacuum, KAPTON),
        "enclosure_cycle": laws.enclosure_cycle(path, vacuum, KAPTON),
        "stop_in_time": laws.stop_in_time(
            1.3, 1.6, FALLING, TIMES, 3e4, None, 9.8, 2e-5, 20_000.0, KAPTON
        ),
    }
    for name, result in results.items():
        fields = result._asdict() if hasattr(result, "_asdict") else dict(enumerate(result))
        for field, values in fields.items():
            if values is not None and not hasattr(values, "_fields"):
                yield f"{name}.{field}", np.asarray(values, float)


def totals(array: np.ndarray, small: float = SMALL) -> Iterator[tuple[str, float]]:
    """Yield how many numbers are finite and positive, and the sum of their logarithms.

    A number that changes by a millionth changes the sum by as much, however small it is. `small` is
    the size, relative to the largest, below which a number may be rounding.
    """
    finite = array[np.isfinite(array)]
    large = finite[np.abs(finite) > small * np.abs(finite).max(initial=0.0)]
    yield "finite", float(finite.size)
    yield "positive", float((large > 0).sum())
    yield "logarithms", float(np.log(np.abs(large)).sum())

"""Intervals of a batch: a law for samples of the brake's uncertain numbers, case by case."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.stop.algebra import NOT_A_CASE, SNAPS
from layerjam.brake.simulate.prediction import LEVEL, Prediction
from layerjam.core.errors import QuantityError

Array = np.ndarray[Any, Any]
Run = Callable[[int, int, Mapping[str, Array]], None]
"""Function that evaluates `count` flat cases, starting with `first`, into arrays of that length."""
BLOCK, BATCH_SAMPLES = 500, 250
"""Number of cases that are evaluated at once, and of samples for each."""
ENDS = ("low", "high")
TESTED, OUTCOME = "tested", "outcome"


@dataclass(frozen=True)
class Sweep:
    """One quantity of a batch: its dimension, its values and its stride over the flat grid."""

    name: str
    dimension: str | None
    values: Array = field(repr=False)
    stride: int = 1

    def take_cases(self, cases: Array) -> Array:
        """Return the values of the flat cases."""
        return self.values[(cases // self.stride) % len(self.values)]


class BatchSpread:
    """Intervals of the results of a law over the cases of a batch.

    `sweeps` are the quantities of the batch, `names` the results of the law. Vacuum, slip and speed
    are conditions of the prediction if the law has them.
    """

    def __init__(
        self,
        law: Callable[..., Any],
        brake: BrakeFile | Brake | str,
        sweeps: Sequence[Sweep],
        names: Sequence[str],
        of_mean: bool,
    ) -> None:
        self.law, self.of_mean = law, of_mean
        file = load(brake) if isinstance(brake, str) else brake
        self.file = BrakeFile.from_record(file) if isinstance(file, Brake) else file
        self.sweeps = {s.name: s for s in sweeps}
        self.order = [name for name in inspect.signature(law).parameters if name != "brake"]
        if odd := ", ".join(name for name in self.sweeps if name not in self.order):
            raise QuantityError(
                f"interval: {odd} is swept, but tests hold for the brake in the file; omit one"
            )
        if odd := ", ".join(name for name in self.order if name not in self.sweeps):
            raise QuantityError(f"interval: {odd} is fixed, but an interval needs a number of it")
        self.names = tuple(name for name in names if name != OUTCOME)

    @property
    def keys(self) -> tuple[str, ...]:
        """Names of the further results: the ends of each interval, and whether a case is tested."""
        return *(f"{name}_{end}" for name in self.names for end in ENDS), TESTED

    def state(self) -> dict[str, str | float]:
        """Return the attributes of the labelled result."""
        prediction = Prediction(self.file, of_mean=self.of_mean)
        word = "handbook" if prediction.basis.word == "handbook" else "tested where `tested`"
        notes = "; ".join([prediction.basis.reason, *map(str, prediction.notices())])
        return {
            "interval_level": LEVEL,
            "interval_of": prediction.subject,
            "basis": word,
            "notes": notes.strip("; "),
        }

    def extend(self, run: Run) -> Run:
        """Return the evaluator of flat cases with the ends of the intervals as further results."""

        def run_all(first: int, count: int, out: Mapping[str, Array]) -> None:
            run(first, count, {n: values for n, values in out.items() if n not in self.keys})
            for start in range(0, count, BLOCK):
                size = min(BLOCK, count - start)
                piece = {name: values[start : start + size] for name, values in out.items()}
                self._fill(first + start, size, piece)

        return run_all

    def _fill(self, first: int, count: int, out: Mapping[str, Array]) -> None:
        cases = np.arange(first, first + count)
        numbers = {name: self.sweeps[name].take_cases(cases) for name in self.order}
        slip = numbers.get("slip", self._evaluate(numbers, self.file.brake).get("slip"))
        prediction = Prediction(
            self.file,
            numbers.get("vacuum"),
            np.zeros(count) if slip is None else slip,
            numbers.get("speed"),
            of_mean=self.of_mean,
            samples=BATCH_SAMPLES,
        )
        grid = np.ones((prediction.samples, count))
        wide = {name: values * grid for name, values in numbers.items()}
        values = self._evaluate(wide, prediction.brakes)
        for name in self.names:
            ends = prediction.interval(np.broadcast_to(values[name], grid.shape))
            for end in ENDS:
                out[f"{name}_{end}"][:] = ends[end]
        out[TESTED][:] = (prediction.basis.word != "handbook") & prediction.is_tested()

    def _evaluate(self, numbers: Mapping[str, Array], brake: Any) -> dict[str, Array]:
        """Return the results of the law by name, infinite for brakes that snap."""
        answer = self.law(*(numbers[name] for name in self.order), brake)
        flat = answer._asdict() if hasattr(answer, "_asdict") else {self.law.__name__: answer}
        results = {name: np.asarray(value, float) for name, value in flat.items()}
        snaps = np.isin(results.get(OUTCOME, 0.0), (SNAPS, NOT_A_CASE))
        return {
            name: np.where(snaps | np.isnan(values), np.inf, values)
            for name, values in results.items()
        }

"""Brakes that others built and tested, predicted without their results; part of `make coverage`.

Only Choi et al. 2018 publish enough numbers to predict a pulled brake. Each number is predicted
twice, with a scale factor of 1 and the computed stiffness: from the handbook's friction of the
film, and from the friction that the paper measured on a sled. The table goes to docs/coverage.md.

    python tests/blind_predictions.py [--write]
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax
import numpy as np

jax.config.update("jax_enable_x64", True)

from layerjam.brake.device.brake import Brake  # noqa: E402
from layerjam.brake.device.brake_file import BrakeFile, materials  # noqa: E402
from layerjam.brake.device.load import load  # noqa: E402
from layerjam.brake.mechanics.pull import peak  # noqa: E402
from layerjam.brake.mechanics.stiffness import working_stiffness  # noqa: E402
from layerjam.brake.mechanics.stop.exact import stop  # noqa: E402
from layerjam.brake.mechanics.stop.motion import rope_spring  # noqa: E402
from layerjam.brake.mechanics.stop.tune import tuned_stop  # noqa: E402
from layerjam.brake.simulate.prediction import Prediction  # noqa: E402
from layerjam.core.evolve import evolve  # noqa: E402
from layerjam.core.toml_files.source import Source  # noqa: E402
from layerjam.core.toml_files.toml import parse_toml  # noqa: E402

PAGE = Path(__file__).parent.parent / "docs" / "coverage.md"
MARKS = ("<!-- blind predictions: begin -->", "<!-- blind predictions: end -->")
VACUUM, ATMOSPHERE, MASS, GRAVITY, ROPE = 94.5e3, 101325.0, 1.0, 9.80665, 16.8e3
FILMS = {"choi2018-kapton": "kapton-hn", "choi2018-ptfe": "ptfe"}


@dataclass(frozen=True, kw_only=True)
class Test:
    """One published result: its values [unit], the law that predicts it, and its conditions."""

    what: str
    brake: str
    measured: tuple[float, ...]
    text: str
    unit: str
    law: Callable[[Brake], Any]
    vacuum: float | None = None
    speed: float | None = None


def _pull(brake: Brake) -> Any:
    return peak(VACUUM, 0.06, brake).force


def _stiffness(brake: Brake) -> Any:
    return np.asarray(working_stiffness(brake)) / 1e3


def _stop_in_g(brake: Brake, speed: float, vacuum: Any) -> Any:
    ones = np.ones(np.shape(brake.scale_factor))
    spring = rope_spring(ROPE, brake) * ones
    end = stop(MASS * ones, speed * ones, vacuum * ones, spring, GRAVITY, brake)
    return np.asarray(end.peak_force) / (MASS * GRAVITY)


def _full_vacuum(brake: Brake) -> Any:
    return _stop_in_g(brake, 3.7, ATMOSPHERE)


def _tuned(brake: Brake) -> Any:
    ones = np.ones(np.shape(brake.scale_factor))
    vacuum = tuned_stop(MASS * ones, 2.5 * ones, 0.04 * ones, ROPE, GRAVITY, brake)
    vacuum = np.where(np.isfinite(vacuum), vacuum, ATMOSPHERE)
    return _stop_in_g(brake, 2.5, vacuum)


KAPTON, PTFE = FILMS
TESTS = (
    Test(
        what="peak at 94.5 kPa, Kapton", brake=KAPTON, measured=(174.60, 175.93),
        text="174.6 to 175.9", unit="N", law=_pull, vacuum=VACUUM, speed=0.013,
    ),
    Test(
        what="peak at 94.5 kPa, PTFE", brake=PTFE, measured=(52.25, 52.28),
        text="52.3", unit="N", law=_pull, vacuum=VACUUM, speed=0.013,
    ),
    Test(
        what="stiffness, Kapton", brake=KAPTON, measured=(107.0, 131.0), text="107 to 131",
        unit="kN/m", law=_stiffness,
    ),
    Test(
        what="stiffness, PTFE", brake=PTFE, measured=(42.0, 55.0), text="42 to 55",
        unit="kN/m", law=_stiffness,
    ),
    Test(
        what="peak at 3.7 m/s, 1 kg, full vacuum", brake=KAPTON, measured=(10.0,),
        text="about 10", unit="g", law=_full_vacuum, vacuum=ATMOSPHERE, speed=3.7,
    ),
    Test(
        what="peak at 2.5 m/s, 1 kg, stopped in 40 mm", brake=KAPTON, measured=(2.0,),
        text="at most 2", unit="g", law=_tuned, speed=2.5,
    ),
)  # fmt: skip


def blind_file(name: str, from_handbook: bool) -> BrakeFile:
    """The brake of the paper without what its own pulls showed."""
    file = load(name)
    film, sources = file.brake.film, dict(file.sources)
    for path in ("scale_factor", "stiffness_measured", "amplification_held"):
        sources.pop(path, None)
    if from_handbook:
        table = parse_toml(materials()["films"][FILMS[name]], name)
        film = evolve(film, static=table["static"]["value"], kinetic=table["kinetic"]["value"])
        for key in ("static", "kinetic"):
            sources[f"film.{key}"] = Source(kind="handbook", text=table[key]["source"])
    brake = evolve(
        file.brake,
        film=film,
        scale_factor=1.0,
        stiffness_measured=None,
        amplification_held=None,
    )
    return evolve(file, brake=brake, sources=sources, evidence=())


def predict(test: Test, from_handbook: bool) -> tuple[float, float, float]:
    """Value and 95 % interval of one test."""
    file = blind_file(test.brake, from_handbook)
    prediction = Prediction(file, test.vacuum, None, test.speed)
    assert prediction.basis.word == "handbook"
    value = float(np.ravel(np.asarray(test.law(file.brake)))[0])
    interval = prediction.interval(test.law(prediction.brakes))
    return value, interval["low"], interval["high"]


def list_rows() -> Iterator[str]:
    """The rows of the table."""
    for test in TESTS:
        cells = [test.what, f"{test.text} {test.unit}"]
        for from_handbook in (True, False):
            value, low, high = predict(test, from_handbook)
            inside = all(low <= measured <= high for measured in test.measured)
            mark = "" if inside else " **outside**"
            cells.append(f"{value:.4g} ({low:.3g} to {high:.3g}){mark}")
        yield f"| {' | '.join(cells)} |"


def main() -> None:
    """Predict, print, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="write docs/coverage.md")
    given = parser.parse_args()
    rows = [
        "| what | measured | from the handbook's friction | from the paper's friction test |",
        "|---|---|---|---|",
        *list_rows(),
    ]
    print("\n".join(rows))
    if given.write:
        text = PAGE.read_text(encoding="utf-8")
        before, rest = text.split(MARKS[0])
        made = "\n".join(
            [MARKS[0], "", "Made by `python tests/blind_predictions.py --write`:", "", *rows, ""]
        )
        PAGE.write_text(f"{before}{made}\n{MARKS[1]}{rest.split(MARKS[1])[1]}", encoding="utf-8")


if __name__ == "__main__":
    main()

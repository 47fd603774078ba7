"""Claims about procedures (friction test, calibration, validation), tested with synthetic files.

The paper's raw curves are not published. This module runs the paper's procedure on files from a
virtual test machine whose true values are the paper's results, and checks that it recovers them.
"""

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.pull import factor_and_stiffness_of_eq8_and_eq9, peak
from layerjam.brake.mechanics.stiffness import stiffness_before_slip
from layerjam.core.drawing import style
from layerjam.core.evolve import evolve
from layerjam.laboratory.campaigns.campaign import campaign
from layerjam.laboratory.campaigns.exports import LAYOUTS, write_trace
from layerjam.laboratory.campaigns.faults import Faults
from layerjam.laboratory.campaigns.spec import FrictionTests, Pulls, Spec, Truth
from layerjam.laboratory.identify.calibration.peaks import calibrate
from layerjam.laboratory.identify.calibration.result import Calibration
from layerjam.laboratory.identify.friction.reduction import FrictionResult, reduce_friction
from layerjam.laboratory.identify.pull.features import PullFeatures, pull_features
from layerjam.laboratory.identify.validation.metrics import Validation, validate_pulls
from layerjam.laboratory.measure.readers.read import read_trace
from layerjam.studies.choi2018 import figures
from layerjam.studies.choi2018.claims import Claim, claim
from layerjam.studies.choi2018.figures import CALIBRATED, FIG7, FULL, NAMES, TESTED

NORMAL_FORCE = 0.250 * 9.80665
CONTACT_AREA = 0.025 * 0.025
TABLE_SD = {"choi2018-kapton": (0.0818, 0.0277), "choi2018-ptfe": (0.0871, 0.0317)}
CALIBRATED_ON = Pulls(vacuums=(FULL,), speeds=(13e-3,), repeats=1, travel=TESTED)
VALIDATED_ON = Pulls(vacuums=tuple(FIG7), speeds=(7e-3, 19e-3), repeats=2, travel=TESTED)
PRINTED, SPREAD = 0.32, 0.11
"""Printed error of the paper's model before calibration, and its standard deviation."""
REPEATS = 3
TEST_COUNT = "3 friction tests, 1 calibration pull, 12 validation pulls"
"""Number of tests of each film."""
PULL_MACHINE = Faults(force_noise=0.15, load_cell_range=500.0, force_step=1e-3, travel_step=1e-7)


@dataclass(frozen=True, kw_only=True)
class FilmRun:
    """Results of the procedure for one film."""

    file: BrakeFile
    friction: FrictionResult
    calibration: Calibration
    uncalibrated: Validation
    calibrated: Validation


def write_friction_files(file: BrakeFile, folder: Path) -> list[Path]:
    """Write friction tests of a film in Bluehill's file layout, with the scatter of table I."""
    static, kinetic = TABLE_SD[file.name]
    tests = FrictionTests(
        repeats=REPEATS,
        normal_force=NORMAL_FORCE,
        travel=0.1,
        static_scatter=static,
        kinetic_scatter=kinetic,
        force_noise=0.002,
        load_cell_range=10.0,
        force_step=1e-3,
    )
    traces = campaign(Spec(brakes=(Truth(brake=file),), seed=11, friction=tests)).traces()
    film = NAMES[file.name].lower()
    return [
        write_trace(t, folder / f"friction-{film}-{n}.csv", "bluehill", overwrite=True)
        for n, t in enumerate(traces, 1)
    ]


def write_pulls(file: BrakeFile, folder: Path, pulls: Pulls, layout: str, stem: str) -> list[Path]:
    """Write pulls of a brake as files of one layout, with names that begin with `stem`."""
    spec = Spec(brakes=(Truth(brake=file),), seed=7, pulls=pulls, machine=PULL_MACHINE)
    film, ending = NAMES[file.name].lower(), LAYOUTS[layout].ending
    paths = []
    for trace in campaign(evolve(spec, seed=spec.seed + len(stem))).traces():
        facts = trace.facts
        condition = f"{(facts.vacuum or 0.0) / 1e3:.1f}kPa-{(facts.speed or 0.0) * 1e3:g}mms"
        path = folder / f"{stem}-{film}-{condition}-{facts.repeat}{ending}"
        paths.append(write_trace(trace, path, layout, overwrite=True))
    return paths


def read_pulls(paths: list[Path]) -> list[tuple[PullFeatures, float]]:
    """Return the pulls in files, and their vacuums from the sidecars."""
    out = []
    for path in paths:
        trace = read_trace(path)
        out.append((pull_features(trace), float(trace.facts.vacuum or 0.0)))
    return out


@cache
def run_film_study(name: str) -> FilmRun:
    """Run the paper's whole procedure for one film on synthetic files; the result is cached."""
    file = load(name)
    with TemporaryDirectory() as place:
        folder = Path(place)
        tests = [read_trace(p) for p in write_friction_files(file, folder)]
        pull = read_pulls(write_pulls(file, folder, CALIBRATED_ON, "testxpert", "calibration"))
        pulls = read_pulls(write_pulls(file, folder, VALIDATED_ON, "bluehill", "validation"))
    calibration = calibrate(pull, evolve(file.brake, scale_factor=1.0))
    fitted_brake = evolve(
        file.brake, scale_factor=calibration.scale_factor, stiffness_measured=calibration.stiffness
    )
    return FilmRun(
        file=file,
        friction=reduce_friction(tests, NORMAL_FORCE),
        calibration=calibration,
        uncalibrated=validate_pulls(pulls, evolve(fitted_brake, scale_factor=1.0)),
        calibrated=validate_pulls(pulls, fitted_brake),
    )


def run_studies() -> dict[str, FilmRun]:
    """Return `run_film_study` for both films that the paper calibrated."""
    return {name: run_film_study(name) for name in CALIBRATED}


def draw_fig8() -> style.Figure:
    """Draw Fig. 8 with the procedure's calibrations."""
    return figures.draw_fig8({name: run.calibration for name, run in run_studies().items()})


def friction_claims() -> list[Claim]:
    """Return the claims in section III-C: table I."""
    out = [claim("test-pressure", NORMAL_FORCE / CONTACT_AREA / 1e3)]
    for name, run in run_studies().items():
        for kind, sd in zip(("static", "kinetic"), TABLE_SD[name], strict=True):
            paper = getattr(run.file.brake.film, kind)
            table_value = {"paper": paper, "tolerance": sd * paper}
            our_friction = getattr(run.friction, kind)
            out.append(
                claim("table-1", our_friction, instead=table_value, kind=kind, film=NAMES[name])
            )
    return out


def _apply_eq8_and_eq9(name: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the values for two claims: whether the printed a and k follow from eq. 8 and 9."""
    brake, variant_name = load(name).brake, f"{name}-eq9"
    printed_pair = brake.scale_factor, brake.stiffness_measured or np.nan
    factor, slope = factor_and_stiffness_of_eq8_and_eq9(*printed_pair, FULL, brake)
    read = brake.with_(scale_factor=float(factor), stiffness_measured=float(slope))
    loss = 1 - float(peak(FULL, TESTED, read).force / peak(FULL, TESTED, brake).force)
    words = {"printed": printed_pair[0], "read": float(factor), "less": loss, "other": variant_name}
    sheets = float(stiffness_before_slip(brake)) / 1e3
    stiffness_values = {
        "printed": printed_pair[1] / 1e3,
        "read": float(slope) / 1e3,
        "sheets": sheets,
    }
    return words, stiffness_values | {"other": variant_name}


def calibration_claims() -> list[Claim]:
    """Return the claims in section III-D: Fig. 8 and 9, eq. 7 to 9."""
    out = []
    for name, run in run_studies().items():
        factor, result = run.file.brake.scale_factor, run.calibration
        a = {"paper": factor, "tolerance": 0.0005 if factor < 1 else 0.005}
        k = {"paper": (run.file.brake.stiffness_measured or np.nan) / 1e3}
        eq9 = (result.stiffness_eq9 or np.nan) / 1e3
        error = result.standard_errors["scale_factor"] or 0
        film, (eq8_words, eq9_words) = NAMES[name], _apply_eq8_and_eq9(name)
        out += [
            claim("scale-factor", result.scale_factor, instead=a, film=film, error=error),
            claim("eq8", result.scale_factor_eq8, instead=a, film=film, **eq8_words),
            claim("slope", result.stiffness / 1e3, instead=k, film=film),
            claim("eq9", eq9, instead=k, film=film, **eq9_words),
        ]
    return out


def validation_claims() -> list[Claim]:
    """Return the claims in sections III-C and III-D: MAPE before and after calibration."""
    uncalibrated_errors = [
        c.mape for run in run_studies().values() for c in run.uncalibrated.curves
    ]
    calibrated_errors = [c.mape for run in run_studies().values() for c in run.calibrated.curves]
    factor_errors = [abs(1 / run.file.brake.scale_factor - 1) for run in run_studies().values()]
    explained_error = float(np.mean(factor_errors))
    unexplained_share = 1 - explained_error / PRINTED
    return [
        claim(
            "mape-before", 100 * float(np.mean(uncalibrated_errors)), pulls=len(uncalibrated_errors)
        ),
        claim(
            "explains",
            holds=explained_error > PRINTED - SPREAD,
            alone=factor_errors,
            rest=unexplained_share,
        ),
        claim(
            "mape-after", 100 * float(np.mean(calibrated_errors)), pulls=len(uncalibrated_errors)
        ),
        claim(
            "mape-spread",
            100 * float(np.std(calibrated_errors, ddof=1)),
            pulls=len(uncalibrated_errors),
        ),
    ]

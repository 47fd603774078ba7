"""Reading exports, against a bare pandas.read_csv, and one calibration, against curve_fit."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pandas

from benchmarks.calibration import pulled
from benchmarks.timing import Row, median
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.pull import force_at_elongation
from layerjam.laboratory.campaigns.exports import LAYOUTS, write_trace
from layerjam.laboratory.identify.calibration.peaks import calibrate
from layerjam.laboratory.identify.pull.features import PullFeatures, pull_features
from layerjam.laboratory.measure.readers.read import read_trace

MACHINES = {"our CSV": "own", "Instron Bluehill": "bluehill", "Zwick testXpert": "testxpert"}


def _with_curve_fit(pull: PullFeatures, vacuum: float, brake: Brake) -> object:
    """Scale factor and stiffness by general least squares, as a user would do it in SciPy."""
    from dataclasses import replace

    from scipy.optimize import curve_fit

    def curve(u: np.ndarray, factor: float, stiffness: float) -> np.ndarray:
        trial = replace(brake, scale_factor=factor, stiffness_measured=stiffness)
        return np.asarray(force_at_elongation(np.maximum(u, 0.0), vacuum, trial))

    return curve_fit(curve, pull.elongation, pull.force, p0=(1.0, pull.stiffness))


def _head(path: Path) -> int:
    """Lines above the numbers."""
    for number, line in enumerate(path.read_text("latin-1").splitlines()):
        plain = line.replace('"', "")
        if plain[:1].isdigit() and plain.count(",") >= 2:
            return number
    raise ValueError(path)


def _bare(path: Path, head: int) -> pandas.DataFrame:
    return pandas.read_csv(path, skiprows=head, header=None, encoding="latin-1")


def rows() -> list[Row]:
    """Seconds a file and a calibration."""
    file = load("choi2018-kapton")
    trace = pulled(file.brake, 94.5e3, 13e-3, seed=1)
    out = []
    with tempfile.TemporaryDirectory() as folder:
        for name, layout in MACHINES.items():
            path = write_trace(trace, Path(folder) / f"{layout}{LAYOUTS[layout].ending}", layout)
            bare = median(lambda p=path, s=_head(path): _bare(p, s))
            read = median(lambda p=path: read_trace(p))
            out.append(Row(f"{name}, {len(trace)} rows", read, 0.05, bare, "bare pandas.read_csv"))
        pull = pull_features(read_trace(path))
    one = median(lambda: calibrate([(pull_features(trace), 94.5e3)], file.brake), 21)
    general = median(lambda: _with_curve_fit(pull, 94.5e3, file.brake), 5)
    out.append(Row("one calibration, 40,001 samples", one, 0.01, general, "SciPy curve_fit"))
    return out

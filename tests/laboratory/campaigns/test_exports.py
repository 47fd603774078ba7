"""Exports of machines and locales that no reader was written for: the truth comes back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from laboratory.campaigns import bench as virtual
from laboratory.measure.exports import EXPORTS
from layerjam.brake.mechanics.pull import peak
from layerjam.laboratory.identify.calibration.peaks import calibrate
from layerjam.laboratory.identify.pull.features import pull_features
from layerjam.laboratory.measure.readers.read import read_trace
from layerjam.laboratory.measure.trace import Trace
from strategies import KAPTON, change

VACUUM = 94.5e3
BLANK = change(KAPTON, scale_factor=1.0, stiffness_measured=None)


@pytest.fixture(scope="module")
def pull() -> Trace:
    """A pull of a known brake with 0.1 % noise."""
    noise = 1e-3 * float(peak(VACUUM, 0.06, KAPTON).force)
    machine = virtual.Machine(load_cell_noise=noise, sampling_rate=400.0, seed=11)
    return virtual.pull(KAPTON, VACUUM, 13e-3, 20e-3, machine)


@pytest.mark.parametrize("name", EXPORTS)
def test_truth_comes_back(name: str, pull: Trace, tmp_path: Path) -> None:
    export = EXPORTS[name]
    assert pull.time is not None
    path = tmp_path / "export.txt"
    path.write_bytes(export.write(pull.time, pull.elongation, pull.force))
    trace = read_trace(path)
    np.testing.assert_allclose(trace.force, pull.force, atol=2e-3)
    np.testing.assert_allclose(trace.elongation - export.origin, pull.elongation, atol=2e-7)
    np.testing.assert_allclose(trace.time, pull.time, atol=1e-4)
    assert len(trace.understood) >= 3
    if export.below:
        assert any("below the numbers" in w for w in trace.warnings)
    else:
        assert trace.warnings == ()
    found = calibrate([(pull_features(trace), VACUUM)], BLANK)
    assert found.scale_factor == pytest.approx(KAPTON.scale_factor, rel=0.02)
    assert found.stiffness == pytest.approx(KAPTON.stiffness_measured, rel=0.05)

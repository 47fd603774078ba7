"""Measured logs that come with the program: their bytes, and leaks beside independent fits."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from layerjam.core.command.log_options import LogOptions
from layerjam.laboratory.commands.leak import leak

EXAMPLES = Path(str(files("layerjam.laboratory.measure"))) / "examples"
SOURCE = Path(__file__).parents[3] / "shared/data/pneumatic_friction_leak"
AS_THEY_ARE = LogOptions(columns="time:ms,skip,pressure:bar", reading="gauge")


def _columns(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Time [s] and pressure [Pa]; the source writes 1 002 ms as 1.002.000."""
    rows = [line.split(";") for line in (EXAMPLES / name).read_text().splitlines()]
    time = np.array([float(row[0].replace(".", "")) for row in rows]) * 1e-6
    return time, np.array([float(row[2]) for row in rows]) * 1e5


def test_the_filament_chamber_leaks_as_a_straight_line_of_the_logarithm() -> None:
    time, gauge = _columns("chamber-filament.csv")
    part = (time >= 6.0) & (time <= 14.0)
    slope = np.polyfit(time[part], np.log(gauge[part]), 1)[0]
    found = leak(EXAMPLES / "chamber-filament.csv", start=6.0, end=14.0, options=AS_THEY_ARE)
    assert found.model == "linear" and found.verdict == "passed"
    assert found.time_constant_low < -1 / slope < found.time_constant_high
    assert found.time_constant == pytest.approx(-1 / slope, rel=0.04)


def test_the_resin_chamber_is_too_tight_for_its_log() -> None:
    time, gauge = _columns("chamber-resin.csv")
    found = leak(EXAMPLES / "chamber-resin.csv", start=10.0, options=AS_THEY_ARE)
    assert [row["name"] for row in found.failed_checks] == ["leak interval"]
    part = time >= 10.0
    rate = np.polyfit(time[part], gauge[part], 1)[0]
    assert found.pressure_change_rate == pytest.approx(rate, rel=0.15)


@pytest.mark.parametrize(
    ("name", "original"),
    [("chamber-resin", "airchamber_Prusa"), ("chamber-filament", "airchamber_Ultimaker_020")],
)
def test_the_bytes_are_those_of_the_source(name: str, original: str) -> None:
    text = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    assert "CC0 1.0" in text and f"`{name}.csv`" in text
    if (SOURCE / f"{original}.csv").exists():
        same = (SOURCE / f"{original}.csv").read_bytes()
        assert (EXAMPLES / f"{name}.csv").read_bytes() == same

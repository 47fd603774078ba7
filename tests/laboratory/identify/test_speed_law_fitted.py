"""A fit over speed goes into the brake's file, and the brake made of it stops as the truth does."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from laboratory.identify.fitted import TRUTH, campaign
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.speed_effects import brake_growth
from layerjam.brake.simulate.drop import drop
from layerjam.core.errors import FitError
from layerjam.laboratory.identify.calibration.peaks import calibrate_peaks
from layerjam.laboratory.identify.calibration.speed_law import make_speed_law, speed_notices
from layerjam.laboratory.identify.calibration.whole_curves import calibrate_curves
from layerjam.laboratory.identify.provenance import format_brake
from layerjam.laboratory.identify.validation.metrics import validate_curves
from strategies import KAPTON

FILE = load("choi2018-kapton")
BLANK = replace(FILE, brake=replace(KAPTON, scale_factor=1.0, stiffness_measured=None))
SLOPE, SPEEDS = 0.2, (2e-3, 2e-2, 2e-1)
G = 9.80665


def truth_at(speed: float) -> float:
    """The scale factor that the virtual pulls were made with at a speed [m/s]."""
    return TRUTH[0] * np.exp(SLOPE * np.log10(speed / 0.01))


def stopped(mass: float, arrival: float, vacuum: float) -> float:
    """Slip [m] of the true brake by scipy: its friction a power of the speed down to any."""
    sheets, film, shell = KAPTON.sheets, KAPTON.film, KAPTON.enclosure
    c = film.kinetic * (sheets.count - 1) * sheets.width * vacuum
    pull = film.friction_on_silicone * shell.modulus * shell.wall * vacuum
    stretch = 2 * TRUTH[2] * sheets.width * np.sqrt(pull)
    spring = TRUTH[1]

    def change(_: float, y: Any) -> list[float]:
        force = spring * (y[0] - y[2])
        share = (force - stretch * np.sqrt(max(y[2], 0.0))) / (c * (sheets.overlap - y[2]))
        pace = 0.01 * max(share / TRUTH[0], 0.0) ** (np.log(10) / SLOPE)
        return [y[1], G - force / mass, pace]

    def stands(_: float, y: Any) -> float:
        return float(y[1])

    stands.terminal, stands.direction = True, -1.0  # type: ignore[attr-defined]
    made: Any = solve_ivp(
        change, (0, 1), [0, arrival, 0], "Radau", rtol=1e-8, atol=1e-11, events=stands
    )
    return float(made.y[2, -1])


@pytest.mark.slow
def test_a_fitted_growth_is_written_and_the_brake_stops_as_the_truth_does() -> None:
    curves = campaign((40e3, 90e3), 1, slope=SLOPE, speeds=SPEEDS)
    found = calibrate_curves(curves, BLANK.brake, ("speed",))
    made = BrakeFile.read(format_brake(FILE, found, "curves", "calibrated"), "calibrated")
    law = made.brake.speed_law
    assert law is not None
    assert (law.test_speed, law.fastest) == pytest.approx((found.reference_speed, 0.2))
    assert made.sources["speed_law.rest_speed"].kind == "assumed"
    for speed in (2e-3, 7e-3, 2e-2, 6e-2, 2e-1):
        factor = made.brake.scale_factor * float(brake_growth(speed, made.brake))
        assert factor == pytest.approx(truth_at(speed), rel=3e-3)
    # its sheets slide at up to 0.4 m/s, a little beyond what was pulled
    case = {"mass": 5.0, "speed": 0.6, "vacuum": 60e3}
    timed, _ = drop(made, **case)
    assert timed.slip == pytest.approx(stopped(5.0, 0.6, 60e3), rel=0.01)
    # a file without it would be off by more
    bare = replace(made, brake=replace(made.brake, speed_law=None))
    assert drop(bare, **case)[0].slip > 1.1 * timed.slip
    assert [n.key for n in speed_notices(found)] == ["speed-law-fitted"]


def test_a_law_of_the_file_is_held_in_later_calibrations_and_validations() -> None:
    curves = campaign((40e3, 90e3), 1, slope=SLOPE, speeds=SPEEDS)
    law = make_speed_law(SLOPE, 0.05, SPEEDS)
    assert law is not None
    brake = replace(BLANK.brake, speed_law=law)
    for made in (calibrate_curves(curves, brake), calibrate_peaks(curves, brake)):
        # its enclosure is 1.3 times the file's, which peaks do not tell
        near = 3e-3 if made.fit is not None else 1e-2
        assert made.scale_factor == pytest.approx(truth_at(0.05), rel=near)
        assert "speed_law.power" not in made.sources
        alone = [one.scale_factor for one in made.fits]
        assert np.ptp(alone) < 0.02 * np.mean(alone)
    fitted = calibrate_curves(curves, brake)
    values = fitted.values
    whole = replace(
        brake,
        scale_factor=values["scale_factor"],
        stiffness_measured=values["stiffness"],
        enclosure=replace(
            brake.enclosure, modulus=brake.enclosure.modulus * values["enclosure_factor"] ** 2
        ),
    )
    assert validate_curves(curves, whole).mape < 0.01
    assert validate_curves(curves, replace(whole, speed_law=None)).mape > 0.05
    with pytest.raises(FitError, match="has neither a speed"):
        calibrate_peaks([replace(curves[0], speed=None)], brake)


def test_friction_that_falls_with_speed_is_no_law_and_that_is_said() -> None:
    curves = campaign((60e3,), 2, slope=-0.1, speeds=(2e-3, 2e-2))
    found = calibrate_curves(curves, BLANK.brake, ("speed",))
    assert "speed_law.power" not in found.sources
    assert [n.key for n in speed_notices(found)] == ["speed-law-not-fitted"]
    # an old law does not outlive the factor it belonged to
    law = make_speed_law(SLOPE, 0.05, SPEEDS)
    old = calibrate_curves(curves, replace(BLANK.brake, speed_law=law), ("speed",))
    assert old.sources["speed_law.power"][0] == 0
    assert old.scale_factor == pytest.approx(found.scale_factor, rel=1e-9)
    assert make_speed_law(3.0, 0.05, SPEEDS) is None

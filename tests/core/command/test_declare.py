"""What every declared command does with its input and its result."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import layerjam as lj
from layerjam.brake.commands.sensor import Sensing
from layerjam.core.errors import LayerjamError, QuantityError
from strategies import unchecked

KAPTON = lj.load("choi2018-kapton")
DROP = {"mass": "1 kg", "speed": "2.5 m/s", "vacuum": "94.5 kPa"}


def test_text_and_si_numbers_are_the_same() -> None:
    text = lj.drop(KAPTON, **DROP)
    numbers = lj.drop(KAPTON, mass=1.0, speed=2.5, vacuum=94.5e3)
    assert text.values == numbers.values
    assert isinstance(text.peak_force, float)
    # mechanics.md, section 6
    roped = lj.drop(KAPTON, **DROP, rope_stiffness="16.8 kN/m")
    assert (roped.outcome, roped.slip) == ("STOPPED", pytest.approx(17.0251044e-3, rel=1e-8))
    assert roped.peak_force == pytest.approx(175.925038, rel=1e-8)


def test_a_brake_has_four_forms(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    lj.new("mine", "choi2018-kapton", path)
    forms = ("choi2018-kapton", path, KAPTON, KAPTON.brake)
    found = {lj.force(form, slip=0.02, vacuum=94.5e3).force for form in forms}
    assert len(found) == 1
    assert found.pop() == pytest.approx(133.942755, abs=1e-6)
    assert float(lj.laws.brake_force(0.02, 94.5e3, KAPTON)) == pytest.approx(133.942755, abs=1e-6)


@pytest.mark.parametrize(("width", "said"), [(13.0, "at most 500 mm"), (-1.0, "at least 1 mm")])
def test_a_record_that_no_file_could_hold_is_refused(width: float, said: str) -> None:
    """By whatever hand it was made: the answer would be a silent wrong number."""
    with pytest.raises(LayerjamError, match=said):
        replace(KAPTON.brake.sheets, width=width)
    # as a step of an optimiser may, which calls no constructor
    brake = unchecked(KAPTON.brake, sheets=unchecked(KAPTON.brake.sheets, width=width))
    for form in (brake, replace(KAPTON, brake=brake)):
        with pytest.raises(LayerjamError, match=said):
            lj.force(form, slip=0.02, vacuum=94.5e3)


def test_a_forgotten_unit_is_warned_of() -> None:
    keys = [w.key for w in lj.force(KAPTON, slip=0.02, vacuum=94.5).warnings]
    assert keys == ["unlikely-unit"]
    assert not lj.force(KAPTON, slip=0.02, vacuum=94.5e3).warnings
    assert not lj.force(KAPTON, slip=0.02, vacuum="94.5 Pa").warnings


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"mass": "1 m"}, "mass: '1 m' is not in units of mass"),
        ({"mass": None}, "mass: missing"),
        ({"mass": [1.0]}, "is not a single number; layerjam.batch"),
        ({"mass": -1.0}, "mass: -1 kg is not allowed"),
        ({"vacuum": "Tuned"}, "did you mean tuned"),
        ({"vacuum": "110 kPa"}, "exceeds atmospheric pressure"),
        ({"accelerometer": "adxl19"}, "adxl193"),
    ],
)
def test_bad_input_names_the_quantity(given: dict[str, object], said: str) -> None:
    with pytest.raises(LayerjamError, match=said):
        lj.drop(KAPTON, **(DROP | given))


def test_options_that_belong_together_are_given_as_a_record_or_by_name() -> None:
    how = {"accelerometer": "adxl193", "filter_class": "cfc180"}
    loose = lj.drop(KAPTON, **DROP, **how)
    record = lj.drop(KAPTON, **DROP, sensing=Sensing(**how))
    assert loose.values == record.values
    assert loose.filter == "cfc180" and loose.peak_loss > 1e-3
    with pytest.raises(TypeError, match="not both"):
        lj.drop(KAPTON, **DROP, sensing=Sensing(), filter_class="cfc60")


def test_results_print_save_and_turn_into_frames(tmp_path: Path) -> None:
    stop = lj.drop(KAPTON, **DROP)
    said = str(stop)
    assert "peak force" in said and "175.9 N" in said and "array" not in said
    assert "<table>" in stop._repr_html_() and "175.9 N" in stop._repr_html_()
    frame, data = stop.to_frame(), stop.to_xarray()
    assert frame["force"].max() == pytest.approx(stop.peak_force, rel=1e-3)
    assert data["force"].attrs["units"] == "N"
    for name in ("stop.csv", "stop.json", "stop.svg"):
        assert stop.save(tmp_path / name).stat().st_size > 500
        with pytest.raises(LayerjamError, match="already exists"):
            stop.save(tmp_path / name)
    with pytest.raises(LayerjamError, match=r"\.docx"):
        stop.save(tmp_path / "stop.docx")


def test_arrays_are_shown_as_a_short_table() -> None:
    found = lj.force(KAPTON, slip=np.linspace(0, 0.06, 61), vacuum="90 kPa")
    assert "force [N]" in str(found) and len(str(found)) < 1500
    assert found.to_frame().shape == (61, 5)
    single = lj.force(KAPTON, slip=0.03, vacuum="90 kPa")
    assert found.force[30] == pytest.approx(single.force, rel=1e-14)


def test_double_precision_is_scoped() -> None:
    """No switch is needed, and other JAX code of the process is left as it was."""
    code = """
import layerjam as lj
import jax.numpy as jnp
brake = lj.load("choi2018-kapton")
assert abs(lj.force(brake, slip="20 mm", vacuum="94.5 kPa").force - 133.94275548951626) < 1e-12
stop = lj.drop(brake, mass=1.0, speed=2.5, vacuum="tuned", travel="40 mm")
assert abs(stop.slip - 0.04) < 1e-12
assert lj.tensile(brake, vacuum=94.5e3, speed=0.013, travel=0.04).peak_force > 175.9
assert jnp.asarray(1.0).dtype == jnp.float32
"""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        capture_output=True, text=True, timeout=300, check=False,
        env={**__import__("os").environ, "JAX_ENABLE_X64": "0"},
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")


def test_quantity_errors_carry_their_quantity() -> None:
    with pytest.raises(QuantityError) as caught:
        lj.drop(KAPTON, **(DROP | {"mass": None}))
    assert (caught.value.key, caught.value.quantity) == ("quantity", "mass")

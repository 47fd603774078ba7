"""Errors of JAX, Matplotlib and NumPy that a user can cause are one sentence of ours."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import jax
import numpy as np
import pytest

import layerjam as lj
from layerjam.core.drawing.style import format_svg
from layerjam.core.errors import LayerjamError, QuantityError

KAPTON = "choi2018-kapton"
TUNED = """
import layerjam as lj
lj.batch(lj.laws.brake_force, {"slip": [0.01], "vacuum": [5e4]}, brake="choi2018-kapton")
"""


def run(code: str, **variables: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", "from layerjam.core.errors import LayerjamError\ntry:\n"
         + "".join(f"    {line}\n" for line in code.strip().splitlines())
         + "except LayerjamError as error:\n    print(error)\n"],
        env={**os.environ, **variables}, capture_output=True, text=True, check=False,
    )  # fmt: skip


@pytest.mark.timing
@pytest.mark.parametrize("platform", ["cuda", "tpuu"])
def test_a_platform_that_jax_lacks_is_named(platform: str) -> None:
    if platform == "cuda" and any(d.platform == "gpu" for d in jax.devices()):
        pytest.skip("this machine has a GPU")
    done = run(TUNED, JAX_PLATFORMS=platform)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(f"JAX_PLATFORMS={platform}: JAX cannot start this platform")


def test_a_date_that_is_not_a_number_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    force = lj.force(KAPTON, slip=0.02, vacuum=5e4)
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "abc")
    wrong = "SOURCE_DATE_EPOCH: 'abc' is not a number of seconds"
    for draw in (
        lambda: force.plot(tmp_path / "force.pdf"),
        lambda: force.plot(tmp_path / "force.svg"),
        lambda: format_svg(force.draw()),
    ):
        with pytest.raises(QuantityError, match=wrong):
            draw()
    assert not [*tmp_path.iterdir()]
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    force.plot(tmp_path / "force.pdf")


DATED = """
import layerjam as lj
lj.design("wrist", out="made.toml")
"""


@pytest.mark.parametrize(
    ("date", "reason"),
    [
        ("abc", "'abc' is not a number of seconds"),
        ("-1", "'-1' is not a number of seconds"),
        ("999999999999", "999999999999 s is after the year 9999"),
    ],
)
def test_a_date_that_a_library_cannot_read_stops_a_command_at_its_start(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, date: str, reason: str
) -> None:
    """NumPy and SciPy read the date while they are imported: here in a fresh process."""
    monkeypatch.chdir(tmp_path)
    done = run(DATED, SOURCE_DATE_EPOCH=date)
    assert done.stdout.startswith(f"SOURCE_DATE_EPOCH: {reason}"), done.stderr
    assert not [*tmp_path.iterdir()]


@pytest.mark.parametrize("trace", [jax.grad, jax.jit, jax.vmap], ids=lambda f: f.__name__)
def test_a_traced_command_names_the_laws(trace: object) -> None:
    argument = np.array([0.01, 0.02]) if trace is jax.vmap else 0.02
    with pytest.raises(QuantityError, match=r"slip: is traced by JAX, .*layerjam\.laws"):
        trace(lambda slip: lj.force(KAPTON, slip=slip, vacuum=5e4).force)(argument)  # type: ignore[operator]


def test_many_masses_name_batch() -> None:
    for masses in (np.array([1.0, 2.0]), [1.0, 2.0], ["1 kg", "2 kg"]):
        with pytest.raises(QuantityError, match=r"mass: .* not a single number; layerjam\.batch"):
            lj.drop(KAPTON, mass=masses, speed=2, vacuum=5e4)  # type: ignore[arg-type]


def test_batch_refuses_a_command_and_names_a_law() -> None:
    for call in (
        lambda: lj.batch(lj.drop, mass=[1, 2]),  # type: ignore[call-arg]
        lambda: lj.batch(lj.drop, {"mass": [1, 2]}, brake=KAPTON),
    ):
        with pytest.raises(LayerjamError, match=r"drop is a command; .*layerjam\.laws\.stop"):
            call()


def test_outcomes_of_a_batch_have_names() -> None:
    sweep = {"mass": [1.0, 50.0], "speed": 2.0, "vacuum": [9e4, 0.0], "gravity": 0.0, "spring": 1e4}
    stops = lj.batch(lj.laws.stop, sweep, brake=KAPTON)
    names = dict(
        zip(
            stops.outcome.attrs["flag_values"],
            stops.outcome.attrs["flag_meanings"].split(),
            strict=True,
        )
    )
    assert names[float(stops.outcome.sel(mass=1.0, vacuum=9e4))] == "STOPPED"
    assert names[float(stops.outcome.sel(mass=50.0, vacuum=0.0))] == "BOTTOMED_OUT"


def test_beyond_the_overlap_a_law_is_unknown_or_that_of_the_enclosure() -> None:
    brake = lj.load(KAPTON).brake
    beyond, vacuum = brake.sheets.overlap + 0.01, 5e4
    for law in (lj.laws.brake_force, lj.laws.slip_work, lj.laws.slip_heat):
        assert np.isnan(law(beyond, vacuum, brake))
    assert lj.laws.sheet_friction(beyond, vacuum, brake) == 0
    alone = lj.laws.force_at_elongation(beyond, vacuum, brake)
    slip = beyond - alone / brake.stiffness_measured
    assert alone == pytest.approx(lj.laws.enclosure_force(slip, vacuum, brake), rel=1e-9)
    assert "enclosure alone" in " ".join(str(lj.laws.force_at_elongation.__doc__).split())


def test_an_unlikely_unit_is_noted_in_the_result() -> None:
    for result in (
        lj.force(KAPTON, slip=0.02, vacuum=94.5),
        lj.drop(KAPTON, mass=1, speed=2, vacuum=94.5),
        lj.tensile(KAPTON, vacuum=94.5, speed=0.01, elongation=0.01),
    ):
        assert [w.key for w in result.warnings].count("unlikely-unit") == 1

"""`drop` and `tune` at the command line: keys, check values of section 6, bad input."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from .conftest import Run

DROP = ("drop", "choi2018-kapton", "--mass", "1kg", "--rope-stiffness", "16.8kN/m", "--json")
TUNE = ("tune", "choi2018-kapton", "--mass", "1kg", "--travel", "40mm", "--rope-stiffness",
        "16.8kN/m", "--json")  # fmt: skip
DROP_KEYS = {
    "slip": "m", "peak_force": "N", "peak_deceleration": "m/s^2", "peak_g": "1",
    "stopping_time": "s", "dissipated_energy": "J", "end_speed": "m/s", "vacuum": "Pa",
}  # fmt: skip
G = 9.80665


@pytest.mark.parametrize(
    ("speed", "vacuum", "slip", "peak"),
    [("2.5m/s", "94.5kPa", "17.0251044", "175.925038"),
     ("3.0m/s", "80kPa", "44.0565365", "149.007238")],
)  # fmt: skip
def test_drop(run: Run, speed: str, vacuum: str, slip: str, peak: str) -> None:
    ran = run(*DROP, "--speed", speed, "--vacuum", vacuum)
    found = ran.json
    assert (ran.code, ran.err, found["outcome"]) == (0, "", "STOPPED")
    for key, unit in DROP_KEYS.items():
        assert found["units"][key] == unit and key in found
    assert f"{found['slip'] * 1e3:.7f}" == slip and f"{found['peak_force']:.6f}" == peak
    assert found["peak_deceleration"] == pytest.approx(found["peak_force"] - G, rel=1e-12)
    assert found["peak_g"] == pytest.approx(found["peak_force"] / G, rel=1e-12)
    assert isinstance(found["warnings"], list)


def test_the_paper_at_its_greatest_speed_runs_out_of_travel(run: Run) -> None:
    ran = run(*DROP, "--speed", "3.7m/s", "--vacuum", "94.5kPa")
    assert ran.code == 0 and ran.json["outcome"] == "BOTTOMED_OUT"
    assert ran.json["slip"] == 0.060 and f"{ran.json['end_speed']:.2f}" == "1.29"


def test_a_slow_mass_never_slides(run: Run) -> None:
    ran = run(*DROP, "--speed", "0.1m/s", "--vacuum", "94.5kPa")
    assert ran.code == 0 and ran.json["outcome"] == "NEVER_SLID" and ran.json["slip"] == 0
    assert ran.json["peak_force"] < 175.43


def test_a_soft_rope_snaps(run: Run) -> None:
    words = [*DROP, "--speed", "4.5m/s", "--vacuum", "94.5kPa"]
    words[words.index("16.8kN/m")] = "2 kN/m"
    ran = run(*words)
    assert ran.code == 1 and ran.json["outcome"] == "SNAPS"


@pytest.mark.parametrize("speed", ["0.465m/s", "2.5m/s", "3.327m/s"])
def test_tune(run: Run, speed: str) -> None:
    ran = run(*TUNE, "--speed", speed)
    found = ran.json
    assert (ran.code, ran.err, found["feasible"], found["reason"]) == (0, "", True, None)
    assert found["units"]["vacuum"] == found["units"]["vacuum_eq10"] == "Pa"
    assert found["units"]["floor_g"] == "1" and found["vacuum"] > found["vacuum_eq10"]
    v = float(speed.removesuffix("m/s"))
    stopped = run(*DROP, "--speed", speed, "--vacuum", f"{found['vacuum']!r} Pa").json
    assert stopped["outcome"] == "STOPPED" and stopped["slip"] == pytest.approx(0.04, rel=1e-6)
    k = 1 / (1 / 131e3 + 1 / 16.8e3)
    floor = 1 + v**2 / (2 * G * (0.04 + stopped["peak_force"] / k))
    assert found["floor_g"] == pytest.approx(floor, rel=1e-3)
    assert stopped["peak_g"] >= found["floor_g"]


@pytest.mark.parametrize("speed", ["0.463m/s", "3.329m/s"])
def test_what_cannot_be_tuned(run: Run, speed: str) -> None:
    ran = run(*TUNE, "--speed", speed)
    assert ran.code == 1 and ran.json["feasible"] is False
    assert ran.json["vacuum"] is None and len(ran.json["reason"]) > 20


@pytest.mark.parametrize(
    "words",
    [
        ("--speed", "2.5", "--vacuum", "94.5kPa"),
        ("--speed", "2.5m/s"),
        ("--vacuum", "94.5kPa"),
        ("--speed", "1m/s", "--height", "1m", "--vacuum", "94.5kPa"),
        ("--height", "1m", "--horizontal", "--vacuum", "94.5kPa"),
        ("--speed", "1m/s", "--vacuum", "tuned"),
        ("--speed", "1m/s", "--vacuum", "200kPa"),
        ("--speed", "1m/s", "--vacuum", "94.5kPa", "--no-brake"),
        ("--speed=-1m/s", "--vacuum", "94.5kPa"),
    ],
)
def test_bad_input(refuses: Callable[..., str], words: tuple[str, ...]) -> None:
    refuses(*DROP, *words)

"""`plan`: the whole answer, "cannot" as an answer, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from layerjam.bench.commands.plan import plan
from layerjam.brake.fluid.line_file import LineFile
from layerjam.cli.main import main
from layerjam.core.errors import QuantityError, UnknownNameError

CASE = {"mass": "1 kg", "speed": "2.5 m/s", "warning": "3 s", "travel": "40 mm"}
TANK = """name = "tank"
[chamber]
volume = "12 mL"
[pump]
flow = "5 mL/s"
ultimate = "5 kPa"
power = "3 W"
[leak]
laminar = "0.02 mL/s"
[reservoir]
volume = "60 mL"
conductance = "0.05 L/(s bar)"
delay = "15 ms"
"""


def asked(line="choi2018", **changes):
    return plan(line, "choi2018-kapton", **(CASE | changes))


def test_enough():
    made = asked()
    assert made.feasible is True and made.reason is None
    assert made.reached == pytest.approx(74566, rel=1e-3)
    assert made.slip < 0.04 and made.tuned_slip == pytest.approx(0.04, rel=1e-9)
    assert made.tuned_vacuum == made.needed and made.tuned_capped is False
    assert made.tuned_peak_g < made.peak_g
    assert made.reservoir_needed is None and "not needed" in made.reservoir_needed_reason
    assert made.heat_per_work == pytest.approx(made.dissipated_energy / made.jam_work)
    assert any("inferred" in w for w in made.warnings)
    assert set(made.units) <= set(made.values)


def test_too_little_is_an_answer_with_what_to_build():
    made = asked(warning="0.3 s")
    assert made.feasible is False
    assert made.reason.startswith("12.63 kPa is reached after 0.3 s; 61.1 kPa is needed")
    assert made.outcome == "BOTTOMED_OUT" and made.end_speed > 2
    assert made.warning_needed == pytest.approx(2.081, rel=1e-3)
    assert made.standing_needed == pytest.approx(55361, rel=1e-4)
    assert made.reservoir_needed > 0 and made.cv_needed > 0
    assert made.standing_needed_force > 90
    assert made.tuned_capped is True and made.tuned_vacuum == made.reached
    assert any("all three are assumed" in w for w in made.warnings)
    # and with that built it does
    there = asked(warning=made.warning_needed * 1.0001)
    assert there.feasible is True


def test_a_brake_too_weak_says_what_the_brake_needs():
    made = asked(speed="5 m/s")
    assert made.feasible is False and made.needed is None
    assert "vacuum available at the site is sufficient" in made.reason and "sheets" in made.reason
    assert made.standing_needed is None and made.standing_needed_reason is not None


def test_uncertain():
    made = asked(mass_sd="0.1 kg", speed_sd="0.2 m/s")
    assert made.full_expected_g > made.tuned_expected_g
    assert 0 < made.full_out < made.tuned_out < 1
    assert made.chance_error < 2e-3
    again = asked(mass_sd="0.1 kg", speed_sd="0.2 m/s")
    assert again.values == made.values
    other = asked(mass_sd="0.1 kg", speed_sd="0.2 m/s", seed=2, samples=10_000)
    error = (made.chance_error**2 + other.chance_error**2) ** 0.5
    assert other.tuned_out == pytest.approx(made.tuned_out, abs=4 * error)


def test_a_reservoir_a_leak_and_their_cost():
    line = LineFile.read(TANK, "tank.toml")
    made = asked(line, warning="0.2 s", standing="20 kPa", stored="90 kPa")
    assert made.standing_power > 0
    assert made.standing_electric > made.standing_power
    assert made.refill_work > 0 and made.pump_energy == pytest.approx(0.6)
    assert made.heat_per_pump_energy == pytest.approx(made.dissipated_energy / 0.6)
    assert any("opens after" in w for w in asked(line, warning="10 ms").warnings)
    assert any("evacuated to" in w for w in asked(line).warnings)


@pytest.mark.campaign
def test_a_stretching_sleeve():
    text = TANK.replace('volume = "12 mL"', 'volume = "12 mL"\nvolume_per_slip = "40 mm^2"', 1)
    made = asked(LineFile.read(text, "tank.toml"), speed="1.8 m/s", warning="0.5 s")
    assert made.coupling_remaining <= 1e-6
    assert made.tuned_vacuum_change > 0 and made.tuned_slip_change < 0
    assert made.tuned_coupling_matters is True
    assert any("stretching" in w for w in made.warnings)


def test_water():
    made = asked(fluid="water", warning="1 s")
    assert made.reached == pytest.approx(3.33e-6 / 6.607e-11, rel=1e-3)
    assert made.standing_power is None
    assert any("water" in w for w in made.warnings)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"mass": "0 kg"}, "mass: 0 g is not allowed"),
        ({"mass": "1"}, "mass: '1' has no unit"),
        ({"speed": "-2 m/s"}, "speed: -2 m/s is not allowed"),
        ({"warning": "-1 s"}, "warning: -1 s is not allowed; warning time"),
        ({"warning": float("nan")}, "warning: nan is not allowed"),
        ({"travel": "61 mm"}, "travel: 61 mm is beyond the usable travel of 60 mm"),
        ({"standing": "102 kPa"}, "standing: 102 kPa is more than the line can hold"),
        ({"mass_sd": "2 kg"}, "mass sd: 2 kg is more than the mass itself"),
        ({"speed_sd": "-1 m/s"}, "speed sd: -1 m/s is not allowed"),
        ({"stored": "90 kPa"}, "stored: the line has no reservoir"),
        (
            {"samples": 5},
            "samples: 5 is not allowed; masses, speeds and brakes to try must be at least 100",
        ),
        ({"seed": -1}, "seed: -1 is not allowed"),
        ({"rope_stiffness": "0 N/m"}, "rope stiffness: 0 kN/m is not allowed"),
    ],
)
def test_what_is_refused(changes, words):
    with pytest.raises(QuantityError, match=words):
        asked(**changes)


def test_other_refusals():
    with pytest.raises(UnknownNameError, match="fluid"):
        asked(fluid="oil")
    with pytest.raises(UnknownNameError, match="line"):
        asked("choi2019")
    tank = LineFile.read(TANK, "tank.toml")
    with pytest.raises(QuantityError, match="chamber.compliance: not given"):
        asked(tank, fluid="water")
    wet = LineFile.read(TANK.replace("[pump]", 'compliance = "0.07 mL/kPa"\n[pump]'), "t")
    with pytest.raises(QuantityError, match="tank has a gas reservoir"):
        asked(wet, fluid="water")
    with pytest.raises(QuantityError, match="stored: 110 kPa exceeds atmospheric pressure"):
        asked(tank, stored="110 kPa")
    high = LineFile.read(TANK + '[site]\natmosphere = "80 kPa"\n', "t")
    with pytest.raises(QuantityError, match="80 kPa in the line tank and 101.325 kPa in the"):
        asked(high)
    assert asked(high, atmosphere="80 kPa").reached < 75e3


def test_the_command_and_its_figure(tmp_path: Path, capsys):
    figure = tmp_path / "plan.png"
    words = ["--mass", "1kg", "--speed", "2.5m/s", "--speed-sd", "0.2m/s", "--warning", "0.3s"]
    words += ["--travel", "40mm", "--figure", str(figure), "--json"]
    assert main(["plan", "choi2018", "choi2018-kapton", *words]) == 1
    values = json.loads(capsys.readouterr().out)
    assert values["feasible"] is False and values["units"]["needed"] == "Pa"
    assert figure.read_bytes()[:4] == b"\x89PNG"


def test_rope_of_the_brake_file_is_used_only_if_its_stiffness_is_given():
    answers = [
        plan("choi2018", "choi2018-kapton", **CASE, rope_stiffness=k) for k in (None, 16.8e3)
    ]
    said = ["give --rope-stiffness 16.8kN/m" in "; ".join(answer.warnings) for answer in answers]
    assert said == [True, False]
    assert answers[1].needed < answers[0].needed

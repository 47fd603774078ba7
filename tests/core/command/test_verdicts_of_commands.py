"""Verdicts of commands on logs, specimens, pulls, lines and designs: exit 4, and what is accepted.

Every log is computed here from its closed form, so that what is wrong with it is known.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import layerjam as lj
from layerjam.brake.fluid.line import Leak
from layerjam.brake.simulate.accelerometer import Accelerometer
from layerjam.cli.main import main
from layerjam.core.command.results import Result
from layerjam.core.errors import QuantityError
from layerjam.core.verdict import Acceptance

ATMOSPHERE, G = 101325.0, 9.80665


def written(path: Path, **columns: np.ndarray) -> Path:
    """A CSV file with one column for each name."""
    table = np.column_stack(list(columns.values()))
    head = ",".join(columns)
    np.savetxt(path, table, delimiter=",", header=head, comments="", fmt="%.8g")
    return path


def failed(made: Result) -> set[str]:
    """The names of the failed checks."""
    return {check["name"] for check in made.failed_checks}


def hold(path: Path, lost: float, noise: float = 20.0) -> Path:
    """Ten minutes of a chamber at 80 kPa of vacuum that loses this share, with its temperature."""
    time = np.arange(0, 600, 1.0)
    vacuum = 80e3 * (1 - lost) ** (time / 600)
    read = ATMOSPHERE - vacuum + np.random.default_rng(1).normal(0, noise, len(time))
    return written(
        path,
        **{"time [s]": time, "pressure [Pa]": read, "temperature [K]": np.full(len(time), 293.15)},
    )


def test_a_tight_chamber_has_no_leak_to_rely_on(tmp_path: Path) -> None:
    good = lj.leak(hold(tmp_path / "good.csv", 0.4), reading="absolute")
    assert good.verdict == "passed" and good.exit_code == 0
    assert all(check["level"] in ("passed", "warning") for check in good.checks)
    tight = lj.leak(hold(tmp_path / "tight.csv", 0.0), reading="absolute", start="0 s")
    assert tight.exit_code == 4 and failed(tight) == {"leak interval"}
    assert 0 < tight.rate_low < 0.01 * tight.rate_high
    reason = {"leak interval": "an upper bound does"}
    kept = lj.leak(tmp_path / "tight.csv", reading="absolute", start="0 s", accept=reason)
    assert (kept.verdict, kept.exit_code) == ("accepted", 0)
    assert kept.accepted[0]["reason"] == "an upper bound does"


def test_a_valve_that_opens_in_the_log_fails_the_law(tmp_path: Path) -> None:
    time = np.arange(0, 60, 0.1)
    pressure = ATMOSPHERE - 80e3 * np.exp(-time / 60)
    pressure[300:] = ATMOSPHERE - 5e3
    path = written(tmp_path / "opened.csv", **{"time [s]": time, "pressure [Pa]": pressure})
    assert "law" in failed(lj.leak(path, reading="absolute"))
    falls = 5e3 + 96e3 * np.exp(-time / 3)
    falls[300:] += 60e3
    path = written(tmp_path / "pump.csv", **{"time [s]": time, "pressure [Pa]": falls})
    assert "law" in failed(lj.pump_down(path, reading="absolute"))


def test_a_pump_down_passes(tmp_path: Path) -> None:
    time = np.linspace(0, 20, 1000)
    read = 5e3 + 96e3 * np.exp(-time / 3) + np.random.default_rng(2).normal(0, 20, len(time))
    path = written(tmp_path / "down.csv", **{"time [s]": time, "pressure [Pa]": read})
    made = lj.pump_down(path, reading="absolute", volume="1 L")
    assert made.verdict == "passed"
    assert made.flow_low < 1e-3 / 3 < made.flow_high


def specimen(path: Path, factor: float) -> Path:
    """A neo-Hookean specimen of 18 mm² with a 100 % modulus of `factor` times 69 kPa."""
    strain = np.linspace(0, 3, 400)
    stretch = 1 + strain
    stress = factor * 69e3 * (stretch - stretch**-2) / (2 - 0.25)
    return written(path, **{"strain [-]": strain, "stress [Pa]": stress})


def test_one_specimen_in_another_unit_is_named_and_no_brake_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    paths = [specimen(tmp_path / f"s{n}.csv", f) for n, f in enumerate((1.0, 1.04, 0.97))]
    out = tmp_path / "brake.toml"
    words = ["enclosure", *map(str, paths), "--material", "ecoflex-00-30"]
    words += ["--brake", "choi2018-kapton", "--out", str(out)]
    assert main([*words, "--json"]) == 0 and out.exists()
    assert json.loads(capsys.readouterr().out)["verdict"] == "passed"
    out.unlink()
    specimen(paths[1], 4.448)  # newtons read as pounds
    assert main([*words, "--json"]) == 4 and not out.exists()
    answer = json.loads(capsys.readouterr().out)
    rows = {row["name"]: row["reason"] for row in answer["failed_checks"]}
    assert "s1.csv" in rows["repeats"] and {"level"} <= set(answer["checks"][0])
    accept = [w for name in rows for w in ("--accept", f"{name}=a trial")]
    assert main([*words, *accept]) == 0
    capsys.readouterr()
    stored = lj.load(out).accepted
    assert {one.check for one in stored} == set(rows)
    assert all("enclosure.modulus" in one.numbers for one in stored)


def pulse(path: Path, clip: float = np.inf, end: float = 0.2) -> Path:
    """A half sine of 50 g and 20 ms with noise."""
    time = np.arange(0, end, 1e-4)
    inside = (time >= 0.08) & (time <= 0.1)
    shape = np.where(inside, np.sin(np.pi * (time - 0.08) / 0.02), 0.0)
    noise = np.random.default_rng(3).normal(0, 0.3, len(time))
    signal = np.minimum(50 * G * shape + noise, clip * G)
    return written(path, **{"time [s]": time, "acceleration [m/s^2]": signal})


def test_a_saturated_or_cut_pulse_fails(tmp_path: Path) -> None:
    assert lj.crash(pulse(tmp_path / "good.csv")).verdict == "passed"
    assert failed(lj.crash(pulse(tmp_path / "clipped.csv", clip=30))) == {"saturation"}
    assert "whole pulse" in failed(lj.crash(pulse(tmp_path / "cut.csv", end=0.092)))


def test_a_peak_beyond_the_accelerometers_range_fails() -> None:
    case = {"mass": 1.0, "speed": 2.5, "vacuum": 94.5e3, "rope_stiffness": 16.8e3}
    plain = lj.drop("choi2018-kapton", **case)
    assert plain.verdict is None and plain.checks == ()
    small = Accelerometer(range=5 * G)
    assert plain.peak_g > 5
    made = lj.drop("choi2018-kapton", **case, accelerometer=small)
    assert made.exit_code == 4 and failed(made) == {"saturation"}
    kept = lj.drop("choi2018-kapton", **case, accelerometer=small, accept={"saturation": "known"})
    assert kept.exit_code == 0 and kept.verdict == "accepted"


def small_line(volume: float, leak: float) -> Any:
    """The paper's line with another volume [m³] and a laminar leak [m³/s]."""
    line = lj.load_line("choi2018").line
    chamber = replace(line.chamber, volume=volume)
    return replace(line, chamber=chamber, leak=Leak(laminar=leak))


def test_a_ripple_of_a_multiple_of_the_band_fails_with_its_cause_and_the_remedy_holds() -> None:
    line = small_line(0.75e-6, 1e-7)
    how = {"target": 11e3, "safe_state": "release", "sensor_range": "103 kPa"}
    made = lj.regulate(line, kind="bang-bang", **how)
    assert made.outcome == "HEALTHY" and made.exit_code == 4 and failed(made) == {"ripple"}
    regulator, loop = made.record
    late = loop.vacuum[loop.time > 0.75 * loop.time[-1]]
    assert np.ptp(late) > 0.45 * 11e3
    # the change of one sample, from the plant's own differential equation
    plant, sample = regulator.plant, regulator.sample_time
    fall = (plant.vent + plant.leak) * 11e3 * sample
    (reason,) = (check["reason"] for check in made.failed_checks)
    assert f"{fall / 1e3:.3f}" in reason and "one sample (10 ms) of the vent" in reason
    assert "a sample time of" in reason and "use pi" in reason
    time = reason.split("a sample time of ")[1].split(",")[0]
    for remedy in ({"kind": "bang-bang", "sample_time": time}, {"kind": "pi"}):
        assert lj.regulate(line, **how, **remedy).verdict == "passed"


def test_a_target_that_is_not_reached_fails() -> None:
    how = {"target": "60 kPa", "safe_state": "release", "sensor_range": "103 kPa"}
    short = lj.regulate("choi2018", duration="0.5 s", **how)
    assert failed(short) == {"target"}
    assert lj.regulate("choi2018", **how).verdict == "passed"
    with pytest.raises(QuantityError, match="has not failed"):
        lj.regulate("choi2018", accept={"ripple": "no"}, **how)


def test_a_run_of_the_bench_begins_only_with_a_regulator_that_holds(tmp_path: Path) -> None:
    run = tmp_path / "run.ljrun"
    how: dict[str, Any] = {
        "procedure": "evacuate to 40 kPa and hold 1 s; vent",
        "brake": "choi2018-kapton",
        "line": "choi2018",
        "safe_state": "release",
        "vent_rest": "open",
        "sensor_range": "103 kPa",
        "kind": "bang-bang",
        "least_run": "1 s",
        "out": run,
    }
    made = lj.bench_run("sim:choi2018?speed=0", **how)
    assert made.exit_code == 4 and failed(made) == {"ripple"}
    assert made.outcome == "NOT_BEGUN" and not run.exists()
    kept = lj.bench_run("sim:choi2018?speed=0", **how, accept={"ripple": "a trial"})
    assert kept.verdict == "accepted" and run.exists()
    later = lj.bench_export(run, out=tmp_path / "run.csv")
    assert [row["reason"] for row in later.accepted] == ["a trial"]
    assert any("a trial" in said for said in later.warnings)


def accepted(text: str, *numbers: str) -> str:
    """The text of a file with one accepted failure."""
    row = '\n[[accepted]]\ncheck = "agreement"\nreason = "new operator"\ndate = "2026-11-24"\n'
    return text + row + (f"numbers = {json.dumps(numbers)}\n" if numbers else "")


def test_an_acceptance_of_a_line_travels_through_reading_changing_and_writing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "line.toml"
    path.write_text(accepted(lj.load_line("choi2018").text, "chamber.volume"))
    file = lj.load_line(path)
    (decision,) = file.accepted
    assert isinstance(decision, Acceptance) and decision.reason == "new operator"
    assert type(file).read(file.render("again"), "again").accepted[0].check == "agreement"
    assert file.with_(count=2).accepted[0].date == "2026-11-24"
    assert file.with_(chamber_volume="9 mL").accepted[0].reason == "new operator"
    assert file.with_(chamber_volume=file.line.chamber.volume).accepted == file.with_().accepted
    assert main(["rise", str(path), "--target", "60kPa", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["verdict"] == "accepted" and answer["accepted"][0]["file"] == str(path)
    assert any("new operator" in said for said in answer["warnings"])


def pulls(folder: Path, factors: Any) -> list[Path]:
    """Pulls of the model at 60 and 80 kPa with their sidecars, forces times a factor each."""
    made = []
    for number, factor in enumerate(factors):
        vacuum = ("60 kPa", "80 kPa")[number % 2]
        pull = lj.tensile("choi2018-kapton", vacuum=vacuum, speed="13 mm/s", travel="30 mm")
        frame = pull.to_frame()
        path = written(
            folder / f"pull-{number}.csv",
            **{
                "time [s]": frame["time"].to_numpy(),
                "elongation [mm]": frame["elongation"].to_numpy() * 1e3,
                "force [N]": frame["force"].to_numpy() * factor,
            },
        )
        Path(f"{path}.toml").write_text(f'vacuum = "{vacuum}"\n')
        made.append(path)
    return made


def test_validation_names_a_pull_in_another_unit(tmp_path: Path) -> None:
    good = lj.validate("choi2018-kapton", pulls(tmp_path, (1.0, 1.01, 0.99, 1.02)))
    assert good.verdict == "passed"
    wrong = lj.validate("choi2018-kapton", pulls(tmp_path, (1.0, 1.01, 4.4482216, 1.02)))
    assert wrong.exit_code == 4 and failed(wrong) >= {"pulls"}
    reason = next(c["reason"] for c in wrong.failed_checks if c["name"] == "pulls")
    assert "pull-2.csv" in reason and "lbf" in reason and "--exclude" in reason
    every = lj.validate("choi2018-kapton", pulls(tmp_path, [1e-3 * 4.45] * 4))
    assert "model" in failed(every)


def test_a_chosen_design_is_checked() -> None:
    from layerjam.brake.mechanics.pull import peak
    from layerjam.workshop.design.verdict import design_checks

    file = lj.load("choi2018-kapton")
    sheets, film = file.brake.sheets, file.brake.film
    force = float(peak(94.5e3, sheets.usable_travel, file.brake).force)
    # the sheets of one side share the force: the fewer of both sides
    stress = force / ((sheets.count // 2) * sheets.width * sheets.thickness)
    for strength, level in ((stress * 1.01, "passed"), (stress * 0.99, "failed")):
        weak = replace(file, brake=replace(file.brake, film=replace(film, strength=strength)))
        (found,) = design_checks(weak, 94.5e3)
        assert found.level == level

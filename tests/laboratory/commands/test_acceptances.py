"""An acceptance of a failed check is carried by every command that writes or derives a brake.

It ends only if the same number is measured again from at least as many files and passes.
"""

from __future__ import annotations

import dataclasses
import importlib.util
import json
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import layerjam as lj
from laboratory.campaigns import bench as virtual
from layerjam.brake.commands.edit import edit
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.cli.main import main
from layerjam.core.command.index import commands
from layerjam.core.errors import QuantityError
from layerjam.core.verdict import Check
from layerjam.laboratory.commands.friction import FrictionTest
from layerjam.laboratory.commands.records import records_add, records_list
from layerjam.laboratory.measure.trace import Trace
from layerjam.workshop.commands.design import brake_of, design

BRAKE = "choi2018-kapton"
FRICTION = ("film.static", "film.kinetic")
FITTED = ("scale_factor", "stiffness_measured")
NUMBERS = (*FRICTION, *FITTED, "enclosure.modulus")
SLED = virtual.Machine(sampling_rate=100.0, load_cell_noise=0.002, load_cell_range=10.0)
FILES = 3
"""Number of files on which each acceptance rests."""


@pytest.fixture
def accepted(tmp_path: Path) -> Path:
    """A brake with an accepted failure of each of its numbers."""
    path = tmp_path / "accepted.toml"
    rows = "".join(
        f'\n[[accepted]]\ncheck = "{number} check"\nreason = "new operator"\n'
        f'date = "2026-11-24"\nnumbers = ["{number}"]\nfiles = {FILES}\n'
        for number in NUMBERS
    )
    path.write_text(lj.load(BRAKE).text + rows)
    return path


def friction_tests(count: int) -> list[Trace]:
    return [
        virtual.friction(
            0.32, 0.24, 2.45, machine=SLED, repeat=n, static_sd=0.003, kinetic_sd=0.003
        )
        for n in range(1, count + 1)
    ]


def pulls(count: int) -> list[Trace]:
    brake = lj.load(BRAKE).brake
    factors = 0.875 * (1 + 0.01 * np.random.default_rng(3).standard_normal(count))
    return [
        virtual.pull(dataclasses.replace(brake, scale_factor=f), 94.5e3, 0.013, 0.04, repeat=n)
        for n, f in enumerate(factors, 1)
    ]


def specimens(folder: Path, count: int) -> list[Path]:
    """Neo-Hookean specimens with a 100 % modulus near 69 kPa."""
    strain = np.linspace(0, 3, 400)
    stretch = 1 + strain
    paths = []
    for number in range(count):
        stress = (1 + 0.01 * number) * 69e3 * (stretch - stretch**-2) / (2 - 0.25)
        paths.append(folder / f"specimen-{number}.csv")
        table = np.column_stack([strain, stress])
        np.savetxt(paths[-1], table, delimiter=",", header="strain [-],stress [Pa]", comments="")
    return paths


def holds(count: int) -> list[Trace]:
    """Friction tests after holds of 1 s to 1000 s."""
    traces = []
    for number in range(count):
        hold = 10.0 ** (number % 4)
        static = 0.3 + 0.02 * np.log10(hold)
        trace = virtual.friction(static, 0.24, 2.45, machine=SLED, repeat=number + 1)
        traces.append(dataclasses.replace(trace, facts=dataclasses.replace(trace.facts, hold=hold)))
    return traces


def from_friction(brake: Any, folder: Path, count: int) -> Path:
    out = folder / "friction.toml"
    lj.friction(friction_tests(count), test={"normal_force": "2.45 N"}, brake=brake, out=out)
    return out


def from_calibrate(brake: Any, folder: Path, count: int) -> Path:
    out = folder / "calibrate.toml"
    lj.calibrate(brake, pulls(count), vacuum="94.5 kPa", out=out)
    return out


def from_enclosure(brake: Any, folder: Path, count: int) -> Path:
    out = folder / "enclosure.toml"
    files = specimens(folder, count)
    lj.enclosure(files, material="ecoflex-00-30", brake=brake, out=out)
    return out


def from_ageing(brake: Any, folder: Path, count: int) -> Path:
    out = folder / "ageing.toml"
    lj.ageing(holds(count), hold=10.0, brake=brake, out=out, test={"normal_force": "2.45 N"})
    return out


def from_design(brake: Any, folder: Path, _count: int) -> Path:
    out = folder / "design.toml"
    spec = {
        "name": "next", "brake": str(brake), "constraints": ["holding_force >= 50 N"],
        "objectives": ["minimise mass"], "vary": {"count": [13, 15]},
    }  # fmt: skip
    lj.design(spec, out=out)
    return out


def from_new(brake: Any, folder: Path, _count: int) -> Path:
    out = folder / "new.toml"
    lj.new("next", brake, out)
    return out


MEASURE: dict[str, tuple[Callable[[Any, Path, int], Path], tuple[str, ...], Sequence[int]]] = {
    "friction": (from_friction, FRICTION, (1, 2, 3, 4)),
    "calibrate": (from_calibrate, FITTED, (1, 2, 3, 4)),
    "enclosure": (from_enclosure, ("enclosure.modulus",), (1, 2, 3, 4)),
    "ageing": (from_ageing, (), (8,)),
    "new": (from_new, (), (0,)),
    "design": (from_design, (), (0,)),
}
"""{command that writes a brake: (call, numbers that it measures and judges, numbers of files)}."""


def carried(file: BrakeFile) -> set[str]:
    return {number for entry in file.accepted for number in entry.numbers}


MASS = ["--mass", "0.5kg", "--speed", "1m/s"]
VACUUM = ["--vacuum", "60kPa"]
BENCH = ["--safe-state", "release", "--sensor-range", "103kPa"]
READ: dict[str, list[str]] = {
    "show": ["show", "BRAKE"],
    "force": ["force", "BRAKE", "--slip", "20mm", *VACUUM],
    "vacuum": ["vacuum", "BRAKE", "--slip", "10mm", "--force", "50N"],
    "tensile": ["tensile", "BRAKE", *VACUUM, "--speed", "13mm/s", "--travel", "5mm"],
    "drop": ["drop", "BRAKE", *MASS, "--vacuum", "80kPa"],
    "tune": ["tune", "BRAKE", *MASS, "--travel", "40mm"],
    "stick_slip": ["stick-slip", "BRAKE", *VACUUM, "--speed", "5mm/s"],
    "bend": ["bend", "BRAKE", *VACUUM, "--angle", "30deg"],
    "array": ["array", "BRAKE"],
    "compare": ["compare", "BRAKE"],
    "follow": [
        "follow", "choi2018", "BRAKE", "--profile", "sine", "--low", "20N", "--high", "80N",
        "--period", "10s", "--duration", "10s", "--speed", "1mm/s", *BENCH,
    ],
    "plan": ["plan", "choi2018", "BRAKE", *MASS, "--warning", "9s", "--travel", "40mm"],
    "build": ["build", "BRAKE", "--out", "OUT"],
    "export_c": ["export", "c", "BRAKE", "--out", "OUT"],
    "export_fmu": ["export", "fmu", "BRAKE", "--out", "OUT.fmu"],
    "export_html": ["export", "html", "BRAKE", "--out", "OUT.html"],
    "export_mujoco": ["export", "mujoco", "BRAKE", "--out", "OUT", "--no-build"],
    "bench_run": [
        "bench", "run", "sim:choi2018?speed=0", "--brake", "BRAKE", "--line", "choi2018",
        "--procedure", "evacuate to 40 kPa and hold 1 s; vent", "--vent-rest", "open",
        "--out", "OUT.ljrun", *BENCH,
    ],
}  # fmt: skip
"""{command that reads a brake: words}, besides those of MEASURE."""
OF_FILES = {"validate", "report", "publish"}
"""Commands that read a brake and the files of a campaign; tests/laboratory/dataset has them."""
SLOW = {"build": pytest.mark.slow, "bench_run": pytest.mark.timing}


def read_signatures() -> dict[str, str]:
    """Return {function of a command: its signature} from the sources."""
    modules = {entry.module for entry in commands().values()}
    heads = re.compile(r"\n@command\([^@]*?\ndef (\w+)\((.*?)\n\) ->", re.DOTALL)
    sources = [Path(str(importlib.util.find_spec(name).origin)) for name in modules]  # type: ignore[union-attr]
    return dict(match for path in sources for match in heads.findall(path.read_text("utf-8")))


def test_every_command_with_a_brake_is_listed() -> None:
    found = read_signatures()
    assert len(found) > 20
    assert {name for name, signature in found.items() if "OutBrake" in signature} == {*MEASURE}
    words = re.compile("BrakeInput|AnyBrake|TargetBrake|BrakeFile")
    reads = {name for name, signature in found.items() if words.search(signature)}
    assert reads <= {*READ, *MEASURE, *OF_FILES}


@pytest.mark.parametrize("name", [pytest.param(n, marks=SLOW.get(n, ())) for n in READ])
def test_every_command_that_reads_a_brake_reports_its_acceptances(
    accepted: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    paths = {"BRAKE": str(accepted), "OUT": str(tmp_path / "out")}
    words = [re.sub("BRAKE|OUT", lambda match: paths[match[0]], word) for word in READ[name]]
    code = main([*words, "--json"])
    answer = json.loads(capsys.readouterr().out)
    assert code in (0, 4) and answer["verdict"] in ("accepted", "failed"), answer
    assert {row["reason"] for row in answer["accepted"]} == {"new operator"}
    assert len(answer["accepted"]) == len(NUMBERS)
    assert any("new operator" in sentence for sentence in answer["warnings"])


def test_the_brake_in_the_head_of_a_record_has_them(accepted: Path, tmp_path: Path) -> None:
    path = lj.tensile(accepted, vacuum="60 kPa", speed="13 mm/s", travel="5 mm").record.to_csv(
        tmp_path / "pull.csv"
    )
    head = [line for line in path.read_text("utf-8").splitlines() if line.startswith("#   ")]
    text = "\n".join(line.removeprefix("#   ") for line in head)
    assert carried(BrakeFile.read(text, "again")) == {*NUMBERS}


QUICK = {
    *(("friction", n) for n in (2, 3)),
    *(("calibrate", n) for n in (1, 2, 3)),
    *(("enclosure", n) for n in (2, 3)),
    ("ageing", 8),
    ("new", 0),
}
"""Fewer files than those of the acceptance, and as many."""


@pytest.mark.parametrize(
    ("name", "count"),
    [
        pytest.param(name, count, marks=[] if (name, count) in QUICK else pytest.mark.slow)
        for name in MEASURE
        for count in MEASURE[name][2]
    ],
)
def test_an_acceptance_is_carried_or_replaced_by_as_many_files_that_pass(
    accepted: Path, tmp_path: Path, name: str, count: int
) -> None:
    call, numbers, _ = MEASURE[name]
    ends = {*numbers} if count >= FILES else set()
    out = call(accepted, tmp_path, count)
    if (name, count) == ("calibrate", 2):
        assert not out.exists()  # two pulls determine no interval: exit 4
        return
    file = lj.load(out)
    assert carried(file) == {*NUMBERS} - ends
    assert {entry.reason for entry in file.accepted} <= {"new operator"}


@pytest.mark.parametrize(
    "name",
    ["friction", "calibrate", "ageing", pytest.param("enclosure", marks=pytest.mark.slow)],
)
def test_a_plain_brake_carries_them_too(accepted: Path, tmp_path: Path, name: str) -> None:
    call, numbers, counts = MEASURE[name]
    count = max(counts)
    brake = lj.load(accepted).brake
    ends = {*numbers} if count >= FILES else set()
    assert carried(lj.load(call(brake, tmp_path, count))) == {*NUMBERS} - ends
    assert carried(lj.show(brake).record) == {*NUMBERS}
    assert lj.show(brake.with_(width="14 mm")).verdict == "accepted"


def test_a_measurement_that_fails_and_is_accepted_replaces_only_the_same_check(
    accepted: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out.toml"
    tests = friction_tests(4)
    tests[0] = dataclasses.replace(tests[0], force=tests[0].force * 1e-3)
    test = {"normal_force": "2.45 N"}
    answer = lj.friction(tests, test=test, brake=accepted, out=out)
    assert answer.exit_code == 4 and not out.exists()
    reasons = {row["name"]: "the sled was lifted" for row in answer.failed_checks}
    lj.friction(tests, test=test, brake=accepted, out=out, accept=reasons)
    file = lj.load(out)
    assert carried(file) == {*NUMBERS}
    assert {entry.files for entry in file.accepted} == {FILES, 4}
    again = tmp_path / "again.toml"
    lj.friction(friction_tests(3), test=test, brake=out, out=again)
    assert "the sled was lifted" in {entry.reason for entry in lj.load(again).accepted}
    lj.friction(friction_tests(4), test=test, brake=out, out=again, overwrite=True)
    assert "the sled was lifted" not in {entry.reason for entry in lj.load(again).accepted}


@pytest.mark.parametrize("value", ["same", "0.2401", None])
def test_a_hand_keeps_them(accepted: Path, value: str | None) -> None:
    file = lj.load(accepted)
    same = file.brake.film.kinetic
    changes = {} if value is None else {"film.kinetic": same if value == "same" else value}
    assert carried(edit(file, changes).record) == {*NUMBERS}
    assert carried(file.with_(**{k.partition(".")[2]: v for k, v in changes.items()})) == {*NUMBERS}
    assert carried(edit(file.brake, changes, name="mine").record) == {*NUMBERS}
    assert carried(file.with_(scale_factor=None)) == {*NUMBERS} - {"scale_factor"}


SPECIFICATION = """
name = "hold"
brake = "{brake}"
constraints = ["holding_force >= 100 N"]
objectives = ["minimise mass"]
{film}
[vary]
count = {{ from = 5, to = 21, step = 2 }}
overlap = ["40 mm", "60 mm"]
"""


def designed(folder: Path, brake: object, film: object = None) -> tuple[Any, BrakeFile]:
    table = "" if film is None else f'[[film]]\nuse = "{film}"'
    path = folder / "hold.toml"
    path.write_text(SPECIFICATION.format(brake=brake, film=table))
    result = design(path)
    return result, brake_of(result, result.chosen["number"])


@pytest.mark.slow
def test_a_design_carries_those_of_its_brake_and_of_its_film(
    accepted: Path, tmp_path: Path
) -> None:
    result, file = designed(tmp_path, accepted.name)
    assert result.verdict == "accepted" and carried(file) == {*NUMBERS}
    result, file = designed(tmp_path, BRAKE, accepted.name)
    assert result.verdict == "accepted"
    assert carried(file) == {*FRICTION, "scale_factor"}
    result, file = designed(tmp_path, accepted.name, BRAKE)
    assert carried(file) == {"stiffness_measured", "enclosure.modulus"}


def test_the_film_of_another_brake_keeps_its_sources_and_its_spread(
    accepted: Path, tmp_path: Path
) -> None:
    text = accepted.read_text().replace(f'name = "{BRAKE}"', 'name = "other"')
    changed = lj.load(accepted).with_(scale_factor=0.9)
    assert changed.brake.scale_factor == 0.9
    other = tmp_path / "other.toml"
    other.write_text(changed.text.replace(f'name = "{BRAKE}"', 'name = "other"'))
    assert text != accepted.read_text()
    result, file = designed(tmp_path, BRAKE, "other.toml")
    assert file.brake.scale_factor == 0.9
    assert "as for other" in file.sources["scale_factor"].text
    assert BRAKE not in file.sources["scale_factor"].text
    spread = [str(w) for w in result.warnings if getattr(w, "key", "") == "scatter"]
    assert all("other" in sentence for sentence in spread)


def test_the_list_of_records_shows_them(accepted: Path, tmp_path: Path) -> None:
    db = str(tmp_path / "records.db")
    records_add([accepted], db=db)
    (row,) = [row for row in records_list(db=db).rows_ if row["kind"] == "brake"]
    assert row["accepted"] == len(NUMBERS)
    words = " ".join(str(records_list(db=db)).split())
    assert f"accepted: {len(NUMBERS)} failed checks" in words


def test_an_accepted_name_means_one_check(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`repeats` of the friction tests does not accept `repeats` of the calibration."""
    from layerjam.laboratory.commands.measurements import Measurements
    from layerjam.laboratory.commands.stages import HowTested, compute_stages
    from layerjam.laboratory.identify.calibration import peaks

    fit_peaks = peaks.calibrate_peaks

    def failing(*given: Any) -> Any:
        fit = fit_peaks(*given)
        checks = [c for c in fit.checks if c.name != "repeats"]
        failed = Check(name="repeats", level="failed", sentence="the pulls scatter")
        return dataclasses.replace(fit, checks=(*checks, failed))

    monkeypatch.setattr(peaks, "calibrate_peaks", failing)
    tests = friction_tests(3)
    tests[0] = dataclasses.replace(tests[0], force=tests[0].force * 1e-3)

    def stages(friction: Sequence[Trace], accept: dict[str, str]) -> Any:
        def written(traces: Sequence[Trace], word: str) -> list[Path]:
            paths = [tmp_path / f"{word}-{number}.csv" for number in range(len(traces))]
            pairs = zip(traces, paths, strict=True)
            return [virtual.write_bluehill(t, p, overwrite=True) for t, p in pairs]

        return compute_stages(
            lj.load(BRAKE),
            Measurements(friction=written(friction, "friction"), pulls=written(pulls(3), "pull")),
            HowTested(test=FrictionTest(normal_force=2.45), vacuum=94.5e3, accept=accept),
            lambda *_: None,
            command="test",
        )

    with pytest.raises(QuantityError, match=r"friction\.repeats, calibration\.repeats"):
        stages(tests, {"repeats": "the sled was lifted"})
    content = stages(tests, {"friction.repeats": "the sled was lifted"})
    failed = {check.name for check in content.verdict.failed}
    assert "calibration.repeats" in failed and "friction.repeats" not in failed
    assert all(entry.numbers == FRICTION for entry in content.file.accepted)
    content = stages(friction_tests(3), {"repeats": "a new mounting"})
    (entry,) = content.verdict.decisions
    assert entry.check == "calibration.repeats" and "scale_factor" in entry.numbers

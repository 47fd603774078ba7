"""`friction` and `pull` as verbs: the keys, the refusals, what is said."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from laboratory.campaigns import bench as virtual
from laboratory.campaigns.bench import FULL, curve
from laboratory.identify.saw import sled
from layerjam.core.drawing.folder import to_json as _plain
from layerjam.core.errors import FitError, Notice, QuantityError, UnknownNameError
from layerjam.laboratory.commands.friction import friction
from layerjam.laboratory.commands.pull import UNITS_OF_A_PULL, pull
from layerjam.laboratory.measure.readers.read import read_trace
from layerjam.laboratory.measure.sidecar import Facts
from layerjam.laboratory.measure.trace import Trace
from layerjam.workbench.pages.laboratory_results import REMEDIES
from strategies import KAPTON

MACHINE = virtual.Machine(sampling_rate=100.0, load_cell_noise=0.002, load_cell_range=10.0)


@pytest.fixture(scope="module")
def smooth(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("smooth")
    out = []
    for repeat in (1, 2, 3):
        trace = virtual.friction(0.32, 0.24, 2.45, machine=MACHINE, repeat=repeat, kinetic_sd=0.01,
                                 string_stiffness=300.0, travel=0.14)  # fmt: skip
        out.append(virtual.write_own(trace, folder / f"smooth-{repeat}.csv"))
    return out


@pytest.fixture(scope="module")
def saw(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("saw") / "saw.csv"
    return virtual.write_own(sled(0.32, 0.24, uneven=0.03, seed=1), path)


def test_every_key_is_there_and_is_json(smooth: list[Path]) -> None:
    answer = friction(smooth)
    assert answer.repeats == len(answer.repeats_table) == 3 and answer.stick_slip is None
    assert answer.standard == "paper" and answer.window == [0.040, 0.100]
    for name in ("static", "kinetic"):
        over = answer.intervals[name]
        assert over["mean"] == getattr(answer, name) and over["sd"] == getattr(answer, f"{name}_sd")
        assert over["low"] < over["mean"] < over["high"]
    json.dumps(_plain(answer.values), allow_nan=False)
    one = friction(smooth[:1])
    assert one.static_sd is None and one.intervals["kinetic"]["low"] is None


def test_the_pressure_of_the_test_and_of_use(smooth: list[Path]) -> None:
    answer = friction(smooth)
    assert answer.pressure["test"] == pytest.approx(2.45 / 0.025**2)  # the paper's 3.9 kPa
    assert answer.pressure["ratio"] == pytest.approx(101325 / 3920)
    assert any("3.92 kPa" in w and "26 times" in w for w in answer.warnings)
    wide = friction(smooth, area="40 cm^2")
    assert wide.pressure["test"] == pytest.approx(612.5) and not wide.pressure["area_assumed"]
    close = friction(smooth, area="30 mm^2")
    assert not any("times that" in w for w in close.warnings)
    with pytest.raises(QuantityError, match="area"):
        friction(smooth, area="25 mm")


def test_standards_and_windows(smooth: list[Path]) -> None:
    iso = friction(smooth, standard="iso8295")
    assert iso.window[1] - iso.window[0] == pytest.approx(0.060, abs=1e-9)
    assert iso.repeats_table[0]["inertial_force"] == pytest.approx(
        2.5e-3 * np.sqrt(300.0 * 0.2), rel=0.03
    )
    asked = friction(smooth, standard="d1894", start="20 mm")
    assert asked.window == [0.020, 0.130]
    with pytest.raises(UnknownNameError, match="iso8295"):
        friction(smooth, standard="iso8296")
    with pytest.raises(QuantityError, match="not below"):
        friction(smooth, end="30 mm")


def test_the_standards_own_sled(smooth: list[Path], tmp_path: Path) -> None:
    bare = tmp_path / "bare.csv"
    bare.write_bytes(smooth[0].read_bytes())
    with pytest.raises(Exception, match="--normal-force"):
        friction([bare])
    answer = friction([bare], standard="d1894")
    assert answer.static == pytest.approx(0.32 * 2.45 / (0.2 * 9.80665), rel=0.01)
    assert any("200 g sled of ASTM D1894" in w for w in answer.warnings)


def test_stick_slip_leaves_kinetic_null_with_a_reason(saw: Path, tmp_path: Path) -> None:
    answer = friction([saw])
    assert answer.kinetic is answer.kinetic_sd is answer.intervals["kinetic"] is None
    found = answer.stick_slip
    assert "not reported" in found["reason"] and found["files"] == [str(saw)]
    assert found["upper"] == pytest.approx(0.32, rel=0.02)
    assert found["lower"] == pytest.approx(0.16, rel=0.05)
    assert answer.repeats_table[0]["stick_slip"] and answer.repeats_table[0]["kinetic"] is None
    keys = {w.key: w for w in answer.warnings if isinstance(w, Notice)}
    assert "--accept-stick-slip" in keys["no-kinetic-friction"] and REMEDIES.keys() <= keys.keys()
    target = tmp_path / "mine.toml"
    with pytest.raises(FitError, match="--accept-stick-slip") as caught:
        friction([saw], brake="choi2018-kapton", out=target)
    assert not target.exists() and caught.value.notice in REMEDIES
    taken = friction([saw], accept_stick_slip=True, brake="choi2018-kapton", out=target)
    assert taken.kinetic == pytest.approx(0.24, rel=0.01) == found["middle"]
    assert any("is used as kinetic friction" in w for w in taken.warnings) and target.exists()
    assert not any(getattr(w, "key", "") == "no-kinetic-friction" for w in taken.warnings)
    assert friction([saw], accept_judder=True).kinetic == taken.kinetic  # type: ignore[call-arg]
    assert ": 0.3" in str(answer) and "stick–slip between" in str(answer)


def test_one_path_and_a_cut_trace_are_taken_as_well(smooth: list[Path]) -> None:
    alone = friction(smooth[0])
    assert alone.static == friction([str(smooth[0])]).static
    trace = read_trace(smooth[0])
    cut = trace.between(end=float(trace.elongation[0]) + 0.11, over="elongation")
    both = friction([cut, smooth[1]])
    assert both.repeats == 2 and both.repeats_table[0]["samples"] < len(trace)
    assert pull(cut).pulls[0]["file"] == str(smooth[0])
    twice = friction([cut, cut])
    assert twice.repeats == 1 and "same measurement" in twice.refused[cut.path]


def test_pull_answers_file_by_file(tmp_path: Path) -> None:
    trace = curve(KAPTON)
    made = Trace(trace.force + 1.0, trace.elongation, trace.time, "", "model",
                 facts=Facts(vacuum=FULL, synthetic=True, seed=1))  # fmt: skip
    slack = np.arange(-100, 0) * 1e-5
    late = replace(
        made,
        force=np.concatenate([np.full(100, 1.0), made.force]),
        elongation=np.concatenate([slack, made.elongation]),
        time=np.arange(4101) * 1e-3,
    )
    paths = [virtual.write_own(late, tmp_path / "late.csv")]
    (tmp_path / "bad.csv").write_text("nothing\n")
    answer = pull([*paths, tmp_path / "bad.csv"])
    assert list(answer.refused) == [str(tmp_path / "bad.csv")]
    (row,) = answer.pulls
    assert set(UNITS_OF_A_PULL) < set(row) and row["vacuum"] == FULL
    assert row["slack"] == pytest.approx(1e-3, abs=1e-8) and row["preload"] == pytest.approx(1.0)
    assert row["stiffness"] == pytest.approx(131e3, rel=1e-6)
    assert row["unloading_stiffness"] is None and row["stick_slip"] is False
    assert any("preload" in w for w in answer.warnings)
    tared = pull(paths, tare=True).pulls[0]
    assert tared["tared"] == pytest.approx(1.0)
    assert tared["peak_force"] == pytest.approx(row["peak_force"] - 1.0, abs=1e-3)
    json.dumps(_plain(answer.values), allow_nan=False)


def test_files_of_another_film_are_named_once(smooth: list[Path], tmp_path: Path) -> None:
    traces = [read_trace(path) for path in smooth]
    named = [replace(t, facts=replace(t.facts, brake="choi2018-ptfe")) for t in traces]
    answers = [friction(named, brake=name, out=tmp_path / f"{name}.toml")
               for name in ("choi2018-kapton", "choi2018-ptfe")]  # fmt: skip
    keys = [[w.key for w in answer.warnings] for answer in answers]
    assert [k.count("other-film") for k in keys] == [1, 0]

"""Files as users have them: every layout gives its right answer, or asks with a hint that works.

`Case.hints` is the number of hints to type, one after the other, before the command answers. Each
hint is taken from the message and typed on the file that caused it.
"""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from independent import field_files as made
from laboratory.measure.field_cases import CASES, GAUGE, SIZES, crash_file
from laboratory.measure.layouts import REAL
from layerjam.cli.main import main
from layerjam.core.errors import FitError

FIELD = REAL / "field"
HINT = re.compile(r"(--[a-z-]+) (?!lists)('[^']*'|[^\s;)]+)")
REPEATED = ("--negative",)


def run(capsys: pytest.CaptureFixture[str], *words: object) -> tuple[int, str, str]:
    """Return exit code, standard output and errors of a command."""
    code = main([str(word) for word in words])
    out = capsys.readouterr()
    return code, out.out, out.err


def read_hints(message: str) -> Iterator[list[str]]:
    """Yield the options that a message offers, as words to type."""
    for option, value in HINT.findall(message):
        yield [option, *shlex.split(value)]


def add_option(words: list[str], hint: list[str]) -> list[str]:
    """Return a command line with the option of a hint instead of an earlier one."""
    if hint[0] in words and hint[0] not in REPEATED:
        place = words.index(hint[0])
        words = words[:place] + words[place + 2 :]
    return [*words, *hint]


def find_number(result: Any, key: str) -> float:
    """Return a number of a result, or of its first pull."""
    return float(result["pulls"][0][key] if "pulls" in result else result[key])


@pytest.mark.parametrize("name", CASES)
def test_a_file_gives_its_right_answer(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = CASES[name]
    path = case.make(tmp_path / f"file.{case.ending}")
    words, said = [case.command, str(path), *case.options], []
    for _ in range(case.hints):
        code, _, err = run(capsys, *words)
        assert code == 2, f"{words} did not ask: {err}"
        assert err.count("\n") == 1 or len(err) > 70
        said.append(err)
        hints = list(read_hints(err))
        assert hints, f"{err} has no hint"
        words = add_option(words, hints[min(case.take, len(hints) - 1)])
    code, out, err = run(capsys, *words)
    assert code in (0, 4), f"{words}: {err}"
    text = " ".join(" ".join([*said, out]).split())
    for part in case.words:
        assert part in text
    assert "\nread:\n" in out
    _, out, _ = run(capsys, *words, "--json")
    for key, value in case.right.items():
        assert find_number(json.loads(out), key) == pytest.approx(value, rel=case.within)


@pytest.mark.parametrize("name", [name for name, case in CASES.items() if case.hints])
def test_every_hint_that_is_offered_works(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """No typed hint leads back to its own question, or to an error about the hint."""
    case = CASES[name]
    path = case.make(tmp_path / f"file.{case.ending}")
    words = [case.command, str(path), *case.options]
    code, _, err = run(capsys, *words)
    assert code == 2
    for hint in read_hints(err):
        code, _, after = run(capsys, *add_option(words, hint))
        assert code in (0, 4) or (after != err and list(read_hints(after))), (hint, after)


def test_load_cycles_are_not_stick_slip(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for count in (1, 2, 10):
        path = tmp_path / f"{count}.csv"
        made.csv(path, "Time (s),Extension (mm),Load (N)", *made.load_cycles(count), form="%.4f")
        code, out, _ = run(capsys, "pull", path, "--json")
        row = json.loads(out)["pulls"][0]
        assert code == 0 and not row["stick_slip"] and not row["ripple"]
        assert row["stiffness"] == pytest.approx(50e3, rel=5e-3)
        assert any("load cycles" in w and "0.35" in w for w in json.loads(out)["warnings"])
        code, _, err = run(capsys, "calibrate", "choi2018-kapton", path, "--vacuum", "90kPa")
        assert code == 2 and "no peak" in err


@pytest.mark.parametrize("given", ["acceleration:g=Z", "acceleration:m/s^2=Z"])
def test_a_stated_unit_is_not_overridden(
    given: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = crash_file("time (s),Z (mG)", lambda t, a: t, lambda t, a: 1e3 * a)(tmp_path / "z.csv")
    code, _, err = run(capsys, "crash", path, "--columns", given)
    assert code == 2 and "is in 'mG'" in err
    code, out, _ = run(capsys, "crash", path, "--columns", "time:s,acceleration:g", "--json")
    assert any("'mG', not in 'g' as given" in w for w in json.loads(out)["warnings"])


@pytest.mark.parametrize("lost", [1, 10, 25])
def test_one_rate_does_not_close_gaps(
    lost: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A pulse of 7.64 m/s in which samples are missing: never a narrow interval about less."""
    time = np.arange(400) * 1e-3
    value = np.where((time >= 0.1) & (time <= 0.16), 200 * np.sin(np.pi * (time - 0.1) / 0.06), 0.0)
    value += 0.1 * np.random.default_rng(1).standard_normal(400)
    keep = np.ones(400, bool)
    keep[125 : 125 + lost] = False
    path = made.csv(tmp_path / "x.csv", "time (s),acc (m/s^2)", time[keep], value[keep])
    code, _, err = run(capsys, "crash", path, "--filter", "none", "--sampling", "1kHz")
    assert code == 2 and "omit --sampling" in err and "0.124 s" in err.replace("124 ms", "0.124 s")
    code, out, _ = run(capsys, "crash", path, "--filter", "none", "--json")
    assert code == (4 if lost > 1 else 0)
    assert json.loads(out)["velocity_change"] == pytest.approx(7.64, rel=0.12)


def drop_with_history(folder: Path) -> tuple[list[str], np.ndarray]:
    """Return a drop with a vacuum log as a gauge shows it, to type, and the vacuums [Pa]."""
    time, pressure = made.pump_down()
    shown = np.minimum(GAUGE(pressure), 0)
    path = made.csv(folder / "v.csv", "time (s),vacuum (kPa)", time, shown)
    words = ["drop", "choi2018-kapton", "--mass", "1kg", "--speed", "1m/s"]
    return [*words, "--vacuum-history", str(path)], -1e3 * shown


def test_a_history_of_vacuum_asks_too(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    words, vacuum = drop_with_history(tmp_path)
    code, _, err = run(capsys, *words)
    assert code == 2 and words[-1] in err and "(--reading gauge)" in err
    read: list[Any] = []

    def stop(*_: Any, vacuum: Any, **__: Any) -> None:
        read.append(vacuum)
        raise FitError("not simulated here")

    monkeypatch.setattr("layerjam.brake.simulate.stop.simulate_stop", stop)
    assert "not simulated here" in run(capsys, *words, "--reading", "gauge")[2]
    assert read[0].vacuum == pytest.approx(vacuum, abs=1.0)


@pytest.mark.slow
def test_a_drop_with_a_history_whose_reading_is_given(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words, _ = drop_with_history(tmp_path)
    assert run(capsys, *words, "--reading", "gauge")[0] in (0, 1)


def test_an_error_of_several_files_names_the_file_the_column_and_the_cause(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    short = made.csv(tmp_path / "short.csv", "time (s),vacuum (kPa)", [0, 1, 2], [80, 79, 78])
    code, _, err = run(capsys, "leak", short)
    assert code == 2 and str(short) in err and "3 samples" in err
    flat = made.csv(tmp_path / "flat.csv", "time (s),vacuum (kPa)", range(50), [80] * 50)
    code, _, err = run(capsys, "pump-down", flat)
    assert code == 2 and str(flat) in err


SHARED = {
    "01_leak_vacuum_column_negative.csv": (
        "leak",
        (),
        1,
        {"time_constant": 150.1, "mean_pressure": 27.0e3},
    ),
    "04_leak_millis_header.csv": ("leak", ("--reading", "absolute"), 0, {"time_constant": 300}),
    "06_enclosure_stretch_read_as_strain.csv": ("enclosure", (), 0, {"modulus_300": 177.2e3}),
    "08_lvm_decimal_comma_no_x_column.lvm": ("crash", (), 0, {"peak": 196.7, "peak_time": 0.03}),
    "09_lvm_one_x_column_per_channel.lvm": ("crash", (), 0, {"peak": 196.7, "peak_time": 0.03}),
    "11_enclosure_bluehill_extension_twice.csv": ("enclosure", (), 0, {"modulus_100": 87.5e3}),
    "13_enclosure_tension_negative.csv": ("enclosure", SIZES, 1, {"modulus_100": 87.5e3}),
    "15_crash_phone_time_stamps.csv": (
        "crash",
        ("--filter", "none"),
        0,
        {"peak": 30.0, "peak_time": 6.04},
    ),
    "16_leak_absolute_gauge_called_vacuum.csv": ("leak", (), 1, {"time_constant": 200}),
    "17_pull_unknown_names.csv": ("pull", (), 1, {"stiffness": 49.95e3}),
    "19_leak_iso_time_stamps.csv": ("leak", (), 0, {"time_constant": 300}),
    "21_pull_grams_not_shown.csv": ("pull", (), 0, {"stiffness": 5.0e3}),
}


@pytest.mark.skipif(not FIELD.is_dir(), reason="the shared files are not here")
@pytest.mark.parametrize("name", SHARED)
def test_a_shared_file_gives_its_right_answer(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    command, options, count, right = SHARED[name]
    words = [command, str(FIELD / name), *options]
    for _ in range(count):
        code, _, err = run(capsys, *words)
        assert code == 2
        words = add_option(words, next(read_hints(err)))
    code, out, _ = run(capsys, *words, "--json")
    assert code == 0
    for key, value in right.items():
        assert find_number(json.loads(out), key) == pytest.approx(value, rel=3e-3)

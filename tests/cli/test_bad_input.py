"""Bad input: exit code 2, one plain sentence that names what is wrong, nothing written."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from layerjam.brake.device.load import load

from .conftest import Run

Refuses = Callable[..., str]
KAPTON = "choi2018-kapton"


def force(slip: str = "20mm", vacuum: str = "94.5kPa", brake: str = KAPTON) -> tuple[str, ...]:
    return ("force", brake, f"--slip={slip}", f"--vacuum={vacuum}", "--json")


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        (force(slip="20"), ("slip", "'20' has no unit", "20 mm")),
        (force(vacuum="94.5"), ("vacuum", "has no unit", "94.5 kPa")),
        (force(slip="20 kPa"), ("slip", "not in units of length", "'mm'")),
        (force(vacuum="5 N"), ("vacuum", "not in units of pressure", "'kPa'")),
        (force(vacuum="101.4 kPa"), ("vacuum", "101.4 kPa", "atmospheric", "101.325 kPa")),
        (force(vacuum="-5 kPa"), ("vacuum", "-5 kPa", "zero or more")),
        (force(slip="-1 mm"), ("slip", "-1 mm", "zero or more")),
        (force(slip="nan mm"), ("slip", "not a number")),
        (force(vacuum="inf kPa"), ("vacuum", "not a number")),
        (force(vacuum="1e400 kPa"), ("vacuum",)),
        (force(slip="1e999m"), ("slip",)),
        (force(slip=""), ("slip", "not a number")),
        (force(slip="twenty mm"), ("slip", "not a number")),
        (force(slip="20 mm; 30 mm"), ("slip",)),
        (force(slip="__import__('os') mm"), ("slip",)),
        (force(slip="68.1 mm"), ("slip", "68.1 mm", "overlap of 68 mm", "separated")),
        (force(slip="1 km"), ("slip", "1000 m", "overlap of 68 mm")),
        (("vacuum", KAPTON, "--slip", "20mm", "--force", "100"), ("force", "has no unit", "N")),
        (("vacuum", KAPTON, "--slip", "20mm", "--force=-5N"), ("force", "zero or more")),
        (("vacuum", KAPTON, "--slip", "69mm", "--force", "5N"), ("overlap of 68 mm",)),
        (("show", KAPTON, "--atmosphere", "101325"), ("atmosphere", "has no unit")),
        (("show", KAPTON, "--atmosphere", "1 kPa"), ("atmosphere", "at least 10 kPa")),
        (("show", KAPTON, "--atmosphere", "1 m"), ("atmosphere", "units of pressure")),
        ((*force(), "--atmosphere", "90kPa"), ("94.5 kPa exceeds atmospheric pressure, 90 kPa",)),
    ],
)  # fmt: skip
def test_quantities(refuses: Refuses, words: tuple[str, ...], parts: tuple[str, ...]) -> None:
    sentence = refuses(*words)
    for part in parts:
        assert part in sentence, sentence


PULL = {"--vacuum": "94.5kPa", "--speed": "13mm/s", "--elongation": "40mm"}


def pull(**changed: str | None) -> list[str]:
    options = {**PULL, **{f"--{key}": value for key, value in changed.items()}}
    return ["tensile", KAPTON, *(f"{k}={v}" for k, v in options.items() if v is not None)]


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        (pull(procedure="vent"), ("procedure", "vacuum, speed, elongation", "not both")),
        (pull(speed=None, travel=None, procedure="vent"), ("vacuum", "not both")),
        (pull(speed=None), ("speed: missing", "procedure")),
        (["tensile", KAPTON], ("vacuum, speed, elongation: missing",)),
        (pull(speed="0 mm/s"), ("speed", "at least 0.0001 mm/s")),
        (pull(speed="13 mm"), ("speed", "units of m/s")),
        (pull(elongation="0 mm"), ("elongation", "at least 1 µm")),
        (pull(elongation="1 km"), ("elongation", "at most")),
        (pull(vacuum="110 kPa"), ("vacuum", "atmospheric")),
        (pull(model="magic"), ("unknown model 'magic'", "stack")),
        (["tensile", KAPTON, "--procedure", "do something"], ("'do something' is not a step",)),
        (["tensile", KAPTON, "--procedure", ""], ("no step",)),
        (["tensile", KAPTON, "--procedure", "evacuate to 110 kPa"], ("atmospheric",)),
        (["tensile", KAPTON, "--procedure", "pull at 1 mm/s until 2 mm; pull at 1 mm/s until 1 mm"],
         ("does not pull",)),
        (["tensile", KAPTON, "--procedure", "pull at 1 until 2 mm"], ("has no unit",)),
    ],
)  # fmt: skip
def test_tensile(refuses: Refuses, words: list[str], parts: tuple[str, ...]) -> None:
    sentence = refuses(*words)
    for part in parts:
        assert part in sentence, sentence


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        (("force", KAPTON), ("--slip",)),
        (("force",), ("BRAKE",)),
        (("force", KAPTON, "--slip", "1mm"), ("--vacuum",)),
        (("vacuum", KAPTON, "--slip", "1mm"), ("--force",)),
        (("friction",), ("FILE",)),
        (("calibrate", KAPTON), ("FILE",)),
        (("validate", KAPTON), ("FILE",)),
        (("reproduce",), ("--out",)),
        (("new", "x"), ("--from",)),
        (("new", "x", "--from", KAPTON), ("--out",)),
        (("conquer",), ("conquer",)),
        ((*force(), "--nonsense"), ("--nonsense",)),
        ((*force(), "extra"), ("extra",)),
        (("force", KAPTON, "--slip"), ("--slip",)),
    ],
)
def test_missing_and_unknown_words(
    run: Run, words: tuple[str, ...], parts: tuple[str, ...]
) -> None:
    ran = run(*words)
    assert ran.code == 2 and ran.err.count("\n") == 1 and ran.err.startswith("layerjam: ")
    assert ran.out == ""
    for part in parts:
        assert part in ran.err, ran.err


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("choi2018-captn", "choi2018-kapton"),
        ("kapton", "choi2018-kapton"),
        ("Choi2018-PTFE", "choi2018-ptfe"),
        ("zzz", "choi2018-kapton"),
        ("", "choi2018-kapton"),
    ],
)
@pytest.mark.parametrize("command", ["show", "force", "calibrate"])
def test_unknown_brakes_get_the_nearest_names(
    refuses: Refuses, tmp_path: Path, name: str, near: str, command: str
) -> None:
    more = {
        "show": (),
        "force": ("--slip", "1mm", "--vacuum", "1kPa"),
        "calibrate": (str(tmp_path / "x.csv"),),
    }[command]
    sentence = refuses(command, name, *more)
    assert "unknown brake" in sentence and near in sentence


BROKEN = {
    "no toml": ("name = 'x'\n[sheets\n", 2, "is not valid TOML"),
    "unclosed": ('name = "x\n', 1, "is not valid TOML"),
    "empty": ("", None, "missing"),
    "unit": (("overlap = { value = \"68 mm\"", "overlap = { value = 68"), 0, "has no unit"),
    "dimension": (("value = \"68 mm\"", "value = \"68 kPa\""), 0, "units of length"),
    "negative": (("value = \"68 mm\"", "value = \"-68 mm\""), 0, "sheets.overlap"),
    "unknown key": (("overlap = {", "overlapp = {"), 0, "overlapp"),
    "one sheet": (("count = { value = 11", "count = { value = 1"), 0, "sheets.count"),
    "half a sheet": (("count = { value = 11", "count = { value = 10.5"), 0, "an integer"),
    "kinetic above static": (("kinetic = { value = 0.24", "kinetic = { value = 0.5"), 0, "kinetic"),
    "kind": (('kind = "paper", source = "Choi 2018, section II-A: 8 mm', 'kind = "dream", source '
              '= "'), 0, "dream"),
    "material": (('use = "kapton-hn"', 'use = "kapton"'), 0, "kapton-hn"),
    "nan": (("value = 0.875", "value = nan"), None, "finite"),
}  # fmt: skip


@pytest.mark.parametrize("what", list(BROKEN))
def test_broken_brake_files_name_file_and_line(refuses: Refuses, tmp_path: Path, what: str) -> None:
    change, line, why = BROKEN[what]
    text = load(KAPTON).text
    if isinstance(change, str):
        text = change
    else:
        assert text.count(change[0]) == 1, change
        if line == 0:
            line = text[: text.index(change[0])].count("\n") + 1
        text = text.replace(*change)
    path = tmp_path / "broken.toml"
    path.write_text(text)
    sentence = refuses("show", path)
    assert "broken.toml" in sentence and why in sentence, sentence
    if line:
        assert f"broken.toml, line {line}:" in sentence, sentence


def test_files_that_are_no_text(refuses: Refuses, tmp_path: Path) -> None:
    (tmp_path / "bytes.toml").write_bytes(b"name = '\xff\xfe'\n")
    assert "not UTF-8" in refuses("show", tmp_path / "bytes.toml")
    (tmp_path / "folder.toml").mkdir()
    assert "is a folder" in refuses("show", tmp_path / "folder.toml")
    assert "cannot be read: No such file" in refuses("show", tmp_path / "absent.toml")
    assert "cannot be read" in refuses("show", "/" + "x" * 300 + ".toml")


@pytest.mark.parametrize("command", ["friction", "calibrate"])
def test_out_must_be_toml(refuses: Refuses, tmp_path: Path, command: str) -> None:
    brake = () if command == "friction" else (KAPTON,)
    sentence = refuses(command, *brake, tmp_path / "a.csv", "--out", tmp_path / "b.txt")
    assert ".txt" in sentence and ".toml" in sentence


def test_new_needs_a_name_and_an_ending(refuses: Refuses, tmp_path: Path) -> None:
    out = str(tmp_path / "b.toml")
    for name in ("", " ", "a\nb", "x" * 100, '"'):
        assert "name" in refuses("new", name, "--from", KAPTON, "--out", out)
    assert ".toml" in refuses("new", "b", "--from", KAPTON, "--out", tmp_path / "b.txt")
    assert "unknown brake" in refuses("new", "b", "--from", "nobody", "--out", out)

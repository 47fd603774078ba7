"""The first minute on the command line: help where it is looked for, errors with what to type."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import layerjam as lj
from layerjam.cli.main import MOST_USED, main
from layerjam.core.command.declare import load_command
from layerjam.core.command.index import commands
from layerjam.core.system import quote_word
from printed import split_command


@pytest.mark.parametrize("words", [[], ["help"], ["--help"]])
def test_the_short_list_is_help_and_no_error(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 0
    out, err = capsys.readouterr()
    assert err == "" and max(map(len, out.splitlines())) <= 80
    listed = [
        line.split()[0] for line in out.splitlines() if line.startswith("  ") and line[2] > " "
    ]
    assert next(word for word in listed if word in MOST_USED) == "new"
    assert set(MOST_USED) <= set(listed) and len(MOST_USED) == 15
    assert "layerjam help all lists the other" in out and "bench soak" not in out


def test_the_whole_list_and_one_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["help", "all"]) == 0
    out = capsys.readouterr().out
    assert [n for n in commands() if f"  {n} " not in out] == ["parts"]  # `catalogue` lists them
    assert out.index("Report and share:") < out.index("  records add")
    assert main(["help", "force"]) == 0
    assert "--slip" in capsys.readouterr().out
    assert main(["help", "bench"]) == 0
    assert "bench run" in capsys.readouterr().out
    assert main(["help", "forse"]) == 2
    assert "did you mean force" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "name"), [("sleeve", "enclosure"), ("apply", "scenario"), ("judder", "stick-slip")]
)
def test_former_names_of_commands(old: str, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert getattr(lj, old) is getattr(lj, name.replace("-", "_"))
    assert main([old, "--help"]) == 0
    shown = capsys.readouterr()
    assert shown.err == f"layerjam: {old} is now called {name}\n" and "Usage:" in shown.out
    assert main(["help", "all"]) == 0
    out = capsys.readouterr().out
    assert f"  {name} " in out and f"  {old} " not in out


def test_python_runs_the_package_as_a_module() -> None:
    ended = subprocess.run(
        [sys.executable, "-m", "layerjam", "--version"], capture_output=True, text=True, check=False
    )
    assert ended.returncode == 0 and ended.stdout.startswith("layerjam ")


def test_a_unit_that_is_typed_as_a_word_of_its_own(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["force", "choi2018-kapton", "--slip", "20mm", "--vacuum", "50", "kPa"]) == 2
    err = capsys.readouterr().err
    assert 'write the number and unit as one word: --vacuum 50kPa or --vacuum "50 kPa"' in err


def test_brake_and_file_in_the_wrong_order(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["calibrate", "pull.csv", "choi2018-kapton"]) == 2
    assert "pull.csv is a measurement; name the brake first" in capsys.readouterr().err


def test_a_missing_option_shows_the_line_to_type(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new", "my-brake", "--from", "choi2018-kapton"]) == 2
    said, line = capsys.readouterr().err.split("; type, for example: ")
    assert said == "layerjam: --out is missing (Brake file to write)"
    assert line == "layerjam new my-brake --from choi2018-kapton --out my-brake.toml\n"
    assert main(split_command(line)[1:]) == 0
    assert (tmp_path / "my-brake.toml").is_file()
    # words typed with "=" and with spaces stay as they are
    assert main(["new", "my-brake", "--out=a brake.toml"]) == 2
    err = capsys.readouterr().err
    place = quote_word("--out=a brake.toml")
    assert err.endswith(f" layerjam new my-brake {place} --from choi2018-kapton\n")
    assert main(["show"]) == 2
    err = capsys.readouterr().err
    assert err.startswith("layerjam: BRAKE is missing (Catalogue name or path of ")
    assert err.endswith("; type, for example: layerjam show choi2018-kapton\n")


def test_what_a_command_needs_is_in_the_line_to_type(capsys: pytest.CaptureFixture[str]) -> None:
    checked = 0
    for name in commands():
        required = [p for p in load_command(name).parameters if p.required]
        options = {p.option for p in required if not p.is_positional}
        alone = ["x"] * (len(required) - len(options))
        for words in ([alone] if options else []) + ([[]] if alone else []):
            assert main([*name.split(), *words]) == 2
            typed = split_command(capsys.readouterr().err.split("; type, for example: ")[1])
            assert typed[: 1 + len(name.split())] == ["layerjam", *name.split()]
            assert words != alone or options <= {*typed}
            checked += 1
    assert checked > 60


DEVELOPERS = ["bench faults", "bench soak", "scenario", "schema", "reproduce"]


def test_commands_for_developers_are_behind_help_all_under_their_heading(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["help"]) == 0
    short = capsys.readouterr().out
    assert not any(f"\n  {name} " in short for name in DEVELOPERS)
    assert main(["help", "all"]) == 0
    head, _, rest = capsys.readouterr().out.partition("For developers of the method")
    assert all(f"  {name} " in rest and f"  {name} " not in head for name in DEVELOPERS)
    assert {e.name for e in commands().values() if e.group == "develop"} == {*DEVELOPERS}

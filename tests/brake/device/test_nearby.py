"""A name that was mistyped is answered with the file that lies there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from layerjam.brake.commands.edit import edit
from layerjam.brake.device.load import load
from layerjam.core.errors import FileError, UnknownNameError
from layerjam.laboratory.measure.readers.read import read_trace


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    text = edit("choi2018-kapton", name="tested").text
    (tmp_path / "tested.toml").write_text(text, encoding="utf-8")
    (tmp_path / "pull-1.csv").write_text("a\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_nearest_file_is_named(folder: Path) -> None:
    with pytest.raises(FileError, match=r"^testd\.toml: cannot be read: .*mean tested\.toml\?$"):
        load("testd.toml")
    meant = re.escape(str(folder / "pull-1.csv"))
    with pytest.raises(FileError, match=f"does not exist; did you mean {meant}"):
        read_trace(folder / "pul-1.csv")


def test_nothing_is_named_where_nothing_is_near(folder: Path) -> None:
    for name in ("quite-another.toml", "no/such/folder.toml"):
        with pytest.raises(FileError) as refused:
            load(name)
        assert "did you mean" not in str(refused.value)


def test_a_name_without_its_ending_is_answered_with_the_file(folder: Path) -> None:
    with pytest.raises(UnknownNameError, match=r"did you mean tested\.toml\?"):
        load("tested")
    with pytest.raises(UnknownNameError, match="did you mean choi2018-kapton"):
        load("choi2018-kapto")

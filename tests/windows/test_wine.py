"""`make windows` itself: what it compares, and what it says where it cannot run."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from windows import questions, wine


def demo(folder: Path, force: float, when: str) -> Path:
    folder.mkdir()
    text = f'[{{"ours": {force!r}, "unit": "N", "date": "{when}"}}]'
    (folder / "results.json").write_text(text, encoding="utf-8")
    return folder


def test_numbers_of_two_systems_are_compared_one_by_one(tmp_path: Path) -> None:
    ours = demo(tmp_path / "a", 133.9428, "2026-11-26T01:02:03Z")
    same = demo(tmp_path / "b", 133.9428 * (1 + 1e-12), "2026-11-27T09:08:07Z")
    assert wine.compare(ours, same) == []
    other = demo(tmp_path / "c", 133.9428 * (1 + 1e-8), "2026-11-26")
    (difference,) = wine.compare(ours, other)
    assert difference.startswith("results.json: 133.9428 here, 133.94280133")
    assert "results.json: missing on Windows" in wine.compare(ours, tmp_path / "none")
    assert wine.compare(tmp_path / "none", ours) == ["no numbers were written here"]


def test_digests_and_names_are_not_numbers(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_text(
        f'sha256 = "{"1e9" * 21}f"\nv94 = -1.5e-3\nfile = "kapton-2.csv"\n', encoding="utf-8"
    )
    assert wine.numbers(path) == [-0.0015]


def test_without_root_one_sentence_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["wine.py", str(tmp_path / "w")])
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    assert wine.main() == 0
    said = capsys.readouterr().out
    assert said.startswith("skipped, nothing was tried on Windows: it needs root")
    assert said.count("\n") == 1 and not (tmp_path / "w").exists()
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    monkeypatch.setattr(shutil, "which", lambda _: None)
    assert wine.main() == 0 and "it needs the program unshare" in capsys.readouterr().out


def test_a_registry_that_does_not_answer_is_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["wine.py", str(tmp_path / "w")])
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    monkeypatch.setattr(shutil, "which", lambda name: f"/bin/{name}")

    def refuse(words: tuple[str, ...], **_: object) -> subprocess.CompletedProcess[str]:
        return subprocess.CompletedProcess(words, 1, "", "W: no\nE: cannot be reached\n")

    monkeypatch.setattr(subprocess, "run", refuse)
    assert wine.main() == 0
    (line,) = capsys.readouterr().out.splitlines()[1:]
    assert "Debian's packages cannot be installed (apt-get: E: cannot be reached)" in line


def test_the_folders_that_run_exist() -> None:
    tests = Path(wine.ROOT) / "tests"
    assert all((tests / name).is_dir() for name in wine.TESTS)


def test_the_questions_of_the_part_for_ci_have_numbers_to_compare(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", ["questions.py", str(tmp_path / "a")])
    questions.main()
    assert len(wine.numbers(tmp_path / "a/results.json")) > 500

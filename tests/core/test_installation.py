"""The command that adds an optional package works in the present installation."""

from __future__ import annotations

import importlib.metadata
import json
import os
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tomllib
from pathlib import Path
from types import SimpleNamespace

import pytest

from layerjam.core import installation
from layerjam.core.installation import install_command
from layerjam.core.plugins import OWN_GROUPS

ROOT = Path(__file__).parents[2]


def installed_from(monkeypatch: pytest.MonkeyPatch, text: str | None) -> None:
    record = SimpleNamespace(read_text=lambda name: text if name == "direct_url.json" else None)
    monkeypatch.setattr(importlib.metadata, "distribution", lambda _: record)
    monkeypatch.setattr(installation, "CHECKOUT", ROOT / "src")


def test_a_checkout_is_named_by_its_folder() -> None:
    words = shlex.split(install_command("step"))
    assert words[-2:] == ["-e", f"{ROOT}[step]"]
    assert words[:-2] in (["pip", "install"], [sys.executable, "-m", "pip", "install"])


def test_a_wheel_or_a_package_of_an_index(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    wheel = tmp_path / "layerjam 1.whl"
    wheel.touch()
    installed_from(monkeypatch, json.dumps({"url": wheel.as_uri(), "archive_info": {}}))
    assert install_command("pdf").endswith(f' install "{wheel}[pdf]"')
    wheel.unlink()
    assert install_command("pdf").endswith(' install "layerjam[pdf]"')
    for text in (None, "{}", "broken"):
        installed_from(monkeypatch, text)
        assert install_command("pdf").endswith(' install "layerjam[pdf]"')


def test_pip_belongs_to_this_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    own = str(Path(sys.executable).parent / "pip")
    for found, starts in ((own, "pip install "), ("/other/pip", sys.executable)):
        monkeypatch.setattr(shutil, "which", lambda name, found=found: found)
        assert install_command("pdf").startswith(starts)


def test_make_installs_quietly() -> None:
    installs = [
        line
        for line in (ROOT / "Makefile").read_text(encoding="utf-8").splitlines()
        if "-m pip install" in line
    ]
    assert len(installs) > 4 and all("install -qq --disable-pip-version" in i for i in installs)


def list_dependencies() -> list[str]:
    """Folders of installed packages without those that lead to the checkout."""
    return [p for p in sys.path if Path(p).name in ("site-packages", "dist-packages")]


def run_uninstalled(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run the files of the checkout with the packages in a folder, and nothing else."""
    path = os.pathsep.join((str(ROOT / "src"), str(folder)))
    return subprocess.run(
        [sys.executable, "-S", "-m", "layerjam", *words],
        check=False,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": path},
    )


def link_packages(folder: Path) -> None:
    """Link every installed package except the metadata of layerjam."""
    for source in list_dependencies():
        for entry in Path(source).iterdir():
            if not entry.name.startswith(("layerjam", "_editable_impl_layerjam")):
                (folder / entry.name).symlink_to(entry)


def test_groups_of_entry_points_are_those_of_the_project() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    own = [group for group in project["entry-points"] if group.startswith("layerjam.")]
    assert sorted(own) == sorted(OWN_GROUPS)


@pytest.mark.parametrize("words", [["--help"], ["show", "choi2018-kapton"], ["nonsense"]])
def test_files_without_an_installation_name_the_command(words: list[str], tmp_path: Path) -> None:
    link_packages(tmp_path)
    done = run_uninstalled(tmp_path, *words)
    assert done.returncode == 2 and done.stdout == ""
    [line] = done.stderr.splitlines()
    assert line.startswith("layerjam: the entry points layerjam.commands are missing")
    assert shlex.split(line)[-2:] == ["-e", str(ROOT)]


@pytest.mark.parametrize(
    "points", ["", "brake = layerjam.brake.commands\n", "x = layerjam.gone.a\n"]
)
def test_an_older_installation_is_not_taken_for_this_one(points: str, tmp_path: Path) -> None:
    link_packages(tmp_path)
    metadata = tmp_path / "layerjam-0.0.1.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Name: layerjam\nVersion: 0.0.1\n", encoding="utf-8")
    text = f"[layerjam.commands]\n{points}"
    (metadata / "entry_points.txt").write_text(text, encoding="utf-8")
    done = run_uninstalled(tmp_path, "show", "choi2018-kapton")
    assert done.returncode == 2
    [line] = done.stderr.splitlines()
    assert shlex.split(line)[-2:] == ["-e", str(ROOT)]


def test_a_missing_package_is_one_sentence(tmp_path: Path) -> None:
    done = run_uninstalled(tmp_path, "--help")
    assert done.returncode == 2
    [line] = done.stderr.splitlines()
    assert line.startswith("layerjam: No module named 'click'; install it: ")


def test_a_system_that_refuses_pip_gets_an_environment(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "EXTERNALLY-MANAGED").touch()
    monkeypatch.setattr(sys, "prefix", sys.base_prefix)
    monkeypatch.setattr(sysconfig, "get_path", lambda name: str(tmp_path))
    monkeypatch.setattr(shutil, "which", lambda name: None)
    expected = f"{sys.executable} -m venv .venv && .venv/bin/python -m pip install -e"
    assert install_command().startswith(expected)

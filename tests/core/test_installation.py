"""The command that adds an optional package works in the present installation."""

from __future__ import annotations

import importlib.metadata
import json
import shlex
import shutil
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from layerjam.core.installation import install_command

ROOT = Path(__file__).parents[2]


def installed_from(monkeypatch: pytest.MonkeyPatch, text: str | None) -> None:
    record = SimpleNamespace(read_text=lambda name: text if name == "direct_url.json" else None)
    monkeypatch.setattr(importlib.metadata, "distribution", lambda _: record)


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

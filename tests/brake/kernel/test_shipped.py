"""The compiled kernel that came with layerjam serves before any compiler does."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from layerjam.brake.kernel import compiler, engine, kernel
from layerjam.brake.kernel.compiler import KERNEL, TARGETS, find_on_path, shipped_library
from layerjam.cli.main import main

MACHINE = (sys.platform, compiler.platform.machine())
pytestmark = pytest.mark.skipif(find_on_path() is None, reason="there is no C compiler here")


@pytest.fixture
def shipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A kernel as a wheel has it, on a machine without compiler and with an empty cache."""
    folder = tmp_path / "built"
    folder.mkdir()
    path = folder / compiler.engine_name(KERNEL, (), MACHINE)
    command = [*(find_on_path() or ()), *compiler.FLAGS, "-shared", "-fPIC"]
    subprocess.run([*command, "-o", str(path), *map(str, KERNEL), "-lm"], check=True)
    for module in (compiler, engine):
        monkeypatch.setattr(module, "SHIPPED", folder)
    load = kernel.load_library.__wrapped__
    for module in (kernel, engine):
        monkeypatch.setattr(module, "load_library", load)
    monkeypatch.setattr(engine, "_is_available", engine._is_available.__wrapped__)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.delenv(engine.SWITCH, raising=False)
    monkeypatch.setattr(compiler.importlib.util, "find_spec", lambda _: None)
    return path


def test_the_kernel_that_came_is_loaded_without_a_compiler(
    shipped: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert shipped_library(KERNEL) == shipped
    library, _ = kernel.load_library("double")
    assert library._name == str(shipped)
    assert main(("--version", "--verbose")) == 0
    version, said = capsys.readouterr().out.splitlines()
    assert version.startswith("layerjam ")
    assert said == f"engine  kernel (shipped with layerjam: {shipped})"


def test_other_sources_do_not_use_it(shipped: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert shipped_library(KERNEL, ("LJ_SINGLE",)) is None
    monkeypatch.setattr(compiler, "FLAGS", (*compiler.FLAGS, "-O3"))
    assert shipped_library(KERNEL) is None
    assert engine.describe_engine().startswith("law (no compiled kernel")


def test_one_that_cannot_be_loaded_leaves_the_law(shipped: Path) -> None:
    shipped.write_bytes(b"damaged")
    assert engine.describe_engine().startswith("law (no compiled kernel")


def test_the_switch_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(engine.SWITCH, "off")
    assert engine.describe_engine() == "law (LAYERJAM_KERNEL=off)"


def test_version_alone_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(("--version",)) == 0
    assert capsys.readouterr().out.count("\n") == 1


def test_every_platform_has_a_file_of_its_own() -> None:
    names = [compiler.engine_name(KERNEL, (), machine) for machine in TARGETS]
    assert len(set(names)) == 5
    assert sorted(Path(n).suffix for n in names) == [".dll", ".dylib", ".dylib", ".so", ".so"]
    assert {target.split("-")[0] for target in TARGETS.values()} == {"x86_64", "aarch64"}
    assert all(name.startswith("layerjam-") for name in names)

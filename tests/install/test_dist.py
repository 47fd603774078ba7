"""What `make dist` accepts, and the source archive that hatchling builds."""

from __future__ import annotations

import importlib.util
import os
import re
import runpy
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from counts import FULL
from install.dist import KERNELS, LIBRARIES, REQUIRED, ROOT, build, contents, faults
from install.environment import bare


def test_a_missing_licence_and_a_test_are_faults() -> None:
    whole = [f"layerjam-1/{name}" for name in REQUIRED]
    assert faults(whole) == []
    assert faults(whole[1:]) == ["LICENSE is missing"]
    for name in ("layerjam-1/tests/x.py", "layerjam/test_x.py", "layerjam/__pycache__/x.pyc"):
        assert faults([*whole, name]) == [f"{name} does not belong there"]


@pytest.mark.slow
def test_both_files_are_whole_and_built_the_same_twice(tmp_path: Path) -> None:
    first, second = (build(tmp_path / name, "1700000000") for name in ("first", "second"))
    assert first == second and len(first) == 2
    for name in first:
        names = contents(tmp_path / "first" / name)
        assert faults(names) == []
        held = {n.split("layerjam/", 1)[1] for n in names if "layerjam/" in n}
        command = ("git", "ls-files", "src/layerjam")
        listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
        kept = {line.removeprefix("src/layerjam/") for line in listed.stdout.splitlines()}
        assert kept <= held
    later = build(tmp_path / "later", "1700000002")
    assert later.keys() == first.keys() and later != first


def test_the_tool_is_the_one_that_pip_builds_with() -> None:
    done = subprocess.run([sys.executable, "-m", "hatchling", "version"], cwd=ROOT, check=True,
                          capture_output=True, text=True)  # fmt: skip
    from layerjam import __version__

    assert done.stdout.strip() == __version__


def test_a_wheel_built_with_ziglang_has_the_kernel_of_every_machine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from layerjam.brake.kernel import compiler

    targets: list[str] = []

    def compile_nothing(command: Sequence[str], target: Path, **_: object) -> None:
        targets.append(command[command.index("-target") + 1])
        target.write_bytes(b"")

    monkeypatch.setattr(compiler, "run_compiler", compile_nothing)
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: object())
    hook = runpy.run_path(str(ROOT / "hatch_build.py"))["KernelHook"]
    made = hook(str(ROOT), {}, None, None, str(tmp_path), "wheel")
    data: dict[str, dict[str, str]] = {"force_include": {}}
    made.initialize("editable", data)
    assert not data["force_include"]
    made.initialize("standard", data)
    assert set(targets) == set(compiler.TARGETS.values()) and len(targets) == KERNELS
    assert len(data["force_include"]) == KERNELS
    for path, place in data["force_include"].items():
        assert place == f"layerjam/brake/kernel/built/{Path(path).name}" and Path(path).exists()
    made.finalize("standard", data, "")
    assert not any(map(os.path.exists, data["force_include"]))
    monkeypatch.setenv("LAYERJAM_SYSTEMS", "linux windows")
    with pytest.raises(ValueError, match="windows is not one of darwin, linux, win32"):
        made.initialize("standard", data)


@pytest.fixture(scope="module")
def builder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Python of an environment with the tools of `make dist`, ziglang excepted."""
    folder = tmp_path_factory.mktemp("tools")
    subprocess.run([sys.executable, "-m", "venv", folder / "venv"], check=True)
    lock = (ROOT / "tests/install/requirements.lock").read_text(encoding="utf-8")
    rows = [f"{row}\n" for row in re.split(r"\n(?=\w)", lock)]
    for name, chosen in (
        ("zig", [row for row in rows if row.startswith("ziglang")]),
        ("rest", [row for row in rows if not row.startswith("ziglang")]),
    ):
        (folder / f"{name}.lock").write_text("".join(chosen), encoding="utf-8")
    python = folder / "venv/bin/python"
    fill(python, folder / "rest.lock")
    return python


def fill(python: Path, lock: Path) -> None:
    """Install what a lock names; skip the test if no index has it."""
    done = pip(python, "install", "--require-hashes", "-r", str(lock))
    if done.returncode:
        reason = done.stderr.strip().splitlines()[-1]
        pytest.skip(f"the tools of `make dist` cannot be downloaded here: {reason}")


def pip(python: Path, *words: str) -> subprocess.CompletedProcess[str]:
    command = (python, "-m", "pip", *words, "-q", "--disable-pip-version-check", "--retries", "1")
    return subprocess.run(command, env=bare(), capture_output=True, text=True, check=False)


def engine(python: Path, target: Path, source: Path) -> str:
    """What an installation of sources or a wheel computes pulls with, if PATH has no compiler."""
    done = pip(python, "install", "--no-deps", "--no-build-isolation", "--no-index",
               "--target", str(target), str(source))  # fmt: skip
    assert done.returncode == 0, done.stderr
    code = "from layerjam.brake.kernel.engine import describe_engine; print(describe_engine())"
    env = {**bare(), "PYTHONPATH": str(target), "PATH": "", "XDG_CACHE_HOME": str(target / "cache")}
    words = (sys.executable, "-c", code)
    return subprocess.check_output(words, env=env, cwd=target, text=True)


@pytest.mark.slow
def test_pip_and_make_dist_with_and_without_ziglang(builder: Path, tmp_path: Path) -> None:
    assert "no compiled kernel" in engine(builder, tmp_path / "without", ROOT)
    assert not (tmp_path / "without/layerjam/brake/kernel/built").exists()
    fill(builder, builder.parents[2] / "zig.lock")
    words = (builder, ROOT / "tests/install/dist.py", tmp_path / "dist")
    # for Windows, ziglang compiles a C library first, which takes three quarters of the time
    env = bare() if FULL else {**bare(), "LAYERJAM_SYSTEMS": "linux darwin"}
    done = subprocess.run(words, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert {path.suffix for path in (tmp_path / "dist").iterdir()} == {".whl", ".gz"}
    [wheel] = (tmp_path / "dist").glob("*.whl")
    said = engine(builder, tmp_path / "with", wheel)
    assert said.startswith("kernel (shipped with layerjam: ") and str(tmp_path / "with") in said
    held = len(list((tmp_path / "with/layerjam/brake/kernel/built").iterdir()))
    assert held == (KERNELS if FULL else KERNELS - LIBRARIES)

"""The kernel's WebAssembly: it belongs to the sources, stays small, and is built again if not."""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sys

import pytest

from layerjam.brake.kernel import web
from layerjam.core.errors import CompilerError
from layerjam.core.installation import install_command

LARGEST = 20_000
ADVICE = 'run `python -m layerjam.brake.kernel.web` where `pip install ".[fmu]"` was run'


def changed_sources(tmp_path, monkeypatch, old, new):
    """Let the module's first source be a copy with a different text."""
    text = web.CODE[0].read_text("utf-8")
    assert old in text
    copy = tmp_path / web.CODE[0].name
    copy.write_text(text.replace(old, new), "utf-8")
    monkeypatch.setattr(web, "CODE", (copy, *web.CODE[1:]))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def test_the_stored_module_is_that_of_the_sources():
    stored = [path.name for path in web.FOLDER.glob("*.wasm")]
    assert stored == [web.find_stored_module().name], ADVICE
    module = web.read_module()
    assert module.startswith(b"\0asm") and len(module) <= LARGEST
    assert b"/" not in module  # no path of the machine that compiled it


def test_comments_leave_the_module_as_it_is(tmp_path, monkeypatch):
    before = web.find_stored_module()
    changed_sources(tmp_path, monkeypatch, "/* One brake", "/* Exactly one brake")
    assert web.find_stored_module() == before


def test_other_sources_are_compiled_or_the_error_names_the_compiler(tmp_path, monkeypatch):
    changed_sources(tmp_path, monkeypatch, "HALVINGS = 100", "HALVINGS = 101")
    assert not web.find_stored_module().exists()
    if importlib.util.find_spec("ziglang") is None:
        with pytest.raises(CompilerError, match=re.escape(install_command("fmu"))):
            web.read_module()
    else:
        assert web.read_module().startswith(b"\0asm")


@pytest.mark.slow
def test_the_same_sources_give_the_same_bytes(tmp_path):
    """In the environments of `make dist` and `make interop`, which have the pinned compiler."""
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip("no ziglang here")
    run = subprocess.run(
        [sys.executable, "-m", "ziglang", "version"], capture_output=True, text=True, check=True
    )
    if not run.stdout.startswith("0.17."):
        pytest.skip(f"the stored module was compiled by ziglang 0.17, not {run.stdout.strip()}")
    web.build_module(tmp_path / "again.wasm")
    assert (tmp_path / "again.wasm").read_bytes() == web.read_module()

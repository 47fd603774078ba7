"""Which C compiler is used, and that a library appears whole or not at all."""

from __future__ import annotations

import shutil

import pytest

from layerjam.brake.kernel import compiler as compilers
from layerjam.brake.kernel.parameters import parameters
from layerjam.core.errors import CompilerError, QuantityError
from strategies import KAPTON, change

CC = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler here")


def test_a_compiler_is_named_or_found_or_asked_for(monkeypatch, tmp_path):
    monkeypatch.setenv("CC", "no-such-compiler -m32")
    with pytest.raises(CompilerError, match="'no-such-compiler' was not found"):
        compilers.find_compiler()
    monkeypatch.delenv("CC")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(compilers.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(CompilerError, match="install gcc or clang"):
        compilers.find_compiler()


@CC
def test_a_library_is_built_once_and_anew_when_any_file_beside_it_changes(monkeypatch, tmp_path):
    monkeypatch.setattr(compilers, "library_folder", lambda: tmp_path / "kept")
    (tmp_path / "kept").mkdir()
    source, header = tmp_path / "one.c", tmp_path / "one.h"
    source.write_text('#include "one.h"\nint one(void) { return ONE; }\n')
    header.write_text("#define ONE 1\n")
    first = compilers.build_library([source])
    stamp = first.stat().st_mtime_ns
    assert compilers.build_library([source]) == first and first.stat().st_mtime_ns == stamp
    header.write_text("#define ONE 2\n")
    assert compilers.build_library([source]) != first
    assert compilers.build_library([source], ["MORE"]) != compilers.build_library([source])
    source.write_text("int one(void) { return }\n")
    before = sorted(path.name for path in (tmp_path / "kept").iterdir())
    with pytest.raises(CompilerError, match="cannot build"):
        compilers.build_library([source])
    assert sorted(path.name for path in (tmp_path / "kept").iterdir()) == before


def test_a_rope_without_stiffness_is_refused():
    for stiffness in (0.0, -1.0, float("nan")):
        with pytest.raises(QuantityError) as caught:
            parameters(KAPTON, stiffness)
        assert caught.value.quantity == "rope_stiffness"
    assert parameters(change(KAPTON, film__kinetic=0.12)).contact == pytest.approx(
        parameters(KAPTON).contact / 2
    )

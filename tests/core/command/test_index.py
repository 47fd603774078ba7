"""The index of commands, found in the source without importing it."""

from __future__ import annotations

import importlib
from pathlib import Path

import pytest

from layerjam.core.command import index
from layerjam.core.command.declare import REGISTRY
from layerjam.core.command.index import EXAMPLES

DIVE = """
@command("predict")
def dive() -> {result}:
    \"\"\"Dive.\"\"\"
"""


def names(source: str, folder: Path) -> list[str]:
    file = folder / "dive.py"
    file.write_text("import layerjam\n\n" + source, encoding="utf-8")
    return [entry.name for entry in index._read_entries(file, "sea.dive")]


@pytest.mark.parametrize("result", ["Dive", "results.Result", "Sequence[Dive]"])
def test_any_result_type_is_found(result: str, tmp_path: Path) -> None:
    assert names(DIVE.format(result=result), tmp_path) == ["dive"]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("@command(", "@declare.command("),
        ("-> Dive:", ":"),
        ('"""Dive."""', "return 0"),
        ('"""Dive."""', "'Dive.'"),
        ("-> Dive:", "-> (\n    Dive\n):"),
    ],
)
def test_no_command_is_passed_over(old: str, new: str, tmp_path: Path) -> None:
    source = DIVE.format(result="Dive").replace(old, new)
    with pytest.raises(RuntimeError, match="line .*: command not recognised"):
        names(source, tmp_path)


def test_a_command_after_one_without_a_result_is_not_taken_for_it(
    tmp_path: Path,
) -> None:
    source = DIVE.format(result="Dive")
    first = source.replace("-> Dive:", ":").replace("dive", "surface")
    with pytest.raises(RuntimeError, match="line 4: command not recognised"):
        names(f"{first}\n\n{source}", tmp_path)


def test_the_index_lists_what_the_modules_declare() -> None:
    for entry in index.commands().values():
        importlib.import_module(entry.module)
    assert {entry.name for entry in index._source_entries()} == set(REGISTRY) == {*EXAMPLES}


def test_no_command_is_declared_in_another_folder() -> None:
    home = Path(index.__file__).parents[2]
    files = [path for path in home.rglob("*.py") if path.name != "index.py"]
    declared = sum(len(index.DECORATOR.findall(p.read_text(encoding="utf-8"))) for p in files)
    assert declared == len(index._source_entries())

"""Every code block of README and docs does what the page says (tests/docs/examples.py)."""

from __future__ import annotations

import ast
import importlib
import importlib.util
import shutil
from pathlib import Path

import pytest

from docs import examples


@pytest.fixture(scope="module")
def practice(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the practice files of `make demo`."""
    folder = tmp_path_factory.mktemp("practice") / "files"
    examples.practice_files(folder)
    return folder


LONG = (
    "README.md", "bayes.md", "bench.md", "build.md", "design.md", "first-bench.md",
    "first-calibration.md", "gallery.md", "impact.md", "models.md", "records.md",
    "report.md", "stick-slip.md", "vacuum.md",
)  # fmt: skip
"""Pages that compile, sample or wait for seconds."""
PAGES = [
    pytest.param(p, id=str(p.relative_to(examples.ROOT)),
                 marks=[pytest.mark.slow] if p.name in LONG else [])
    for p in examples.pages()
]  # fmt: skip


@pytest.mark.parametrize("page", PAGES)
def test_page(page: Path, practice: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "reader"
    shutil.copytree(practice, folder)
    monkeypatch.chdir(folder)
    monkeypatch.setenv("COLUMNS", "80")
    examples.Page(page).run()


def test_blocks_for_other_programs_import_names_that_exist() -> None:
    """Those blocks run in `make interop` only; a name that is gone shows here."""
    for page in examples.pages():
        for block in examples.blocks(page.read_text(encoding="utf-8")):
            if not block.needs or block.kind != "python":
                continue
            for line in ast.walk(ast.parse(block.text)):
                if isinstance(line, ast.ImportFrom) and (line.module or "").startswith("layerjam."):
                    module = importlib.import_module(str(line.module))
                    for name in (alias.name for alias in line.names):
                        assert hasattr(module, name) or importlib.util.find_spec(
                            f"{line.module}.{name}"
                        ), f"{page.name}: {line.module} has no {name}"


def test_every_page_is_in_the_navigation() -> None:
    nav = (examples.ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    docs = [p for p in examples.pages() if p.parent.name == "docs"]
    assert docs
    for page in docs:
        assert page.name in nav, f"{page.name} is in no navigation"


@pytest.mark.parametrize("page", examples.pages(), ids=lambda p: p.name)
def test_code_is_no_wider_than_the_page(page: Path) -> None:
    for block in examples.blocks(page.read_text(encoding="utf-8")):
        for line in block.text.splitlines():
            if block.kind in ("python", "sh", "text") or line.startswith("$ "):
                assert len(line) <= 88, f"{page.name}, block at line {block.line}: {line}"


def test_dots_stand_for_any_lines() -> None:
    assert examples.same("a\n...\nc", "a\nb\nb\nc\n")
    assert examples.same("a\n...", "a\n")
    assert not examples.same("a\n...\nc", "a\nb\n")
    assert not examples.same("1.0", "1.01")


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("```yaml\na: 1\n```\n", "a block of kind 'yaml'"),
        ("```\na\n```\n", "a block of kind ''"),
        ("```console\n$ rm -r .\n```\n", "no command the docs may show"),
        ("```console\n$ layerjam force choi2018-kapton\n```\n", "ended with 2, not 0"),
        ("```console\n$ layerjam --version\nlayerjam 0\n```\n", "shown:"),
        ("```text\na\n```\n", "a python block before it"),
        ("```python\nprint(1)\n```\n\n```text\n2\n```\n", "shown:"),
        ("```csv\na\n```\n", "needs a title"),
    ],
)
def test_a_wrong_page_fails(text: str, why: str, tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(text, encoding="utf-8")
    with pytest.raises(examples.Mismatch, match=why):
        examples.Page(page).run()

"""What a notebook shows of a result: as much as the terminal, its picture, and a short record."""

from __future__ import annotations

import ast
import importlib
import re
from collections.abc import Iterator, Mapping
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import layerjam as lj
from layerjam.core import brief
from layerjam.core.command.index import commands
from layerjam.core.command.results import Judged, Result, fact, number, result

KAPTON = "choi2018-kapton"


@result
class Invented(Judged):
    """A result with every part that can be printed."""

    length: float = number("m", "length", default=0.02)
    refused: Mapping[str, str] | None = fact("refused files", default=None, listed=False)
    understood: Mapping[str, list[str]] | None = fact("readings", default=None, listed=False)

    def lines(self) -> Iterator[str]:
        yield from ("", "chosen: 19 sheets", "  mass: 73 g", "  layerjam show 'a & b'")


def words(text: str) -> list[str]:
    return unescape(re.sub("<[^>]*>", " ", text)).split()


INVENTED = Invented.create(
    checks=[{"name": "zero", "level": "failed", "sentence": "the zero is off by 3 N"}],
    failed_checks=[{"name": "zero", "reason": "the zero is off by 3 N"}],
    refused={"a.csv": "no column is called <force>"},
    understood={"b.csv": ["decimal comma"]},
    warnings=["the film is not calibrated"],
    record=[(np.zeros(4000), {"a": 1})] * 50,
)


@pytest.mark.parametrize(
    "shown",
    [
        INVENTED,
        lj.parts(),
        lj.show(KAPTON),
        lj.vacuum(KAPTON, slip=0.02, force=[50, 100, 300]),
    ],
    ids=["invented", "parts", "show", "vacuum"],
)
def test_a_notebook_shows_every_word_of_the_terminal(shown: Result) -> None:
    printed = shown.table(10**6).replace("^2", "²").replace("^3", "³").split()
    assert len(printed) > 4
    assert words(shown._repr_html_()) == printed
    assert len(repr(shown.record)) <= brief.LONGEST


def test_text_of_a_file_cannot_become_html() -> None:
    html = INVENTED._repr_html_()
    assert "&lt;force&gt;" in html and "a &amp; b" in html
    assert html.index("FAIL") < html.index("refused:") < html.index("note: the film")


def test_a_plot_is_a_picture_in_a_notebook() -> None:
    figure: Any = lj.force(KAPTON, slip=0.02, vacuum=5e4).plot()
    assert figure._repr_svg_().startswith("<?xml") and "</svg>" in figure._repr_svg_()


def test_a_shortened_record_equals_the_original() -> None:
    for record in ([1, "a"], (1, 2.0), {"a": [1]}):
        short = brief.shorten_group(record)
        assert short == record and isinstance(short, type(record))
    assert repr(brief.shorten_group([1.0, 2.0, 3.0, 4.0, 5.0])) == "1; 2; 3, and 2 more"


def _record_types() -> Iterator[tuple[str, type]]:
    """Yield (result, class) of the record classes that results name in their source."""
    for module in sorted({entry.module for entry in commands().values()}):
        tree = ast.parse(Path(str(importlib.import_module(module).__file__)).read_text("utf-8"))
        sources = {
            alias.asname or alias.name: (node.module, alias.name)
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom)
            for alias in node.names
        }
        for node in tree.body:
            if not isinstance(node, ast.ClassDef):
                continue
            for line in node.body:
                if isinstance(line, ast.AnnAssign) and ast.unparse(line.target) == "record":
                    for name in re.findall(r"[A-Z]\w+", ast.unparse(line.annotation)):
                        home, inside = sources.get(name, (module, name))
                        kind = getattr(importlib.import_module(str(home)), inside, None)
                        if isinstance(kind, type):
                            yield node.name, kind


def test_every_record_is_described_in_one_paragraph() -> None:
    kinds = [*_record_types()]
    assert len(kinds) > 30
    unlike = [
        f"{name}: {kind.__name__}"
        for name, kind in kinds
        if kind.__module__.startswith("layerjam") and kind.__repr__ is not brief._describe_record
    ]
    assert unlike == []

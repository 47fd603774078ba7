"""No flag of the command line stands on a page: sentences name the control instead."""

from __future__ import annotations

import ast
import functools
import re
from pathlib import Path

import pytest

import layerjam
from layerjam.core.command.declare import load_command
from layerjam.core.command.index import commands
from layerjam.core.errors import FileError, QuantityError
from layerjam.workbench.pages.laboratory import FREE as FREE_CHOICE
from layerjam.workbench.pages.laboratory import STICK_SLIP
from layerjam.workbench.spoken import (
    FREE,
    OTHERWISE,
    PHRASES,
    format_sentence,
    page_text,
    typeset_text,
)

FLAG = re.compile(r"(?<![\w-])--[a-z]")
ROOT = Path(layerjam.__file__).parent


@functools.cache
def said_in(path):
    """The texts of a source file in which a flag stands, f-strings with a word for each value."""
    texts = []
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.JoinedStr):
            words = (str(v.value) if isinstance(v, ast.Constant) else "12 kPa" for v in node.values)
            texts.append("".join(words))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            texts.append(node.value)
    return texts


@pytest.mark.slow
def test_every_sentence_of_the_source_loses_its_flags():
    found = 0
    for path in ROOT.rglob("*.py"):
        for text in said_in(path):
            if FLAG.search(text):
                found += 1
                assert not FLAG.search(page_text(text)), page_text(text)
    assert found > 100


def test_each_phrase_is_in_a_sentence_of_the_source():
    """A phrase whose sentence was reworded would leave half of it on the page."""
    texts = [t for path in ROOT.rglob("*.py") if path.name != "spoken.py" for t in said_in(path)]
    for pattern, _ in PHRASES:
        assert any(re.search(pattern, text) for text in texts), pattern


def test_a_flag_becomes_the_name_of_its_field():
    """The fields of a fold are called so: `Parameter.label`, read here from the declarations."""
    seen = set()
    for name in ("friction", "calibrate", "drop", "rise", "report", "design"):
        for p in load_command(name).parameters:
            option = p.option.removeprefix("--")
            if not p.positional and option not in OTHERWISE:
                seen.add(option)
                assert page_text(f"give {p.option}; so") == f"give '{p.label.capitalize()}'; so"
    assert len(seen) > 40 and commands()


@pytest.mark.parametrize(("said", "page"), [
    ("nothing says how hard they were pressed; give --normal-force",
     "nothing says how hard they were pressed; give 'Normal force'"),
    ("there is no mean (--accept-stick-slip uses the midpoint)",
     "there is no mean ('Stick–slip' uses the midpoint)"),
    ("depth curves can fit it (--free force_offset)",
     "depth curves can fit it ('Also fit': force offset)"),
    ("a preload, or the load cell's zero (--tare subtracts it)",
     "a preload, or the load cell's zero"),
    ("a dash -- and 3--4 and --", "a dash -- and 3--4 and --"),
])  # fmt: skip
def test_sentences_read_as_english_on_the_page(said, page):
    assert page_text(said) == page


def test_no_key_reaches_a_reader():
    said = "chamber.volume is an estimate; holding_force >= 300 N; a_file_of.csv 'usable_travel'"
    page = "chamber volume is an estimate; holding force ≥ 300 N; a_file_of.csv 'usable_travel'"
    assert typeset_text(said) == page


def test_what_a_file_asks_for_is_not_told_as_an_option():
    err = FileError("a.csv", "its force is negative", how=" (--negative force)", asks="force-sign")
    assert format_sentence(err) == "a.csv: its force is negative"
    assert "--negative" in str(err), "the command line keeps its own"
    assert format_sentence(QuantityError("give\n --volume")) == "give 'Volume'"


def test_the_laboratorys_own_names_are_those_it_shows():
    assert OTHERWISE["accept-stick-slip"] == STICK_SLIP.name
    assert OTHERWISE["free"] == FREE_CHOICE.name
    assert dict(FREE_CHOICE.words) == dict(FREE)

"""Notebooks of the docs: what is stored in them is what they give today."""

from __future__ import annotations

import json
import re
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from docs.examples import ROOT, script

notebooks = script(ROOT / "docs" / "notebooks.py")
STORED = sorted(notebooks.FOLDER.glob("*.ipynb"))
NUMBER = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")
NAME = re.compile(r"\b[mp][0-9a-f]{10}\b")
"""A name of a marker or a clip path: a hash of coordinates, to the last digit."""


def difference(stored: dict[str, Any], made: dict[str, Any]) -> str:
    """Where the outputs of two runs differ; pictures may in the hundredths of a point."""
    pairs = zip(deepcopy(stored["cells"]), deepcopy(made["cells"]), strict=True)
    for number, (old, new) in enumerate(pairs, 1):
        for a, b in zip(old.get("outputs", ()), new.get("outputs", ()), strict=True):
            pictures = ["".join(o.get("data", {}).pop("image/svg+xml", "")) for o in (a, b)]
            pictures = [NAME.sub("name", picture) for picture in pictures]
            points = [np.array(NUMBER.findall(picture), dtype=float) for picture in pictures]
            if len({NUMBER.sub("", picture) for picture in pictures}) > 1:
                return f"the shapes in the picture of cell {number}"
            if points[0].shape != points[1].shape or not np.allclose(*points, atol=0.01):
                return f"the picture of cell {number}"
        if old != new:
            return f"cell {number}: {new}"
    return ""


@pytest.mark.slow
@pytest.mark.parametrize("path", STORED, ids=lambda p: p.stem)
def test_stored_outputs_are_what_the_cells_give(path: Path, tmp_path: Path) -> None:
    stored = notebooks.read(path)
    made = notebooks.executed(stored, tmp_path)
    assert difference(stored, made) == "", f"run docs/notebooks.py {path.stem}"


@pytest.mark.parametrize("path", STORED, ids=lambda p: p.stem)
def test_a_stored_notebook_was_run_in_order_and_shows_something(path: Path) -> None:
    notebook = notebooks.read(path)
    assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
    ids = [cell["id"] for cell in notebook["cells"]]
    assert len(set(ids)) == len(ids)
    code = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert [cell["execution_count"] for cell in code] == list(range(1, len(code) + 1))
    outputs = [output for cell in code for output in cell["outputs"]]
    assert any("image/svg+xml" in output.get("data", {}) for output in outputs)
    assert all(len(line) <= 88 for cell in code for line in "".join(cell["source"]).split("\n"))
    assert not re.search(r"/(?:tmp|home|root|work)/", json.dumps(notebook))


def written(*sources: str) -> dict[str, Any]:
    """A notebook that has not been run; the first source is prose."""
    cells = [{"cell_type": "markdown", "id": "a", "metadata": {}, "source": [sources[0]]}]
    cells += [
        {"cell_type": "code", "execution_count": None, "id": f"b{i}", "metadata": {},
         "outputs": [], "source": source.splitlines(keepends=True)}
        for i, source in enumerate(sources[1:])
    ]  # fmt: skip
    return {"cells": cells, "metadata": {}, "nbformat": 4, "nbformat_minor": 5}


DRAWN = """from pathlib import Path
from IPython.display import SVG
Path("a.svg").write_text("<svg><path d='M 1.5 2'/></svg>")
SVG("a.svg")"""


def test_cells_share_names_print_and_show_their_last_line(tmp_path: Path) -> None:
    made = notebooks.executed(written("# Title", "x = 6\nprint('six')", "x * 7", DRAWN), tmp_path)
    _, first, second, third = made["cells"]
    assert first["outputs"] == [{"name": "stdout", "output_type": "stream", "text": ["six\n"]}]
    assert second["outputs"][0]["data"] == {"text/plain": ["42"]}
    assert "M 1.5 2" in "".join(third["outputs"][0]["data"]["image/svg+xml"])
    text, pictures = notebooks.page(made, "name")
    assert "[Download this notebook](name.ipynb)" in text
    assert text.index("print('six')") < text.index("```text\nsix\n```") < text.index("42")
    assert list(pictures) == ["name-1.svg"] and "![Title](name-1.svg)" in text


def test_a_changed_number_or_picture_is_found(tmp_path: Path) -> None:
    made = notebooks.executed(written("# Title", "40 + 2", DRAWN), tmp_path)
    for old, new in (('"42"', '"43"'), ("1.5", "1.6")):
        assert difference(json.loads(json.dumps(made).replace(old, new)), made)
    near = json.loads(json.dumps(made).replace("M 1.5 2'/></svg>\"]", "M 1.505 2'/></svg>\"]"))
    assert near != made
    assert difference(made, near) == ""


def test_a_link_to_another_notebook_leads_to_its_page(tmp_path: Path) -> None:
    notebook = written("See [this](other.ipynb) and [that](../models.md).")
    text, _ = notebooks.page(notebook, "name", {"other"})
    assert "[this](other.md) and [that](../models.md)" in text
    text, _ = notebooks.page(notebook, "name", {"name"})
    assert "[this](other.ipynb)" in text

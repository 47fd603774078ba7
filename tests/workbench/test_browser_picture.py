"""The photograph in docs/workbench.md shows the page as it is today."""

from __future__ import annotations

import io
import json

import numpy as np
import pytest

from docs.examples import ROOT, script

COMMITTED = ROOT / "docs" / "images" / "workbench.png"
pytestmark = [pytest.mark.slow, pytest.mark.timing]


@pytest.mark.campaign
def test_photograph_has_the_words_of_the_page_in_their_places(chromium, workbench):
    image = pytest.importorskip("PIL.Image")
    program = script(COMMITTED.with_suffix(".py"))
    picture, words = program.photograph(chromium, workbench)
    committed = json.loads(COMMITTED.with_suffix(".json").read_text("utf-8"))
    # the browser adds the labels of the 3-D view in any order
    committed, words = (sorted(some, key=lambda row: row[0]) for some in (committed, words))
    assert [word for word, *_ in committed] == [word for word, *_ in words], "make pictures"
    places = [[place for _, *place in some] for some in (committed, words)]
    assert np.allclose(*places, rtol=0, atol=4), "make pictures"
    sizes = {image.open(io.BytesIO(some)).size for some in (COMMITTED.read_bytes(), picture)}
    assert sizes == {tuple(program.SIZE.values())}
    assert len(COMMITTED.read_bytes()) <= 150_000

"""One dataset as its authors publish it, for the tests that forge copies of it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from laboratory.dataset.forger import derive_once, publish_honestly
from layerjam.laboratory.commands.publish import Published


@pytest.fixture(scope="module")
def published(tmp_path_factory: pytest.TempPathFactory) -> Published:
    return publish_honestly(tmp_path_factory)


@pytest.fixture(scope="module")
def derived_once(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with derive_once(tmp_path_factory):
        yield

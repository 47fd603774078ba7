"""Addresses of pages: one that was published still leads somewhere."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from docs.examples import ROOT, script

yaml = pytest.importorskip("yaml")
toc = pytest.importorskip("markdown.extensions.toc")
DOCS = ROOT / "docs"
PUBLISHED = (Path(__file__).with_name("addresses.txt")).read_text("utf-8").split()
"""Pages in the navigation of commit 06b5a187, and sections of those that were merged."""
redirects = script(DOCS / "redirects.py")


@cache
def settings() -> dict[str, Any]:
    """mkdocs.yml without its Python tags, which only mkdocs reads."""
    text = re.sub(r"!!python/\S+", "", (ROOT / "mkdocs.yml").read_text("utf-8"))
    found: dict[str, Any] = yaml.safe_load(text)
    return found


def moved() -> dict[str, str]:
    """The new page and section of each page that was merged into another."""
    table: dict[str, str] = settings()["extra"]["moved"]
    return table


def navigation(entry: object = None) -> list[str]:
    """Files of the menu, in its order."""
    entry = settings()["nav"] if entry is None else entry
    if isinstance(entry, str):
        return [entry]
    parts = entry.values() if isinstance(entry, dict) else entry
    return [file for part in parts for file in navigation(part)]


def sections(text: str) -> set[str]:
    """Anchors of the headings of a page, as mkdocs makes them."""
    bare = re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)
    found: set[str] = set()
    for heading in re.findall(r"^#{1,6} (.+)$", bare, re.MULTILINE):
        plain = re.sub(r"\[([^]]*)\]\([^)]*\)|[`*]", r"\1", heading)
        toc.unique(toc.slugify(plain, "-"), found)
    return found


@pytest.mark.parametrize("name", PUBLISHED)
def test_a_published_address_is_a_page_or_leads_to_one(name: str) -> None:
    page, _, asked = name.partition("#")
    if page not in moved():
        assert page in navigation()
        return
    assert not (DOCS / page).exists() and page not in navigation()
    file, _, section = moved()[page].partition("#")
    assert file in navigation() and file not in moved()
    if asked or section:
        assert (asked or section) in sections((DOCS / file).read_text("utf-8"))


def test_a_redirect_keeps_the_section_that_a_link_names() -> None:
    page = redirects.redirect("notebooks/old.md", "new.md#part")
    assert 'location.replace("../new.html" + (location.hash || "#part"))' in page
    assert 'content="0; url=../new.html#part"' in page
    assert 'url=new.html"' in redirects.redirect("old.md", "new.md")


def test_sections_are_found_as_the_site_names_them() -> None:
    text = "# A `b`\n\n```sh\n# not one\n```\n\n## [Link](x.md) here\n\n## Link here\n"
    assert sections(text) == {"a-b", "link-here", "link-here_1"}

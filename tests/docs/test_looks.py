"""What the site's hook does to the code of a page (docs/page_looks.py)."""

from __future__ import annotations

import re

from docs.examples import ROOT, script

looks = script(ROOT / "docs" / "page_looks.py").looks


def shown(content: str) -> str:
    return re.sub(r"<[^>]*>", "", content)


def test_an_option_stays_in_one_piece_and_reads_as_before() -> None:
    page = "<p><code>--figure name.svg</code> and <code>a-b</code>, <code>x</code></p>"
    made = looks(page)
    assert '<code><span class="kept">--figure</span> name.svg</code>' in made
    assert '<span class="kept">a-b</span>' in made
    assert "<code>x</code>" in made
    assert shown(made) == shown(page)


def test_blocks_of_code_stay_as_they_are() -> None:
    block = "<pre><span></span><code>$ layerjam --version a\\|b</code></pre>"
    assert looks(block) == block
    assert looks(block + "<code>--a</code>").startswith(block)


def test_a_bar_of_a_table_loses_the_backslash_that_github_needs() -> None:
    assert looks("<td><code>step\\|sine</code></td>") == "<td><code>step|sine</code></td>"


def test_only_what_is_too_long_for_a_column_may_break_there() -> None:
    long = "layerjam bench run ADDRESS --procedure TEXT --brake BRAKE --line LINE"
    assert looks(f"<code>{long}</code>").startswith('<code class="long">')
    assert looks("<code>layerjam show BRAKE</code>").startswith("<code>")
    word = "--" + "x" * 40
    assert looks(f"<code>{word}</code>") == f"<code>{word}</code>", "wider than a phone"

"""The counts of sentences and names that break the style guide may only fall.

After an improvement, in the folder tests:
python -m docs.plain_english .. --since fc6b757 --json > docs/plain_english.json
"""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import pytest

from docs.plain_english import Text, check, check_text

ROOT = Path(__file__).parents[2]
LIMITS = Path(__file__).with_name("plain_english.json")
START = "fc6b757"
"""Last commit before the guide was agreed: later subjects follow it."""


@pytest.mark.slow
def test_no_count_rises() -> None:
    since = START if (ROOT / ".git").exists() else "HEAD"
    hits, read = check(ROOT, since)
    counts = Counter((hit.rule, hit.group) for hit in hits)
    limits = json.loads(LIMITS.read_text("utf-8"))
    worse = {
        f"{rule} in {group}": f"{count}, at most {limits.get(rule, {}).get(group, 0)}"
        for (rule, group), count in counts.items()
        if count > limits.get(rule, {}).get(group, 0)
    }
    assert not worse
    assert read["cli"] > 4000 and read["identifiers"] > 40000


def test_the_checker_finds() -> None:
    """One sentence for each of some rules, and one that breaks none."""
    found = {hit.rule for hit in check_text(Text("cli", "", "this is no file that stands here."))}
    assert {"is-no", "stands"} <= found
    assert not list(check_text(Text("cli", "", "The file does not exist.")))

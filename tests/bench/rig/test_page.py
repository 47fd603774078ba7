"""The page's table holds every header of the instrument, and none that it has not."""

from __future__ import annotations

import re
from pathlib import Path

from bench.rig.boards import firmware

PAGE = Path(__file__).parents[3] / "docs" / "scpi.md"


def test_the_page_names_every_header_as_it_is() -> None:
    page = PAGE.read_text("utf-8").split("## The commands of the instrument")[1]
    table = page.split("## Errors\n")[0]
    rows = [row.split("|")[1] for row in table.splitlines() if row.startswith("| `")]
    said = {name for row in rows for name in re.findall(r"`([^`]+)`", row)}
    wanted = set()
    for header, command, query in firmware().commands.TABLE:
        ends = "(?)" if command and query else "?" if query else ""
        wanted.add(header + ends)
    assert said == wanted

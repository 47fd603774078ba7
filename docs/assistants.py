"""Lists for people and their coding assistants: pages, commands and decisions, one a line."""

from __future__ import annotations

import re
from pathlib import Path

from layerjam.core.command.index import GROUPS, commands

DOCS = Path(__file__).parent
LINK = re.compile(r"\[([^]]+)\]\([^)]*\)")


def decisions() -> str:
    """Every decision, the newest last: its date, its title and its status."""
    lines = ["| date | decision | status |", "| --- | --- | --- |"]
    for path in sorted((DOCS / "decisions").glob("2*.md")):
        text = path.read_text(encoding="utf-8")
        title, status = re.match(r"# (.+)\n\nStatus: (\w[^.;,]*)", text).groups()  # type: ignore[union-attr]
        lines.append(f"| {path.name[:10]} | [{title}]({path.name}) | {status} |")
    return "\n".join(lines)


def page_list() -> str:
    """The pages of the site in the order of its menu, with the first sentence of each."""
    menu = (DOCS.parent / "mkdocs.yml").read_text(encoding="utf-8").split("\nnav:\n")[1]
    lines = []
    for entry in re.split(r"\n(?! )", menu)[0].splitlines():
        title, _, file = entry.strip(" -").rpartition(": ")
        if not file.endswith(".md"):
            lines.append(f"\n## {entry.strip(' -:')}\n")
        elif (DOCS / file).exists():  # pages of notebooks are made with the site
            lines.append(f"- [{title.strip(chr(34))}]({file}): {_first_sentence(DOCS / file)}")
    return "\n".join(lines).strip()


def _first_sentence(page: Path) -> str:
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    paragraph = next(part for part in text.split("\n\n")[1:] if part.lstrip("`")[:1].isalpha())
    return LINK.sub(r"\1", re.split(r"(?<=[.:])\s", paragraph)[0]).rstrip(":.") + "."


def command_list() -> str:
    """Every command by its group, with its summary."""
    lines = []
    for group, title in GROUPS.items():
        members = [entry for entry in commands().values() if entry.group == group]
        lines += [f"\n**{title}**\n", *(f"- `{e.name}`: {e.summary}" for e in members)]
    return "\n".join(lines).strip()

"""Words that must not come back, where a user reads them (docs/contribute.md#style).

python tests/docs/words.py     every line with such a word
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
WORDS = re.compile(
    r"\b(judder(?:s|ed|ing)?|sleeves?|verbs?|rivals?|warmth|upsets?|standing vacuum|"
    r"needed is|(?:is|are|was|were) (?:told|felt)(?! apart)|gives way|all the way|"
    r"holds? the force|holds (?:more than|\d+ N))\b"
)
"""Only static friction holds; a brake that slides resists."""
CODE = re.compile(
    r"```.*?```|`[^`\n]*`|<!-- generated:.*?<!-- end -->|\]\([^)]*\)|\[judder\]|"
    r"layerjam (?:sleeve|judder)|^### \w+$|^::: .*\n(?:    .*\n)*",
    re.DOTALL | re.MULTILINE,
)
"""Code, links and what is generated from declarations keep the names that users type."""
PAGES = ("docs/decisions", "CHANGELOG.md")
"""What may name the words, as it was written about the past."""
LIST = re.compile(r"^## Style\n.*?(?=^## )", re.DOTALL | re.MULTILINE)
"""The list of the words itself, in docs/contribute.md."""


def in_pages() -> Iterator[str]:
    """Offending lines of README, CONTRIBUTING and docs."""
    files = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
    for path in files:
        name = path.relative_to(ROOT).as_posix()
        if name.startswith(PAGES):
            continue
        text = path.read_text(encoding="utf-8")
        if name == "docs/contribute.md":
            text = LIST.sub(lambda m: "\n" * m.group(0).count("\n"), text)
        bare = CODE.sub(lambda m: "\n" * m.group(0).count("\n"), text)
        for number, line in enumerate(bare.split("\n"), 1):
            for found in WORDS.finditer(line):
                yield f"{name}:{number}: {found.group(0)}"


def in_notebooks() -> Iterator[str]:
    """Offending texts of the notebooks, code and output not included."""
    for path in sorted((ROOT / "docs" / "notebooks").glob("*.ipynb")):
        for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
            text = CODE.sub(" ", "".join(cell["source"]) if cell["cell_type"] == "markdown" else "")
            for found in WORDS.finditer(text):
                yield f"{path.name}: {found.group(0)}"


def in_source() -> Iterator[str]:
    """Offending texts of the source: messages, help and docstrings."""
    for path in sorted((ROOT / "src").rglob("*.py")):
        name = path.relative_to(ROOT).as_posix()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                text = CODE.sub(" ", node.value)
                if " " not in text.strip():
                    continue  # a name, a key, an option
                for found in WORDS.finditer(text):
                    yield f"{name}:{node.lineno}: {found.group(0)}"


if __name__ == "__main__":
    lines = [*in_pages(), *in_notebooks(), *in_source()]
    print(*lines, sep="\n")
    print(f"{len(lines)} places")

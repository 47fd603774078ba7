"""Count sentences and names in a checkout that break the rules of plain English.

    python -m docs.plain_english CHECKOUT [--since COMMIT]   table: rule x group
    python -m docs.plain_english CHECKOUT --list RULE        every hit, PATH:LINE: text
    python -m docs.plain_english CHECKOUT --json             {rule: {group: count}}

Run it in `tests`. It reads src/**/*.py, docs/**/*.md, README.md and commit subjects, and in docs
the scripts, the SCPI headers and the pictures. Groups: cli, page (src/*/workbench), docstrings,
comments, docs, commits, identifiers.
"""

from __future__ import annotations

import argparse
import ast
import json
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from docs.style_rules import (
    COMPILED,
    PATTERNS,
    SENTENCE_TESTS,
    TRUE_PERCENT,
    WHOLE_TESTS,
    identifier_hits,
    module_names,
)  # fmt: skip
from docs.style_texts import (
    GROUPS,
    Hit,
    Text,
    commit_texts,
    markdown_texts,
    picture_texts,
    python_texts,
    sentences,
    table_texts,
)  # fmt: skip

READERS = {
    ".md": markdown_texts,
    ".py": python_texts,
    ".toml": table_texts,
    ".svg": picture_texts,
}
"""{extension of a file in docs: reader of its texts}."""
RULES = (*PATTERNS, *SENTENCE_TESTS, *WHOLE_TESTS, "participle", "function-word")


def check_text(text: Text) -> Iterator[Hit]:
    """Yield the breaches in one piece of text, at most one for each rule and sentence."""
    for rule, (group, test) in WHOLE_TESTS.items():
        if text.group == group and test(text.text):
            yield Hit(rule, group, text.place, " ".join(text.text.split())[:200])
    for sentence in sentences(text.text):
        for rule, pattern in COMPILED.items():
            if rule == "what-start" and text.group == "docs" and not sentence.endswith("."):
                continue  # a heading such as "What was measured" is good English
            if pattern.search(sentence):
                yield Hit(rule, text.group, text.place, sentence)
        for rule, test in SENTENCE_TESTS.items():
            if test(sentence):
                yield Hit(rule, text.group, text.place, sentence)


def check(root: Path, since: str = "") -> tuple[list[Hit], Counter[str]]:
    """Return all hits, and the number of texts (or names) read in each group."""
    hits: list[Hit] = []
    read: Counter[str] = Counter()
    texts: list[Text] = []
    for path in sorted((root / "src").rglob("*.py")):
        texts += python_texts(root, path)
        found = list(identifier_hits(root, path))
        read["identifiers"] += sum(1 for _ in module_names(ast.parse(path.read_text("utf-8"))))
        hits += found
    for path in [root / "README.md", *sorted((root / "docs").rglob("*.*"))]:
        if path.exists() and path.suffix in READERS:
            texts += READERS[path.suffix](root, path)
    texts += commit_texts(root, since)
    for text in texts:
        read[text.group] += 1
        hits += check_text(text)
    return hits, read


def table(hits: list[Hit], read: Counter[str]) -> str:
    """Return the counts as a Markdown table: a row for each rule, a column for each group."""
    counts = Counter((hit.rule, hit.group) for hit in hits)
    rows = [
        "| rule | " + " | ".join(GROUPS) + " | all | true % |",
        "|---" * (len(GROUPS) + 3) + "|",
    ]
    for rule in RULES:
        cells = [counts[rule, group] for group in GROUPS]
        rows.append(
            f"| {rule} | "
            + " | ".join(str(c or "") for c in cells)
            + f" | {sum(cells)} | {TRUE_PERCENT[rule]} |"
        )
    rows.append(
        "| texts read | "
        + " | ".join(str(read[g]) for g in GROUPS)
        + f" | {sum(read.values())} | |"
    )
    return "\n".join(rows)


def main() -> int:
    """Run the checker on the command line's arguments."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("checkout", type=Path)
    parser.add_argument("--since", default="", help="Read commit subjects after this commit only.")
    parser.add_argument("--list", metavar="RULE", choices=RULES, help="Print every hit of a rule.")
    parser.add_argument("--json", action="store_true", help="Print {rule: {group: count}}.")
    args = parser.parse_args()
    hits, read = check(args.checkout, args.since)
    if args.list:
        for hit in hits:
            if hit.rule == args.list:
                print(f"{hit.place}: [{hit.group}] {hit.text}")
        return 0
    if not args.json:
        print(table(hits, read))
        return 0
    counts: dict[str, dict[str, int]] = {}
    for hit in hits:
        groups = counts.setdefault(hit.rule, {})
        groups[hit.group] = groups.get(hit.group, 0) + 1
    print(json.dumps(counts, indent=1, sort_keys=True))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

"""Each class of the page has a rule: nothing generates utility classes in the browser."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from layerjam import workbench

nicegui = pytest.importorskip("nicegui", reason="the extra 'workbench' is not installed")
FOLDER = Path(workbench.__file__).parent
SIZES = re.compile(r"(?<![\w-])(?:gap-x|gap-y|gap|[whmp][xytblr]?)-\d+(?![\w-])")
"""Classes of sizes, which are also positional arguments."""


def class_names(path: Path) -> Iterator[str]:
    """Yield the literal class names of a module: of `classes`, and in HTML."""
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Call):
            given = [word.value for word in node.keywords if word.arg == "classes"]
            if isinstance(node.func, ast.Attribute) and node.func.attr == "classes":
                given += node.args
            for part in (leaf for value in given for leaf in ast.walk(value)):
                if isinstance(part, ast.Constant) and isinstance(part.value, str):
                    yield from part.value.split()
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            for names in re.findall(r"class=[\"']([^\"'{]*)", node.value):
                yield from names.split()
            yield from SIZES.findall(node.value)


def test_every_class_has_a_rule():
    sheets = [*(Path(nicegui.__file__).parent / "static").glob("*.css"), *FOLDER.glob("*.css")]
    rules = re.findall(r"\.(-?[A-Za-z_][\w-]*)", "\n".join(s.read_text("utf-8") for s in sheets))
    scripts = "\n".join(path.read_text("utf-8") for path in FOLDER.glob("*.js"))
    used = {name: path.name for path in FOLDER.rglob("*.py") for name in class_names(path)}
    assert len(used) > 80
    assert {n: path for n, path in used.items() if n not in rules and n not in scripts} == {}

"""The notebooks of the docs: run and stored with their outputs, and shown as pages.

    python docs/notebooks.py [NAME...]    run docs/notebooks/*.ipynb again and store the outputs

A hook of mkdocs makes a page of each that is in the navigation, from the stored outputs; the others
are downloads, which the tutorials link. The cells run in a folder of their
own, top to bottom; what the last line of a cell is worth is shown, as Jupyter does. Jupyter itself
is not needed for it.
"""

from __future__ import annotations

import ast
import contextlib
import io
import json
import re
import sys
import tempfile
from collections.abc import Collection, Iterator
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files

FOLDER = Path(__file__).parent / "notebooks"
DISPLAY = "IPython.display"
NOTEBOOK = re.compile(r"\]\(([\w-]+)\.ipynb\)")
"""A link to another notebook; on the site it leads to that one's page, if it has one."""


class SVG:
    """Stands for the class of that name in IPython.display, which notebooks import."""

    def __init__(self, filename: str) -> None:
        self.text = Path(filename).read_text(encoding="utf-8")

    def _repr_svg_(self) -> str:
        return self.text

    def __repr__(self) -> str:
        return "<IPython.core.display.SVG object>"


@contextlib.contextmanager
def _display() -> Iterator[None]:
    """`from IPython.display import SVG`, whether or not IPython is installed."""
    stand_in = ModuleType(DISPLAY)
    stand_in.SVG = SVG  # type: ignore[attr-defined]
    kept = sys.modules.get(DISPLAY)
    sys.modules[DISPLAY] = stand_in
    try:
        yield
    finally:
        del sys.modules[DISPLAY]
        if kept is not None:
            sys.modules[DISPLAY] = kept


def _lines(text: str) -> list[str]:
    return text.splitlines(keepends=True)


def _data(value: object) -> dict[str, list[str]]:
    """Return the texts with which a value shows itself, by kind."""
    made = {"text/plain": _lines(repr(value))}
    for kind, method in (("text/html", "_repr_html_"), ("image/svg+xml", "_repr_svg_")):
        if text := getattr(value, method, lambda: None)():
            made[kind] = _lines(text)
    return made


def run_cell(source: str, namespace: dict[str, Any], number: int) -> list[dict[str, Any]]:
    """The outputs of a code cell: what it prints, and the value of its last line."""
    body = ast.parse(source)
    last = body.body.pop() if body.body and isinstance(body.body[-1], ast.Expr) else None
    printed, value = io.StringIO(), None
    with contextlib.redirect_stdout(printed):
        exec(compile(body, f"cell {number}", "exec"), namespace)
        if last is not None:
            value = eval(compile(ast.Expression(last.value), f"cell {number}", "eval"), namespace)
    outputs: list[dict[str, Any]] = []
    if printed.getvalue():
        text = _lines(printed.getvalue())
        outputs.append({"name": "stdout", "output_type": "stream", "text": text})
    if value is not None:
        shown = {"data": _data(value), "execution_count": number, "metadata": {}}
        outputs.append({**shown, "output_type": "execute_result"})
    return outputs


def executed(notebook: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The notebook with the outputs that its cells give in `folder`."""
    namespace: dict[str, Any] = {"__name__": "__main__"}
    cells, number = [], 0
    with contextlib.chdir(folder), _display():
        for cell in notebook["cells"]:
            new = dict(cell)
            if cell["cell_type"] == "code":
                number += 1
                outputs = run_cell("".join(cell["source"]), namespace, number)
                new |= {"execution_count": number, "outputs": outputs}
            cells.append(new)
    return {**notebook, "cells": cells}


def page(
    notebook: dict[str, Any], name: str, shown: Collection[str] = ()
) -> tuple[str, dict[str, str]]:
    """The notebook as Markdown with its stored outputs, and the pictures by file name.

    `shown` names the notebooks that have a page of their own.
    """

    def link(found: re.Match[str]) -> str:
        return f"]({found[1]}.md)" if found[1] in shown else found[0]

    parts: list[str] = []
    pictures: dict[str, str] = {}
    heading = name
    for cell in notebook["cells"]:
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(NOTEBOOK.sub(link, source))
            heading = source.splitlines()[0].lstrip("# ")
            if len(parts) == 1:
                parts.append(f"[Download this notebook]({name}.ipynb) and open it in Jupyter.")
            continue
        parts.append(f"```python\n{source}\n```")
        for output in cell["outputs"]:
            data = output.get("data", {"text/plain": output.get("text")})
            if "image/svg+xml" in data:
                file = f"{name}-{len(pictures) + 1}.svg"
                pictures[file] = "".join(data["image/svg+xml"])
                parts.append(f"![{heading}]({file})")
            elif "text/html" in data:
                parts.append(f'<div class="jupyter">{"".join(data["text/html"])}</div>')
            else:
                text = "".join(data["text/plain"]).rstrip("\n")
                parts.append(f"```text\n{text}\n```")
    return "\n\n".join(parts) + "\n", pictures


def read(path: Path) -> dict[str, Any]:
    """A stored notebook."""
    notebook: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return notebook


def on_files(files: Files, config: MkDocsConfig, **_of: object) -> Files:
    """Add a page for each notebook in the navigation; mkdocs calls this."""
    from mkdocs.structure.files import File

    listed = set(re.findall(r"notebooks/([\w-]+)\.md", json.dumps(config.nav)))
    for path in sorted(FOLDER.glob("*.ipynb")):
        if path.stem not in listed:
            continue
        text, pictures = page(read(path), path.stem, listed)
        for name, content in {f"{path.stem}.md": text, **pictures}.items():
            files.append(File.generated(config, f"notebooks/{name}", content=content))
    return files


def main() -> None:
    """Run all of them, or those named."""
    import jax

    jax.config.update("jax_enable_x64", True)
    for path in sorted(FOLDER.glob("*.ipynb")):
        if sys.argv[1:] and path.stem not in sys.argv[1:]:
            continue
        with tempfile.TemporaryDirectory() as folder:
            made = executed(read(path), Path(folder))
        path.write_text(json.dumps(made, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        print(path.name)


if __name__ == "__main__":
    main()

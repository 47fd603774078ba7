"""What a page shows as a Jupyter notebook (nbformat 4): cells that compute and draw it anew."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from layerjam.workbench.call import Call, apart, python_parts

SHOWING = "from IPython.display import SVG, display\n"
"""What the lines that show a figure need."""


def notebook(
    title: str, calls: Sequence[Call], pinned: Mapping[str, Call] = MappingProxyType({})
) -> str:
    """The notebook's JSON; it needs layerjam, and Jupyter to be opened.

    Brakes and lines that are in no catalogue are in the notebook, and written beside it where it is
    run; of measured files it says that they belong there.
    """
    own = apart(calls, pinned)
    head, *asked = python_parts(own.calls, own.pinned, display=True)
    files = [file.shown for call in (*own.calls, *own.pinned.values()) for file in call.data]
    cells = [_words(_about(title, own.calls, files)), _code(head + SHOWING)]
    if own.texts:
        cells.append(_code("from pathlib import Path\n\n" + "".join(_writing(own.texts))))
    return _whole([*cells, *map(_code, asked)])


def notebook_of(title: str, lines: str) -> str:
    """The notebook's JSON of Python lines that draw a `figure`."""
    about = f"# {title}\n\nMade by layerjam's workbench. Run it where layerjam is installed.\n"
    return _whole([_words(about), _code(f"{lines}figure\n")])


def _whole(cells: list[dict[str, Any]]) -> str:
    for number, cell in enumerate(cells, 1):
        cell["id"] = f"cell-{number}"
    spec = {"name": "python3", "display_name": "Python 3", "language": "python"}
    about = {"kernelspec": spec, "language_info": {"name": "python"}}
    whole = {"nbformat": 4, "nbformat_minor": 5, "metadata": about, "cells": cells}
    return json.dumps(whole, indent=1, ensure_ascii=False) + "\n"


def _writing(texts: Mapping[str, str]) -> Iterator[str]:
    """Lines that write files, so that the notebook needs nothing beside it."""
    for name, text in texts.items():
        lines = "".join(f"    {_literal(line)}\n" for line in text.splitlines(keepends=True))
        yield f'text = (\n{lines})\nPath({_literal(name)}).write_text(text, encoding="utf-8")\n'


def _literal(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


def _about(title: str, calls: Sequence[Call], files: Sequence[str]) -> str:
    """What stands above the cells: the files that are needed, and the commands behind it."""
    lines = [f"# {title}\n\nMade by layerjam's workbench. Run it where layerjam is installed.\n"]
    needed = dict.fromkeys(files)
    if needed:
        named = "".join(f"- `{name}`\n" for name in needed)
        lines.append(f"Put these files into the notebook's folder first:\n\n{named}")
    lines += [f"    {line}\n" for call in calls for line in call.command().splitlines()]
    return "\n".join(lines)


def _words(text: str) -> dict[str, Any]:
    return {"cell_type": "markdown", "metadata": {}, "source": _lines(text)}


def _code(text: str) -> dict[str, Any]:
    empty: dict[str, Any] = {"metadata": {}, "execution_count": None, "outputs": []}
    return {"cell_type": "code", **empty, "source": _lines(text)}


def _lines(text: str) -> list[str]:
    """A cell's text as the format has it, without an empty line at its end."""
    return text.rstrip("\n").splitlines(keepends=True)

"""What a page shows as a Jupyter notebook (nbformat 4): cells that compute and draw it anew."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from layerjam.workbench.call import Call, Subject, python_parts

SHOWING = "from IPython.display import SVG, display\n"
"""What the lines that show a figure need."""


def notebook(
    title: str, calls: Sequence[Call], pinned: Mapping[str, Call] = MappingProxyType({})
) -> str:
    """The notebook's JSON; it needs layerjam, and Jupyter to be opened.

    Brakes and lines that are in no catalogue are in the notebook, and written beside it where it is
    run; of measured files it says that they belong there.
    """
    texts: dict[str, str] = {}
    calls = [_own(call, texts) for call in calls]
    pinned = {label: _own(call, texts) for label, call in pinned.items()}
    head, *asked = python_parts(calls, pinned, display=True)
    cells = [_words(_about(title, calls)), _code(head + SHOWING)]
    if texts:
        cells.append(_code("from pathlib import Path\n\n" + "".join(_writing(texts))))
    cells += [_code(lines) for lines in asked]
    for number, cell in enumerate(cells, 1):
        cell["id"] = f"cell-{number}"
    spec = {"name": "python3", "display_name": "Python 3", "language": "python"}
    about = {"kernelspec": spec, "language_info": {"name": "python"}}
    whole = {"nbformat": 4, "nbformat_minor": 5, "metadata": about, "cells": cells}
    return json.dumps(whole, indent=1, ensure_ascii=False) + "\n"


def _own(call: Call, texts: dict[str, str]) -> Call:
    """The call, its files named as `texts`, {file name: content}, keeps them, each under its own.

    Two brakes may have one name: the edited one, and the one that was pinned before.
    """

    def kept(subject: Subject) -> Subject:
        if subject.file is None:
            return subject
        stem, name, count = subject.name.removesuffix(".toml"), subject.name, 1
        while texts.setdefault(name, subject.file.text) != subject.file.text:
            count += 1
            name = f"{stem}-{count}.toml"
        return replace(subject, name=name)

    options = {k: kept(v) if isinstance(v, Subject) else v for k, v in call.options.items()}
    return replace(call, subjects=tuple(map(kept, call.subjects)), options=options)


def _writing(texts: Mapping[str, str]) -> Iterator[str]:
    """Lines that write files, so that the notebook needs nothing beside it."""
    for name, text in texts.items():
        lines = "".join(f"    {_literal(line)}\n" for line in text.splitlines(keepends=True))
        yield f'text = (\n{lines})\nPath({_literal(name)}).write_text(text, encoding="utf-8")\n'


def _literal(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


def _about(title: str, calls: Sequence[Call]) -> str:
    """What stands above the cells: what is needed, and the commands behind it."""
    lines = [f"# {title}\n\nMade by layerjam's workbench. Run it where layerjam is installed.\n"]
    needed = dict.fromkeys(file.shown for call in calls for file in call.data)
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

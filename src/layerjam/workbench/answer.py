"""A page's answer: a call with its result, and all files derived from them.

The figure, curves, copied code, notebook and pins of a chart all come from one answer. They
therefore belong to one computation, even if the settings have changed since.
"""

import json
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from layerjam.core.command.results import Result
from layerjam.core.drawing.style import Figure, save
from layerjam.core.errors import LayerjamError, find_error_quantity
from layerjam.core.verdict import list_failures
from layerjam.workbench.call import Call, CallExport, disambiguate, python_blocks, python_code
from layerjam.workbench.state import Pin
from layerjam.workbench.widgets import one_line


@dataclass(frozen=True)
class Answer:
    """A call, its result or the text of its error, and the pinned curves.

    If it contains neither a result nor an error, the call runs when its figure is requested.
    """

    call: Call
    result: Any = None
    refusal: str = ""
    quantity: str | None = None
    """Name of the quantity that the error concerns, or None."""
    pins: "tuple[Pinned, ...]" = ()
    title: str = ""
    """File name without an extension, if the call does not specify one."""
    finish: Callable[[Figure], None] | None = None
    """Function that adds the page's own marks to the figure; it is not part of the Python code."""

    @property
    def name(self) -> str:
        """Name of the exported files, without an extension."""
        return self.title or f"{self.call.subjects[0].name.removesuffix('.toml')}-{self.call.name}"

    @property
    def failures(self) -> Sequence[str]:
        """Sentences about failed checks of the numbers, including those of pinned curves."""
        results = [self.result, *(pin.answer.result for pin in self.pins)]
        return list_failures(*(result for result in results if result is not None))

    @property
    def pinned_answers(self) -> "Mapping[str, Answer]":
        """Return {label: answer} for each pinned answer that has a curve."""
        return {pin.label: pin.answer for pin in self.pins if pin.answer.result.has_curve}

    @property
    def pinned_calls(self) -> Mapping[str, Call]:
        """Return {label: call} for each pinned curve."""
        return {label: answer.call for label, answer in self.pinned_answers.items()}

    def figure(self, ending: str) -> bytes:
        """Return the figure, with the pinned curves, as bytes."""
        pinned_results = {label: answer.result for label, answer in self.pinned_answers.items()}
        return file_bytes(self.result or self.call.run(), ending, pinned_results, self.finish)

    def python_code(self) -> str:
        """Return Python code that computes and draws the figure in a new process."""
        export = self._export_calls
        return python_code(export.calls, export.pinned_calls)

    @property
    def files(self) -> Mapping[str, str]:
        """Return {file name: content} for each brake that is not in the catalogue."""
        return self._export_calls.texts

    @property
    def _export_calls(self) -> CallExport:
        return disambiguate([self.call], self.pinned_calls)

    def notebook(self) -> str:
        """Return a Jupyter notebook that computes and draws the figure."""
        return build_notebook(self.name, [self.call], self.pinned_calls)


@dataclass(frozen=True)
class Pinned:
    """A pinned curve: its label, its answer, and its entry in the state.

    `more` is an additional result that the page computes for the pin, or None.
    """

    label: str
    answer: Answer
    more: Any = None
    pin: Pin | None = None


def try_call(call: Call, **more: Any) -> Answer:
    """Run one of several independent calls; the answer contains its result or its error."""
    try:
        return Answer(call, call.run(**more))
    except LayerjamError as err:
        return Answer(call, refusal=one_line(err), quantity=find_error_quantity(err))


def collect_answers(result: Any) -> list[Answer]:
    """Return every answer in a page's results, in order."""
    if isinstance(result, Answer):
        return [result]
    parts = list(result.values()) if isinstance(result, Mapping) else result
    return [a for p in parts for a in collect_answers(p)] if isinstance(parts, list | tuple) else []


def file_bytes(
    result: Result,
    ending: str,
    pinned_results: Mapping[str, Result] | None = None,
    finish: Callable[[Figure], None] | None = None,
) -> bytes:
    """Return a result's figure or record as bytes, as the command writes it.

    With `pinned_results` or `finish`, which adds marks to the figure, the file is a figure.
    """
    with tempfile.TemporaryDirectory(prefix="layerjam-") as folder:
        path = Path(folder) / f"file.{ending}"
        if not pinned_results and finish is None:
            return result.save(path).read_bytes()
        figure = result.plot(beside=pinned_results)
        if finish is not None:
            finish(figure)
        save(figure, path)
        return path.read_bytes()


SHOWING = "from IPython.display import SVG, display\n"
"""Import statement for code that displays a figure."""


def build_notebook(
    title: str, calls: Sequence[Call], pinned_calls: Mapping[str, Call] = MappingProxyType({})
) -> str:
    """Return the notebook as JSON; running it needs layerjam and Jupyter.

    The notebook contains brakes and lines that are not in the catalogue, and writes them to its
    folder when run. It states which measured files belong in that folder.
    """
    export = disambiguate(calls, pinned_calls)
    head, *blocks = python_blocks(export.calls, export.pinned_calls, display=True)
    files = [
        file.shown for call in (*export.calls, *export.pinned_calls.values()) for file in call.data
    ]
    cells = [_markdown_cell(_introduction(title, export.calls, files)), _code_cell(head + SHOWING)]
    if export.texts:
        cells.append(
            _code_cell("from pathlib import Path\n\n" + "".join(_write_statements(export.texts)))
        )
    return _notebook_json([*cells, *map(_code_cell, blocks)])


def build_figure_notebook(title: str, lines: str) -> str:
    """Return a notebook as JSON; the Python code `lines` creates its `figure`."""
    heading = f"# {title}\n\nCreated by the layerjam workbench; it requires layerjam.\n"
    return _notebook_json([_markdown_cell(heading), _code_cell(f"{lines}figure\n")])


def _notebook_json(cells: list[dict[str, Any]]) -> str:
    for number, cell in enumerate(cells, 1):
        cell["id"] = f"cell-{number}"
    spec = {"name": "python3", "display_name": "Python 3", "language": "python"}
    metadata = {"kernelspec": spec, "language_info": {"name": "python"}}
    document = {"nbformat": 4, "nbformat_minor": 5, "metadata": metadata, "cells": cells}
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"


def _write_statements(texts: Mapping[str, str]) -> Iterator[str]:
    """Yield code that writes each file, so that the notebook needs no others."""
    for name, text in texts.items():
        lines = "".join(f"    {_py_literal(line)}\n" for line in text.splitlines(keepends=True))
        yield f'text = (\n{lines})\nPath({_py_literal(name)}).write_text(text, encoding="utf-8")\n'


def _py_literal(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


def _introduction(title: str, calls: Sequence[Call], files: Sequence[str]) -> str:
    """Return the text above the cells: the required files and the commands."""
    lines = [f"# {title}\n\nCreated by the layerjam workbench; it requires layerjam.\n"]
    names = dict.fromkeys(files)
    if names:
        listing = "".join(f"- `{name}`\n" for name in names)
        lines.append(f"First put these files in the notebook's folder:\n\n{listing}")
    lines += [f"    {line}\n" for call in calls for line in call.command_line().splitlines()]
    return "\n".join(lines)


def _markdown_cell(text: str) -> dict[str, Any]:
    return {"cell_type": "markdown", "metadata": {}, "source": _cell_lines(text)}


def _code_cell(text: str) -> dict[str, Any]:
    empty: dict[str, Any] = {"metadata": {}, "execution_count": None, "outputs": []}
    return {"cell_type": "code", **empty, "source": _cell_lines(text)}


def _cell_lines(text: str) -> list[str]:
    """Return the lines of a cell in the notebook's format, without an empty last line."""
    return text.rstrip("\n").splitlines(keepends=True)

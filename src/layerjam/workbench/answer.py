"""Answer of a page: a call with its result, and all files that are made of it.

Figure, curves, copied lines, notebook and pins of a chart are made of one answer. So they come from
one computation, whatever was set since.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layerjam.commands.results import Result
from layerjam.errors import LayerjamError
from layerjam.report.style import save
from layerjam.workbench.call import Apart, Call, apart, as_python
from layerjam.workbench.notebook import notebook
from layerjam.workbench.state import Pin
from layerjam.workbench.widgets import one_line

if TYPE_CHECKING:
    from layerjam.report.style import Figure


@dataclass(frozen=True)
class Answer:
    """A call, its result or the refusal in words, and the pinned curves beside it.

    Without both the call is computed when its figure is asked for.
    """

    call: Call
    result: Any = None
    refusal: str = ""
    pins: tuple[Pinned, ...] = ()
    title: str = ""
    """Name of the files, without an ending, if the call does not give it."""
    finish: Callable[[Figure], None] | None = None
    """Function that completes the figure on the page; the lines of Python do not have it."""

    @property
    def name(self) -> str:
        """Name of the exported files, without an ending."""
        return self.title or f"{self.call.subjects[0].name.removesuffix('.toml')}-{self.call.name}"

    @property
    def beside(self) -> Mapping[str, Answer]:
        """The pinned answers that have a curve, by their labels."""
        return {one.label: one.answer for one in self.pins if one.answer.result.has_curve}

    @property
    def pinned(self) -> Mapping[str, Call]:
        """The calls behind them."""
        return {label: answer.call for label, answer in self.beside.items()}

    def figure(self, ending: str) -> bytes:
        """The bytes of the figure, with what is pinned."""
        beside = {label: answer.result for label, answer in self.beside.items()}
        return file_bytes(self.result or self.call.run(), ending, beside, self.finish)

    def python(self) -> str:
        """Lines that compute and draw it in a fresh process."""
        own = self._apart
        return as_python(own.calls, own.pinned)

    @property
    def files(self) -> Mapping[str, str]:
        """{name: content} of the brakes that are in no catalogue."""
        return self._apart.texts

    @property
    def _apart(self) -> Apart:
        return apart([self.call], self.pinned)

    def notebook(self) -> str:
        """A Jupyter notebook that computes and draws it."""
        return notebook(self.name, [self.call], self.pinned)


@dataclass(frozen=True)
class Pinned:
    """A pinned curve: its label, its answer, and what the desk keeps of it.

    `more` is what the page computes besides for its pin, None where nothing.
    """

    label: str
    answer: Answer
    more: Any = None
    pin: Pin | None = None


def answered(call: Call, **more: Any) -> Answer:
    """The answer, or the refusal in words: where one of several calls may be refused alone."""
    try:
        return Answer(call, call.run(**more))
    except LayerjamError as err:
        return Answer(call, refusal=one_line(err))


def answers_in(found: Any) -> list[Answer]:
    """Every answer in what a page has computed, in order."""
    if isinstance(found, Answer):
        return [found]
    parts = list(found.values()) if isinstance(found, Mapping) else found
    return [a for p in parts for a in answers_in(p)] if isinstance(parts, list | tuple) else []


def file_bytes(
    result: Result,
    ending: str,
    beside: Mapping[str, Result] | None = None,
    finish: Callable[[Figure], None] | None = None,
) -> bytes:
    """The bytes of a result's figure or record, as the command writes them.

    With other results `beside` it, and what `finish` draws, it is a figure in any case.
    """
    with tempfile.TemporaryDirectory(prefix="layerjam-") as folder:
        path = Path(folder) / f"file.{ending}"
        if not beside and finish is None:
            return result.save(path).read_bytes()
        figure = result.plot(beside=beside)
        if finish is not None:
            finish(figure)
        save(figure, path)
        return path.read_bytes()

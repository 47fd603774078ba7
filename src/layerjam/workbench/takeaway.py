"""What a page gives away of a chart: its figure, its curves, Python and a notebook that draw it.

Figures and records are made by the functions that write the command line's files.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from nicegui import run, ui

from layerjam.commands.results import Result
from layerjam.errors import LayerjamError
from layerjam.records.table_text import comment, rows_text
from layerjam.report.style import save
from layerjam.workbench import copying
from layerjam.workbench.apart import Apart, apart
from layerjam.workbench.call import Call, as_python
from layerjam.workbench.notebook import notebook
from layerjam.workbench.widgets import button, one_line

if TYPE_CHECKING:
    from layerjam.report.style import Figure

ENDINGS = ("svg", "png", "pdf")
NOTEBOOK = "application/x-ipynb+json"
QUIET = 'flat dense no-caps padding="4px 8px"'


class Takeable(Protocol):
    """What the buttons under a chart need of what it shows."""

    @property
    def name(self) -> str:
        """Of the files, without an ending."""

    @property
    def files(self) -> Mapping[str, str]:
        """{name: content} of what the lines need beside them."""

    def figure(self, ending: str) -> bytes:
        """The bytes of the figure."""

    def python(self) -> str:
        """Lines that draw it in a fresh process."""

    def notebook(self) -> str:
        """A Jupyter notebook that draws it."""


@dataclass(frozen=True)
class Taken:
    """What a chart shows: a result, the call behind it, and pinned ones with their labels.

    Without a result the call is computed when its figure is asked for.
    """

    result: Result | None
    name: str
    """Of the files, without an ending."""
    call: Call
    beside: Mapping[str, tuple[Call, Result]] = field(default_factory=dict)
    finish: Callable[[Figure], None] | None = None
    """What the page draws into the figure besides; the lines of Python do not."""

    def figure(self, ending: str) -> bytes:
        """The bytes of the figure, with what is pinned."""
        pinned = {label: result for label, (_, result) in self.beside.items()}
        return file_bytes(self.result or self.call.run(), ending, pinned, self.finish)

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
        return apart([self.call], self._pinned)

    def notebook(self) -> str:
        """A Jupyter notebook that computes and draws it."""
        return notebook(self.name, [self.call], self._pinned)

    @property
    def _pinned(self) -> Mapping[str, Call]:
        return {label: call for label, (call, _) in self.beside.items()}


def row(ident: str, chart: ui.echart, shown: Callable[[], Takeable | None]) -> ui.row:
    """The buttons under a chart; `shown` is what it shows now, None while it shows nothing."""

    async def give(ending: str) -> None:
        taken = shown()
        if taken is None:
            ui.notify("nothing is computed yet")
            return
        try:
            content = await run.io_bound(taken.figure, ending)
        except LayerjamError as err:
            ui.notify(one_line(err), type="warning")
            return
        if content is not None:  # None: the program is being ended
            ui.download.content(content, f"{taken.name}.{ending}")

    def curves() -> None:
        taken = shown()
        text = "" if taken is None else curves_csv(chart.options)
        if taken is None or not text:
            ui.notify("nothing is computed yet")
        else:
            ui.download.content(text.encode(), f"{taken.name}-curves.csv", "text/csv")

    async def python() -> None:
        taken = shown()
        if taken is None:
            ui.notify("nothing is computed yet")
        else:
            await copying.offer(taken.python(), "python", taken.files)

    def cells() -> None:
        taken = shown()
        if taken is None:
            ui.notify("nothing is computed yet")
        else:
            ui.download.content(taken.notebook().encode(), f"{taken.name}.ipynb", NOTEBOOK)

    with ui.row().classes("items-center gap-1") as made:
        ui.label("Take away").classes("text-sm")
        for ending in ENDINGS:
            tip = f"The figure as {ending.upper()}"
            act = partial(give, ending)
            button(ending.upper(), act, f"{ident}-figure-{ending}", how=QUIET, tip=tip)
        tip = "Every curve of the chart as it is drawn"
        button("curves as CSV", curves, f"{ident}-curves", how=QUIET, tip=tip)
        tip = "Lines that compute and draw it"
        button("Python", python, f"{ident}-python", how=QUIET, tip=tip)
        tip = "A Jupyter notebook that computes and draws it"
        button("notebook", cells, f"{ident}-notebook", how=QUIET, tip=tip)
    return made


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


def curves_csv(options: Mapping[str, Any]) -> str:
    """CSV of a chart's curves one below the other: panel, curve, x and y as the axes say.

    A name that a spreadsheet would take as a formula has an apostrophe before it.
    """
    rows = list(_points(options))
    if not rows:
        return ""
    head = comment("layerjam: what a chart draws, thinned to some 500 points a curve")
    return f"{head}\n" + rows_text([("y axis", "curve", "x axis", "x", "y"), *rows])


def _points(options: Mapping[str, Any]) -> Iterator[tuple[str, str, str, Any, Any]]:
    axes = [_listed(options.get(side)) for side in ("xAxis", "yAxis")]
    below = axes[0][-1].get("name", "") if axes[0] else ""
    for number, series in enumerate(options.get("series", ()), 1):
        place = series.get("yAxisIndex", 0)
        y_name = axes[1][place].get("name", "")
        name = series.get("name") or f"curve {number}"
        if "areaStyle" in series:  # its edges are curves of their own
            continue
        for point in series.get("data", ()):
            pair = point.get("value", ()) if isinstance(point, Mapping) else point
            if len(pair) >= 2 and None not in pair[:2]:
                yield y_name, name, below, pair[0], pair[1]


def _listed(axis: Any) -> Sequence[Mapping[str, Any]]:
    """The axes of a chart, of which one stands alone."""
    return [] if axis is None else axis if isinstance(axis, list) else [axis]

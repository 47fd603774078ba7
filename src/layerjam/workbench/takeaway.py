"""Buttons below a chart that export its figure, its curves, Python code or a notebook."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from operator import methodcaller
from typing import Any, Protocol

from nicegui import run, ui

from layerjam.core.errors import LayerjamError
from layerjam.core.toml_files.table_text import comment, format_rows
from layerjam.workbench import copying
from layerjam.workbench.widgets import button, one_line

NOTHING = "nothing has been computed yet"
ENDINGS = ("svg", "png", "pdf")
NOTEBOOK = "application/x-ipynb+json"
QUIET = 'flat dense no-caps padding="4px 8px"'


class Exportable(Protocol):
    """Content of a chart that the buttons below it can export."""

    @property
    def name(self) -> str:
        """Name of the exported files, without an extension."""

    @property
    def files(self) -> Mapping[str, str]:
        """{name: content} of the files that the code needs."""

    @property
    def failures(self) -> Sequence[str]:
        """Sentences about failed checks of the numbers."""

    def figure(self, ending: str) -> bytes:
        """Return the figure as bytes."""

    def python_code(self) -> str:
        """Return Python code that draws the chart in a new process."""

    def notebook(self) -> str:
        """Return a Jupyter notebook that draws the chart."""


async def save_result(make: Callable[[], str | bytes], name: str, kind: str = "") -> None:
    """Download the result of `make`, which runs in a separate thread.

    An error or an empty result is reported instead.
    """
    try:
        content = await run.io_bound(make)
    except LayerjamError as err:
        ui.notify(one_line(err), type="warning")
        return
    if content:
        ui.download.content(content, name, kind)
    elif content is not None:  # None means that the program is stopping
        ui.notify(NOTHING)


def add_exports(ident: str, chart: ui.echart, source: Callable[[], Exportable | None]) -> ui.row:
    """Add the buttons below a chart; `source` returns the displayed answer, or None."""

    async def export(
        ending: str, make: Callable[[Exportable], str | bytes], kind: str = ""
    ) -> None:
        item = source()
        if item is None:
            ui.notify(NOTHING)
        else:
            await save_result(partial(make, item), f"{item.name}{ending}", kind)

    async def show_python() -> None:
        item = source()
        if item is None:
            ui.notify(NOTHING)
        else:
            await copying.show_copy(item.python_code(), "python", item.files)

    with ui.row().classes("items-center gap-1") as buttons:
        ui.label("Export").classes("text-sm")
        for ending in ENDINGS:
            tip = f"Figure as {ending.upper()}"
            act = partial(export, f".{ending}", methodcaller("figure", ending))
            button(ending.upper(), act, f"{ident}-figure-{ending}", look=QUIET, tip=tip)
        tip = "All curves of the chart, as drawn"
        make = lambda item: curves_csv(chart.options, item.failures)  # noqa: E731
        curves = partial(export, "-curves.csv", make, "text/csv")
        button("curves as CSV", curves, f"{ident}-curves", look=QUIET, tip=tip)
        tip = "Python code that computes and draws the chart"
        button("Python", show_python, f"{ident}-python", look=QUIET, tip=tip)
        tip = "Jupyter notebook that computes and draws the chart"
        cells = partial(export, ".ipynb", methodcaller("notebook"), NOTEBOOK)
        button("notebook", cells, f"{ident}-notebook", look=QUIET, tip=tip)
    return buttons


def curves_csv(options: Mapping[str, Any], failures: Sequence[str] = ()) -> str:
    """Return a CSV of a chart's curves: panel, curve, x and y in the units of the axes.

    Comments at the top state the `failures`. A name that a spreadsheet would interpret as a formula
    gets a leading apostrophe.
    """
    rows = list(_chart_points(options))
    if not rows:
        return ""
    title = "layerjam: curves of a chart, thinned to about 500 points each"
    head = "".join(f"{comment(text)}\n" for text in (title, *failures))
    return head + format_rows([("y axis", "curve", "x axis", "x", "y"), *rows])


def _chart_points(options: Mapping[str, Any]) -> Iterator[tuple[str, str, str, Any, Any]]:
    x_name = options["xAxis"][-1]["name"] if options else ""
    for number, series in enumerate(options.get("series", ()), 1):
        y_name = options["yAxis"][series.get("yAxisIndex", 0)]["name"]
        name = series.get("name") or f"curve {number}"
        if "areaStyle" in series:  # the edges of a band are separate curves
            continue
        for point in series.get("data", ()):
            pair = point.get("value", ()) if isinstance(point, Mapping) else point
            if len(pair) >= 2 and None not in pair[:2]:
                yield y_name, name, x_name, pair[0], pair[1]

"""Drawing functions: one style, panels with units, and labels that avoid the curves.

A figure is a function under `@use_style`: it makes a canvas, draws curves, bands, points and lines,
and finishes every axes with `label_axes`, which names them. The functions place labels next to
their curves, in the same colour, without coordinates for a particular brake.
"""

import functools
import io
import textwrap
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any, ParamSpec

import numpy as np

import layerjam.core.outputs as outputs
from layerjam.core.errors import FileError, LayerjamError, MissingExtraError
from layerjam.core.store import accept_force_option, store_file
from layerjam.core.system import check_source_date

P = ParamSpec("P")
Axes = outputs.Axes
Figure = outputs.Figure
# Okabe and Ito's palette, ordered so that neighbours also differ in lightness
BLUE, ORANGE, GREEN, RED = "#0072B2", "#E69F00", "#009E73", "#D55E00"
PURPLE, SKY = "#CC79A7", "#56B4E9"
INK, GREY, FAINT, SHADE = "#1c2530", "#66717d", "#C9D0D6", "#f1f4f6"
CYCLE = (BLUE, RED, GREEN, PURPLE, ORANGE, SKY)
VACUUMS = ("#08306b", "#2171b5", "#4f9bcb", "#8c96a0")
"""Colours from dark to pale for decreasing vacuum."""
DASHED, LONG, DOTTED = (0, (4, 2)), (0, (5, 3)), (0, (1, 2))
MM, MS, KPA, KN = 1e3, 1e3, 1e-3, 1e-3
"""Factors from SI to the units of the axes."""
WORDS = 8.8
"""Font size in a figure [pt]."""
_READABLE = {ORANGE: "#8a5f00", PURPLE: "#8e4a79", SKY: "#2a7fb0", FAINT: GREY}
"""{colour too pale for text: darker shade}."""
_GROUND = {"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 0.8}

_RC: dict[Any, Any] = {
    "font.size": 9.5,
    "font.family": "sans-serif",
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelcolor": INK,
    "axes.edgecolor": GREY,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e7ebee",
    "grid.linewidth": 0.7,
    "axes.axisbelow": True,
    "text.color": INK,
    "xtick.color": GREY,
    "ytick.color": GREY,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "lines.linewidth": 1.8,
    "lines.solid_capstyle": "round",
    "legend.frameon": True,
    "legend.framealpha": 0.8,
    "legend.edgecolor": "none",
    "legend.fancybox": False,
    "legend.fontsize": WORDS,
    "legend.handlelength": 1.5,
    "legend.labelspacing": 0.3,
    "legend.borderaxespad": 0.3,
    "figure.dpi": 110,
    "savefig.dpi": 160,
    "svg.hashsalt": "layerjam",
    "pdf.fonttype": 42,
}


@contextmanager
def apply_style(words: bool = False) -> Iterator[None]:
    """Set the style of the figures drawn inside; MissingExtraError if matplotlib is not installed.

    With `words` an SVG keeps its labels as text; otherwise they are drawn as curves.
    """
    with MissingExtraError.raise_if_missing("drawing (matplotlib)", "figures"):
        import matplotlib
    with matplotlib.rc_context({**_RC, "svg.fonttype": "none" if words else "path"}):
        yield


def use_style(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Return a function that applies this style while it draws its figure."""

    @functools.wraps(draw)
    def draw_styled(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with apply_style():
            return draw(*args, **kwargs)

    return draw_styled


def make_axes(
    columns: int = 1, rows: int = 1, width: float = 6.4, height: float = 3.9, **grid: Any
) -> tuple[Figure, list[Axes]]:
    """Return a figure and a flat list of its axes, without global state, so that threads may draw.

    Inside `draw_into` the axes are those given there.
    """
    from matplotlib.figure import Figure

    if (given_axes := _own_axes.get()) is not None:
        if len(given_axes) != rows * columns:
            raise LayerjamError(
                f"ax: {len(given_axes)} given, but this figure needs {rows * columns} axes, "
                f"such as plt.subplots({rows}, {columns})[1]"
            )
        return given_axes[0].figure.get_figure(root=True), given_axes  # type: ignore[return-value]
    figure = Figure(figsize=(width, height), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **grid)
    return figure, list(axes.ravel())


_own_axes: ContextVar[list[Axes] | None] = ContextVar("own_axes", default=None)


@contextmanager
def draw_into(axes: Any) -> Iterator[None]:
    """Draw the figures of a with block into the user's axes: one, a list or an array."""
    flat = [*(axes.flat if hasattr(axes, "flat") else [axes])]
    if isinstance(axes, list | tuple):
        flat = [*axes]
    if not all(hasattr(item, "figure") for item in flat):
        kind = type(axes).__name__
        raise LayerjamError(
            f"ax: {kind} is not a Matplotlib Axes object, such as plt.subplots()[1]"
        )
    token = _own_axes.set(flat)
    try:
        yield
    finally:
        _own_axes.reset(token)


def label_axes(axes: Axes, headline: str = "", detail: str = "", **axis: Any) -> None:
    """Set names, units and limits of the axes, and add a title; `axis` is as in Axes.set."""
    axes.set(**axis)
    if headline or detail:
        add_title(axes, headline, detail)


def add_title(axes: Axes, headline: str, detail: str = "") -> None:
    """Write a headline, and a smaller line below it."""
    axes.set_title(headline, pad=20 if detail else 8)
    if detail:
        axes.text(0, 1.015, detail, transform=axes.transAxes, fontsize=8.5, color=GREY, va="bottom")


def mark_figure(figure: Figure, synthetic: bool) -> Figure:
    """Return the figure, marked in its corner if it shows data generated by a program."""
    if synthetic:
        figure.text(0.995, 0.995, "synthetic data", ha="right", va="top", fontsize=8.5, color=GREY)
    return figure


def add_failures(figure: Figure, failures: Sequence[str]) -> Figure:
    """Return the figure with the sentences of failed checks at its foot, below any other text."""
    lines = [
        line for text in failures for line in textwrap.wrap(text, int(16 * figure.get_figwidth()))
    ]
    if lines:
        before = figure.get_supxlabel()
        words, color = "\n".join([before, *lines] if before else lines), INK if before else RED
        figure.supxlabel(words, x=0.01, ha="left", fontsize=8.5, color=color)
    return figure


def show_in_notebooks(figure: Figure) -> Figure:
    """Return the figure with its picture for notebooks, which need no `%matplotlib inline` then."""
    figure._repr_svg_ = functools.partial(format_svg, figure)  # type: ignore[attr-defined]
    return figure


def text_ink(color: str) -> str:
    """Return the colour for text about a curve of this colour."""
    return _READABLE.get(color.upper(), color)


def add_label(axes: Axes, x: float, y: float, text: str, color: str = INK, **props: Any) -> None:
    """Write a label at a point, in a curve's colour, on a pale background."""
    props = {"fontsize": WORDS, "color": text_ink(color), "va": "center", "bbox": _GROUND, **props}
    axes.text(x, y, text, **props)


def add_end_labels(axes: Axes, x: float, items: Sequence[tuple[float, str, str]]) -> None:
    """Write (y, text, colour) labels at the right end of curves, separated if they would touch."""
    low, high = axes.get_ylim()
    spec, figure = axes.get_subplotspec(), axes.get_figure(root=True)
    if figure is None or not items:
        return
    place = axes.get_position() if spec is None else spec.get_position(figure)
    points = place.height * figure.get_figheight() * 72
    gap = (high - low) * 1.25 * WORDS / points
    labels = sorted(item for item in items if np.isfinite(item[0]))
    heights: list[float] = []
    for y, _, _ in labels:
        heights.append(max(y, heights[-1] + gap, low) if heights else max(y, low))
    excess = max(heights[-1] - high, 0.0) if heights else 0.0
    for (_, text, color), y in zip(labels, heights, strict=True):
        ground = _GROUND if x < axes.get_xlim()[1] else None
        props = {"va": "center", "annotation_clip": False, "bbox": ground}
        _annotate(axes, text, x, y - excess, color, (4, 0), **props)
    axes.set_ylim(low, high)


def add_key(axes: Axes | Figure, *items: tuple[Any, ...], loc: str = "best", **props: Any) -> None:
    """Write a legend in the curves' colours in a free corner; by default, of all labelled curves.

    An item is (text, colour), or (text, colour, style) of a curve that is not solid; the style "o"
    means points.
    """
    from matplotlib.colors import to_hex
    from matplotlib.lines import Line2D

    bare = props.get("handlelength") == 0  # the key shows text without symbols

    def make_handle(text: str, color: str, dash: Any = "-") -> Line2D:
        style = "none" if bare or dash == "o" else dash
        marker = "o" if dash == "o" else ""
        return Line2D([], [], color=color, label=text, ls=style, marker=marker, ms=4)

    if items:
        props["handles"] = [make_handle(*item) for item in items]
    legend = axes.legend(
        **{"loc": loc, "labelcolor": "linecolor", "handletextpad": 0.8 * (not bare), **props}
    )
    for text in legend.get_texts():
        text.set_color(text_ink(to_hex(text.get_color())))


def add_point(
    axes: Axes, x: float, y: float, text: str = "", color: str = RED, shape: str = "o", **props: Any
) -> None:
    """Draw a point, with its label on the side where there is space."""
    axes.plot(x, y, shape, **{"color": color, "ms": 5.5, "zorder": 4, **props})
    if text:
        x_share, up = axes.transAxes.inverted().transform(axes.transData.transform((x, y)))
        side = -7 if x_share > 0.6 else 7
        height = -7 if up > 0.9 else 7
        ha, va = ("right" if side < 0 else "left"), ("top" if height < 0 else "bottom")
        _annotate(axes, text, x, y, color, (side, height), ha=ha, va=va, bbox=_GROUND, zorder=5)


def mark_y(
    axes: Axes, y: float, text: str = "", color: str = RED, share: float = 0.02, below: bool = False
) -> None:
    """Draw a horizontal line at a height, with its name at a fraction of the width."""
    axes.axhline(y, color=color, lw=1.1, ls=LONG)
    if text:
        va, shift = ("top", -4) if below else ("bottom", 4)
        place = {"xycoords": axes.get_yaxis_transform(), "ha": "right" if share > 0.5 else "left"}
        _annotate(axes, text, share, y, color, (0, shift), va=va, **place)


def mark_x(axes: Axes, x: float, text: str = "", color: str = GREY, share: float = 0.97) -> None:
    """Draw a vertical line at x, with its name next to it at a fraction of the height."""
    axes.axvline(x, color=color, lw=1.0, ls=DASHED)
    if text:
        corner = axes.transData.transform((x, axes.get_ylim()[0]))
        side = -4 if axes.transAxes.inverted().transform(corner)[0] > 0.5 else 4
        place = {"xycoords": axes.get_xaxis_transform(), "ha": "right" if side < 0 else "left"}
        va = "top" if share > 0.5 else "bottom"
        _annotate(axes, text, x, share, color, (side, 0), va=va, bbox=_GROUND, **place)


def _annotate(
    axes: Axes, text: str, x: float, y: float, color: str, shift: tuple[float, float], **props: Any
) -> None:
    props = {"fontsize": WORDS, "color": text_ink(color), "textcoords": "offset points", **props}
    axes.annotate(text, (x, y), shift, **props)


def add_callout(
    axes: Axes,
    text: str,
    point: tuple[float, float],
    place: tuple[float, float],
    color: str,
    **props: Any,
) -> None:
    """Write a label at a position in data coordinates, with a thin line to its point."""
    line = {"arrowstyle": "-", "color": color, "lw": 0.5, "shrinkA": 1, "shrinkB": 4}
    line |= props.pop("line", {})
    props = {"fontsize": WORDS, "va": "center", "zorder": 5, "bbox": _GROUND, **props}
    axes.annotate(text, point, place, color=text_ink(color), arrowprops=line, **props)


def add_leader(
    axes: Axes,
    text: str,
    point: tuple[float, float],
    place: tuple[float, float],
    va: str,
    **options: Any,
) -> None:
    """Write a text centred at `place`, with a line to a point of the drawing."""
    line = {"arrowstyle": "-", "color": INK, "lw": 0.6, "shrinkB": 0}
    options |= {"ha": "center", "va": va, "fontsize": WORDS, "arrowprops": line}
    axes.annotate(text, point, place, **options)


def add_band(axes: Axes, x: Any, low: Any, high: Any, color: str, alpha: float = 0.2) -> None:
    """Draw a pale band between two curves."""
    axes.fill_between(x, low, high, color=color, alpha=alpha, lw=0)


def hide_axes(axes: Axes) -> None:
    """Hide the frame and the axes of a drawing to scale or of a picture."""
    axes.set_axis_off()
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_visible(False)


def set_log_scale(axes: Axes, names: str = "x") -> None:
    """Set a logarithmic scale with plain numbers."""
    for name in names:
        axis = axes.xaxis if name == "x" else axes.yaxis
        axes.set(**{f"{name}scale": "log"})
        axis.set_major_formatter("{x:g}")


def thin_out(x: Any, y: Any, bins: int = 400) -> tuple[Any, Any]:
    """Reduce a long record to at most 2 * `bins` samples: the extremes of y in each bin."""
    if len(y) <= 2 * bins:
        return x, y
    indices = []
    for part in np.array_split(np.arange(len(y)), bins):
        indices += sorted({int(part[np.argmin(y[part])]), int(part[np.argmax(y[part])])})
    return x[indices], y[indices]


def choose_colours(names: Sequence[str]) -> dict[str, str]:
    """Return a colour for each name, in order: for more than four, a ramp from dark to pale."""
    if len(names) <= 4:
        return dict(zip(names, (BLUE, RED, GREEN, PURPLE), strict=False))
    ramp = np.array([[int(c[i : i + 2], 16) for i in (1, 3, 5)] for c in VACUUMS], float)
    positions = np.linspace(0, len(VACUUMS) - 1, len(names))
    colors = np.stack(
        [np.interp(positions, range(len(VACUUMS)), channel) for channel in ramp.T], axis=1
    )
    shades = (f"#{red:02x}{green:02x}{blue:02x}" for red, green, blue in colors.round().astype(int))
    return dict(zip(names, shades, strict=True))


@accept_force_option
def save(figure: Figure, path: Path, overwrite: bool = False) -> Path:
    """Write .svg, .png or .pdf, completely or not at all; equal figures produce equal bytes."""
    kind = path.suffix.lower().lstrip(".")
    if kind not in ("svg", "png", "pdf"):
        raise FileError(path, (f"extension '{path.suffix}' is unknown; use .svg, .png or .pdf"))
    meta = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind)
    check_source_date()
    with apply_style():
        return store_file(path, lambda p: figure.savefig(p, format=kind, metadata=meta), overwrite)


def format_svg(figure: Figure, words: bool = False) -> str:
    """Return the figure as an SVG file's text; the same figure produces the same bytes.

    With `words`, its labels stay text, for a page with its own typeface. The figure is drawn only
    once, whereas `savefig` draws a figure with a layout twice.
    """
    check_source_date()
    buffer = io.StringIO()
    with apply_style(words):
        from matplotlib import rcParams
        from matplotlib.backends.backend_svg import FigureCanvasSVG

        figure.set_dpi(rcParams["savefig.dpi"])
        canvas: Any = FigureCanvasSVG(figure)
        canvas.print_svg(buffer, metadata={"Date": None})
    return buffer.getvalue()

"""One look for every figure: quiet axes, colours a colour-blind reader can tell apart."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layerjam.device.load import write_whole
from layerjam.errors import MissingExtraError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito's palette, ordered so that neighbours differ in lightness too
BLUE, ORANGE, GREEN, RED, PURPLE, SKY = (
    "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9",
)  # fmt: skip
INK, GREY, FAINT = "#1c2530", "#66717d", "#c9d0d6"
VACUUMS = ("#08306b", "#2171b5", "#4f9bcb", "#8c96a0")
"""Dark to pale for falling vacuum."""

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
    "legend.frameon": False,
    "figure.dpi": 110,
    "savefig.dpi": 160,
    "svg.hashsalt": "layerjam",
    "svg.fonttype": "path",
    "pdf.fonttype": 42,
}


@contextmanager
def look() -> Iterator[None]:
    """The style, for the figures made inside; raises MissingExtraError without matplotlib."""
    try:
        import matplotlib
    except ImportError:
        raise MissingExtraError("drawing (matplotlib)", "figures") from None
    with matplotlib.rc_context(_RC):
        yield


def canvas(
    columns: int = 1, rows: int = 1, width: float = 6.4, height: float = 3.9, **grid: Any
) -> tuple[Figure, list[Axes]]:
    """A figure and its axes as a flat list; no global state, so that threads may draw."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **grid)
    return figure, list(axes.ravel())


def title(axes: Axes, what: str, detail: str = "") -> None:
    """A headline that says what is seen, and a quiet line under it."""
    axes.set_title(what, pad=20 if detail else 8)
    if detail:
        axes.text(
            0, 1.0, detail, transform=axes.transAxes, fontsize=8.5, color=GREY, va="bottom"
        ).set_position((0, 1.015))


def label(axes: Axes, x: float, y: float, text: str, color: str, **how: Any) -> None:
    """A word beside a curve, in its colour, on a pale ground."""
    how = {"fontsize": 8.8, "color": color, "va": "center", **how}
    axes.text(
        x,
        y,
        text,
        bbox={"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 0.8},
        **how,
    )


def labels_right(axes: Axes, x: float, items: Sequence[tuple[float, str, str]]) -> None:
    """(y, text, colour) labels at the right end of curves, moved apart where they would touch."""
    low, high = axes.get_ylim()
    gap = (high - low) * 0.058
    places: list[float] = []
    for y, _, _ in sorted(items):
        places.append(max(y, places[-1] + gap) if places else y)
    for (_, text, color), y in zip(sorted(items), places, strict=True):
        axes.annotate(
            text, (x, y), xytext=(4, 0), textcoords="offset points", va="center", fontsize=8.8,
            color=color, annotation_clip=False,
        )  # fmt: skip


def save(figure: Figure, path: Path, force: bool = False) -> Path:
    """Write .svg, .png or .pdf, whole or not at all; the same figure gives the same bytes."""
    kind = path.suffix.lower().lstrip(".")
    when = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind)
    with look():
        return write_whole(path, lambda p: figure.savefig(p, format=kind, metadata=when), force)

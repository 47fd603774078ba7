"""A figure is drawn once, and its text is the one that Matplotlib writes."""

import io

from layerjam.core.drawing import style


@style.use_style
def figure(slope: float) -> style.Figure:
    made, (axes,) = style.make_axes()
    axes.plot([0, 1], [0, slope])
    style.label_axes(axes, "A line", "and its slope", xlabel="x [m]", ylabel="y [N]")
    return made


def by_matplotlib(made: style.Figure) -> str:
    """As `savefig` writes it, which lays out first and draws then."""
    buffer = io.StringIO()
    with style.apply_style():
        made.savefig(buffer, format="svg", metadata={"Date": None})
    return buffer.getvalue()


def test_the_same_text_as_matplotlib() -> None:
    texts = [style.format_svg(figure(slope)) for slope in (1.0, -2.0)]
    assert texts == [by_matplotlib(figure(slope)) for slope in (1.0, -2.0)]
    assert texts[0] != texts[1]

"""Figures of a validation."""

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.core.drawing import style
from layerjam.core.drawing.style import BLUE, FAINT, INK, MM, SKY
from layerjam.core.errors import count_text
from layerjam.core.units import show
from layerjam.laboratory.identify.validation.metrics import Validation


@style.use_style
def draw_validation(file: BrakeFile, result: Validation, synthetic: bool) -> style.Figure:
    """Draw measured and predicted curves over the comparison window, and their differences."""
    figure, (axes, residuals) = style.make_axes(
        rows=2, width=6.8, height=5.2, sharex=True, height_ratios=(2, 1)
    )
    ends = {}
    for curve in result.curves:
        x = curve.elongation * MM
        axes.plot(x, curve.measured, color=SKY, lw=3.2)
        axes.plot(x, curve.model, color=INK, lw=1.2, ls=style.DASHED)
        residuals.plot(x, curve.model - curve.measured, color=BLUE, lw=0.9)
        ends[show(curve.vacuum, "Pa")] = float(curve.model[-1])
    residuals.axhline(0, color=FAINT, lw=1)
    words = f"MAPE {result.mape:.2%}, RMSE {show(result.rmse, 'N', 3)}"
    words += f" over {count_text(len(result.curves), 'file')}" + ", synthetic data" * synthetic
    headline = f"{file.name}: files (light blue) and model (dashed)"
    style.label_axes(axes, headline, words, ylabel="force [N]", ylim=(0, None), xlim=(0, None))
    style.add_end_labels(axes, axes.get_xlim()[1], [(y, text, INK) for text, y in ends.items()])
    style.label_axes(residuals, xlabel="elongation [mm]", ylabel="model − file [N]")
    return figure

"""`pull` on the command line."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from layerjam.cli import options as opt
from layerjam.units import show

if TYPE_CHECKING:
    from layerjam.commands.answer import Answer


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command("pull")(pull)


def pull(
    files: opt.Files,
    tare: Annotated[
        bool, typer.Option("--tare", help="Subtract the force before the load rises.")
    ] = False,
    negative: opt.Negative = None,
    column: opt.Column = None,
    decimal: opt.Decimal = None,
    columns: opt.Columns = None,
    specimen: opt.Specimen = None,
    sheet: opt.Sheet = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """What measured pulls show: slack, preload, onset, stiffness, peak, stick-slip, way back."""
    opt.check_figure(figure, force)
    from layerjam.cli.old_output import say
    from layerjam.cli.ticker import Ticker
    from layerjam.commands import pull as verb

    with Ticker() as ticker:
        answer = verb.pull(
            files, tare=tare, progress=ticker,
            choices=opt.choices(negative, column, decimal, columns, specimen, sheet),
        )  # fmt: skip
    if figure:
        from layerjam.report import pull_figures

        pull_figures.save(pull_figures.pulls(answer.record), figure, force)
    hidden = ("pulls", "tare", "understood", "refused")
    return say(answer, as_json, hidden=hidden, lines=_lines(answer))


def _lines(answer: Answer) -> list[str]:
    """A paragraph a pull."""
    from layerjam.commands.pull import UNITS_OF_A_PULL

    def text(row: dict[str, Any], key: str) -> str:
        unit, error = UNITS_OF_A_PULL[key], row.get(f"{key}_se")
        value = show(row[key], unit)
        return value if error is None else f"{value} ± {show(error, unit, 2)}"

    out: list[str | None] = []
    for row in answer.pulls:
        out += [
            "" if out else None,
            Path(row["file"]).name,
            f"  slack {text(row, 'slack')}, preload {text(row, 'preload')}, onset at "
            f"{text(row, 'onset')}",
            f"  stiffness {text(row, 'stiffness')}, peak {text(row, 'peak_force')} at "
            f"{text(row, 'peak_elongation')}",
        ]
        if row["steady_slope"] is not None:
            out.append(
                f"  after it {text(row, 'steady_slope')}, {text(row, 'steady_force')} between "
                f"{text(row, 'steady_from')} and {text(row, 'steady_to')}"
            )
        if row["stick_slip"]:
            out.append(
                f"  stick-slip ± {text(row, 'stick_slip_amplitude')}, {row['teeth']} teeth, every "
                f"{text(row, 'stick_slip_spacing')}, {text(row, 'stick_slip_period')}"
            )
        if row["unloading_stiffness"] is not None:
            out.append(
                f"  unloading {text(row, 'unloading_stiffness')}, left over "
                f"{text(row, 'residual_elongation')} and {text(row, 'residual_force')}; kept "
                f"{text(row, 'loop_energy')} of {text(row, 'work')}"
            )
    return [line for line in out if line is not None]

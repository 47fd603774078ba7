"""`sleeve`, `leak`, `pump-down` and `crash` on the command line."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from layerjam.cli import options as opt

LogFile = Annotated[
    Path, typer.Argument(metavar="FILE", help="Log: a column of time, one measured.")
]
Columns = Annotated[
    str | None,
    typer.Option(
        metavar="ROLE:UNIT,skip,...",
        help="What the columns are, in order, or ROLE:UNIT=NAME,... by name.",
    ),
]
Reading = Annotated[
    str | None,
    typer.Option(metavar="absolute|gauge|vacuum", help="What the pressure counts from."),
]
Zero = Annotated[
    str | None, typer.Option(metavar="Q", help="Reading of the sensor at the atmosphere; 0.")
]
Start = Annotated[
    str | None, typer.Option("--from", metavar="Q", help="Time where the part used starts.")
]
End = Annotated[str | None, typer.Option("--to", metavar="Q", help="Time where it ends.")]


def register(app: typer.Typer) -> None:
    """Add the commands of this file."""
    app.command("sleeve")(sleeve)
    app.command("leak")(leak)
    app.command("pump-down")(pump_down)
    app.command("crash")(crash)


def sleeve(
    files: opt.Files,
    area: Annotated[
        str | None, typer.Option(metavar="Q", help="Cross-section, for files of force: 18mm^2.")
    ] = None,
    gauge_length: Annotated[
        str | None, typer.Option(metavar="Q", help="Length, for files of elongation: 33mm.")
    ] = None,
    start: Annotated[
        str, typer.Option("--from", metavar="STRAIN", help="Strain where the initial slope starts.")
    ] = "5%",
    end: Annotated[
        str, typer.Option("--to", metavar="STRAIN", help="Strain where the initial slope ends.")
    ] = "20%",
    fit_to: Annotated[
        str | None, typer.Option(metavar="STRAIN", help="Largest strain fitted, 200%; else all.")
    ] = None,
    material: Annotated[
        str | None, typer.Option(metavar="NAME", help="Silicone of the catalogue to compare with.")
    ] = None,
    brake: Annotated[
        str | None, typer.Option(metavar="BRAKE", help="Brake to write the modulus into.")
    ] = None,
    out: opt.OutBrake = None,
    partial: opt.Partial = False,
    columns: Columns = None,
    decimal: opt.Decimal = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Modulus and hyperelastic fit of the sleeve's silicone from ASTM D412 curves."""
    opt.check_figure(figure, force)
    opt.check_target(out, force, (".toml",))
    opt.engine()
    from layerjam.cli.old_output import say
    from layerjam.commands import sleeve as verb

    answer = verb.sleeve(
        files, area=area, gauge_length=gauge_length, window=(start, end), fit_to=fit_to,
        material=material, columns=columns, decimal=decimal, brake=brake, out=out,
        partial=partial, force=force,
    )  # fmt: skip
    if figure:
        from layerjam.report import measurement_figures as figures

        sheets = {path: row["data_sheet"] for path, row in answer.values["files"].items()}
        figures.save(figures.sleeve(answer.record, sheets), figure, force)
    many = answer.values["specimens"] is None
    hidden = opt.hidden_keys(
        answer.values["file"], "files", "understood", "refused", "models", "window",
        *(answer.values if many else ()),
    )  # fmt: skip
    return say(
        answer, as_json, hidden=hidden, lines=["", *_specimens(answer.values["files"])],
        shown=_shown(answer.values),
    )  # fmt: skip


def _shown(values: Mapping[str, Any]) -> dict[str, str]:
    """Parameters and ranges as people read them."""
    if values["model"] is None:
        return {}
    low, high = values["strain_range"]
    out = {
        "parameters": _parameters(values["parameters"]),
        "strain_range": f"{low:.1%} to {high:.0%}",
    }
    for key in ("difference", "error_at_100", "strain_at_end"):
        if values[key] is not None:
            out[key] = f"{values[key]:+.1%}" if key != "strain_at_end" else f"{values[key]:.0%}"
    return out


def _parameters(values: Mapping[str, float]) -> str:
    from layerjam.units import show

    return ", ".join(
        f"{k} {show(v, '1' if k.startswith('alpha') else 'Pa')}" for k, v in values.items()
    )


def _specimens(files: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """One line a file: its 100 % modulus beside the data sheet's, and its model."""
    from layerjam.units import show

    out = []
    for path, row in files.items():
        text = f"{Path(path).name}: 100 % modulus {show(row['modulus_100'], 'Pa')}"
        if row["difference"] is not None:
            text += (
                f", data sheet of {row['material']} {show(row['data_sheet'], 'Pa')} "
                f"({row['difference']:+.0%})"
            )
        elif row["data_sheet"] is None:
            text += ", material not known (--material compares it with a data sheet)"
        out.append(f"{text}; {row['model']}")
    return out


def leak(
    file: LogFile,
    volume: Annotated[
        str | None, typer.Option(metavar="Q", help="Volume of the chamber and its line, 120mL.")
    ] = None,
    reading: Reading = None,
    temperature: Annotated[
        str | None, typer.Option(metavar="Q", help="Temperature of the gas, 23°C; else 20 °C.")
    ] = None,
    zero: Zero = None,
    start: Start = None,
    end: End = None,
    atmosphere: opt.Atmosphere = None,
    columns: Columns = None,
    decimal: opt.Decimal = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Leak of a closed chamber from a pressure-hold log."""
    opt.check_figure(figure, force)
    opt.engine()
    from layerjam.cli.old_output import say
    from layerjam.commands import pressure_log as verb

    answer = verb.leak(
        file, volume=volume, reading=reading, temperature=temperature, atmosphere=atmosphere,
        zero=zero, start=start, end=end, columns=columns, decimal=decimal,
    )  # fmt: skip
    if figure:
        from layerjam.report import measurement_figures as figures

        figures.save(figures.leak(answer.record), figure, force)
    values = answer.values
    lines = [""]
    for name, fit in values["models"].items():
        constant = f"{fit['time_constant']:.4g} s" if fit["time_constant"] else "none"
        lines.append(f"{name}: time constant {constant}, misses by {fit['rmse']:.3g} Pa (RMSE)")
    shown = _ranges(values, "rate", "1/s") | _ranges(values, "leak_rate", "Pa m³/s")
    shown |= _ranges(values, "time_constant", "s") | _between(values)
    return say(
        answer, as_json, lines=lines, shown=shown,
        hidden=("models", "understood", "rate", *_LIMITS),
    )  # fmt: skip


_LIMITS = tuple(
    f"{k}_{end}"
    for k in ("rate", "leak_rate", "time_constant", "volume", "flow", "ultimate_pressure",
              "compliance_ratio")
    for end in ("low", "high")
)  # fmt: skip


def _between(values: Mapping[str, Any]) -> dict[str, str]:
    low, high = values["window"]
    return {"window": f"{low:.4g} s to {high:.4g} s"}


def _ranges(values: Mapping[str, Any], key: str, unit: str, factor: float = 1.0) -> dict[str, str]:
    """A value with its 95 % interval, where it has one; "above" where that is open."""
    value, low, high = (values[k] for k in (key, f"{key}_low", f"{key}_high"))
    if value is None:
        return {}
    text = f"{value * factor:.4g} {unit}"
    if low is not None and high is not None:
        text += f" (95 %: {low * factor:.4g} to {high * factor:.4g})"
    elif low is not None:
        text += f" (95 %: above {low * factor:.4g})"
    return {key: text}


def pump_down(
    file: LogFile,
    with_volume: Annotated[
        Path | None,
        typer.Argument(metavar="[FILE2]", help="The same line with a known volume added."),
    ] = None,
    volume: Annotated[
        str | None, typer.Option(metavar="Q", help="Volume pumped, where it is known: 7.5mL.")
    ] = None,
    flow: Annotated[
        str | None, typer.Option(metavar="Q", help="Flow of the pump, where it is known: 3.33mL/s.")
    ] = None,
    added_volume: Annotated[
        str | None, typer.Option(metavar="Q", help="Volume added for FILE2, 10mL.")
    ] = None,
    compliance: Annotated[
        str | None,
        typer.Option(metavar="Q|fit", help="Volume lost per vacuum, 0.01mL/kPa, or fit it too."),
    ] = None,
    reading: Reading = None,
    zero: Zero = None,
    start: Start = None,
    end: End = None,
    atmosphere: opt.Atmosphere = None,
    columns: Columns = None,
    decimal: opt.Decimal = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Volume and pump flow from pump-down logs, as far as they tell them."""
    opt.check_figure(figure, force)
    opt.engine()
    from layerjam.cli.old_output import say
    from layerjam.commands import pressure_log as verb

    answer = verb.pump_down(
        file, with_volume, volume=volume, flow=flow, added_volume=added_volume,
        compliance=compliance, reading=reading, atmosphere=atmosphere, zero=zero, start=start,
        end=end, columns=columns, decimal=decimal,
    )  # fmt: skip
    if figure:
        from layerjam.report import measurement_figures as figures

        figures.save(figures.pump_down(*answer.record), figure, force)
    values = answer.values
    shown = _ranges(values, "rate", "1/s") | _between(values)
    shown |= _ranges(values, "volume", "mL", 1e6) | _ranges(values, "flow", "mL/s", 1e6)
    shown |= _ranges(values, "ultimate_pressure", "kPa", 1e-3)
    if values["compliance"] is not None:
        shown["compliance"] = f"{values['compliance'] * 1e9:.4g} mL/kPa"
    if values["compliance_ratio"] is not None:
        shown |= _ranges(values, "compliance_ratio", "1/kPa", 1e3)
    hidden = ["understood", "samples", *_LIMITS]
    hidden += [k for k in ("rate_with_volume", "compliance", "compliance_ratio") if not values[k]]
    return say(answer, as_json, shown=shown, hidden=hidden)


def crash(
    file: LogFile,
    filter: Annotated[
        str, typer.Option(metavar="cfc180|none", help="SAE J211-1: cfc60, 180, 600, 1000, none.")
    ] = "cfc180",
    sampling: Annotated[
        str | None, typer.Option(metavar="Q", help="Sampling rate of a file without time, 10kHz.")
    ] = None,
    before: Annotated[
        str | None, typer.Option(metavar="Q", help="Length of the quiet part at the beginning.")
    ] = None,
    range: Annotated[
        str | None, typer.Option("--range", metavar="Q", help="Range of the sensor, '250 g'.")
    ] = None,
    falling: Annotated[
        bool, typer.Option("--falling", help="The sensor fell freely before, along its axis.")
    ] = False,
    hic: Annotated[
        str | None, typer.Option(metavar="Q", help="Head injury criterion over at most this, 15ms.")
    ] = None,
    columns: Columns = None,
    decimal: opt.Decimal = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Peak, filtered peak, velocity change and duration of an impact in an accelerometer's log."""
    opt.check_figure(figure, force)
    opt.engine()
    from layerjam.cli.old_output import say
    from layerjam.commands import measurements as verb

    answer = verb.crash(
        file, filter=filter, sampling=sampling, before=before, range=range, falling=falling,
        hic=hic, columns=columns, decimal=decimal,
    )  # fmt: skip
    if figure:
        from layerjam.report import measurement_figures as figures

        figures.save(figures.crash(answer.record), figure, force)
    values = answer.values
    spans = {
        key: f"{values[key][0]:.6g} s to {values[key][1]:.6g} s"
        for key in ("pulse", "quiet", "hic_window")
        if values[key] is not None
    }
    hidden = ["understood", "samples", *(k for k in ("hic", "hic_window") if values[k] is None)]
    return say(answer, as_json, shown=spans, hidden=hidden)

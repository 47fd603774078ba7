"""`enclosure`: modulus and hyperelastic fit of the enclosure's silicone."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial as bound
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from layerjam.brake.commands.arguments import Accept, OutBrake, Overwrite, TargetBrake
from layerjam.brake.device.brake_file import BrakeFile, updated_text
from layerjam.brake.simulate.quantities import AREA
from layerjam.core.command.declare import Help, command
from layerjam.core.command.results import Figure, Judged, fact, number, result
from layerjam.core.errors import FitError, Notice, QuantityError, UnknownNameError
from layerjam.core.toml_files.source import Source
from layerjam.core.units import QuantitySpec, show
from layerjam.core.verdict import Verdict, judge
from layerjam.laboratory.commands.files import FromFiles, map_files, write_brake
from layerjam.laboratory.commands.reading import Partial, SpecimenOptions, list_files

if TYPE_CHECKING:
    from layerjam.laboratory.identify.rubber.hyperelastic import Fit
    from layerjam.laboratory.identify.rubber.tensile import Moduli, Specimen

GAUGE_LENGTH = QuantitySpec("m", "gauge length of the specimen", lo=1e-4, hi=10, example="33mm")
STRAIN = QuantitySpec("1", "engineering strain", hi=30)
SEVERAL_MATERIALS = Notice(
    "the files contain several materials, so no mean is given; see each one in 'files'",
    "several-materials",
)


def _format_percent(part: float) -> str:
    return f"{part:+.1%}"


def _format_range(span: Sequence[float]) -> str:
    return f"{span[0]:.1%} to {span[1]:.0%}"


def _format_parameters(values: Mapping[str, float]) -> str:
    return ", ".join(
        f"{k} {show(v, '1' if k.startswith('alpha') else 'Pa')}" for k, v in values.items()
    )


@result
class SiliconeFit(FromFiles, Judged):
    """Means over the specimens of a silicone, and the model fitted to all of their curves.

    If the files contain several materials, numbers without a mean are None; `files` has those of
    each file. `record` is {path: (Specimen, Moduli, {model: Fit}, model)}.
    """

    record: "dict[str, tuple[Specimen, Moduli, dict[str, Fit], str]]"
    material: str | None = fact("silicone from the catalogue")
    specimens: int | None = number("1", "specimens used")
    modulus_100: float | None = number("Pa", "engineering stress at 100 % strain")
    modulus_100_sd: float | None = number("Pa", "SD between the specimens")
    data_sheet: float | None = number("Pa", "100 % modulus from the manufacturer's data sheet")
    difference: float | None = number(
        "1", ("relative difference from the data sheet"), shown=_format_percent
    )
    initial_modulus: float | None = number("Pa", "slope over the strain window")
    initial_modulus_sd: float | None = number("Pa", "SD between the specimens")
    modulus_300: float | None = number("Pa", "engineering stress at 300 % strain")
    strength: float | None = number("Pa", "maximum engineering stress")
    strain_at_end: float | None = number("1", "strain where the record ends", shown="{:.0%}".format)
    model: str | None = fact("chosen model")
    parameters: Mapping[str, float] | None = fact("model parameters", shown=_format_parameters)
    why: str | None = fact("reason for the choice")
    model_modulus: float | None = number("Pa", "initial modulus of the model")
    strain_range: Sequence[float] | None = number("1", "fitted strain range", shown=_format_range)
    rmse: float | None = number("Pa", "root mean square error")
    error_at_100: float | None = number("1", "model error at 100 % strain", shown=_format_percent)
    stable: bool | None = fact("whether the model is stable")
    models: Mapping[str, Any] | None = fact("every fitted model", listed=False)
    window: Sequence[float] = number("1", "strain window of the initial slope", listed=False)
    files: Mapping[str, Mapping[str, Any]] = fact("each specimen", listed=False)

    def lines(self) -> Iterator[str]:
        """Yield one line per file: its 100 % modulus, that of the data sheet, and its model."""
        yield ""
        for path, row in self.files.items():
            text = f"{Path(path).name}: 100 % modulus {show(row['modulus_100'], 'Pa')}"
            if row["difference"] is not None:
                text += (
                    f", data sheet of {row['material']} {show(row['data_sheet'], 'Pa')} "
                    f"({row['difference']:+.0%})"
                )
            elif row["data_sheet"] is None:
                text += ", material not known (--material compares it with a data sheet)"
            yield f"{text}; {row['model']}"

    def draw(self) -> Figure:
        """Return the figure of stress versus strain of every specimen with its model."""
        from layerjam.core.drawing.style import mark_figure
        from layerjam.laboratory.figures import measurement_figures as figures

        sheets = {path: row["data_sheet"] for path, row in self.files.items()}
        return mark_figure(figures.draw_sleeve(self.record, sheets), self.synthetic)


@command("test")
def enclosure(
    files: Annotated[
        Sequence[str | Path] | str | Path, Help("Files from a test machine.", metavar="FILE...")
    ],
    *,
    area: Annotated[
        float | None, AREA, Help("Cross-section of the specimen, for files with force data.")
    ] = None,
    gauge_length: Annotated[
        float | None, GAUGE_LENGTH, Help("Gauge length, for files with elongation data.")
    ] = None,
    start: Annotated[
        float, STRAIN, Help("Strain at the start of the initial slope.", option="--from")
    ] = 0.05,
    end: Annotated[
        float, STRAIN, Help("Strain at the end of the initial slope.", option="--to")
    ] = 0.2,
    fit_to: Annotated[
        float | None, STRAIN, Help("Maximum strain to fit, e.g. 200%. Default: all.")
    ] = None,
    material: Annotated[
        str | None, Help("Catalogue silicone to compare with.", metavar="NAME")
    ] = None,
    brake: TargetBrake | None = None,
    out: OutBrake | None = None,
    tare: Annotated[bool, Help("Subtract the stress without strain.")] = False,
    hyperelastic: Annotated[
        bool, Help("Also write the chosen model into the brake, as [hyperelastic].")
    ] = False,
    partial: Partial = False,
    accept: Accept = None,
    options: SpecimenOptions = SpecimenOptions(),
    overwrite: Overwrite = False,
) -> SiliconeFit:
    """Fit the modulus and a hyperelastic model of the enclosure's silicone to ASTM D412 curves.

    `start` and `end` bound the strain of the initial slope. `tare` subtracts the stress without
    strain. Specimens of one material are pooled. `material` names the silicone to compare with.
    `brake` and `out` write the mean 100 % modulus into a copy; `hyperelastic`, also the model.
    """
    from layerjam.laboratory.identify.rubber.specimen_checks import check_specimens
    from layerjam.laboratory.identify.rubber.specimens import load_sheets, make_rows, pool, read

    sheets = load_sheets()
    _check_options(start, end, brake, out, material, sheets, hyperelastic)
    sizes: dict[str, Any] = {"area": area, "gauge_length": gauge_length, "limit": fit_to}
    read_specimen = bound(read, window=(start, end), options=options, tare=tare, **sizes)
    specimens, refusals = map_files(list_files(files), lambda p: [("", bound(read_specimen, p))])
    specimens_by_path = {row[0].path: row for row in specimens}
    rows = make_rows(specimens_by_path, material, sheets)
    values = pool(specimens, [*rows.values()], fit_to)
    changes = _brake_changes(values, specimens_by_path, brake, hyperelastic)
    checks = check_specimens(rows, values, hyperelastic)
    verdict = judge(checks, accept, list(changes), out, files=len(specimens))
    path, notices = None, list[Notice]()
    if brake is not None:
        text = _make_text(brake, values, specimens, changes, verdict)
        path, notices = write_brake(out, text, overwrite, bool(refusals), partial, verdict)
        notices += _list_factor_notices(brake, path)
    return SiliconeFit.create(
        values,
        verdict,
        window=[float(start), float(end)],
        files=rows,
        understood={p: list(s.understood) for p, (s, *_) in specimens_by_path.items()},
        refused=refusals,
        file=path,
        warnings=[*_list_warnings(specimens, values), *notices],
        record=specimens_by_path,
    )


def _list_warnings(specimens: Sequence[Any], values: Mapping[str, Any]) -> list[str]:
    """Return the warnings of the specimens, and one if they are of several materials."""
    warnings: list[str] = [w for s, m, *_ in specimens for w in (*s.warnings, *m.warnings)]
    return warnings if values else [*warnings, SEVERAL_MATERIALS]


def _check_options(
    start: float,
    end: float,
    brake: BrakeFile | None,
    out: str | Path | None,
    material: str | None,
    sheets: Mapping[str, Any],
    hyperelastic: bool,
) -> None:
    if (brake is None) != (out is None):
        raise QuantityError("--brake and --out: give both to write a brake, or neither")
    if hyperelastic and brake is None:
        raise QuantityError("hyperelastic: give brake and out too; a brake stores the model")
    if start >= end:
        raise QuantityError(f"from: {start:.3g} is not below to, {end:.3g}")
    if material is not None and material not in sheets:
        raise UnknownNameError("silicone", material, sheets)


def _list_factor_notices(brake: BrakeFile, path: str | None) -> Iterator[Notice]:
    """Yield a notice if the scale factor of the brake written is that of the old enclosure."""
    factor = brake.brake.scale_factor
    if path and factor != 1.0:
        old = (
            f"the scale factor {factor:g} was fitted with the old enclosure; run "
            "'layerjam calibrate' again"
        )
        yield Notice(old, "old-scale-factor")


def _make_text(
    brake: BrakeFile,
    values: Mapping[str, Any],
    specimens: Sequence[Any],
    changes: Mapping[str, tuple[float, Source] | None],
    verdict: Verdict,
) -> Callable[[str], str]:
    """Return what writes the brake with its changes and with the scatter of the specimens."""
    from layerjam.laboratory.identify.material_evidence import make_enclosure_evidence

    strain = min(moduli.strain_at_end for _, moduli, *_ in specimens)
    evidence = make_enclosure_evidence(brake, values, strain, changes)
    return bound(updated_text, brake, changes=changes, verdict=verdict, evidence=evidence)


def _brake_changes(
    values: Mapping[str, Any],
    results: Mapping[str, Any],
    brake: BrakeFile | None,
    hyperelastic: bool,
) -> dict[str, tuple[float, Source] | None]:
    """Return the modulus and, if requested, the chosen model, in the form of a brake file."""
    from layerjam.laboratory.identify.provenance import mark_sources

    if brake is None:
        return {}

    modulus = _modulus_changes(values, results)
    source = modulus["enclosure.modulus"][1]
    changes = {
        **modulus,
        **_model_changes(values, brake, source, hyperelastic),
    }
    return mark_sources(changes, any(specimen.synthetic for specimen, *_ in results.values()))


def _model_changes(
    values: Mapping[str, Any], brake: BrakeFile, modulus: Source, is_requested: bool
) -> dict[str, tuple[float, Source] | None]:
    """Return the chosen model in the form of a brake file, replacing the existing one."""
    from layerjam.brake.device.hyperelastic import NAMES

    old = [path for path in brake.sources if path.startswith("hyperelastic.")]
    if not is_requested:
        if old:
            raise QuantityError(
                "hyperelastic: the brake has the model of a different enclosure; replace it too "
                "(--hyperelastic), or remove [hyperelastic] from its file"
            )
        return {}
    if not values["stable"]:
        raise FitError(
            f"hyperelastic: {values['model']} is not stable in tension over the whole "
            "curve; fit a smaller strain range (--fit-to)"
        )
    text = modulus.text.replace("engineering stress at 100 %", f"{values['model']} fitted")
    source = Source(kind="measured", text=text)
    names = NAMES[values["model"]]
    entries: dict[str, tuple[float, Source] | None] = dict.fromkeys(old)
    entries |= {f"hyperelastic.{names[p]}": (v, source) for p, v in values["parameters"].items()}
    entries["hyperelastic.strain"] = (float(values["strain_range"][1]), source)
    return entries


def _modulus_changes(
    values: Mapping[str, Any], results: Mapping[str, Any]
) -> dict[str, tuple[float, Source]]:
    """Return the mean 100 % modulus in the form of a brake file; FitError if there is none."""
    from layerjam.laboratory.identify.provenance import sha256

    if values.get("modulus_100") is None:
        raise FitError("out: writing a brake needs one 100 % modulus common to all files")
    names = ", ".join(f"{Path(p).name} (SHA-256 {sha256(p)[:12]})" for p in results)
    sd = values.get("modulus_100_sd")
    source = Source(
        kind="measured",
        text=f"tensile test to ASTM D412, engineering stress at 100 %, first loading; {names}",
        spread=f"SD {show(sd, 'Pa')} over {values['specimens']} specimens" if sd else "",
    )
    return {"enclosure.modulus": (float(values["modulus_100"]), source)}

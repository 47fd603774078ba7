"""`compare`: force and mass of layer-jamming brakes and of published devices."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any

from layerjam.brake.commands.arguments import (
    AnyBrake,
    Atmosphere,
    Interval,
    check_vacuum,
    convert_brake,
)
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.simulate.quantities import VACUUM
from layerjam.core.command.declare import Help, Input, command
from layerjam.core.command.results import Figure, Result, fact, result
from layerjam.core.command.wording import format_interval
from layerjam.core.errors import Notice
from layerjam.core.units import show

if TYPE_CHECKING:
    from layerjam.workshop.design.force_density import SheetLine
    from layerjam.workshop.design.published import PublishedDevices

TABLE_UNITS = {
    "mass": "kg",
    "max_force": "N",
    "force_density": "N/kg",
    "vacuum": "Pa",
    "sheets": "1",
    "brakes": "1",
    "torque": "N m",
    "lever": "m",
    "force_per_sheet": "N",
    "mass_per_sheet": "kg",
    "density_per_sheet": "N/kg",
    "sheet_mass": "kg",
    "paper_force": "N",
    "paper_mass": "kg",
    "paper_density": "N/kg",
}
NOTES = (
    Notice(
        "force density is the ratio of force to the mass of the device alone: pump, valve "
        "and supply are excluded for every device",
        "own-mass",
    ),
    Notice(
        "the other devices are those with published numbers, not the best of their class",
        "not-the-best",
    ),
)


@result
class Comparison(Result):
    """Force and mass of brakes and of published devices, each with its source.

    `record` is (devices, SheetLine list, the catalogue of published devices).
    """

    record: "tuple[list[dict[str, Any]], list[SheetLine], PublishedDevices]"
    calibration: str | None = fact("which brakes are calibrated; null if all or none are")
    devices: Sequence[Mapping[str, Any]] = fact(
        "brakes and devices: mass, maximum force, force density, source", listed=False
    )
    sheet: Mapping[str, Any] = fact(
        "force added to the first brake by one more sheet, with the paper's claim", listed=False
    )
    sheet_lines: "Sequence[SheetLine]" = fact(
        "each brake with more sheets", listed=False, key="lines"
    )
    none_found: Mapping[str, str] = fact(
        "for each class without a sourced device, the sources searched", listed=False
    )

    @classmethod
    def table_units(cls) -> Mapping[str, str]:
        """Return the units of the rows' keys."""
        return TABLE_UNITS

    def lines(self) -> Iterator[str]:
        """Yield sourced devices, the effect of one more sheet, and classes without a device."""
        yield "mass, maximum force, force density"
        for row in self.devices:
            yield ""
            yield (
                f"{row['name']} ({row['kind']}): {show(row['mass'], 'kg')}, "
                f"{show(row['max_force'], 'N')}{_format_interval(row)}, "
                f"{show(row['force_density'], 'N/kg')}"
            )
            yield f"    {row['source']}"
            if row["basis"]:
                yield f"    basis: {': '.join(filter(None, (row['basis'], row['basis_reason'])))}"
            if row["note"]:
                yield f"    {row['note']}"
        sheet = {name: self._format_value(name) for name in self.sheet}
        yield ""
        yield (
            f"one more sheet in {self.sheet['brake']} at {sheet['vacuum']}: "
            f"{sheet['force_per_sheet']} and {sheet['mass_per_sheet']} "
            f"({sheet['sheet_mass']} bare), {sheet['density_per_sheet']}"
        )
        yield (
            f"    the paper: {sheet['paper_force']} and {sheet['paper_mass']}, "
            f"{sheet['paper_density']}; {self.sheet['why']}"
        )
        yield from ("", "none found (with mass and force in an accessible source)")
        for kind, missing in self.none_found.items():
            yield f"  {kind}: {missing}"

    def _format_value(self, name: str) -> str:
        return show(self.sheet[name], TABLE_UNITS[name]) if name in TABLE_UNITS else ""

    def draw(self) -> Figure:
        """Return force versus mass on logarithmic axes, with lines of constant force density."""
        from layerjam.workshop.figures import density_figures

        rows, lines, _ = self.record
        return density_figures.draw_density(rows, lines, self.sheet, list(self.none_found))


def _format_interval(row: Mapping[str, Any]) -> str:
    if row["intervals"] is None:
        return ""
    ends = row["intervals"]["max_force"]
    return format_interval((ends["low"], ends["high"]), "N", row["max_force"])


def _read_brakes(value: Sequence[AnyBrake], arguments: Mapping[str, Any]) -> list[BrakeFile]:
    from layerjam.brake.device.load import devices

    return [convert_brake(brake, arguments.get("atmosphere")) for brake in value or devices()]


@command("design")
def compare(
    *brakes: Annotated[
        BrakeFile,
        Input("Brakes to compare. Default: all in the catalogue.", "BRAKE", convert=_read_brakes),
    ],
    vacuum: Annotated[
        float | None, VACUUM, Help("Vacuum of the brakes. Default: full vacuum at the site.")
    ] = None,
    atmosphere: Atmosphere = None,
    interval: Interval = "next",
) -> Comparison:
    """Compare the force per mass of brakes with that of published devices.

    Every row names its source. If no brakes are given, those of the catalogue are compared (paper,
    III-F). The first brake is also shown at lower vacuums, in parallel with identical brakes, and
    with more sheets. `devices` is a list of rows; `computed` is True for our brakes. `sheet`
    compares the effect of one more sheet with the paper's statement. `none_found` maps a class
    without a sourced device to the sources searched.
    """
    from layerjam.brake.simulate.prediction import list_borrowed_notices
    from layerjam.workshop.design.comparison import compare_devices, describe_overlaps
    from layerjam.workshop.design.uneven import calibration_notices, describe_calibration

    files: list[Any] = list(brakes)
    for file in files:
        check_vacuum(vacuum or 0.0, file.brake)
    vacuums = [f.brake.site.atmosphere if vacuum is None else vacuum for f in files]
    rows, sheet, lines, others = compare_devices(files, vacuums, interval == "mean")
    overlaps = describe_overlaps(rows[: len(files)]) if interval == "next" else ""
    return Comparison(
        calibration=describe_calibration(files),
        devices=rows,
        sheet=sheet,
        sheet_lines=lines,
        none_found=dict(others.looked_for),
        warnings=[
            *calibration_notices(files),
            *([Notice(overlaps, "intervals-overlap")] if overlaps else []),
            *(w for file in files for w in (*file.warnings(), *list_borrowed_notices(file))),
            *NOTES,
        ],
        record=(rows, lines, others),
    )

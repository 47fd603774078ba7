"""A brake as one self-contained page: its numbers with sources, and a part that computes."""

from layerjam._version import __version__
from layerjam.brake.commands.edit import BRAKE_FIELDS
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.figures.live_page import make_live
from layerjam.core.drawing.page import Page, Part, Table, Word, to_html
from layerjam.core.errors import count_text
from layerjam.core.units import get, show
from layerjam.workshop.commands.show import BrakeSummary
from layerjam.workshop.commands.show import show as show_brake

LIMITS = (
    "“Try it” computes with layerjam's C kernel, to the same digits: kinetic friction of the "
    "sheets, enclosure and stiffness, {rope}.",
    "It does not offer what this kernel lacks: friction that depends on speed, sheets that fan out "
    "without spacers, a hyperelastic enclosure, and the vacuum line. Static friction is in the "
    "holding force only, so a pull does not reach that force.",
    "A safe vacuum allows for errors of mass, speed and vacuum by the stated margin. Friction that "
    "is lower by the same percentage has the effect of such an error of the vacuum.",
)


def make_html(file: BrakeFile, rope_stiffness: float | None = None) -> str:
    """Return the page of a brake, with a rope [N/m] in series; equal brakes give equal bytes.

    For a law that the C kernel lacks, the page states that it does not compute, and why. Raises
    MissingExtraError if jinja2 is not installed, CompilerError as `make_live`.
    """
    summary, live = show_brake(file), make_live(file, rope_stiffness)
    rope = "without a rope"
    if rope_stiffness is not None:
        rope = f"with a rope of {show(rope_stiffness, 'N/m')} in series"
    limits = [text.format(rope=rope) for text in LIMITS if live.script]
    page = Page(
        title=file.title or file.name,
        lead=_make_lead(file, summary),
        key=_describe_basis(file),
        banner=[str(entry.notice()) for entry in file.accepted],
        numbers=[
            (show(summary.max_force, "N"), "maximum force of a pull"),
            (show(summary.holding_force, "N"), "holding force at rest"),
            (show(summary.energy_capacity, "J"), "energy of its travel"),
            (show(summary.usable_travel, "m"), "usable travel"),
            (show(summary.mass, "kg"), "mass of the brake"),
        ],
        parts=[
            Part(id="about", title="About this page", text=limits, notes=summary.warnings),
            Part(id="sources", title="Numbers and their sources", tables=[_sources_table(file)]),
        ],
        footer=f"{file.name}, written by layerjam {__version__}",
    )
    return to_html(page.template_data(), {}, live)


def _make_lead(file: BrakeFile, summary: BrakeSummary) -> str:
    full, force = show(file.brake.site.atmosphere, "Pa"), show(summary.max_force, "N")
    return (
        f"A brake of {file.brake.sheets.count} sheets in an airtight enclosure. At full vacuum, "
        f"{full}, friction between the sheets resists a pull of up to {force}. Without vacuum they "
        "slide freely."
    )


def _describe_basis(file: BrakeFile) -> str:
    """Return the verdict on the brake's numbers, and their basis."""
    verdict = file.verdict or "the brake file stores no check"
    if file.accepted:
        verdict += f", {count_text(len(file.accepted), 'failed check')}"
    basis = "handbook values, not calibrated"
    if file.is_calibrated:
        source, factor = file.sources["scale_factor"], file.brake.scale_factor
        basis = f"calibrated with a scale factor of {factor:.4g} ({source.kind}: {source.text})"
    return f"Verdict: {verdict}. Basis: {basis}. Forces and energy at full vacuum."


def _sources_table(file: BrakeFile) -> Table:
    rows = []
    for path, (spec, _) in BRAKE_FIELDS.items():
        value, source = get(file.brake, path), file.sources.get(path)
        if value is not None:
            sentence = "default" if source is None else source.sentence()
            name = Word(f"{spec.text} ({path})", "words")
            rows.append([name, show(value, spec.unit, 6), Word(sentence, "source")])
    return Table(id="numbers", head=["number", "value", "source"], rows=rows)

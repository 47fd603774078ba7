"""A brake as one self-contained page: its numbers with sources, and a part that computes."""

from layerjam._version import __version__
from layerjam.brake.commands.edit import list_numbers
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.evidence import RANGES
from layerjam.brake.figures.live_page import make_live
from layerjam.core.drawing.page import Page, Part, Table, Word, to_html
from layerjam.core.errors import count_text
from layerjam.core.units import show
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
NUMBERS = {
    "max force": "maximum force of a pull",
    "holding force": "holding force at rest",
    "energy capacity": "energy of its travel",
    "usable travel": "usable travel",
    "mass": "mass of the brake",
}
"""{row of `show`: text below the number}."""


def make_html(file: BrakeFile, rope_stiffness: float | None = None) -> str:
    """Return the page of a brake, with a rope [N/m] in series; equal brakes give equal bytes.

    For a law that the C kernel lacks, the page states that it does not compute, and why. Raises
    MissingExtraError if jinja2 is not installed, CompilerError as `make_live`.
    """
    summary, live = show_brake(file), make_live(file, rope_stiffness)
    rows = dict(summary.rows())
    rope = "without a rope"
    if rope_stiffness is not None:
        rope = f"with a rope of {show(rope_stiffness, 'N/m')} in series"
    full, (force, *_) = show(file.brake.site.atmosphere, "Pa"), rows["max force"].split(" (")
    verdict = file.verdict or "the brake file stores no check"
    if file.accepted:
        verdict += f", {count_text(len(file.accepted), 'failed check')}"
    page = Page(
        title=file.title or file.name,
        lead=f"A brake of {file.brake.sheets.count} sheets in an airtight enclosure. At full "
        f"vacuum, {full}, friction between the sheets resists a pull of up to {force}. Without "
        "vacuum they slide freely.",
        key=f"Verdict: {verdict}. Basis: {rows['basis']}. Forces and energy at full vacuum.",
        banner=[str(entry.notice()) for entry in file.accepted],
        numbers=[_split_note(rows[name], words) for name, words in NUMBERS.items()],
        parts=[
            Part(
                id="about",
                title="About this page",
                text=[text.format(rope=rope) for text in LIMITS if live.script] + _list_tests(file),
                notes=summary.warnings,
            ),
            Part(id="sources", title="Numbers and their sources", tables=[_sources_table(file)]),
        ],
        footer=f"{file.name}, written by layerjam {__version__}",
    )
    return to_html(page.template_data(), {}, live)


def _list_tests(file: BrakeFile) -> list[str]:
    """Return a sentence on the conditions of the brake's tests, if there are any."""
    fit = file.valid_evidence("calibrate")
    spans = [
        f"{name} {show(low, RANGES[name].unit)} to {show(high, RANGES[name].unit)}"
        for name, (low, high) in (fit.ranges.items() if fit else ())
    ]
    return [f"Tests of this brake cover {'; '.join(spans)}."] if spans else []


def _split_note(text: str, words: str) -> tuple[str, str]:
    """Return a number, and its words with the notes in brackets behind the number."""
    value, *notes = text.replace(")", "").split(" (")
    return value, "\n".join([words, *notes])


def _sources_table(file: BrakeFile) -> Table:
    rows = [
        (
            Word(f"{spec.text} ({path})", "words"),
            show(value, spec.unit, 6),
            Word("default" if source is None else source.sentence(), "source"),
        )
        for path, spec, value, source in list_numbers(file)
    ]
    return Table(id="numbers", head=["number", "value", "source"], rows=rows)

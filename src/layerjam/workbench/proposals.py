"""Proposals for a dropped measurement: its use and conditions, each with its source.

Nothing is applied here: a page shows the proposal, and the user accepts it.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

from layerjam.core.errors import FileError, LayerjamError, MissingExtraError
from layerjam.core.units import get_spec, show
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.laboratory.measure.preview import find_vacuum_columns, preview_file, read_column
from layerjam.laboratory.measure.readers.read import open_traces
from layerjam.laboratory.measure.readers.source import load_sources
from layerjam.laboratory.measure.run_text import make_run_facts
from layerjam.laboratory.measure.runs import ENDING, read_run
from layerjam.laboratory.measure.sidecar import Facts, read_facts
from layerjam.laboratory.measure.trace import Trace
from layerjam.workbench.kinds import OTHER_READERS, find_other_reader

FRICTION, CALIBRATE, VALIDATE, ASIDE = "friction", "calibrate", "validate", "aside"
FACTS = ("vacuum", "normal_force", "speed")
"""Conditions for which a value is proposed."""
NEEDED = MappingProxyType({FRICTION: "normal_force", CALIBRATE: "vacuum", VALIDATE: "vacuum"})
"""{use of a file: metadata entry that it requires}."""
CLICKS: Mapping[str, str] = {
    "columns": "Click the headers of the force and elongation columns",
    "force-sign": "If this machine counts tension as negative, click the header of the force "
    "column and choose 'reverse its sign'",
    "elongation-sign": "If this machine counts elongation as negative, click the header of the "
    "elongation column and choose 'reverse its sign'",
    "decimal": "Choose the decimal separator",
    "specimen": "Choose a specimen",
    "sheet": "Choose a worksheet",
    "speed": "Enter the crosshead speed, or click the header of the elongation column",
}
"""{information that a reader requests: instruction on the page}."""
NEAR_HIGHEST = 0.97
"""Fraction of the highest vacuum above which a pull counts as one at the highest vacuum."""
HEAD = 4000
"""Number of bytes at the start of a file that are searched for a description of the test."""
_FRICTION = re.compile(
    r"(?i)friction|reib|frott|attrito|fricci|(?<![a-z])cof(?![a-z])|sled|d1894|iso[ _-]?8295"
)
_PULL = re.compile(r"(?i)(?<![a-z])(?:pull|tensile|tension|zug|traction|trekk?|extension)")
_NUMBER = r"(?<![A-Za-z0-9.,])(\d+(?:[.,p]\d+)?)[ _]?"
_PRESSURE = re.compile(_NUMBER + r"(kPa|hPa|Pa|mbar|bar|psi|torr|mmHg)(abs)?(?![A-Za-z])", re.I)
_FORCE = re.compile(_NUMBER + r"(kN|mN|N|gf|kgf|lbf)(?![A-Za-z])")
_WEIGHT = re.compile(_NUMBER + r"(kg|g)(?![A-Za-z])")
_SPEED = re.compile(_NUMBER + r"mm[ _-]?(?:p(?:er)?[ _-]?|/)?(s|sec|min)(?![A-Za-z])", re.I)
_UNITS = {u.lower(): u for u in ("kPa", "hPa", "Pa", "mbar", "bar", "psi", "torr", "mmHg")}


@dataclass(frozen=True)
class SourcedValue:
    """A value as text (empty if unknown) and its source."""

    text: str = ""
    source: str = ""


@dataclass(frozen=True)
class Proposal:
    """Proposal for one dropped file.

    `kind` is "measurement", a key of OTHER_READERS, or "unknown". `about` states the interpretation
    or the reason for rejection. `asks` is the key in CLICKS of the missing information.
    """

    key: str
    name: str
    kind: str = "measurement"
    about: str = ""
    asks: str = ""
    role: SourcedValue = SourcedValue()
    facts: Mapping[str, SourcedValue] = field(default_factory=dict)
    synthetic: bool = False

    @property
    def is_usable(self) -> bool:
        """Whether it is a measurement that could be read."""
        return self.kind == "measurement" and not self.asks

    def missing_entry(self, role: str, facts: Mapping[str, str]) -> str:
        """Return the metadata entry that a use requires but lacks; empty if none is missing."""
        needed_fact = NEEDED.get(role, "")
        return needed_fact if needed_fact and not facts.get(needed_fact) else ""


def parse_file_name(name: str) -> dict[str, SourcedValue]:
    """Return {"role", "vacuum", "normal_force", "speed": value} as given in a file's name.

    A name with several pressures yields no vacuum, because it is ambiguous.
    """
    stem = Path(name).stem
    values: dict[str, SourcedValue] = {}
    friction, pull = _FRICTION.search(stem), _PULL.search(stem)
    if friction:
        values["role"] = SourcedValue(FRICTION, _cite_name(friction[0]))
    elif pull:
        values["role"] = SourcedValue(CALIBRATE, _cite_name(pull[0]))
    for fact, text, written_as in _find_quantities(stem, bool(friction)):
        try:
            get_spec(Facts, fact).read(text, fact)
        except LayerjamError:
            continue
        values[fact] = SourcedValue(text, _cite_name(written_as))
    return values


def _find_quantities(stem: str, friction: bool) -> Iterator[tuple[str, str, str]]:
    """Yield (key, text, spelling in the name) of each quantity in a name."""
    pressures = {
        (_to_decimal_point(m[1]), _UNITS[m[2].lower()]): m for m in _PRESSURE.finditer(stem)
    }
    if len(pressures) == 1 and not friction:
        (((number, unit), match),) = pressures.items()
        if not match[3]:  # an absolute pressure is not a vacuum
            yield "vacuum", f"{number} {unit}", match[0]
    forces = list(_FORCE.finditer(stem))
    weights = list(_WEIGHT.finditer(stem))
    if friction and len(forces) == 1:
        yield "normal_force", f"{_to_decimal_point(forces[0][1])} {forces[0][2]}", forces[0][0]
    elif friction and not forces and len(weights) == 1:
        unit = {"g": "gf", "kg": "kgf"}[weights[0][2]]
        yield (
            "normal_force",
            f"{_to_decimal_point(weights[0][1])} {unit}",
            f"{weights[0][0]}, its weight",
        )
    speeds = list(_SPEED.finditer(stem))
    if len(speeds) == 1:
        per = "min" if speeds[0][2].lower() == "min" else "s"
        yield "speed", f"{_to_decimal_point(speeds[0][1])} mm/{per}", speeds[0][0]


def _to_decimal_point(number: str) -> str:
    return number.replace(",", ".").replace("p", ".")


def _cite_name(match: str) -> str:
    return f"its name: {match.strip(' _-')}"


def find_read_error(path: Path) -> str:
    """Return why a file cannot be read, and the remedy; empty if it can be read."""
    try:
        for trace in open_traces(path):
            trace.read(ReadingOptions())
    except FileError as err:
        return f"{err.plain}. {CLICKS[err.asks]}." if err.asks in CLICKS else err.reason
    except LayerjamError as err:
        return str(err)
    return ""


def propose_use(key: str, name: str, path: Path) -> Proposal:
    """Return the proposal for one file, whose sidecar holds the user's statements.

    Raises nothing: reading errors are in `about`, which names the file by its path.
    """
    draft = Proposal(key, name)
    try:
        facts = read_facts(path)
    except FileError as err:
        return replace(draft, kind="unknown", about=err.reason)
    try:
        traces = [trace.read(ReadingOptions()) for trace in open_traces(path)]
    except LayerjamError as err:
        role, facts_found = _find_conditions(name, path, facts, ())
        return _complete_proposal(replace(draft, role=role, facts=facts_found), path, err)
    longest = max(traces, key=len)
    force, travel = float(longest.force.max()), float(np.ptp(longest.elongation))
    summary = f"{len(longest)} samples over {show(travel, 'm', 3)}, up to {show(force, 'N', 3)}"
    if len(traces) > 1:
        summary = f"{len(traces)} specimens; the longest has {summary}"
    synthetic = any(t.synthetic for t in traces)
    role, facts_found = _find_conditions(name, path, facts, traces)
    return replace(draft, about=summary, synthetic=synthetic, role=role, facts=facts_found)


def _complete_proposal(draft: Proposal, path: Path, error: LayerjamError) -> Proposal:
    """Return an unreadable file's proposal: its other reader, what is missing, or "unknown"."""
    asks = str(getattr(error, "asks", ""))
    reason = str(getattr(error, "plain", "") or error)
    if isinstance(error, MissingExtraError):
        return replace(draft, kind="unknown", about=reason)
    kind = find_other_reader(path)
    if kind:
        return replace(draft, kind=kind, about=OTHER_READERS[kind].sentence(draft.name))
    if asks in CLICKS:
        return replace(draft, about=reason, asks=asks)
    return replace(draft, kind="unknown", about=reason)


def _find_conditions(
    name: str, path: Path, facts: Facts, traces: Sequence[Trace]
) -> tuple[SourcedValue, dict[str, SourcedValue]]:
    """Return role and metadata: from the sidecar, otherwise from the file's content or name."""
    values = parse_file_name(name)
    facts_found = {fact: value_found for fact in FACTS if (value_found := values.get(fact))}
    facts_found |= dict(_read_content(path, traces))
    facts_found |= {
        fact: SourcedValue(_quantity_text(fact, value), "its sidecar")
        for fact in FACTS
        if (value := getattr(facts, fact)) is not None
    }
    if "speed" in facts_found and facts_found["speed"].source.startswith("its name") and traces:
        del facts_found["speed"]  # ask for it only if the file has no elongation
    return _find_role(path, facts, values, facts_found), facts_found


def _quantity_text(fact: str, value: float) -> str:
    return show(value, get_spec(Facts, fact).unit)


def _find_role(
    path: Path,
    facts: Facts,
    from_file_name: Mapping[str, SourcedValue],
    facts_found: Mapping[str, SourcedValue],
) -> SourcedValue:
    if facts.normal_force is not None:
        return SourcedValue(FRICTION, "its sidecar states a normal force")
    if facts.vacuum is not None:
        return SourcedValue(CALIBRATE, "its sidecar states a vacuum")
    if "role" in from_file_name:
        return from_file_name["role"]
    word = _FRICTION.search(_read_beginning(path))
    if word:
        return SourcedValue(FRICTION, f"its first lines: {word[0]}")
    if "vacuum" in facts_found:
        return SourcedValue(CALIBRATE, f"a vacuum is known ({facts_found['vacuum'].source})")
    return SourcedValue(CALIBRATE, "force versus elongation, with no sign of a friction test")


def _read_beginning(path: Path) -> str:
    if path.suffix == ENDING:
        return ""
    try:
        source = load_sources(path)[0]
    except LayerjamError:
        return ""
    return source.text(0, min(HEAD, len(source.data)))


def _read_content(path: Path, traces: Sequence[Trace]) -> Iterator[tuple[str, SourcedValue]]:
    """Yield (key, value) from a file's content: its header, a column, or its procedure."""
    vacuums = {t.facts.vacuum for t in traces} - {None}
    if len(vacuums) == 1:
        yield (
            "vacuum",
            SourcedValue(_quantity_text("vacuum", float(vacuums.pop() or 0.0)), "the file header"),
        )
        return
    if path.suffix == ENDING:
        try:
            run = make_run_facts(read_run(path))
        except LayerjamError:
            return
        for fact in ("vacuum", "speed"):
            if (value := getattr(run, fact)) is not None:
                yield fact, SourcedValue(_quantity_text(fact, value), "the run's procedure")
        return
    try:
        table = preview_file(path)
        columns = find_vacuum_columns(table)
        if len(columns) == 1:
            yield "vacuum", column_vacuum(path, columns[0][0], columns[0][1], table.names)
    except LayerjamError:
        return


def column_vacuum(path: Path, index: int, unit: str, names: Sequence[str]) -> SourcedValue:
    """Return the vacuum in a column: the median of its values, rounded to their scatter.

    Raises LayerjamError if it has no values, or values that are not a vacuum.
    """
    values = read_column(path, index, unit, "Pa")
    middle = float(np.median(values))
    text = show(middle, "Pa", 4)
    get_spec(Facts, "vacuum").read(text, f"column '{names[index]}'")
    low, high = (show(float(v), "Pa", 3) for v in (values.min(), values.max()))
    return SourcedValue(text, f"its column '{names[index]}': median of {low} to {high}")


def assign_roles(proposals: Iterable[Proposal]) -> list[Proposal]:
    """Assign roles to pulls dropped together: calibrate at the highest vacuum, else validate."""
    files = list(proposals)
    level = {p.key: _stated_vacuum(p) for p in files if p.role.text == CALIBRATE}
    highest = max((v for v in level.values() if v is not None), default=None)
    if highest is None:
        return files
    best = show(highest, "Pa", 4)
    result = []
    for item in files:
        vacuum = level.get(item.key)
        if vacuum is not None and vacuum <= NEAR_HIGHEST * highest:
            reason = f"{item.role.source}; used for validation because another pull is at {best}"
            result.append(replace(item, role=SourcedValue(VALIDATE, reason)))
        else:
            result.append(item)
    return result


def _stated_vacuum(item: Proposal) -> float | None:
    value = item.facts.get("vacuum")
    if value is None or not value.text:
        return None
    return float(get_spec(Facts, "vacuum").read(value.text, "vacuum"))

"""Common steps of commands on measured files: reading, rejected files, and the brake file."""

import hashlib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from layerjam.brake.commands.arguments import check_vacuum
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import catalogue, load
from layerjam.brake.device.sheets import Sheets
from layerjam.core.command.declare import Progress
from layerjam.core.command.results import Result, fact, result
from layerjam.core.errors import FileError, FitError, LayerjamError, Notice
from layerjam.core.store import store_file
from layerjam.core.units import get_spec, show
from layerjam.core.verdict import Verdict
from layerjam.laboratory.commands.reading import Measured, list_files
from layerjam.laboratory.measure.conditions import LIST
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.laboratory.measure.sidecar import FOLDER
from layerjam.laboratory.measure.trace import Trace

if TYPE_CHECKING:
    from layerjam.laboratory.identify.pull.features import PullFeatures
    from layerjam.laboratory.identify.pull.summary import PullSummary
    from layerjam.laboratory.measure.readers.read import UnreadSpecimen

S = TypeVar("S", bound=Measured)
T = TypeVar("T")
SpecimenReaders = Sequence[tuple[str, Callable[[], T] | None]]
CURVE, PICTURE = 10_000, 2_000
"""Number of samples kept of a pull, and of a record that is only drawn. A gigabyte of files
therefore need not fit into memory. The samples kept are means over neighbours; maxima, slopes and
noise are computed beforehand from all samples.
"""


@result
class FromFiles(Result):
    """Result computed from measured files, with the brake file that was written."""

    understood: Mapping[str, Any] = fact("how each file was read", listed=False)
    refused: Mapping[str, str] = fact("files not used, with reasons", listed=False)
    file: str | None = fact("brake file that was written")


def read_each(
    files: Sequence[Measured] | Measured,
    use: Callable[[Trace], T],
    options: ReadingOptions,
    progress: Progress | None = None,
    left_out: Mapping[str, Collection[str]] | None = None,
) -> tuple[list[T], dict[str, str]]:
    """Return the result of `use` for every usable file and trace, and {rejected file: reason}.

    The results of `use` stay in memory, so they should not contain long records. `left_out` names
    the specimens of files to be left out. A record that was exported twice counts once; the second
    file is rejected.
    """
    from layerjam.laboratory.measure.readers.read import open_traces
    from layerjam.laboratory.measure.same_record import Records

    records = Records()

    def use_once(trace: Trace) -> T:
        path = trace.path or "an earlier trace"
        name = f"{path}, specimen {trace.specimen}" if trace.specimen else path
        original = records.find_original(trace)
        if original is not None:
            raise FitError(
                f"contains the same record as {original}, exported with a different sampling "
                "rate or number format; it is counted once"
            )
        value = use(trace)
        records.add(name, trace)
        return value

    def open_source(source: Measured) -> SpecimenReaders[T]:
        if isinstance(source, Trace):
            return [("", partial(use_once, source))]
        out = (left_out or {}).get(str(source), ())
        return [
            (
                trace.label,
                None if trace.label in out else partial(_use_specimen, use_once, trace, options),
            )
            for trace in open_traces(source, options)
        ]

    return map_files(_filter_measurements(list_files(files)), open_source, progress)


def _use_specimen(
    use: Callable[[Trace], T], specimen: "UnreadSpecimen", options: ReadingOptions
) -> T:
    return use(specimen.read(options))


def map_files(
    sources: Sequence[S],
    open_source: Callable[[S], SpecimenReaders[T]],
    progress: Progress | None = None,
) -> tuple[list[T], dict[str, str]]:
    """Return the result for each specimen of each source, and {rejected source: reason}.

    `open_source` yields each specimen of a source with a function that reads it, or None if it is
    left out. If no source can be used, the error of the first is raised.
    """
    results: list[T] = []
    refusals: dict[str, str] = {}
    known_files: dict[str, str] = {}

    def store_result(name: str, source: S) -> None:
        try:
            traces = open_source(source)
            digest = _content_digest(source)
            if digest in known_files:
                raise FitError(
                    f"contains the same measurement as {known_files[digest]}; it is counted once"
                )
            known_files[digest] = name
        except LayerjamError as error:
            refusals[name] = _shorten_reason(error, name)
            return
        for number, (label, read_trace) in enumerate(traces, 1):
            if read_trace is None:
                continue
            own_name = f"{name}, specimen {label or number}" if len(traces) > 1 else name
            try:
                results.append(read_trace())
            except LayerjamError as error:
                refusals[own_name] = _shorten_reason(error, name)

    names = [_specimen_name(source, number) for number, source in enumerate(sources, 1)]
    for count, (name, source) in enumerate(zip(names, sources, strict=True), 1):
        store_result(name, source)
        if progress is not None:
            progress("reading files", count / len(sources))
    if not results:
        if not refusals:
            raise FitError("no file was given")
        path, reason = next(iter(refusals.items()))
        raise FileError(path, reason + _describe_refusals(list(refusals)[1:], names))
    return results, refusals


def _describe_refusals(refusals: Sequence[str], files: Sequence[str]) -> str:
    """Return the number of other files and specimens rejected, as the end of a sentence."""
    file_count = sum(name in files for name in refusals)
    parts = [
        f"{count} more {noun if count == 1 else noun + 's'}"
        for count, noun in ((file_count, "file"), (len(refusals) - file_count, "specimen"))
        if count
    ]
    verb = "was" if len(refusals) == 1 else "were"
    return f" ({' and '.join(parts)} {verb} also rejected)" if parts else ""


def _specimen_name(source: Measured, number: int) -> str:
    return (source.path or f"trace {number}") if isinstance(source, Trace) else str(source) or "''"


def _content_digest(source: Measured) -> str:
    """Return a key that is identical for sources with the same content."""
    from layerjam.laboratory.identify.provenance import sha256

    if not isinstance(source, Trace):
        return sha256(str(source))
    return hashlib.sha256(source.force.tobytes() + source.elongation.tobytes()).hexdigest()


def _shorten_reason(error: LayerjamError, path: str) -> str:
    """Return only the reason if the error concerns that file, otherwise the full message."""
    if not isinstance(error, FileError | FitError) or error.path != path:
        return str(error)
    line = f"line {error.line}: " if isinstance(error, FileError) and error.line else ""
    return f"{line}{error.reason}"


def describe_readings(traces: Iterable[Trace]) -> dict[str, list[str]]:
    """Return {file, with the specimen if it has several: interpretation}."""
    return {
        f"{t.path}, specimen {t.specimen}" if t.specimen else t.path: list(t.understood)
        for t in traces
    }


def _filter_measurements(files: Sequence[Measured]) -> list[Measured]:
    """Return the files without the sidecars and lists that `*` also matches."""
    paths = {str(f) for f in files if not isinstance(f, Trace)}
    neighbours = {
        name
        for name in paths
        if name.removesuffix(".toml") in paths - {name}
        or (Path(name).name in (LIST, FOLDER) and len(paths) > 1)
    }
    return [f for f in files if isinstance(f, Trace) or str(f) not in neighbours]


def metadata_notices(
    trace: Trace, file: BrakeFile, vacuum: float | None, pressure: float
) -> Iterator[Notice]:
    """Yield notices about metadata in the sidecar that contradict the command."""
    name = Path(trace.path).name
    if vacuum is not None and abs(vacuum - pressure) > 1e-6 * pressure:
        yield Notice(
            f"{name}: its file or sidecar states {show(pressure, 'Pa')}, which overrides --vacuum",
            "vacuum-stated",
        )
    brakes, brake_name = catalogue(), trace.facts.brake
    if brake_name not in brakes or brake_name == file.name:
        return
    differs = _describe_sheet_difference(load(brake_name).brake.sheets, file.brake.sheets)
    if differs or file.name in brakes:
        sentence = (
            f"{name}: its sidecar names the brake {brake_name}, but the brake given is {file.name}"
        )
        yield Notice(f"{sentence}{differs}", "other-brake")


def _describe_sheet_difference(file_sheets: Sheets, brake_sheets: Sheets) -> str:
    """Return the first dimension that differs between the sheets, as the end of a sentence."""
    for field in fields(Sheets):
        file_value = getattr(file_sheets, field.name)
        size = getattr(brake_sheets, field.name)
        if abs(file_value - size) > 0.01 * file_value:
            spec = get_spec(Sheets, field.name)
            return (
                f", whose {spec.text} is {show(size, spec.unit)}, not {show(file_value, spec.unit)}"
            )
    return ""


def _list_trace_notices(
    name: str, summary: "PullSummary", baseline: float | None
) -> Iterator[Notice]:
    """Yield notices about features of a pull that the law of a brake does not describe."""
    if baseline:
        yield Notice(
            f"{name}: the force is {show(baseline, 'N')} before the load rises: a preload or a "
            "load cell offset. It is not subtracted; --tare subtracts it, and depth curves can fit "
            "it (--free force_offset)",
            "preload",
        )
    if summary.cycles is not None:
        yield Notice(f"{name}: {summary.cycles}", "load-cycles")
    if summary.teeth is not None:
        yield Notice(
            f"{name}: stick–slip of ±{show(summary.teeth.amplitude, 'N')} about its "
            "midpoint: its peak shows static friction, whereas the law of a brake "
            "describes the midpoint",
            "stick-slip",
        )
    if summary.second_rise is not None:
        yield Notice(
            f"{name}: the force rises twice, as if the brake had been switched on while "
            "sliding. View each rise with 'layerjam pull --from --to', and use a file with "
            "one rise",
            "two-rises",
        )


def _find_pull_vacuum(trace: Trace, default: float | None, brake: Brake) -> float:
    if trace.facts.vacuum is not None:
        return float(check_vacuum(trace.facts.vacuum, brake, "vacuum in its sidecar"))
    if default is None:
        raise FitError(
            f"its vacuum is not stated. Give --vacuum, write "
            f'{Path(trace.path).name}.toml next to it with a line such as vacuum = "94.5 kPa", or '
            f"one {LIST} for the folder, or give a pattern for its name (--names '*_{{vacuum}}_*')"
        )
    return default


def read_pulls(
    files: Sequence[Measured] | Measured,
    file: BrakeFile,
    vacuum: float | None,
    options: ReadingOptions,
    test: "Callable[[PullFeatures, float, Brake], object]",
    progress: Progress | None = None,
    specimens_out: Mapping[str, Collection[str]] | None = None,
    tare: bool = False,
) -> "tuple[list[tuple[Trace, PullFeatures, float]], dict[str, str], list[str]]":
    """Return pulls with features and vacuums [Pa], rejected files, and notices about the others.

    `test` raises an error for an unusable pull; `specimens_out` are specimens excluded manually.
    `tare` subtracts the force before the rise.
    """
    from layerjam.laboratory.identify.pull.features import pull_features
    from layerjam.laboratory.identify.pull.summary import find_baseline, pull_summary, subtract_tare

    check_vacuum(vacuum or 0.0, file.brake)
    file_warnings: list[str] = []

    def reduce_pull(trace: Trace) -> "tuple[Trace, PullFeatures, float]":
        pressure = _find_pull_vacuum(trace, vacuum, file.brake)
        trace = subtract_tare(trace) if tare else trace
        pull = pull_features(trace)
        end, overlap = float(pull.elongation[-1]), file.brake.sheets.overlap
        if end > 2 * overlap:
            raise FitError(
                f"pulls to {show(end, 'm')}, but the sheets overlap by only "
                f"{show(overlap, 'm')}: check the unit of the elongation"
            )
        test(pull, pressure, file.brake)
        file_warnings.extend(trace.warnings)
        baseline = find_baseline(trace, pull)
        file_warnings.extend(
            _list_trace_notices(Path(trace.path).name, pull_summary(trace), baseline)
        )
        pull = replace(pull.thinned(CURVE), baseline=baseline)
        return trace.thinned(PICTURE), pull, pressure

    used, refusals = read_each(files, reduce_pull, options, progress, specimens_out)
    file_warnings += [w for t, _, p in used for w in metadata_notices(t, file, vacuum, p)]
    return used, refusals, file_warnings


def write_brake(
    out: str | Path | None,
    text: Callable[[str], str],
    overwrite: bool,
    refused: bool,
    partial: bool,
    verdict: Verdict | None = None,
) -> tuple[str | None, list[Notice]]:
    """Write a brake file unless a failed check or rejected files prevent this.

    Returns the path, None if nothing was written, and the notices.
    """
    if out is None or (verdict is not None and verdict.failed):
        return None, []
    if refused and not partial:
        sentence = (
            f"{out} was not written because files were rejected; use --partial to write it anyway"
        )
        return None, [Notice(sentence, "not-written")]
    content = text(Path(out).stem)
    BrakeFile.read(content, out)
    store_file(out, content, overwrite)
    return str(out), []

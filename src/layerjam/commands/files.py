"""What every command on measured files does: read each, name the refused, write a brake whole."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TypeVar

from layerjam.commands.answer import Quantity, vacuum_of
from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.device.load import catalogue, write_whole
from layerjam.errors import FileError, FitError, LayerjamError
from layerjam.identify.provenance import sha256
from layerjam.identify.pull.features import PullFeatures, pull_features
from layerjam.identify.pull.summary import off_zero, pull_summary
from layerjam.measure.options import ReadingOptions
from layerjam.measure.readers.read import open_traces
from layerjam.measure.trace import Trace
from layerjam.units import show

T = TypeVar("T")
Paths = Sequence[str | Path]
Progress = Callable[[str, float], None]
"""Told what is done and which share of it."""
CURVE, PICTURE = 10_000, 2_000
"""Samples of a pull, and of a record that is only drawn, that are kept once it has been read, so
that a gigabyte of files does not have to fit into memory. Means over neighbours: maxima, slopes and
noise are taken from all samples before."""


def each(
    files: Paths,
    use: Callable[[Trace], T],
    choices: ReadingOptions | None,
    progress: Progress | None = None,
) -> tuple[list[T], dict[str, str]]:
    """`use` of every file that can be used, and {file: why} of those that cannot.

    Where none can be used, the first one's reason is an error. What `use` returns is kept, so that
    it should not hold a long record. Ctrl-C goes on with the files read so far; the others count as
    refused.
    """
    done: list[T] = []
    refused: dict[str, str] = {}
    seen: dict[str, str] = {}
    said = choices or ReadingOptions()

    def refuse(name: str, path: str | Path, error: LayerjamError) -> None:
        if isinstance(error, FileError):
            line = f"line {error.line}: " if error.line else ""
            own = error.path == str(path)  # else the sidecar beside it
            refused[name] = line + error.reason if own else str(error)
        else:
            refused[name] = str(error).removeprefix(f"{path}: ")

    def take(path: str | Path) -> None:
        try:
            found = open_traces(path, said)
            digest = sha256(str(path))
            if digest in seen:
                raise FitError(f"holds the same measurement as {seen[digest]}, which counts once")
            seen[digest] = str(path)
        except LayerjamError as error:
            refuse(str(path), path, error)
            return
        for number, one in enumerate(found, 1):
            name = f"{path}, specimen {one.label or number}" if len(found) > 1 else str(path)
            try:
                done.append(use(one.read(said)))
            except LayerjamError as error:
                refuse(name, path, error)

    wanted = _measurements(files)
    for count, path in enumerate(wanted):
        whole = False
        try:
            take(path)
            whole = True
            if progress is not None:
                progress("reading files", (count + 1) / len(wanted))
        except KeyboardInterrupt:
            if not done:
                raise
            rest = map(str, wanted[count + whole :])
            refused |= dict.fromkeys(rest, "not read to its end: interrupted")
            break
    if not done:
        if not refused:
            raise FitError("no file was given")
        path, why = next(iter(refused.items()))
        more = f" ({len(refused) - 1} more files were refused too)" if len(refused) > 1 else ""
        raise FileError(path, why + more)
    return done, refused


def understood(traces: Iterable[Trace]) -> dict[str, list[str]]:
    """{file, and specimen where it holds several: what was made of it}."""
    return {
        f"{t.path}, specimen {t.specimen}" if t.specimen else t.path: list(t.understood)
        for t in traces
    }


def _measurements(files: Paths) -> list[str | Path]:
    """The files without the sidecars of others among them: `*` catches both."""
    given = {str(path) for path in files}
    return [p for p in files if str(p).removesuffix(".toml") not in given - {str(p)}]


def odd_facts(
    trace: Trace, file: BrakeFile, vacuum: Quantity | None, pressure: float
) -> Iterator[str]:
    """What the sidecar says against the command."""
    name = Path(trace.path).name
    if vacuum is not None and abs(vacuum_of(vacuum, file.brake) - pressure) > 1e-6 * pressure:
        yield f"{name}: its file or sidecar says {show(pressure, 'Pa')}, which counts, not --vacuum"
    known = catalogue()
    if trace.facts.brake in known and file.name in known and trace.facts.brake != file.name:
        yield f"{name}: its sidecar names the brake {trace.facts.brake}, this is {file.name}"


def _odd_record(trace: Trace) -> Iterator[str]:
    """What a pull shows that no law of a brake describes."""
    name, found = Path(trace.path).name, pull_summary(trace)
    if off_zero(found.start, found.features):
        yield (
            f"{name}: the force is {show(found.start.baseline, 'N')} before the load rises, a "
            "preload or the load cell's zero, and counts as it is; 'layerjam pull --tare' shows "
            "what it changes, depth curves can fit it (--free force_offset)"
        )
    if found.teeth is not None:
        yield (
            f"{name}: sticks and slips, {show(found.teeth.amplitude, 'N')} about its middle: its "
            "peak is static friction, and the law of a brake is that of the middle"
        )


def _vacuum(trace: Trace, given: Quantity | None, brake: Brake) -> float:
    if trace.facts.vacuum is not None:
        return vacuum_of(trace.facts.vacuum, brake, "vacuum in its sidecar")
    if given is None:
        raise FitError(
            f"nothing says at which vacuum it was pulled; give --vacuum, or write "
            f'{Path(trace.path).name}.toml beside it with a line such as vacuum = "94.5 kPa"'
        )
    return vacuum_of(given, brake)


def pulls(
    files: Paths,
    file: BrakeFile,
    vacuum: Quantity | None,
    choices: ReadingOptions | None,
    test: Callable[[PullFeatures, float, Brake], object],
    progress: Progress | None = None,
) -> tuple[list[tuple[Trace, PullFeatures, float]], dict[str, str], list[str]]:
    """Pulls with their features and vacuums [Pa], refused files, and what is odd about the rest.

    `test` raises for a pull that cannot be used.
    """
    if vacuum is not None:
        vacuum_of(vacuum, file.brake)

    odd: list[str] = []

    def use(trace: Trace) -> tuple[Trace, PullFeatures, float]:
        pressure = _vacuum(trace, vacuum, file.brake)
        pull = pull_features(trace)
        far, overlap = float(pull.elongation[-1]), file.brake.sheets.overlap
        if far > 2 * overlap:
            raise FitError(
                f"pulls to {show(far, 'm')}, but the sheets overlap by {show(overlap, 'm')}: is "
                "the unit of the elongation right?"
            )
        test(pull, pressure, file.brake)
        odd.extend(trace.warnings)
        odd.extend(_odd_record(trace))
        return trace.thinned(PICTURE), pull.thinned(CURVE), pressure

    used, refused = each(files, use, choices, progress)
    odd += [w for t, _, p in used for w in odd_facts(t, file, vacuum, p)]
    return used, refused, odd


def write_brake(
    out: str | Path | None, text: Callable[[str], str], force: bool, refused: bool, partial: bool
) -> tuple[str | None, list[str]]:
    """Write a brake's file unless refused files forbid it; its path and what to say."""
    if out is None:
        return None, []
    if refused and not partial:
        return None, [f"{out} was not written because files were refused; --partial writes it"]
    content = text(Path(out).stem)
    BrakeFile.read(content, out)
    write_whole(out, lambda p: _fill(p, content), force)
    return str(out), []


def _fill(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")

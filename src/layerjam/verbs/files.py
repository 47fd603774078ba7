"""What every command on measured files does: read each, name the refused, write a brake whole."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TypeVar

from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile, read_brake
from layerjam.device.load import catalogue, materials, write_whole
from layerjam.errors import FileError, FitError, LayerjamError
from layerjam.identify.columns import Choices
from layerjam.identify.provenance import sha256
from layerjam.identify.pull import PullFeatures, pull_features
from layerjam.identify.readers import open_traces
from layerjam.identify.trace import Trace
from layerjam.units import show
from layerjam.verbs.answer import Quantity, vacuum_of

T = TypeVar("T")
Paths = Sequence[str | Path]


def each(
    files: Paths, use: Callable[[Trace], T], choices: Choices | None
) -> tuple[list[T], dict[str, str]]:
    """`use` of every file that can be used, and {file: why} of those that cannot.

    Where none can be used, the first one's reason is an error.
    """
    done: list[T] = []
    refused: dict[str, str] = {}
    seen: dict[str, str] = {}
    said = choices or Choices()

    def refuse(name: str, path: str | Path, error: LayerjamError) -> None:
        if isinstance(error, FileError):
            line = f"line {error.line}: " if error.line else ""
            own = error.path == str(path)  # else the sidecar beside it
            refused[name] = line + error.reason if own else str(error)
        else:
            refused[name] = str(error).removeprefix(f"{path}: ")

    for path in _measurements(files):
        try:
            found = open_traces(path, said)
            digest = sha256(str(path))
            if digest in seen:
                raise FitError(f"holds the same measurement as {seen[digest]}, which counts once")
            seen[digest] = str(path)
        except LayerjamError as error:
            refuse(str(path), path, error)
            continue
        for number, one in enumerate(found, 1):
            name = f"{path}, specimen {one.label or number}" if len(found) > 1 else str(path)
            try:
                done.append(use(one.read(said)))
            except LayerjamError as error:
                refuse(name, path, error)
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
    choices: Choices | None,
    test: Callable[[PullFeatures, float, Brake], object],
) -> tuple[list[tuple[Trace, PullFeatures, float]], dict[str, str], list[str]]:
    """Pulls with their features and vacuums [Pa], refused files, and what is odd about the rest.

    `test` raises for a pull that cannot be used.
    """
    if vacuum is not None:
        vacuum_of(vacuum, file.brake)

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
        return trace, pull, pressure

    used, refused = each(files, use, choices)
    odd = [w for t, _, _ in used for w in t.warnings]
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
    read_brake(content, out, materials())
    write_whole(out, lambda p: _fill(p, content), force)
    return str(out), []


def _fill(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")

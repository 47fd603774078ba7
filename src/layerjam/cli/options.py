"""Options that several commands share, and what must hold before anything is computed."""

from __future__ import annotations

import contextlib
import os
import signal
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated

import typer

from layerjam.errors import FileError

if TYPE_CHECKING:
    from layerjam.measure.options import ReadingOptions

BrakeName = Annotated[
    str, typer.Argument(metavar="BRAKE", help="Catalogue name or path of a brake's TOML file.")
]
Files = Annotated[list[Path], typer.Argument(metavar="FILE...", help="Exports of a test machine.")]
Atmosphere = Annotated[
    str | None, typer.Option(metavar="Q", help="Atmosphere of the site, e.g. 95kPa.")
]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object in SI units, nothing else.")]
Figure = Annotated[Path | None, typer.Option(metavar="FILE", help="Draw it: .svg, .png or .pdf.")]
Force = Annotated[bool, typer.Option("--force", "--replace", help="Replace files that exist.")]
Replace = Annotated[bool, typer.Option("--replace", help="Replace a figure that exists.")]
Vacuum = Annotated[
    str, typer.Option(metavar="Q", help="Vacuum: atmosphere less the pressure inside, 94.5kPa.")
]
Slip = Annotated[str, typer.Option(metavar="Q", help="Slip of the sheets, e.g. 20mm.")]
FileVacuum = Annotated[
    str | None, typer.Option(metavar="Q", help="Vacuum of files whose sidecar does not say it.")
]
Partial = Annotated[
    bool, typer.Option("--partial", help="Write the brake even if some files were refused.")
]
OutBrake = Annotated[
    Path | None, typer.Option("--out", metavar="FILE.toml", help="Brake file to write.")
]

Negative = Annotated[
    list[str] | None,
    typer.Option(metavar="force|elongation", help="The machine counts this one negative."),
]
Column = Annotated[
    list[str] | None,
    typer.Option(
        metavar="ROLE[:UNIT]=NAME", help="Which column is force, elongation or time, in what unit."
    ),
]
Columns = Annotated[
    str | None,
    typer.Option(
        metavar="ROLE:UNIT,skip,...", help="Every column in order: time:ms,force:N,elongation:mm."
    ),
]
Decimal = Annotated[str | None, typer.Option(metavar=". or ,", help="Decimal sign of the files.")]
Specimen = Annotated[
    int | None, typer.Option(metavar="N", help="Which specimen of files that hold several.")
]
Sheet = Annotated[str | None, typer.Option(metavar="NAME", help="Which sheet of workbooks.")]


def choices(
    negative: list[str] | None,
    column: list[str] | None,
    decimal: str | None,
    columns: str | None = None,
    specimen: int | None = None,
    sheet: str | None = None,
) -> ReadingOptions | None:
    """What the user says of the files where they leave something open."""
    if not (negative or column or decimal or columns or sheet) and specimen is None:
        return None
    from layerjam.measure.options import ReadingOptions

    return ReadingOptions(
        negative=negative or (),
        column=column or (),
        columns=columns,
        decimal=decimal,
        specimen=specimen,
        sheet=sheet,
    )


def engine() -> None:
    """Switch JAX to double precision, with compiled code kept in the user's cache folder.

    Called by every command that computes, and only then: importing JAX takes half a second.
    """
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
    with _uninterrupted():
        import jax
        import platformdirs
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler and _is_main():
        signal.signal(signal.SIGINT, _interrupted)
    jax.config.update("jax_enable_x64", True)
    cache = Path(platformdirs.user_cache_dir("layerjam")) / "compiled"
    try:
        cache.mkdir(parents=True, exist_ok=True)
        writable = os.access(cache, os.W_OK)
    except OSError:
        writable = False
    if writable:
        jax.config.update("jax_compilation_cache_dir", str(cache))
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
        jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)


def _is_main() -> bool:
    return threading.current_thread() is threading.main_thread()


def _interrupted(number: int, frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt, but not in JAX's callback of the garbage collector.

    Python prints and drops what is raised there, and the program would go on: asked again later.
    """
    at = frame
    while at is not None:
        if at.f_code.co_name == "_xla_gc_callback":
            again = threading.Timer(0.02, signal.raise_signal, (number,))
            again.daemon = True
            again.start()
            return
        at = at.f_back
    signal.default_int_handler(number, frame)


@contextlib.contextmanager
def _uninterrupted() -> Iterator[None]:
    """Keep an interrupt until the end: amid the loading of compiled modules it crashes Python."""
    before = signal.getsignal(signal.SIGINT)
    if before is None or not _is_main():
        yield
        return
    caught: list[int] = []
    signal.signal(signal.SIGINT, lambda number, _: caught.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if caught:
        signal.raise_signal(signal.SIGINT)


def check_figure(path: Path | None, force: bool, flag: str = "--force") -> None:
    """Refuse a figure that could not be drawn or written, before anything is computed."""
    check_target(path, force, (".svg", ".png", ".pdf"), flag)
    if path is not None:
        from layerjam.report.style import look

        with look():
            pass


def check_target(
    path: Path | None, force: bool, endings: tuple[str, ...], flag: str = "--force"
) -> None:
    """Refuse an output file of another kind, or one that exists unless `force` (option `flag`)."""
    if path is None:
        return
    if path.suffix.lower() not in endings:
        known = f"{', '.join(endings[:-1])} or {endings[-1]}" if len(endings) > 1 else endings[0]
        raise FileError(path, f"the ending '{path.suffix}' is not known; use {known}")
    try:
        there = os.path.lexists(path)
        if there and not path.is_file():
            raise FileError(path, "is a folder or no regular file")
        if there and not force:
            raise FileError(path, f"exists already; {flag} replaces it")
        if not path.parent.is_dir():
            raise FileError(path, f"cannot be written: there is no folder {path.parent}")
        if not os.access(path.parent, os.W_OK):
            raise FileError(path, f"cannot be written: the folder {path.parent} is read-only")
        if len(os.fsencode(path.name)) > 200:
            raise FileError(f"{path.name[:60]}...", "cannot be written: the name is too long")
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise FileError(str(path)[:200], f"cannot be written: {reason}") from None


def hidden_keys(file: str | None, *keys: str) -> tuple[str, ...]:
    """Keys of an answer that are not printed as a line; `file` only where one was written."""
    return keys if file else (*keys, "file")

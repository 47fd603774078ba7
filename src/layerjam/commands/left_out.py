"""Files that are left out by hand, each with its reason, which stays with the result."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

from layerjam.commands.declare import Help, options
from layerjam.commands.reading import Measured, several
from layerjam.errors import QuantityError
from layerjam.measure.trace import Trace


@options
class LeftOut:
    """Which files are left out, and why."""

    exclude: Annotated[
        Sequence[str] | Mapping[str, str],
        Help("Leave this file out; say why with --because.", metavar="FILE"),
    ] = ()
    because: Annotated[
        Sequence[str], Help("Why, one for each --exclude in their order.", metavar="TEXT")
    ] = ()

    def reasons(self) -> dict[str, str]:
        """{file as it was named: why}; QuantityError where one of the two is missing."""
        if isinstance(self.exclude, Mapping):
            if self.because:
                raise QuantityError.of("because", "the reasons stand with the files already")
            named, reasons = list(self.exclude), list(self.exclude.values())
        else:
            named, reasons = _texts(self.exclude), _texts(self.because)
        if len(named) != len(reasons):
            raise QuantityError.of(
                "exclude",
                f"{len(named)} named, {len(reasons)} reason{'s' * (len(reasons) != 1)} given; "
                "say of each why it is left out: --exclude FILE --because TEXT",
            )
        for name, why in zip(named, reasons, strict=True):
            if not why.strip():
                raise QuantityError.of("because", f"is empty for {name}; say why it is left out")
        if len(set(named)) < len(named):
            twice = next(name for name in named if named.count(name) > 1)
            raise QuantityError.of("exclude", f"{twice} is named twice")
        return dict(zip(named, (why.strip() for why in reasons), strict=True))

    def apart(
        self, files: Sequence[Measured] | Measured
    ) -> tuple[list[Measured], list[dict[str, Any]]]:
        """The other files, and of each that is left out `file`, `because` and `sha256`.

        A file is named by its path, or by its name alone where only one has it. Raises
        QuantityError for a name that is none of the files', and where no file is left.
        """
        kept, given = several(files), several(files)
        out = []
        for name, why in self.reasons().items():
            source = _named(name, given)
            kept.remove(source)
            out.append({"file": _path(source), "because": why, "sha256": _digest(source)})
        if out and not kept:
            raise QuantityError.of("exclude", "names every file; none is left")
        return kept, out

    def among(self, *groups: Sequence[Measured]) -> Iterator[LeftOut]:
        """The same for each of several groups of files; a name must be in one of them."""
        reasons, known = self.reasons(), {_path(f): f for some in groups for f in some}
        found = {_path(_named(name, [*known.values()])): why for name, why in reasons.items()}
        for some in groups:
            paths = {_path(f) for f in some}
            yield LeftOut(exclude={p: why for p, why in found.items() if p in paths})


def excluded_lines(excluded: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """What was left out, and why, as lines for people."""
    if excluded:
        yield from ("", "left out")
    for one in excluded:
        yield f"  {one['file']}: {one['because']}"


def _texts(given: Sequence[str]) -> list[str]:
    return [given] if isinstance(given, str) else list(given)


def _path(source: Measured) -> str:
    return source.path if isinstance(source, Trace) else str(source)


def _named(name: str, files: Sequence[Measured]) -> Measured:
    """The one file of that path, or of that name."""
    same = [f for f in files if _path(f) == name]
    same = same or [f for f in files if Path(_path(f)).name == name]
    if len(same) == 1:
        return same[0]
    if same:
        paths = ", ".join(map(_path, same))
        raise QuantityError.of("exclude", f"{name} is the name of several files: {paths}")
    paths = ", ".join(_path(f) for f in files[:6]) + ", ..." * (len(files) > 6)
    raise QuantityError.of("exclude", f"{name} is none of the files given: {paths}")


def _digest(source: Measured) -> str | None:
    from layerjam.identify.provenance import sha256

    path = _path(source)
    return sha256(path) if path and Path(path).is_file() else None

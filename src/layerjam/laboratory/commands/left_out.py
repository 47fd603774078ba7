"""Files and specimens that a result leaves out, each with a reason that the result states.

A specimen of a file that contains several is named as in results: `FILE, specimen LABEL`.
"""

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, TypeVar

from layerjam.core.command.declare import Help, options
from layerjam.core.errors import QuantityError, count_text
from layerjam.laboratory.commands.reading import Measured, list_files
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.laboratory.measure.trace import Trace

Name = TypeVar("Name", str, tuple[str, str])
SEPARATOR = ", specimen "
"""Text between the names of a file and of a specimen."""
Specimens = Mapping[str, Collection[str]]
"""{file: its excluded specimens}."""


@options
class LeftOut:
    """Excluded files and specimens, with reasons."""

    exclude: Annotated[
        Sequence[str] | Mapping[str, str],
        Help(
            "Exclude this file, or one of its specimens ('FILE, specimen NAME'); give the "
            "reason with --because.",
            metavar="FILE",
        ),
    ] = ()
    because: Annotated[
        Sequence[str], Help("Reason, one for each --exclude, in the same order.", metavar="TEXT")
    ] = ()

    def reasons(self) -> dict[str, str]:
        """Return {file as named: reason}; raises QuantityError if either is missing."""
        if isinstance(self.exclude, Mapping):
            if self.because:
                raise QuantityError.of("because", "the reasons are already stored with the files")
            names, reasons = list(self.exclude), list(self.exclude.values())
        else:
            names, reasons = _make_list(self.exclude), _make_list(self.because)
        if len(names) != len(reasons):
            raise QuantityError.of(
                "exclude",
                f"{len(names)} excluded, {count_text(len(reasons), 'reason')} given; give a "
                "reason for each: --exclude FILE --because TEXT",
            )
        for name, reason in zip(names, reasons, strict=True):
            if not reason.strip():
                raise QuantityError.of(
                    "because", (f"is empty for {name}; give the reason for excluding it")
                )
        return _unique_pairs((n, reason.strip()) for n, reason in zip(names, reasons, strict=True))

    def split_excluded(
        self, files: Sequence[Measured] | Measured, options: ReadingOptions
    ) -> tuple[list[Measured], Specimens, list[dict[str, Any]]]:
        """Return the remaining files, their excluded specimens, and a list of all exclusions.

        The list contains `file` (with its specimen), `because`, `sha256` and `automatic` (False).
        A file is named by its path, or by its name if that is unique. Raises QuantityError if a
        name matches no file, if the file does not contain the specimen, or if nothing is left.
        Raises FileError if a file with a named specimen cannot be read.
        """
        sources, meanings = list_files(files), self._resolve_reasons(list_files(files))
        by_name = {_source_name(f): f for f in sources}
        labels_of: defaultdict[str, set[str]] = defaultdict(set)
        for path, label in meanings:
            if label:
                labels_of[path].add(label)
        in_file = {
            path: _pick_specimens(by_name[path], labels, options)
            for path, labels in labels_of.items()
        }
        paths = {path for path, label in meanings if not label}
        paths |= {path for path, labels in labels_of.items() if labels == in_file[path]}
        sources_left = [f for f in sources if _source_name(f) not in paths]
        if meanings and not sources_left:
            raise QuantityError.of("exclude", "names every file; none is left")
        out = [
            {
                "file": _full_name(path, label),
                "because": reason,
                "sha256": _hash_source(by_name[path]),
                "automatic": False,
            }
            for (path, label), reason in meanings.items()
        ]
        return sources_left, labels_of, out

    def split_groups(self, *groups: Sequence[Measured]) -> "Iterator[LeftOut]":
        """Yield the exclusions of each group of files; every name must occur in some group."""
        meanings = self._resolve_reasons(
            [*{_source_name(f): f for group in groups for f in group}.values()]
        )
        for group in groups:
            paths = {_source_name(f) for f in group}
            yield LeftOut(
                exclude={
                    _full_name(p, label): w for (p, label), w in meanings.items() if p in paths
                }
            )

    def _resolve_reasons(self, files: Sequence[Measured]) -> dict[tuple[str, str], str]:
        """Return {(path, specimen or "" for the whole file): reason}."""
        return _unique_pairs(
            (_resolve_source(name, files), reason) for name, reason in self.reasons().items()
        )


def exclusion_row(source: Measured, reason: str) -> dict[str, Any]:
    """Return the row of a file that no user excluded: `file`, `because`, `sha256`, `automatic`."""
    return {
        "file": _source_name(source),
        "because": reason,
        "sha256": _hash_source(source),
        "automatic": True,
    }


def name_automatic(rows: Iterable[Mapping[str, Any]]) -> str:
    """Return the names of the files that were left out automatically; empty if none were."""
    return ", ".join(Path(row["file"]).name for row in rows if row["automatic"])


def exclusion_lines(rows: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield the files left out, with reasons, as lines of text."""
    if rows:
        yield from ("", "left out")
    for row in rows:
        origin = "automatically, because " if row["automatic"] else ""
        yield f"  {row['file']}: {origin}{row['because']}"


def _make_list(texts: Sequence[str]) -> list[str]:
    return [texts] if isinstance(texts, str) else list(texts)


def _unique_pairs(pairs: Iterable[tuple[Name, str]]) -> dict[Name, str]:
    """Return the pairs as a dictionary; raises QuantityError if a name occurs twice."""
    reasons_by_name: dict[Name, str] = {}
    for name, reason in pairs:
        if name in reasons_by_name:
            twice = name if isinstance(name, str) else _full_name(*name)
            raise QuantityError.of("exclude", f"{twice} is named twice")
        reasons_by_name[name] = reason
    return reasons_by_name


def _full_name(path: str, specimen: str) -> str:
    return f"{path}{SEPARATOR}{specimen}" if specimen else path


def _source_name(source: Measured) -> str:
    return _full_name(source.path, source.specimen) if isinstance(source, Trace) else str(source)


def _resolve_source(name: str, files: Sequence[Measured]) -> tuple[str, str]:
    """Return the path and specimen to which a name refers; the specimen of a whole file is ""."""
    parts = name.split(SEPARATOR)
    for count in range(len(parts), 0, -1):
        source = _match_path(SEPARATOR.join(parts[:count]), files)
        if source is not None:
            return source, SEPARATOR.join(parts[count:])
    paths = ", ".join(map(_source_name, files[:6])) + ", ..." * (len(files) > 6)
    raise QuantityError.of("exclude", f"{name} is not one of the files given: {paths}")


def _match_path(name: str, files: Sequence[Measured]) -> str | None:
    """Return the file with that path or unique name; None if there is none."""
    matches = [f for f in files if _source_name(f) == name]
    matches = matches or [f for f in files if Path(_source_name(f)).name == name]
    if len(matches) > 1:
        paths = ", ".join(map(_source_name, matches))
        raise QuantityError.of("exclude", f"{name} is the name of several files: {paths}")
    return _source_name(matches[0]) if matches else None


def _pick_specimens(
    source: Measured, labels_out: Collection[str], options: ReadingOptions
) -> set[str]:
    """Return the named specimens of a file; raises QuantityError if it lacks one of them."""
    from layerjam.laboratory.measure.readers.read import open_traces

    path, labels = _source_name(source), []
    if not isinstance(source, Trace):
        labels = [s.label for s in open_traces(source, options)]
    if len(labels) < 2:
        sentence = "has only one specimen; exclude it by the file name alone"
        raise QuantityError.of("exclude", f"{path} {sentence}")
    for label in labels_out:
        if labels.count(label) != 1:
            text = ", ".join(f"'{s[:30]}'" for s in labels[:6]) + ", ..." * (len(labels) > 6)
            count_word = "no" if label not in labels else "more than one"
            raise QuantityError.of(
                "exclude", f"{path} contains {count_word} specimen '{label}': {text}"
            )
    return set(labels)


def _hash_source(source: Measured) -> str | None:
    from layerjam.laboratory.identify.provenance import sha256

    path = source.path if isinstance(source, Trace) else str(source)
    return sha256(path) if path and Path(path).is_file() else None

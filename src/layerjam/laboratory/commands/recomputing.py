"""The `recompute` command: computes a published dataset again and compares it file by file."""

import json
import tempfile
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from layerjam.core.command.declare import Progress
from layerjam.core.errors import FileError, LayerjamError, MissingExtraError
from layerjam.core.verdict import Acceptance
from layerjam.laboratory.commands.dataset_stages import STAGES, derive_results, describe_dataset
from layerjam.laboratory.dataset import checksums, crate
from layerjam.laboratory.dataset.comparison import (
    count_numbers,
    diff_files,
    diff_numbers,
    diff_values,
    index_entries,
    prune_items,
)
from layerjam.laboratory.dataset.crate import BRAKE, LINE, METADATA, RAW, README, REPORT, RESULTS
from layerjam.laboratory.dataset.recipe import (
    FORMAT,
    RECIPE,
    Recipe,
    list_program_versions,
    read_recipe,
)
from layerjam.laboratory.dataset.text_comparison import Difference
from layerjam.laboratory.dataset.unpack import open_root
from layerjam.laboratory.identify.provenance import sha256

EXACT = (README, RECIPE)
"""Computed files without computed numbers: every byte is compared."""


@dataclass
class _Comparison:
    """Comparison, in progress, of a dataset in `root` with its recomputed files."""

    root: Path
    recipe: Recipe
    changed: Collection[str]
    numbers: int = 0
    found: list[Difference] = field(default_factory=list)
    not_compared: dict[str, str] = field(default_factory=dict)

    @property
    def equal(self) -> bool | None:
        """Whether everything is as published; None if that is not known of a part."""
        return False if self.found else None if self.not_compared else True

    def compare_file(self, name: str, content: bytes) -> None:
        """Compare a published file, or only its numbers if a different version wrote it."""
        path, versions_note = self.root / name, self._list_versions()
        if not path.is_file():
            if name in self.changed:
                return
            if versions_note:
                self.not_compared[name] = f"it is not in the dataset: {versions_note}"
            else:
                self.found.append(Difference("the file", name, None, "computed"))
            return
        original = path.read_bytes()
        self.numbers += count_numbers(name, content)
        differences = list(diff_files(name, original, content))
        if not differences and name in EXACT and original != content:
            differences = [Difference("text", name, "written differently", None)]
        if differences and versions_note:
            try:
                differences = list(self._compare_numbers(name, original, content))
            except ValueError:
                differences = [Difference("text", name, "cannot be read", None)]
            if not differences:
                self.not_compared[name] = f"its text and drawings: {versions_note}"
        self.found += differences

    def compare_description(self, text: str) -> None:
        """Compare ro-crate-metadata.json, except files whose checksums already differ."""
        path = self.root / METADATA
        content = path.read_bytes() if path.is_file() else b""
        if content == text.encode():
            return
        try:
            original = json.loads(content)
        except (ValueError, RecursionError):
            original = {}
        left_out = {crate.relative_address(name) for name in self.changed}
        before, local = (
            index_entries(prune_items(d, left_out)) for d in (original, json.loads(text))
        )
        differences = list(diff_values(before, local, METADATA, words=True))
        if not (differences or left_out):
            differences = [Difference("text", METADATA, "written differently", None)]
        self.found += differences

    def _compare_numbers(self, name: str, original: bytes, content: bytes) -> Iterator[Difference]:
        if name == RECIPE:  # its numbers are inputs, from which everything else is computed
            return iter(())
        if name != RESULTS:
            return diff_numbers(name, original, content)
        documents = (json.loads(text) for text in (original, content))
        before, local = (
            {s: document[s] for s in STAGES if document.get(s)} for document in documents
        )
        return diff_values(before, local, name)

    def _list_versions(self) -> str:
        """Return, as text, the different versions that wrote the dataset.

        It is empty if there are none.
        """
        original, local = self.recipe.versions, list_program_versions()
        differing = [
            f"{n} {v}, here {local.get(n, 'none')}"
            for n, v in original.items()
            if local.get(n) != v
        ]
        if self.recipe.format < FORMAT:
            differing.append(f"format {self.recipe.format} of the recipe")
        return "; ".join(differing)


def recompute_dataset(source: Path, cited: str | None, progress: Progress) -> dict[str, Any]:
    """Recompute everything in a dataset, whose fingerprint should begin with `cited`.

    Returns the values of the result's keys, and the accepted failed checks as `decisions`.
    """
    with (
        open_root(source) as (root, beside),
        tempfile.TemporaryDirectory(prefix="layerjam-again-") as folder,
    ):
        recipe, (checksums_listed, strange) = read_recipe(root), checksums.read_checksums(root)
        changed_files = checksums.find_changed_files(root, checksums_listed)
        names_left = {checksums.NAME, *((METADATA,) if recipe.stated is None else ())}
        added_files = [
            n for n in checksums.map_files(root) if n not in {*checksums_listed, *names_left}
        ] + beside
        if (root / REPORT / "report.pdf").is_file():
            with MissingExtraError.raise_if_missing("the PDF of a dataset (typst)", "publish"):
                import typst  # noqa: F401
        if strange or not checksums_listed:
            changed_files.append(checksums.NAME)
        work = _Comparison(root, recipe, changed_files)
        work.found += [Difference(f"line {n}", checksums.NAME, t, None) for n, t in strange]
        acceptances: Iterable[Acceptance] = ()
        try:
            files_again, content = derive_results(root, recipe, Path(folder), progress)
        except LayerjamError as error:
            work.found.append(_recomputation_failure(error, root))
        else:
            acceptances = content.accepted
            names = sorted(checksums.list_files(Path(folder)), key=lambda name: name != RESULTS)
            for name in names:
                work.compare_file(name, (Path(folder) / name).read_bytes())
            inputs = {BRAKE, LINE, METADATA, checksums.NAME, *(() if recipe.stated else (README,))}
            for name in sorted({*checksums_listed} - inputs - {*names, *changed_files}):
                if not name.startswith(f"{RAW}/"):
                    work.found.append(Difference("the file", name, "published", None))
            if recipe.stated is None:
                reason = f"format {recipe.format} of the recipe states no title and no authors"
                work.not_compared |= dict.fromkeys((README, METADATA), reason)
            else:
                files = [name for name in checksums_listed if name not in changed_files]
                work.compare_description(
                    describe_dataset(root, files, files_again, recipe.stated, content)
                )
        listing = root / checksums.NAME
        fingerprint = sha256(listing) if listing.is_file() else None
        if cited is not None and not (fingerprint or "").startswith(cited):
            work.found.append(Difference("fingerprint", checksums.NAME, cited, fingerprint))
        return dict(
            equal=False if changed_files or added_files else work.equal,
            numbers=work.numbers,
            differs=[vars(difference) for difference in work.found],
            changed_files=changed_files,
            added_files=added_files,
            not_compared=work.not_compared,
            fingerprint=fingerprint,
            versions={"published": dict(recipe.versions), "recomputed": list_program_versions()},
            record=work.found,
            decisions=tuple(acceptances),
        )


def _recomputation_failure(error: LayerjamError, root: Path) -> Difference:
    """Return the difference for a dataset whose files yield no results."""
    path = Path(error.path) if isinstance(error, FileError) else root / RECIPE
    is_inside = path.is_relative_to(root)
    name = path.relative_to(root).as_posix() if is_inside else RECIPE
    return Difference(f"nothing can be computed: {error}", name, None, None)

"""`recompute`: derive everything in a published dataset again, and compare file by file."""

import json
import tempfile
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from layerjam.commands.dataset_stages import STAGES, derive, describe
from layerjam.commands.declare import Progress
from layerjam.dataset import checksums, crate
from layerjam.dataset.comparison import (
    Difference,
    by_name,
    count,
    differences,
    file_differences,
    number_differences,
    prune,
)
from layerjam.dataset.crate import BRAKE, LINE, METADATA, RAW, README, REPORT, RESULTS
from layerjam.dataset.recipe import FORMAT, RECIPE, Recipe, read_recipe, versions
from layerjam.dataset.unpack import open_root
from layerjam.errors import FileError, LayerjamError, MissingExtraError
from layerjam.identify.provenance import sha256
from layerjam.verdict import Acceptance


@dataclass
class _Comparison:
    """Comparison of a dataset in `root` with its recomputed files, as far as it went."""

    root: Path
    recipe: Recipe
    changed: Collection[str]
    numbers: int = 0
    found: list[Difference] = field(default_factory=list)
    not_compared: dict[str, str] = field(default_factory=dict)

    def file(self, name: str, recomputed: bytes) -> None:
        """Compare a published file; by its numbers alone if other versions wrote it."""
        path = self.root / name
        if not path.is_file():
            if self.recipe.format == FORMAT and name not in self.changed:
                self.found.append(Difference("the file", name, None, "computed"))
            return
        published = path.read_bytes()
        self.numbers += count(name, recomputed)
        found = list(file_differences(name, published, recomputed))
        if found and (others := self._others()):
            try:
                found = list(self._numbers(name, published, recomputed))
            except ValueError:
                found = [Difference("text", name, "cannot be read", None)]
            if not found:
                self.not_compared[name] = f"its words and drawings: {others}"
        self.found += found

    def description(self, recomputed: str) -> None:
        """Compare ro-crate-metadata.json, without the files whose checksum differs already."""
        path = self.root / METADATA
        try:
            published = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
        except (ValueError, RecursionError):
            published = {}
        left_out = {crate.address(name) for name in self.changed}
        was, now = (by_name(prune(d, left_out)) for d in (published, json.loads(recomputed)))
        self.found += differences(was, now, METADATA, words=True)

    def _numbers(self, name: str, published: bytes, recomputed: bytes) -> Iterator[Difference]:
        if name != RESULTS:
            return number_differences(name, published, recomputed)
        whole = (json.loads(text) for text in (published, recomputed))
        was, now = ({s: one[s] for s in STAGES if one.get(s)} for one in whole)
        return differences(was, now, name)

    def _others(self) -> str:
        """Which other versions wrote the dataset, in words; empty if these did."""
        then, now = self.recipe.versions, versions()
        other = [f"{n} {v}, here {now.get(n, 'none')}" for n, v in then.items() if now.get(n) != v]
        if self.recipe.format < FORMAT:
            other.append(f"form {self.recipe.format} of the recipe")
        return "; ".join(other)


def recompute_dataset(source: Path, tell: Progress) -> dict[str, Any]:
    """Compute everything in a dataset again.

    Returns the values of the result's keys, and as `decisions` the failed checks that are accepted.
    """
    with open_root(source) as root, tempfile.TemporaryDirectory(prefix="layerjam-again-") as made:
        recipe, (listed, strange) = read_recipe(root), checksums.read(root)
        changed = checksums.changed(root, listed)
        unlisted = {checksums.NAME, *((METADATA,) if recipe.format < FORMAT else ())}
        added = [n for n in checksums.everything(root) if n not in {*listed, *unlisted}]
        if (root / REPORT / "report.pdf").is_file():
            with MissingExtraError.raise_if_missing("the PDF of a dataset (typst)", "publish"):
                import typst  # noqa: F401
        if strange or not listed:
            changed.append(checksums.NAME)
        work = _Comparison(root, recipe, changed)
        work.found += [Difference(f"line {n}", checksums.NAME, t, None) for n, t in strange]
        accepted: Iterable[Acceptance] = ()
        try:
            again, content = derive(root, recipe, Path(made), tell)
        except LayerjamError as error:
            work.found.append(_failure(error, root))
        else:
            accepted = content.accepted
            names = sorted(checksums.inside(Path(made)), key=lambda name: name != RESULTS)
            for name in names:
                work.file(name, (Path(made) / name).read_bytes())
            inputs = {BRAKE, LINE, METADATA, checksums.NAME, *(() if recipe.stated else (README,))}
            for name in sorted({*listed} - inputs - {*names, *changed}):
                if not name.startswith(f"{RAW}/"):
                    work.found.append(Difference("the file", name, "published", None))
            if recipe.stated is not None:
                files = [name for name in listed if name not in changed]
                work.description(describe(root, files, again, recipe.stated, content))
        fingerprint = root / checksums.NAME
        return dict(
            equal=not (work.found or changed or added),
            numbers=work.numbers,
            differs=[vars(one) for one in work.found],
            changed_files=changed,
            added_files=added,
            not_compared=work.not_compared,
            fingerprint=sha256(fingerprint) if fingerprint.is_file() else None,
            versions={"published": dict(recipe.versions), "recomputed": versions()},
            record=work.found,
            decisions=tuple(accepted),
        )


def _failure(error: LayerjamError, root: Path) -> Difference:
    """The difference that nothing can be computed from the files as they are."""
    path = Path(error.path) if isinstance(error, FileError) else root / RECIPE
    inside = path.is_relative_to(root)
    name = path.relative_to(root).as_posix() if inside else RECIPE
    return Difference(f"nothing can be computed: {error}", name, None, None)

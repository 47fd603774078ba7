"""What a dataset says of itself is no proof: its form, its versions, its names, its inputs."""

from __future__ import annotations

import json
import shutil
import unicodedata
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from laboratory.dataset.forger import (
    CRATE,
    HTML,
    PDF,
    RESULTS,
    SUMS,
    Doctor,
    attacked,
    digest,
    gone,
    older,
    other_versions,
    seal,
    swap,
)
from layerjam.core.errors import QuantityError
from layerjam.laboratory.commands import recomputing
from layerjam.laboratory.commands.publish import Published, recompute
from layerjam.laboratory.measure.readers.read import UnreadSpecimen

DERIVE = recomputing.derive_results
pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("derived_once")]


WORDS = swap(HTML, "Synthetic data: [^<]*", "Measured data.")
CURVE = swap("report/figures/validation.svg", r"stroke-width: \d", "stroke-width: 9")


def without_page(root: Path) -> None:
    for name in (HTML, PDF, "report/figures/validation.svg"):
        gone(name)(root)


@pytest.mark.parametrize("form", [older(1), older(2), other_versions], ids=["1", "2", "versions"])
@pytest.mark.parametrize("doctor", [WORDS, CURVE, without_page, lambda _: None])
def test_what_a_dataset_says_of_itself_never_makes_it_equal(
    published: Published, tmp_path: Path, form: Doctor, doctor: Doctor
) -> None:
    copy = attacked(published, tmp_path, form)
    doctor(copy)
    seal(copy)
    found = recompute(copy)
    assert found.equal is not True and found.exit_code == 1
    assert found.equal is False or found.not_compared


def test_a_downgrade_alone_is_not_comparable(published: Published, tmp_path: Path) -> None:
    found = recompute(attacked(published, tmp_path, lambda root: (older(2)(root), seal(root))))
    assert found.equal is None and found.exit_code == 1 and not found.differs
    assert json.loads(found.json())["equal"] is None
    assert "recipe.json" in found.not_compared
    assert "equal          not comparable" in str(found)


def new_author(root: Path) -> None:
    """Another author, everywhere."""
    for path in (root / "recipe.json", root / CRATE):
        path.write_text(path.read_text().replace("Ada Lovelace", "Charles Babbage"))


def new_licence(root: Path) -> None:
    """Another licence, everywhere."""
    for path in (root / "recipe.json", root / CRATE, root / "README.md"):
        path.write_text(path.read_text().replace("CC-BY-4.0", "CC0-1.0"))


@pytest.mark.parametrize(
    "doctor",
    [new_author, new_licence, swap("data/notes.txt", "lunch", "midnight")],
    ids=["author", "licence", "notes"],
)
def test_a_changed_input_shows_in_the_fingerprint(
    published: Published, tmp_path: Path, doctor: Doctor
) -> None:
    cited = digest(Path(published.folder) / SUMS)
    assert f"--fingerprint {cited[:16]}" in str(published) and published.fingerprint == cited
    assert recompute(published.folder, fingerprint=cited[:16].upper()).equal is True
    copy = attacked(published, tmp_path, doctor)
    seal(copy)
    blind = recompute(copy)
    assert blind.equal is True, str(blind)
    assert "fingerprint" in [w.key for w in blind.warnings]
    found = recompute(copy, fingerprint=cited)
    assert found.equal is False and found.exit_code == 1
    assert [row["number"] for row in found.differs] == ["fingerprint"]
    with pytest.raises(QuantityError, match="fingerprint"):
        recompute(copy, fingerprint="Ada")


def test_decomposed_names_are_the_same_names(published: Published, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    for path in sorted(Path(published.folder).rglob("*")):
        name = path.relative_to(published.folder).as_posix()
        target = copy / unicodedata.normalize("NFD", name)
        target.parent.mkdir(parents=True, exist_ok=True)
        if path.is_file():
            shutil.copyfile(path, target)
    assert any("\u0308" in path.name for path in copy.rglob("*"))
    packed = shutil.make_archive(str(tmp_path / "sent"), "zip", copy)
    for source in (copy, packed):
        found = recompute(source)
        assert found.equal is True, str(found)


def test_a_file_beside_the_dataset_is_named(published: Published, tmp_path: Path) -> None:
    folder = tmp_path / "sent"
    shutil.copytree(published.folder, folder / "dataset")
    assert recompute(folder).equal is True
    (folder / "better numbers.csv").write_text("1\n")
    packed = shutil.make_archive(str(tmp_path / "packed"), "zip", folder)
    for source in (folder, packed):
        found = recompute(source)
        assert found.equal is False and found.added_files == ["../better numbers.csv"]


@pytest.mark.parametrize("part", [1e-10, -1e-9])
def test_another_processor_is_not_a_forger(
    published: Published, monkeypatch: pytest.MonkeyPatch, part: float
) -> None:
    """All forces differ by less than a millionth: every drawing and the PDF have other bytes."""
    read = UnreadSpecimen.read

    def rounded(self: UnreadSpecimen, *args: Any) -> Any:
        trace = read(self, *args)
        return replace(trace, force=trace.force * (1 + part))

    monkeypatch.setattr(UnreadSpecimen, "read", rounded)
    monkeypatch.setattr(recomputing, "derive_results", DERIVE)
    content: dict[str, bytes] = {}
    compare = recomputing._Comparison.compare_file

    def kept(self: Any, name: str, data: bytes) -> None:
        content[name] = data
        compare(self, name, data)

    monkeypatch.setattr(recomputing._Comparison, "compare_file", kept)
    found = recompute(published.folder)
    assert found.equal is True, str(found)
    root = Path(published.folder)
    assert content[RESULTS] != (root / RESULTS).read_bytes()
    assert content["README.md"] == (root / "README.md").read_bytes()

"""Checksums, differences, licences, recipes and zip files of published datasets."""

from __future__ import annotations

import json
import shutil
import stat
import subprocess
import zipfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layerjam.core.errors import FileError, QuantityError
from layerjam.laboratory.dataset import checksums, comparison
from layerjam.laboratory.dataset.people import licence_notices, parse_author
from layerjam.laboratory.dataset.recipe import FORMAT, RECIPE, Recipe, read_recipe
from layerjam.laboratory.dataset.unpack import open_root

GOOD = {"versions": {"layerjam": "0.1.0"}, "brake": "brake.toml", "results": "results.json"}


@pytest.mark.parametrize(
    "number",
    # ORCID's own examples: support.orcid.org, "Structure of the ORCID identifier"
    ["0000-0002-1825-0097", "0000-0001-5109-3700", "0000-0002-1694-233X"],
)
def test_an_orcid_is_known_by_its_check_digit(number: str) -> None:
    found = parse_author(f"Ada King, Countess of Lovelace, {number}")
    assert (found.name, found.orcid) == ("Ada King, Countess of Lovelace", number)
    assert found.id == f"https://orcid.org/{number}"
    for at in (0, 5, 18):
        wrong = str((int(number[at].replace("X", "4")) + 1) % 10)
        with pytest.raises(QuantityError, match="not an ORCID"):
            parse_author(f"Ada, {number[:at]}{wrong}{number[at + 1 :]}")


def test_a_name_alone_is_an_author() -> None:
    assert parse_author("King, Ada").name == "King, Ada"
    assert parse_author("Ada").orcid == ""
    for empty in ("", "  ", ",0000-0002-1825-0097"):
        with pytest.raises(QuantityError, match="no name"):
            parse_author(empty)


def test_what_a_dataset_lacks_is_said() -> None:
    keys = [w.key for w in licence_notices(None, [])]
    assert keys == ["no-licence", "no-author"]
    assert not licence_notices("CC-BY-4.0", [parse_author("Ada")])
    assert [w.key for w in licence_notices("GPL-3.0-only", [parse_author("A")])] == [
        "unknown-licence"
    ]
    with pytest.raises(QuantityError, match="SPDX"):
        licence_notices("do what you want", [])


def test_the_systems_own_program_reads_the_checksums(tmp_path: Path) -> None:
    for name in ("a.csv", "b c/d ü.csv"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(f"force of {name}\n")
    names = checksums.list_files(tmp_path)
    (tmp_path / checksums.NAME).write_bytes(checksums.format_checksums(tmp_path, names).encode())
    program = shutil.which("sha256sum")  # Windows has none
    check = [str(program), "--check", "--strict", checksums.NAME]

    def code() -> int:
        return subprocess.run(check, check=False, cwd=tmp_path, capture_output=True).returncode

    assert program is None or code() == 0
    listed, strange = checksums.read_checksums(tmp_path)
    assert (checksums.find_changed_files(tmp_path, listed), strange) == ([], [])
    (tmp_path / "a.csv").write_text("force of b.csv\n")
    (tmp_path / "b c/d ü.csv").unlink()
    assert checksums.find_changed_files(tmp_path, listed) == names
    assert program is None or code() == 1


NUMBERS = st.recursive(
    st.none() | st.booleans() | st.integers(-9, 9) | st.floats(-1e9, 1e9) | st.text(max_size=3),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner),
    max_leaves=8,
)


@settings(max_examples=10)
@given(NUMBERS)
def test_nothing_differs_from_itself(value: Any) -> None:
    again = json.loads(json.dumps(value))
    assert not list(comparison.diff_values(value, again, "f"))


@given(st.floats(1e-300, 1e300), st.floats(-1e-3, 1e-3))
def test_a_number_differs_beyond_a_millionth(value: float, part: float) -> None:
    other = value * (1 + part)
    found = list(comparison.diff_values({"a": [value]}, {"a": [other]}, "f"))
    if abs(part) > 1.01e-6:
        (one,) = found
        assert (one.number, one.published, one.recomputed) == ("a.0", value, other)
        assert one.share == pytest.approx(abs(part), rel=1e-6, abs=1e-15)
    elif abs(part) < 0.99e-6:
        assert not found


@pytest.mark.parametrize(
    ("was", "now", "share"),
    [(1.0, None, None), (None, 1.0, None), (True, False, None), (0.0, 1.0, None), (1, "1", None)],
)
def test_what_is_no_ratio_differs_all_the_same(was: Any, now: Any, share: None) -> None:
    (one,) = comparison.diff_values({"n": was}, {"n": now}, "f")
    assert one.share is share
    (gone,) = comparison.diff_values({"n": was}, {}, "f")
    assert gone.recomputed is None


def test_words_and_new_numbers_are_not_compared() -> None:
    assert not list(comparison.diff_values({"a": "old"}, {"a": "new", "b": 2.0}, "f"))
    text = json.dumps({"a": "word", "b": [1, None, {"c": 2.0}]})
    assert comparison.count_numbers("f.json", text.encode()) == 3


def dataset(folder: Path, **changes: Any) -> Path:
    (folder / RECIPE).write_text(json.dumps({"format": FORMAT, **GOOD, **changes}))
    return folder


def test_a_recipe_comes_back(tmp_path: Path) -> None:
    made = Recipe(**GOOD, friction=("data/a.csv",), options={"vacuum": 9e4})
    (tmp_path / RECIPE).write_text(made.text())
    assert read_recipe(tmp_path) == made


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"format": FORMAT + 1}, "update layerjam"),
        ({"format": "x"}, "not a recipe"),
        ({"brake": 3}, "brake"),
        ({"brake": "../../etc/passwd"}, "outside the dataset"),
        ({"friction": ["/etc/passwd"]}, "outside the dataset"),
        ({"friction": "data/a.csv"}, "friction"),
        ({"options": []}, "options"),
    ],
)
def test_a_recipe_of_a_stranger_is_looked_at(
    tmp_path: Path, changes: dict[str, Any], words: str
) -> None:
    with pytest.raises(FileError, match=words):
        read_recipe(dataset(tmp_path, **changes))


def zipped(path: Path, *entries: tuple[str | zipfile.ZipInfo, str]) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in entries:
            archive.writestr(name, text)
    return path


def test_a_zip_file_is_looked_into_and_forgotten(tmp_path: Path) -> None:
    path = zipped(tmp_path / "d.zip", ("mine/recipe.json", "{}"), ("mine/data/a.csv", "1"))
    with open_root(path) as (root, beside):
        assert (root / "data" / "a.csv").read_text() == "1"
        assert beside == []
    assert not root.exists()


LINK = zipfile.ZipInfo("data/link")
LINK.external_attr = (stat.S_IFLNK | 0o777) << 16


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        (("../out.csv", "1"), "outside"),
        (("data/../../out.csv", "1"), "outside"),
        (("/out.csv", "1"), "outside"),
        (("..\\out.csv", "1"), "outside"),
        (("C:out.csv", "1"), "outside"),
        ((LINK, "/etc/passwd"), "link"),
        (("data/zeros.csv", "0" * 30_000_000), "implausible compression ratio"),
        (("other.json", "{}"), "recipe.json is missing"),
        (("report//numbers.csv", "1"), "unusual file name"),
        (("report/./numbers.csv", "1"), "unusual file name"),
        (("report\\numbers.csv", "1"), "unusual file name"),
    ],
)
def test_a_zip_file_of_a_stranger_is_looked_at(
    tmp_path: Path, entry: tuple[Any, str], words: str
) -> None:
    inner = tmp_path / "inner"
    inner.mkdir()
    path = zipped(inner / "d.zip", entry)
    with pytest.raises(FileError, match=words), open_root(path):
        pass
    assert [p.name for p in tmp_path.rglob("*") if p.is_file()] == ["d.zip"]


def test_what_is_no_dataset_is_refused(tmp_path: Path) -> None:
    (tmp_path / "broken.zip").write_bytes(b"PK\x03\x04 and no more")
    for path in (tmp_path, tmp_path / "broken.zip", tmp_path / "none"):
        with pytest.raises(FileError), open_root(path):
            pass

"""What differs between two texts, drawings and PDFs, and which files of a folder are what."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from independent.pulls import BRAKE, Pull, write
from layerjam.brake.device.load import load
from layerjam.core.errors import FileError
from layerjam.laboratory.dataset.campaign_folder import (
    find_brake,
    read_campaign,
    relative_paths,
    split_calibration_pulls,
)
from layerjam.laboratory.dataset.comparison import diff_files, diff_numbers
from layerjam.laboratory.dataset.pdf_comparison import diff_pdfs
from layerjam.laboratory.dataset.recipe import RECIPE, read_recipe
from layerjam.laboratory.dataset.text_comparison import DRAWN, SAME, diff_pages, diff_texts
from layerjam.laboratory.measure.options import ReadingOptions

LINES = st.lists(st.lists(st.floats(0.1, 1e6), min_size=1, max_size=4), min_size=1, max_size=4)


def printed(lines: list[list[float]]) -> str:
    return "\n".join("a " + " b ".join(f"{value!r} N" for value in line) for line in lines)


@settings(max_examples=30)
@given(LINES, st.data())
def test_one_changed_number_is_found_with_its_line_and_share(lines, data):
    row = data.draw(st.integers(0, len(lines) - 1))
    column = data.draw(st.integers(0, len(lines[row]) - 1))
    part = data.draw(st.sampled_from((-1e-3, -3e-6, 3e-6, 0.2)))
    others = [list(line) for line in lines]
    others[row][column] *= 1 + part
    (one,) = diff_texts("t", printed(lines), printed(others))
    assert (one.number, one.file) == (f"line {row + 1}", "t")
    assert (one.published, one.recomputed) == (lines[row][column], others[row][column])
    assert one.share == pytest.approx(abs(part), rel=1e-6)
    near = [list(line) for line in lines]
    near[row][column] *= 1 + SAME / 3
    assert not list(diff_texts("t", printed(lines), printed(near)))


def test_whole_numbers_words_and_lines_differ_without_a_tolerance():
    (one,) = diff_texts("t", "1000000 pulls", "1000001 pulls")
    assert (one.published, one.recomputed) == (1e6, 1000001.0)
    (one,) = diff_texts("t", "the old brake holds 3.5 N", "the new brake holds 3.5 N")
    assert (one.published, one.recomputed, one.share) == ("old", "new", None)
    (one, *_) = diff_texts("t", "a\nb", "a")
    assert (one.number, one.published, one.recomputed) == ("number of lines", 2, 1)
    # the sign of a printed page is no hyphen
    (one,) = diff_texts("t", "−2.5 N", "2.5 N")
    assert (one.published, one.recomputed) == (-2.5, 2.5)


def drawing(x: float, y: float, width: float) -> str:
    return (
        f'<svg viewBox="0 0 9 9"><path id="p12345abcde" d="M {x} 1.5 L 3.5 {y}"/>'
        f'<rect x="{x}" y="{y}" width="{width}"/><g transform="translate({x} {y}) scale(1.5)"/>'
        '<use href="#p12345abcde"/></svg>'
    )


@pytest.mark.parametrize(("move", "is_seen"), [(0.9 * DRAWN, False), (1.2 * DRAWN, True)])
def test_points_of_a_drawing_may_move_a_little_and_sizes_may_not(move, is_seen):
    before = f"<p>3.5 N</p>{drawing(4.5, 5.5, 2.5)}<p>end</p>{drawing(1.5, 1.5, 1.5)}"
    moved = before.replace("4.5", f"{4.5 + move}").replace("5.5", f"{5.5 - move}")
    found = list(diff_pages("p", before, moved))
    assert [one.number for one in found] == ["drawing 1, line 1"] * is_seen
    wider = before.replace('width="1.5"', f'width="{1.5 + 0.9 * DRAWN}"')
    (one,) = diff_pages("p", before, wider)
    assert one.number == "drawing 2, line 1"
    # the names of shapes are digests: another one is the same shape, an exchanged one is not
    assert not list(diff_pages("p", before, before.replace("p12345abcde", "p99999abcde")))
    assert list(diff_pages("p", before, before.replace("#p12345abcde", "#p99999abcde", 1)))
    (one,) = diff_pages("p", before, "<p>3.5 N</p>")
    assert (one.number, one.published, one.recomputed) == ("number of drawings", 2, 0)


def pdf(text: str, x: str = "2.5pt") -> bytes:
    import typst

    source = f"#set document(date: none)\n{text}\n#line(start: ({x}, 3pt), end: (40pt, 50pt))"
    return bytes(typst.compile(source.encode()))


def test_words_lines_and_numbers_of_a_pdf_differ_by_name():
    page = pdf("The brake holds 42.5 N.")
    assert not list(diff_pdfs("p", page, pdf("The brake holds 42.5 N.")))
    assert not list(diff_pdfs("p", page, pdf("The brake holds 42.5 N.", "2.506pt")))
    (one,) = diff_pdfs("p", page, pdf("The brake holds 43.5 N."))
    assert (one.published, one.recomputed) == (42.5, 43.5)
    (one, *_) = diff_pdfs("p", page, pdf("The brake holds 42.5 N.", "2.7pt"))
    assert "obj" in one.number
    assert one.recomputed - one.published == pytest.approx(0.2, abs=1e-3)
    (one, *_) = diff_pdfs("p", page + b"and more", page)
    assert one.file == "p"


@pytest.mark.parametrize(
    ("name", "old", "new", "keys"),
    [
        ("a.json", '{"a": [1.5, 2]}', '{"a": [1.5, 3]}', ["a.1"]),
        ("a.json", '{"a": 1.5, "b": "x"}', '{"a": 1.5, "b": "y", "c": 2}', ["b", "c"]),
        ("a.json", '{"a": 1.5}', '{"a": 9, "a": 1.5}', ["line 1"]),
        ("a.toml", 'a = "1.5 kPa"', 'a = "1500 Pa"', []),
        ("a.toml", 'a = "1.5 kPa"', 'a = "1501 Pa"', ["a"]),
        ("a.csv", "n,f\nx,1.5\nx,2.5", "n,f\nx,1.5\nx,2.6", ["rows.x (2).f"]),
        ("a.json", "{", "[", ["text"]),
    ],
)
def test_a_file_differs_by_the_keys_of_its_kind(name, old, new, keys):
    assert [one.number for one in diff_files(name, old.encode(), new.encode())] == keys
    assert not list(diff_files(name, old.encode(), old.encode()))


def test_other_programs_may_order_the_numbers_of_a_page_anew():
    page, other = b"<p>1.5 N, 2.5 N</p><!--3.5-->", b"<p>2.5 N</p><p>1.5000001 N, 7 N</p>"
    assert not list(diff_numbers("p.html", page, other))
    (one,) = diff_numbers("p.html", page, b"<p>2.5 N, 2.5 N</p>")
    assert (one.published, one.recomputed) == (1.5, None)


@pytest.mark.parametrize("form", [1, 2, 3])
def test_a_recipe_of_an_earlier_format_lists_rejected_files_under_their_use(tmp_path, form):
    unused = {"data/c.csv": {"use": "validate", "why": "late"}}
    rows = [{"file": "data/c.csv", "use": "validate", "why": "late"}]
    recipe = {
        "format": form,
        "versions": {},
        "brake": "b.toml",
        "results": "r.json",
        "calibrate": ["data/a.csv"],
        "validate": ["data/b.csv", *(["data/c.csv"] if form == 3 else [])],
        "unused": rows if form == 3 else unused,
    }
    (tmp_path / RECIPE).write_text(json.dumps(recipe))
    found = read_recipe(tmp_path)
    assert found.calibrate == found.used("calibrate") == ("data/a.csv",)
    assert found.validate == ("data/b.csv", "data/c.csv")
    assert found.used("validate") == ("data/b.csv",)


@pytest.fixture
def campaign(tmp_path) -> Callable[..., Path]:
    def fill(*brakes: str, sidecars: str = BRAKE) -> Path:
        facts = {"brake": f'"{sidecars}"'} if sidecars else {}
        write(tmp_path, [Pull(vacuum=v, facts=facts) for v in (3e4, 6e4)])
        sled = tmp_path / "pull-01.csv"
        (tmp_path / "sled.csv").write_text(sled.read_text())
        (tmp_path / "sled.csv.toml").write_text('normal_force = "2 N"\n')
        (tmp_path / "notes.md").write_text("# Made on a Monday\n")
        for name in brakes:
            text = load(BRAKE).text.replace(f'"{BRAKE}"', f'"{name}"')
            (tmp_path / f"{name}.toml").write_text(text)
        return tmp_path

    return fill


def test_the_files_of_a_folder_are_known_by_what_they_hold(campaign):
    found = read_campaign(campaign("mine", sidecars=""), ReadingOptions())
    assert found.pulls == ("pull-01.csv", "pull-02.csv")
    assert (found.friction, found.brakes) == (("sled.csv",), ("mine.toml",))
    assert found.measurements == ("sled.csv", "pull-01.csv", "pull-02.csv")
    assert find_brake(found) == "mine.toml"
    assert split_calibration_pulls(found) == ([], ["pull-01.csv", "pull-02.csv"])
    assert list(relative_paths(found.folder, ["pull-01.csv"])) == ["pull-01.csv"]
    with pytest.raises(FileError, match="does not exist"):
        list(relative_paths(found.folder, ["none.csv"]))


@pytest.mark.parametrize(
    ("brakes", "stated", "expected"),
    [((), BRAKE, BRAKE), (("a", "b"), "b", "b.toml"), (("a",), "b", "a.toml")],
)
def test_the_tested_brake_is_the_only_one_or_the_one_that_the_tests_state(
    campaign, brakes, stated, expected
):
    folder = campaign(*brakes, sidecars=stated)
    (folder / "sled.csv").unlink()
    (folder / "sled.csv.toml").unlink()
    assert find_brake(read_campaign(folder, ReadingOptions())) == expected


def test_a_folder_that_does_not_say_which_brake_was_tested_is_refused(campaign, tmp_path):
    folder = campaign("a", "b", sidecars="")
    with pytest.raises(FileError, match=r"contains a\.toml, b\.toml; specify the tested brake"):
        find_brake(read_campaign(folder, ReadingOptions()))
    (tmp_path / "empty").mkdir()
    with pytest.raises(FileError, match="no readable measurement"):
        read_campaign(tmp_path / "empty", ReadingOptions())

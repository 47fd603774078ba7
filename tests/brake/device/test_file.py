"""The brake's TOML file: errors with file and line, round trips, changes that keep the rest."""

from __future__ import annotations

import dataclasses
import time

import pytest
from hypothesis import given

from layerjam.brake.device.brake_file import BrakeFile, updated_text
from layerjam.brake.device.load import catalogue, load
from layerjam.core.errors import FileError, LayerjamError
from layerjam.core.store import store_file
from layerjam.core.toml_files.source import Source
from layerjam.core.toml_files.toml import find_line, parse_toml
from layerjam.core.units import get
from strategies import change, one, random_brakes, seeds

TEXT = load("choi2018-kapton").text


def read(text: str):
    return BrakeFile.read(text, "my.toml")


@pytest.mark.parametrize("name", catalogue())
def test_render_and_read_is_the_same_brake(name):
    file = load(name)
    again = read(file.render("copy"))
    assert again.brake == file.brake and again.name == "copy" and again.title == file.title
    assert dict(again.sources) == dict(file.sources) | {
        p: Source() for p in again.sources if p not in file.sources
    }


@given(seed=seeds)
def test_any_brake_is_written_and_read_bit_for_bit(seed):
    from layerjam.brake.device.brake_file import BrakeFile

    brake = one(random_brakes(seed, 1, exponent=seed % 2 == 0), 0)
    file = BrakeFile(name="x", brake=brake, sources={}, text="")
    assert read(file.render("x")).brake == brake


def test_strange_text_in_sources_survives():
    file = load("choi2018-kapton")
    odd = Source(kind="measured", text='quote " back \\ tab \t ü 😀 \x01', conflict="'''")
    file = type(file)(**{**vars(file), "sources": {"sheets.width": odd}})
    assert read(file.render("x")).sources["sheets.width"] == odd


def test_update_keeps_comments_and_the_rest():
    file = load("choi2018-kapton")
    file = dataclasses.replace(file, text="# mine, weighed twice\n" + file.text)
    source = Source(kind="calibrated", text="pull 7")
    changes = {
        "scale_factor": (0.9, source),
        "sheets.width": (0.0125, source),
        "site.atmosphere": (98e3, source),
        "film.kinetic": (0.21, source),
    }
    text = updated_text(file, "mine", changes)
    made = read(text)
    assert made.name == "mine" and text.startswith("# mine, weighed twice")
    expected = change(
        file.brake,
        scale_factor=0.9,
        amplification_held=None,  # of the old scale factor
        sheets__width=0.0125,
        site__atmosphere=98e3,
        film__kinetic=0.21,
    )
    assert made.brake == expected
    for path in changes:
        assert made.sources[path] == source
    kept = set(file.sources) - set(changes) - {"amplification_held"}
    assert all(made.sources[p] == file.sources[p] for p in kept)


def test_update_adds_what_was_absent():
    file = load("choi2018-polyester")
    made = read(updated_text(file, "mine", {"stiffness_measured": (9e4, Source(kind="measured"))}))
    assert made.brake == change(file.brake, stiffness_measured=9e4)


@given(seed=seeds)
def test_update_with_any_values_is_exact(seed):
    file = load("choi2018-ptfe")
    brake = one(random_brakes(seed, 1), 0)
    paths = ["scale_factor", "stiffness_measured", "enclosure.modulus", "film.modulus"]
    changes = {p: (get(brake, p), Source(kind="measured", text="t")) for p in paths}
    made = read(updated_text(file, "mine", changes)).brake
    assert all(get(made, p) == get(brake, p) for p in paths)


def line(needle: str) -> int:
    return next(i for i, t in enumerate(TEXT.splitlines(), 1) if needle in t)


@pytest.mark.parametrize(
    ("old", "new", "where", "says"),
    [
        ('width = { value = "13 mm"', "width = { value = 13", "width =", "13 has no unit"),
        ('width = { value = "13 mm"', 'width = { value = "13 kg"', "width =", "units of length"),
        ('width = { value = "13 mm"', 'width = { value = "13 m"', "width =", "is not allowed"),
        ('width = { value = "13 mm"', 'width = { val = "13 mm"', "width =", "unknown key val"),
        ("width = {", "widht = {", "width =", "did you mean sheets.width"),
        ('value = "131 kN/m"', 'value = "131 kN"', "[stiffness_measured]", "N/m"),
        ('value = 11, kind = "paper"', 'value = 11, kind = "rumour"', "count =", "unknown kind"),
        ("value = 11,", "value = 11.5,", "count =", "an integer"),
        ('use = "kapton-hn"', 'use = "kapton"', "[film]", "did you mean kapton-hn"),
        ('use = "kapton-hn"', "use = 3", "[film]", "unknown material"),
        ('name = "choi2018-kapton"', 'name = "a/b"', "name =", "name is missing or"),
        ('usable_travel = { value = "60 mm"', 'usable_travel = { value = "69 mm"',
         "usable_travel", "exceeds the overlap"),
        ('screw_hole = { value = "3 mm"', 'screw_hole = "3 mm" x', "screw_hole", "not valid TOML"),
    ],
)  # fmt: skip
def test_errors_name_file_and_line(old, new, where, says):
    assert old in TEXT
    with pytest.raises(FileError, match=says) as caught:
        read(TEXT.replace(old, new, 1))
    assert caught.value.line is not None
    assert abs(caught.value.line - line(where)) <= (1 if where.startswith("[") else 0)
    assert str(caught.value).startswith(f"my.toml, line {caught.value.line}: ")


def test_missing_keys_are_listed_with_their_meaning():
    text = "\n".join(t for t in TEXT.splitlines() if not t.startswith(("width", "overlap")))
    with pytest.raises(FileError, match=r"sheets.width \(sheet width\).*overlap.* are missing"):
        read(text)


def test_rope_may_be_absent_but_not_half():
    text = TEXT[: TEXT.index("[rope]")]
    assert read(text).brake.rope is None
    with pytest.raises(FileError, match="rope.stiffness"):
        read(text + '[rope]\ndamping = "1 N s/m"\n')


def test_plain_form_and_notes():
    text = TEXT.replace('width = { value = "13 mm", kind = "paper", source = "Choi 2018, section '
                        'II-A" }', 'width = "12 mm"') + '\n[made_by]\ntool = "x"\n'  # fmt: skip
    file = read(text)
    assert file.brake.sheets.width == 0.012 and file.sources["sheets.width"] == Source()
    assert file.notes == {"tool": "x"}


def test_lines_are_found():
    text = 'a = 1\n[t]\nb = 2\n"c" = 3\n[u]\n  b.x = 4\n'
    assert find_line(text, "t.b") == 3 and find_line(text, "t.c") == 4
    assert find_line(text, "u.b") == 6 and find_line(text, "a") == 1
    assert find_line(text, "t.zz") == 2 and find_line(text, "zz") is None


def test_files_that_cannot_be_read(tmp_path):
    for content, says in ((b"\xff", "not UTF-8"), (b"a" * 1_000_001, "larger than")):
        place = tmp_path / "b.toml"
        place.write_bytes(content)
        with pytest.raises(FileError, match=says):
            load(place)
    with pytest.raises(FileError, match="cannot be read"):
        load(tmp_path / "none.toml")
    with pytest.raises(FileError, match="folder"):
        load(str(tmp_path) + "/")
    with pytest.raises(FileError, match="larger than"):
        parse_toml("#" * 1_000_001, "x")


def test_a_file_with_a_byte_order_mark_is_read(tmp_path):
    place = tmp_path / "b.toml"
    place.write_bytes(b"\xef\xbb\xbf" + TEXT.encode())
    assert load(place).brake == load("choi2018-kapton").brake


def test_written_whole_or_not_at_all(tmp_path):
    place = tmp_path / "out.txt"
    assert store_file(place, lambda p: p.write_text("a")) == place and place.read_text() == "a"
    with pytest.raises(FileError, match="--overwrite"):
        store_file(place, lambda p: p.write_text("b"))
    store_file(place, lambda p: p.write_text("b"), overwrite=True)

    def broken(path):
        path.write_text("half")
        raise RuntimeError("stop")

    with pytest.raises(RuntimeError):
        store_file(place, broken, overwrite=True)
    assert place.read_text() == "b" and [p.name for p in tmp_path.iterdir()] == ["out.txt"]
    with pytest.raises(FileError, match="cannot be written"):
        store_file(tmp_path / "no" / "x", lambda p: None)


def test_a_line_of_blanks_after_a_bracket_is_not_slow():
    text = TEXT.replace('title = "Choi 2018, Kapton"', 'title = """\n[' + " " * 9000 + '\n"""')
    begun = time.process_time()
    with pytest.raises(FileError):
        read(text.replace('"13 mm"', '"13 kg"', 1))
    assert time.process_time() - begun < 60  # hours if it grows with the cube of the length


def test_a_huge_hexadecimal_integer_is_a_file_error():
    with pytest.raises(LayerjamError):
        read(TEXT.replace("value = 11,", "value = 0x" + "f" * 5000 + ",", 1))


@pytest.mark.parametrize(
    "text",
    ["", "[" * 5000, "a=" + "[" * 3000, "a." * 2000 + "b=1", "name = 1", "\x00", "=", "[film]"],
)
def test_rubbish_is_a_file_error(text):
    with pytest.raises(FileError):
        read(text)

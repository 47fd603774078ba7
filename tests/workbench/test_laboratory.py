"""The laboratory without a browser: uploads, sidecars, steps, and what is copied from them."""

from __future__ import annotations

import asyncio
import contextlib
import io
import json
import os
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layerjam.core.errors import LayerjamError
from layerjam.laboratory.commands.lab import lab_example
from layerjam.laboratory.measure.readers.workbook import MAX_UNPACKED
from layerjam.workbench import uploads as up
from layerjam.workbench.call import Call, DataFile, Subject, disambiguate
from layerjam.workbench.desk import Desk
from layerjam.workbench.pages import laboratory, laboratory_chain
from layerjam.workbench.pages import laboratory_files as files_of
from layerjam.workbench.pages.laboratory_chain import Campaign, Chain, file_stem, split_roles
from layerjam.workbench.pages.laboratory_files import make_practice_files, read_row
from layerjam.workbench.runner import ComputationStopped
from layerjam.workbench.said import check_edit, get_edits, put_edits, sidecar_text
from layerjam.workbench.uploads import UploadError, Uploads, clean_name, is_sidecar, restore_names
from printed import split_command
from workbench.standing import standing

KAPTON = Subject("choi2018-kapton")
FORCE = [min(7.0 * i, 175 - i) for i in range(60)]
PULL = b"force,elongation\nN,mm\n" + b"".join(
    b"%.3f,%.2f\n" % (f, i / 10) for i, f in enumerate(FORCE)
)


def quiet(what: str, share: float) -> None:
    assert 0 <= share <= 1, what


@pytest.fixture(scope="module")
def practice(tmp_path_factory):
    return make_practice_files(tmp_path_factory.mktemp("practice"), quiet)


@pytest.fixture
def tab():
    made = Uploads()
    yield made
    made.close()


def few(practice: dict[str, bytes]) -> dict[str, bytes]:
    """Two friction tests, two pulls at the highest vacuum, one at another, with sidecars."""
    wanted = ("friction_choi2018-kapton_1", "friction_choi2018-kapton_2", "94.5kPa_7mms_1",
              "94.5kPa_7mms_2", "40kPa_7mms_1")  # fmt: skip
    return {n: d for n, d in practice.items() if any(w in n for w in wanted)}


def campaign_of(rows, tab, brake=KAPTON, tell=quiet, **asked):
    return Campaign(rows, brake, asked, tab.folder, tell)


def rows_of(tab: Uploads, desk: Desk) -> list:
    return files_of.read_rows(tab, get_edits(desk), "paper", read_row, quiet)


@pytest.mark.parametrize("name", ["../../etc/passwd", "..", "C:\\x\\y.csv", "a" * 5000 + ".csv",
                                  "ev\0il\n\x1b[31m.csv", "", ".", "/", "con.csv", "x.toml/..",
                                  "\u202egpj.csv"])  # fmt: skip
def test_a_name_never_becomes_a_path(tab, name):
    made = tab.store_file(name, PULL)
    assert made is not None
    assert made.path.parent == tab.folder
    assert made.path.name.startswith("layerjam-file-0001.")
    assert made.path.suffix in (*up.ENDINGS, ".dat")
    assert sorted(p.name for p in tab.folder.iterdir()) == [made.path.name]
    assert len(made.shown) <= up.LONGEST_NAME and made.shown.isprintable() and made.shown
    assert "/" not in made.shown and "\\" not in made.shown


@given(st.text(max_size=300))
@settings(max_examples=200, deadline=None)
def test_a_cleaned_name_is_short_printable_and_stays_as_it_is(name):
    once = clean_name(name)
    assert 0 < len(once) <= up.LONGEST_NAME
    assert once.isprintable()
    assert clean_name(once) == once


def test_bounds_in_size_and_number_are_said(tab, monkeypatch):
    with pytest.raises(UploadError, match=r"huge.csv: 954 MB is too large for the page"):
        tab.check_room("huge.csv", 10**9)
    with pytest.raises(UploadError, match="is too large for a sidecar"):
        tab.store_file("a.csv.toml", b"x" * (up.SIDECAR + 1))
    monkeypatch.setattr(up, "MAX_FILES", 2)
    tab.store_file("a.csv", b"1")
    tab.store_file("b.csv", b"2")
    with pytest.raises(UploadError, match="at most 2 measurements"):
        tab.store_file("c.csv", b"3")
    monkeypatch.setattr(up, "MAX_FILES", 5)
    monkeypatch.setattr(up, "ALL_TOGETHER", 2)
    with pytest.raises(UploadError, match="all files together"):
        tab.store_file("c.csv", b"3")
    assert up.LARGEST < 64 * 2**20, "a request body is bounded at 64 MB"


def test_the_same_content_counts_once_and_the_same_name_is_numbered(tab):
    tab.store_file("a.csv", b"1")
    with pytest.raises(UploadError, match=r"b.csv has the same content as a.csv"):
        tab.store_file("b.csv", b"1")
    assert tab.store_file("a.csv", b"2").shown == "a (2).csv"


def test_the_folder_goes_with_the_tab_and_nothing_comes_after(tab):
    tab.store_file("a.csv", PULL)
    folder = tab.folder
    tab.close()
    assert not folder.exists() and not folder.parent.exists()
    with pytest.raises(UploadError, match="closed"):
        tab.store_file("b.csv", b"2")


@pytest.mark.parametrize(("name", "data", "why"), [
    ("empty.csv", b"", "is empty"),
    ("picture.csv", b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 9, "is binary"),
    ("cut.xlsx", b"PK\x03\x04" + b"x" * 99, "cannot be read"),
    ("page.xml", b"<?xml version='1.0'?><a/>", "is XML"),
])  # fmt: skip
def test_rubbish_is_refused_in_words_with_the_users_name(tab, name, data, why):
    tab.store_file(name, data)
    (row,) = rows_of(tab, Desk())
    assert why in row.refused
    assert "layerjam-file" not in row.refused and str(tab.folder) not in row.refused


def test_a_workbook_that_unpacks_beyond_memory_is_refused(tab):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as book:
        for number in range(9):
            book.writestr(f"xl/worksheets/sheet{number}.xml", bytes(MAX_UNPACKED // 8))
    assert len(out.getvalue()) < 1e6
    tab.store_file("bomb.xlsx", out.getvalue())
    (row,) = rows_of(tab, Desk())
    assert "unpacks to 281 MB" in row.refused


def test_a_vacuum_set_on_the_page_stands_in_the_sidecar_and_can_be_undone(tab):
    tab.store_file("pull.csv", PULL)
    desk = Desk()
    (row,) = rows_of(tab, desk)
    assert row.missing_entry == "vacuum?" and not row.is_usable
    put_edits(desk, {row.upload.key: {"vacuum": "80 kPa"}})
    (row,) = rows_of(tab, desk)
    assert row.is_usable and row.vacuum == 80e3 and row.upload.edited
    assert up.sidecar_of(row.upload.path).read_text() == 'vacuum = "80 kPa"\n'
    desk.undo()
    (row,) = rows_of(tab, desk)
    assert not row.is_usable and not up.sidecar_of(row.upload.path).exists()


def test_columns_signs_and_units_are_corrected_per_file(tab):
    lines = (b"%d;%.3f;%.2f\n" % (i, -f, i / 10) for i, f in enumerate(FORCE))
    tab.store_file("plain.csv", b"".join(lines))
    tab.store_file("pull.csv", PULL)
    desk = Desk()
    first, second = rows_of(tab, desk)
    assert "Click the headers of the force" in first.refused
    assert "--" not in first.refused and not second.refused
    said = {"vacuum": "50 kPa", "columns": "skip,force:N,elongation:mm", "negative": "force"}
    put_edits(desk, {first.upload.key: said})
    first, second = rows_of(tab, desk)
    assert not first.refused and first.is_usable, first.refused
    assert first.traces[0].force.max() == pytest.approx(max(FORCE))
    assert any("[read] of its sidecar" in s for s in first.understood)
    assert not second.upload.edited


def test_the_users_sidecar_keeps_its_words_and_the_pages_count():
    text = '# mine\nvacuum = "40 kPa"\nnote = "new"\n'
    made = sidecar_text(text, {"vacuum": "50 kPa", "decimal": ","})
    assert "# mine" in made and 'note = "new"' in made and 'vacuum = "50 kPa"' in made
    assert '[read]\ndecimal = ","' in made
    assert sidecar_text(text, {}) == text
    assert sidecar_text("bad [[", {"vacuum": "1 kPa"}) == "bad [["


@pytest.mark.parametrize("changes", [{"vacuum": "2 furlongs"}, {"normal_force": "-1 N"},
                                     {"decimal": ";"}, {"columns": "a,b"}, {"specimen": "x"},
                                     {"column": "force"}])  # fmt: skip
def test_what_is_no_fact_or_answer_is_refused_before_it_is_kept(changes):
    with pytest.raises(LayerjamError):
        check_edit(changes)


@pytest.mark.parametrize("rubbish", ["[]", "{", '{"a": 3}', '{"a": {"vacuum": 3, "evil": "x"}}',
                                     "[" * 5000])  # fmt: skip
def test_rubbish_of_a_link_is_left_out(rubbish):
    desk = Desk()
    desk.put_setting("laboratory", "files", rubbish)
    assert get_edits(desk) in ({}, {"a": {}})


def test_a_broken_sidecar_is_said_with_the_users_name(tab):
    tab.store_file("con.csv.toml", b"vacuum = [[")
    tab.store_file("con.csv", PULL)
    (row,) = rows_of(tab, Desk())
    assert "con.csv.toml" in row.refused and "layerjam-file" not in row.refused


@pytest.fixture(scope="module")
def campaign(practice):
    """A tab with some practice files, divided, and its steps computed."""
    tab, desk, chain = Uploads(), Desk(), Chain()
    for name, data in few(practice).items():
        tab.store_file(name, data)
    put_edits(desk, split_roles(rows_of(tab, desk)))
    rows = rows_of(tab, desk)
    chain.run(campaign_of(rows, tab))
    yield tab, rows, chain
    tab.close()


def test_practice_files_calibrate_the_brake_they_were_made_with(campaign):
    _, rows, chain = campaign
    assert all(r.is_synthetic and r.is_usable for r in rows)
    truth = lab_example()
    assert "scale_factor = 0.92" in truth and 'stiffness = "120 kN/m"' in truth
    fitted = chain.done["calibrate"].result
    product = fitted.scale_factor * chain.done["friction"].result.kinetic
    assert product == pytest.approx(0.92 * 0.235, rel=0.05)
    assert fitted.stiffness == pytest.approx(120e3, rel=0.03)
    assert chain.done["validate"].result.mape < 0.06


def test_what_is_written_and_said_names_files_as_the_user_does(campaign):
    tab, _, chain = campaign
    for done in chain.done.values():
        shown = json.dumps([dict(done.result.values), list(done.result.warnings)], default=str)
        written = "" if done.brake is None else done.brake.text
        for text in (shown, written, done.call.python_code(), done.call.command_line()):
            assert "layerjam-file" not in text and str(tab.folder) not in text
        assert done.picture.lstrip().startswith("<svg")
    names = [f["name"] for f in chain.done["calibrate"].brake.notes["files"]]
    assert names == [n for n in chain.done["calibrate"].call.names.values()]


def test_the_command_says_the_same_as_python(campaign, practice, tmp_path, monkeypatch, capsys):
    from layerjam.cli.main import main

    _, _, chain = campaign
    for name, data in few(practice).items():
        (tmp_path / name).write_bytes(data)
    monkeypatch.chdir(tmp_path)
    for verb in ("friction", "calibrate"):
        words = split_command(chain.done[verb].call.command_line())
        monkeypatch.setattr("sys.argv", [*words, "--json"])
        with contextlib.suppress(SystemExit):
            main()
        said = json.loads(capsys.readouterr().out)
        key = "kinetic" if verb == "friction" else "scale_factor"
        assert said[key] == chain.done[verb].result.values[key]


def test_a_step_whose_inputs_stand_is_not_computed_again(campaign):
    tab, rows, chain = campaign
    before = dict(chain.done)
    chain.run(campaign_of(rows, tab))
    assert all(chain.done[v] is before[v] for v in before)


def test_sampling_is_never_begun_unasked_and_can_be_stopped(campaign):
    tab, rows, _ = campaign
    chain, asked = Chain(), {"depth": "bayesian"}
    chain.run(campaign_of(rows, tab, **asked))
    assert "press 'Sample'" in chain.messages["calibrate"] and "validate" not in chain.done

    def stop(what: str, share: float) -> None:
        if what.startswith("calibrate"):
            raise ComputationStopped

    with pytest.raises(ComputationStopped):
        chain.run(campaign_of(rows, tab, **asked, tell=stop), "sample")
    assert "Stopped" in chain.messages["calibrate"]
    chain.run(campaign_of(rows, tab, **asked))
    assert "press 'Sample'" in chain.messages["calibrate"]


def test_a_step_that_was_stopped_takes_those_that_rest_on_it_along(campaign):
    """Copied, a validation of the brake before would be one of the brake that was just fitted."""
    tab, rows, _ = campaign
    chain = Chain()
    chain.run(campaign_of(rows, tab))
    before = [chain.done[name].call for name in ("friction", "calibrate", "validate")]

    def stop(what: str, share: float) -> None:
        if what == "calibrate: drawing":
            raise ComputationStopped

    fewer = [row for row in rows if row is not [r for r in rows if r.role == "calibrate"][-1]]
    with pytest.raises(ComputationStopped):
        chain.run(campaign_of(fewer, tab, tell=stop))
    assert list(chain.done) == ["friction", "calibrate"]
    assert chain.done["friction"].call == before[0] and chain.done["calibrate"].call != before[1]
    chain.run(campaign_of(rows, tab))
    assert [chain.done[name].call for name in chain.done] == before


def test_a_brake_is_not_written_over_the_one_it_is_made_from(campaign):
    tab, rows, chain = campaign
    fitted = chain.done["calibrate"]
    again = Chain()
    brake = Subject(fitted.call.out, fitted.brake)
    again.run(campaign_of(rows, tab, brake))
    assert again.done["calibrate"].call.out == "choi2018-kapton-again-calibrated.toml"
    assert [*disambiguate([again.done["friction"].call]).texts] == [brake.name]
    assert disambiguate([again.done["calibrate"].call]).texts == {}


@pytest.mark.slow
def test_a_report_names_files_as_the_user_does(campaign):
    tab, rows, _ = campaign
    chain = Chain()
    chain.run(campaign_of(rows, tab), "report")
    done = chain.done["report"]
    assert {"report.html", "report.pdf", "results.json", "numbers.csv"} <= set(done.pages)
    for name in ("report.html", "results.json", "numbers.csv"):
        text = done.pages[name].decode()
        assert "layerjam-file" not in text and str(tab.folder) not in text, name
        assert "friction_choi2018-kapton_1.csv" in text, name
    assert not (tab.folder / "choi2018-kapton-report").exists()
    # it stands while its inputs do, and comes back with them
    for asked, stands in (({}, True), ({"accept_stick_slip": True}, False), ({}, True)):
        chain.run(campaign_of(rows, tab, **asked))
        assert (chain.done.get("report") is done) == stands


def test_names_in_toml_and_copied_text_are_quoted():
    odd = 'my "best" \\ pull.csv'
    text = restore_names('a = "peak of layerjam-file-0001.csv"', {"layerjam-file-0001.csv": odd})
    import tomllib

    assert tomllib.loads(text) == {"a": f"peak of {odd}"}
    file = DataFile(odd, Path("/nowhere/layerjam-file-0001.csv"))
    step = Call("pull", files=(file,))
    assert split_command(step.command_line()) == ["layerjam", "pull", odd]
    space: dict = {}
    exec(step.python_code().splitlines()[2].replace("lj.pull", "list"), space)
    assert space["result"] == [odd]
    dashed = replace(file, shown="-x.csv")
    assert "./-x.csv" in Call("pull", files=(dashed,)).command_line()


@given(st.text(max_size=80))
@settings(max_examples=100, deadline=None)
def test_a_stem_is_safe_in_a_path(name):
    stem = file_stem(Subject(name))
    assert stem and os.path.basename(stem) == stem and stem not in (".", "..")
    assert stem.isascii() and len(stem) <= 60


def test_a_sidecar_is_told_from_a_brake():
    assert is_sidecar("a.csv.toml") and is_sidecar("pull_94.5kPa.TRA.toml")
    assert not is_sidecar("spec.toml") and not is_sidecar("a.csv")


@pytest.mark.slow
def test_the_practice_button_calibrates_on_no_pull_that_it_validates_on(practice, monkeypatch):
    asked = []
    before = laboratory_chain.run_call

    def seen(call, folder, tell):
        asked.append((call.name, tuple(file.shown for file in call.files)))
        return before(call, folder, tell)

    monkeypatch.setattr(laboratory_chain, "run_call", seen)
    monkeypatch.setattr(laboratory, "make_practice_files", lambda *_: few(practice))

    async def press() -> None:
        async with standing(laboratory.Laboratory) as (_, pages):
            while not pages:
                await asyncio.sleep(0.05)
            pages[0]._request_action("practice")
            for _ in range(600):
                if "validate" in pages[0].chain.done:
                    return
                await asyncio.sleep(0.1)

    asyncio.run(press())
    used = dict(asked)
    assert len(asked) == len(used)  # each step once
    assert used["calibrate"] and all("94.5kPa" in name for name in used["calibrate"])
    assert used["validate"] and all("40kPa" in name for name in used["validate"])

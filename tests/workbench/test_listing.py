"""One table of conditions for many files, dropped on the page, says there what commands read."""

from __future__ import annotations

import pytest

from layerjam.core.errors import FileError
from layerjam.laboratory.measure.conditions import read_conditions
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.workbench.desk import Desk
from layerjam.workbench.dropping import attach_conditions, is_conditions_list, read_conditions_list
from layerjam.workbench.proposals import propose_use
from layerjam.workbench.said import sidecar_text
from layerjam.workbench.sorting import _cite_list
from layerjam.workbench.uploads import Uploads

TEXT = (
    "file;vacuum [kPa];speed [mm/s];normal_force;repeat;note\n"
    "a.csv;94,5;13;;2;first of the day\nb.csv;60;;;;\nslide.csv;;;2.45 N;;\nlater.csv;20;;;;\n"
)
ROWS = b"Extension (mm),Load (N)\n" + b"".join(b"%d,%d\n" % (k, 9 * k) for k in range(60))


@pytest.fixture
def tab():
    made = Uploads()
    yield made
    made.close()


def dropped(tab, *names):
    return [tab.store_file(n, ROWS + b"# %d\n" % k, waits=True) for k, n in enumerate(names)]


def test_the_page_reads_what_the_commands_read(tab, tmp_path):
    (tmp_path / "conditions.csv").write_text(TEXT)
    tab.listed = read_conditions_list(TEXT.encode(), "conditions.csv")
    files = dropped(tab, "a.csv", "b.csv", "slide.csv", "other.csv")
    taken, told = attach_conditions(tab)
    assert taken == ["a.csv", "b.csv", "slide.csv"] and told == []
    for one in files[:3]:
        (tmp_path / one.shown).write_bytes(ROWS)
        by_command = read_conditions(tmp_path / one.shown, ReadingOptions())
        laid = tab.write_sidecar(one, tab.sidecars[one.shown])
        assert read_conditions(laid.path, ReadingOptions()) == by_command
    assert "other.csv" not in tab.sidecars


def test_a_proposal_says_that_it_comes_from_the_list(tab):
    tab.listed = read_conditions_list(TEXT.encode(), "conditions.csv")
    a, _, slide = dropped(tab, "a.csv", "b.csv", "slide.csv")
    attach_conditions(tab)
    found = {}
    for one in (a, slide):
        laid = tab.write_sidecar(one, sidecar_text(tab.sidecars[one.shown], {}))
        found[one.shown] = _cite_list(propose_use(one.key, one.shown, laid.path), tab.from_list)
    assert found["a.csv"].facts["vacuum"].text == "94.5 kPa"
    assert found["a.csv"].facts["vacuum"].source == "conditions.csv"
    assert found["a.csv"].role.text == "calibrate"
    assert found["slide.csv"].role.text == "friction"
    assert found["slide.csv"].role.source == "conditions.csv states a normal force"


def test_files_that_come_later_are_known_and_a_sidecar_counts_over_the_list(tab):
    tab.listed = read_conditions_list(TEXT.encode(), "conditions.csv")
    assert attach_conditions(tab) == ([], [])
    tab.store_file("later.csv.toml", b'vacuum = "30 kPa"\nspeed = "1 mm/s"\n')
    dropped(tab, "later.csv")
    taken, told = attach_conditions(tab)
    assert taken == ["later.csv"]
    (sentence,) = told
    assert "its sidecar states vacuum 30 kPa, but conditions.csv states 20 kPa" in sentence
    assert "20" not in tab.sidecars["later.csv"] and tab.from_list["later.csv"] == frozenset()
    assert attach_conditions(tab) == (["later.csv"], []), "it is said once"
    tab.remove_files([tab.files[0].key])
    assert tab.from_list == {} and tab.listed


@pytest.mark.parametrize(("data", "says"), [
    (b"", "is empty"), (b"\xff\xfe\x00", "UTF-8"), (b"a,b\n1,2\n", "unknown column"),
    (b"file,vacuum\na.csv,94.5\n", "no unit"),
    (b"file,vacuum\na.csv,1 kPa\na.csv,2 kPa\n", "twice"),
    (b"file\n" + b"x" * 1_000_001, "the limit for"),
])  # fmt: skip
def test_a_bad_list_is_refused_by_its_name(data, says):
    with pytest.raises(FileError, match=says) as caught:
        read_conditions_list(data, "conditions.csv")
    assert str(caught.value).startswith("conditions.csv")


def test_only_a_file_of_that_name_is_a_list():
    assert is_conditions_list("Conditions.CSV") and is_conditions_list("a/b/conditions.csv")
    assert not is_conditions_list("conditions.csv.toml") and not is_conditions_list(
        "my conditions.csv"
    )
    assert Desk().files.listed == {}

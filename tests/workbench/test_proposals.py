"""What is proposed for a dropped file, from its name, its content, its sidecar; and its columns."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layerjam.core.units import parse
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.laboratory.measure.preview import preview_file
from layerjam.laboratory.measure.readers.read import read_trace
from layerjam.workbench.desk import Desk
from layerjam.workbench.kinds import detect_toml_kind
from layerjam.workbench.proposals import (
    CLICKS,
    assign_roles,
    find_read_error,
    parse_file_name,
    propose_use,
)
from layerjam.workbench.said import column_edit, get_edits, put_edits, reverse_sign, sidecar_text
from layerjam.workbench.uploads import Uploads

DATA = Path(__file__).parents[2] / "shared/data"
FORCE = [min(7.0 * i, 175 - i) for i in range(60)]


def written(place: Path, name: str, *rows: str, head: str = "") -> Path:
    path = place / name
    path.write_text("\n".join([*([head] if head else []), *rows, ""]), encoding="utf-8")
    return path


def make_pull_rows(mark: str = ",", sign: float = 1.0) -> list[str]:
    return [f"{i / 10:.2f}{mark}{sign * f:.3f}" for i, f in enumerate(FORCE)]


@pytest.mark.parametrize(("name", "role", "vacuum", "force"), [
    ("pull_94.5kPa_2.csv", "calibrate", "94.5 kPa", ""),
    ("friction_Kapton.csv", "friction", "", ""),
    ("run 0.5bar.csv", "", "0.5 bar", ""),
    ("zug_94p5kPa_50mm_min.csv", "calibrate", "94.5 kPa", ""),
    ("pull-80kPa.csv", "calibrate", "80 kPa", ""),
    ("Reibung_2,45N.csv", "friction", "", "2.45 N"),
    ("friction-200g.csv", "friction", "", "200 gf"),
    ("friction_Circle_1bar.csv", "friction", "", ""),  # a pressure there is no vacuum of a brake
    ("pull_94.5kPa_to_60kPa.csv", "calibrate", "", ""),  # which one held?
    ("pull_40kPaabs.csv", "calibrate", "", ""),  # no vacuum but an absolute pressure
    ("x_30bar.csv", "", "", ""),  # beyond any atmosphere
    ("kapton.csv", "", "", ""),
    ("a12345678kPa.csv", "", "", ""),
])  # fmt: skip
def test_what_a_name_says(name, role, vacuum, force):
    said = parse_file_name(name)
    found = {what: said[what].text for what in said}
    assert found.get("role", "") == role
    assert found.get("vacuum", "") == vacuum
    assert found.get("normal_force", "") == force
    assert all("its name" in one.source for one in said.values())


@given(st.integers(1, 1013), st.sampled_from(["kPa", "mbar", "hPa"]), st.sampled_from("_- "))
@settings(max_examples=60, deadline=None)
def test_a_vacuum_in_a_name_is_the_number_that_stands_there(tenths, unit, mark):
    number = tenths / 10
    said = parse_file_name(f"pull{mark}{number}{unit}{mark}3.csv")["vacuum"].text
    assert parse(said, "Pa", "vacuum") == pytest.approx(number * (1e3 if unit == "kPa" else 100))


def test_the_sidecar_counts_before_content_and_content_before_the_name(tmp_path):
    rows = [f"{row},{60.0 + (i % 3) / 10}" for i, row in enumerate(make_pull_rows())]
    head = "Extension (mm),Load (N),Vacuum (kPa)"
    path = written(tmp_path, "pull_94.5kPa.csv", *rows, head=head)
    found = propose_use("k", path.name, path)
    assert found.is_usable and found.role.text == "calibrate"
    assert parse(found.facts["vacuum"].text, "Pa", "vacuum") == pytest.approx(60.1e3)
    assert "'Vacuum'" in found.facts["vacuum"].source
    (tmp_path / "pull_94.5kPa.csv.toml").write_text('vacuum = "30 kPa"\n')
    found = propose_use("k", path.name, path)
    assert (found.facts["vacuum"].text, found.facts["vacuum"].source) == ("30 kPa", "its sidecar")


def test_of_pulls_at_several_vacuums_the_highest_calibrate(tmp_path):
    names = ["pull_94.5kPa_1.csv", "pull_94kPa_2.csv", "pull_40kPa.csv", "pull.csv"]
    found = [propose_use(n, n, written(tmp_path, n, *make_pull_rows(), head="mm,N")) for n in names]
    roles = {one.key: one.role.text for one in assign_roles(found)}
    assert roles == dict(zip(names, ["calibrate", "calibrate", "validate", "calibrate"],
                             strict=True))  # fmt: skip
    assert not found[3].facts and found[3].missing_entry("calibrate", {}) == "vacuum"


def test_two_clicks_make_a_table_without_names_a_measurement(tmp_path):
    rows = [f"{i};{row}" for i, row in enumerate(make_pull_rows(";", sign=-1.0))]
    path = written(tmp_path, "friction.dat", *rows)
    assert propose_use("k", path.name, path).asks == "columns"
    assert CLICKS["columns"] in find_read_error(path) and "--" not in find_read_error(path)
    said = column_edit(path, preview_file(path), 1, "elongation", "mm")
    assert said["columns"] == "skip,elongation:mm,skip"
    shown = preview_file(path, ReadingOptions(columns=said["columns"]))
    assert shown.taken == {1: ("elongation", "mm")}
    said |= column_edit(path, shown, 2, "force", "N")
    assert said["columns"] == "skip,elongation:mm,force:N"
    path.with_name("friction.dat.toml").write_text(sidecar_text("", said))
    assert propose_use("k", path.name, path).asks == "force-sign"
    said |= reverse_sign(said, "force")
    path.with_name("friction.dat.toml").write_text(sidecar_text("", said))
    assert propose_use("k", path.name, path).is_usable
    assert read_trace(path).force.max() == pytest.approx(max(FORCE))
    assert reverse_sign(said, "force") == {"negative": ""}


def test_another_unit_outranks_the_one_in_the_head(tmp_path):
    path = written(tmp_path, "pull.csv", *make_pull_rows(), head="Extension (mm),Load (N)")
    shown = preview_file(path)
    assert shown.taken == {0: ("elongation", "mm"), 1: ("force", "N")}
    said = column_edit(path, shown, 1, "force", "lbf")
    path.with_name("pull.csv.toml").write_text(
        sidecar_text('[read]\ncolumn = "force=Load"\n', said)
    )
    assert read_trace(path).force.max() == pytest.approx(max(FORCE) * 4.4482216152605)
    assert column_edit(path, shown, 1, "", "")["columns"] == "elongation:mm,skip"
    assert shown.columns(0, "force", "N") == "force:N,skip", "a role has one column"


@pytest.mark.parametrize(("text", "kind"), [
    ('name = "x"\n[sheets]\ncount = 11\n', "brake"),
    ('[chamber]\nvolume = "7 mL"\n[pump]\nuse = "x"\n', "line"),
    ('vacuum = "94.5 kPa"\n[read]\ndecimal = ","\n', "sidecar"),
    ('name = "wrist"\nbrake = "a"\nconstraints = []\n[vary]\n', "specification"),
    ('a = 1\n', ""), ("no toml", ""),
])  # fmt: skip
def test_a_toml_goes_where_its_keys_belong(text, kind):
    assert detect_toml_kind(text) == kind


def test_what_waits_is_used_by_nobody_and_may_come_again():
    tab = Uploads()
    first = tab.store_file("a.csv", b"1", waits=True)
    assert tab.files_in_use == [] and tab.store_file("b.csv", b"1", waits=True) == first
    tab.waiting.clear()
    assert tab.files_in_use == [first]
    tab.close()


def test_what_was_accepted_is_one_step_of_undo():
    desk = Desk()
    put_edits(desk, {"a": {"role": "friction"}, "b": {"role": "calibrate", "vacuum": "1 kPa"}})
    assert get_edits(desk)["b"]["vacuum"] == "1 kPa"
    desk.undo()
    assert get_edits(desk) == {}


EXPORTS = [  # file, what is said of it, clicks until it is used, or None: refused with what to do
    ("testxpert_tra/Allong_1.TRA", "", 1),
    ("testxpert_tra/Invar_LT_05_01.TRA", "", 1),
    ("testxpert_tra/mDB1pct.TRA", "", 1),
    ("bluehill_resaved/Al5005.csv", "", 1),
    ("bluehill_like/sample_bluehill.csv", "reverse its sign", 2),
    ("bluehill_like/sample_wavematrix_torsion.csv", "Click the head", None),
    ("force_time_log/xy-trial-1.csv", "crosshead speed", 2),
    ("tribometer_umt/HT-2n-6-4_2_001.csv", "Click the head", None),
    ("pneumatic_friction_leak/friction_Circle_1bar.csv", "Click the head", None),
    ("pneumatic_friction_leak/airchamber_Prusa.csv", "Click the head", None),
    ("pneumatic_friction_leak/airchamber_Aluminium.csv", "Click the head", None),
    ("silicone_tensile/Dragon_Skin_30.csv", "layerjam enclosure", None),
    ("silicone_tensile/Dragon_Skin_20.csv", "layerjam enclosure", None),
    ("silicone_tensile/Ecoflex_00-10.csv", "layerjam enclosure", None),
    ("silicone_tensile/Ecoflex_00-30.csv", "layerjam enclosure", None),
]  # fmt: skip


@pytest.mark.parametrize(("name", "says", "clicks"), EXPORTS)
def test_real_exports_are_used_after_two_clicks_or_told_where_to_go(tmp_path, name, says, clicks):
    if not DATA.is_dir():
        pytest.skip("no shared data here")
    path = tmp_path / Path(name).name
    path.write_bytes((DATA / name).read_bytes())
    beside = path.with_name(f"{path.name}.toml")
    found = propose_use("k", path.name, path)
    done = 1  # "Use all"
    if found.asks == "force-sign":
        beside.write_text(sidecar_text("", reverse_sign({}, "force")))
        done += 1
    elif found.asks == "speed":
        beside.write_text('speed = "10 mm/min"\n')
        done += 1
    told = f"{found.about}. {CLICKS.get(found.asks, '')}"
    assert says in told and "--" not in told
    after = propose_use("k", path.name, path)
    assert (done if after.is_usable else None) == clicks, after

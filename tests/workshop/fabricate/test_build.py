"""`layerjam build`: a folder whole or not at all, the same bytes every time, refusals in words."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

import layerjam as lj
from built_parts import KAPTON
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.cli.main import main
from layerjam.core.errors import FileError, LayerjamError, QuantityError
from layerjam.workshop.fabricate.folder import LIST, check_folder, write_folder

pytestmark = pytest.mark.timing


def folder(path: Path) -> dict[str, bytes]:
    return {f.relative_to(path).as_posix(): f.read_bytes() for f in path.rglob("*") if f.is_file()}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, lj.Result]:
    place = tmp_path_factory.mktemp("build") / "kapton"
    return place, lj.build("choi2018-kapton", out=place)


def test_what_is_in_the_folder(made) -> None:
    place, found = made
    assert sorted(folder(place)) == sorted(found.files)
    assert {"bom.csv", "build.json", "cut/sheet.dxf", "print/print.3mf", "cad/sleeve.step"} <= set(
        found.files
    )
    said = json.loads((place / LIST).read_text("utf-8"))
    assert said["feasible"] is True and said["mass"] == pytest.approx(20.90578566734538e-3)
    assert len(said["brake_sha256"]) == 64


def test_the_keys_of_the_specification(made) -> None:
    _, found = made
    said = json.loads(found.json())
    keys = (
        "files mass mass_parts mass_missing fittings_mass pin_to_pin overall_length sleeve_length "
        "strap_length film_pieces film_area film_used cut_length silicone_volume silicone_mass "
        "silicone_parts printed_volume screw preload torque checks assumptions feasible reason "
        "warnings units"
    )
    assert set(keys.split()) <= set(said)
    assert {row["code"] for row in said["checks"]} == {f"C{k}" for k in range(1, 16)}
    assert all(
        {"code", "ok", "value", "limit", "unit", "text"} <= set(row) for row in said["checks"]
    )
    assert said["preload"] == pytest.approx(522.5, abs=0.1)
    assert said["torque"] == pytest.approx(0.3135, abs=1e-4)
    assert said["screw"] == "M3 × 8" and said["strap_length"] == pytest.approx(0.2144)


@pytest.mark.slow
def test_the_same_bytes_in_another_process_zone_and_locale(made, tmp_path: Path) -> None:
    place, _ = made
    code = (
        "import sys; from layerjam.cli.main import main; "
        f"sys.exit(main(['build', 'choi2018-kapton', '--out', {str(tmp_path / 'b')!r}, '--json']))"
    )
    env = {**os.environ, "TZ": "Asia/Kathmandu", "LC_ALL": "C", "PYTHONHASHSEED": "7"}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=env, check=False
    )
    assert done.returncode == 0, done.stderr
    json.loads(done.stdout)
    assert folder(tmp_path / "b") == folder(place)


REMEDIES = {
    "a hard silicone": ({}, 'elongation_at_break = "150 %"', "C5", "softer silicone"),
    "a weak tie": ({}, 'tie_tension = "2 N"', "C11", "tighten the tie to"),
    "a thick silicone": ({"wall": "0.25 mm"}, "", "C12", "a thicker wall"),
    "a strong brake": ({"scale_factor": 20.0}, "", "C8", "more screws (mount.screws)"),
}


@pytest.mark.parametrize("name", sorted(REMEDIES))
def test_what_does_not_pass_says_what_to_change(name: str) -> None:
    from layerjam.workshop.commands.build import judge_build

    changes, row, code, remedy = REMEDIES[name]
    text = KAPTON.with_(**changes).text if changes else KAPTON.text
    if code == "C5":
        text = text.replace('use = "ecoflex-5"', f'use = "ecoflex-5"\n{row}')
    elif code == "C12":
        text = text.replace('use = "ecoflex-5"', 'use = "dragon-skin-10"')
    elif row:
        text += f"\n[build]\n{row}\n"
    failed = [c for c in judge_build(BrakeFile.read(text, "b")).checks if c["ok"] is False]
    (said,) = (c["text"] for c in failed if c["code"] == code and remedy in c["text"])
    assert f"{code}: " not in said


def test_arrays_have_everything_several_times(tmp_path: Path) -> None:
    found = lj.build(KAPTON, out=tmp_path / "a", parallel=2, series=2, coupons=True, no_step=True)
    assert found.brakes == 4
    assert {"cut/yoke.dxf", "cut/link.dxf", "cut/coupon.dxf"} <= set(found.files)
    assert not [name for name in found.files if name.startswith("cad/")]
    assert found.yoke_moment == pytest.approx(1.37, abs=0.005)
    rows = (tmp_path / "a" / "bom.csv").read_text("utf-8")
    for row in ("sheet,", "yoke,", "link,"):
        assert row in rows
    assert '\nsheet,"film 0.254 mm thick, Kapton HN polyimide film",44,pieces' in rows
    assert "cad/" not in rows  # without STEP no file of it is named


@pytest.mark.parametrize(("count", "moment"), [(2, 1.37), (3, 2.73), (5, 8.20)])
def test_the_moment_of_a_yoke(count: int, moment: float) -> None:
    from layerjam.workshop.fabricate.choices import resolve_choices
    from layerjam.workshop.fabricate.drawing import draw_build

    made = draw_build(KAPTON, resolve_choices(KAPTON), 250.79964, count)
    assert made.yoke_moment == pytest.approx(moment, abs=0.0051)


CANNOT = {
    "short clamp": ({"length": "84 mm", "clamped_length": "5 mm"}, {}, "longer sheets"),
    "high stack": ({"count": 240}, {}, "longest available is 60 mm"),
    "narrow": ({"width": "8 mm"}, {}, "M3 nut"),
    "printer": ({}, {"print_bed": "145x145x160mm"}, "too large for the printer by 6 mm along z"),
    "thin sleeve": ({"wall": "0.2 mm"}, {}, "too thin to leave it unknown"),
}


@pytest.mark.parametrize("name", sorted(CANNOT))
def test_cannot_is_an_answer_and_writes_nothing(name: str, tmp_path: Path) -> None:
    changes, more, said = CANNOT[name]
    if name == "narrow":
        changes = {**changes, "screw_hole": "3 mm"}
    found = lj.build(KAPTON.with_(**changes), out=tmp_path / "x", no_step=True, **more)
    assert found.feasible is False and found.exit_code == 1
    assert said in (found.reason or "")
    assert list(tmp_path.iterdir()) == [] and found.files == []
    json.loads(found.json())


WRONG = {
    "kerf as wide as the hole": ('kerf = "1 mm"\ngap = "0.9 mm"', "not less than build.gap"),
    "deep groove": ('tie_depth = "5 mm"', "build.tie_depth"),
    "wide bore": ('air_bore = "4.2 mm"', "build.air_bore"),
    "round edge": ('cheek = "4 mm"\nedge = "2.5 mm"', "build.edge"),
    "no floor for keys": ('mould_wall = "1 mm"', "build.mould_wall"),
    "thick key": ('key = "11 mm"', "build.key"),
}


@pytest.mark.parametrize("name", sorted(WRONG))
def test_bad_input_is_one_sentence(name: str, tmp_path: Path) -> None:
    rows, said = WRONG[name]
    with pytest.raises(LayerjamError, match=said):
        lj.build(BrakeFile.read(f"{KAPTON.text}\n[build]\n{rows}\n", "b"), out=tmp_path / "x")
    assert list(tmp_path.iterdir()) == []


LATE = ('tie_depth = "5 mm"', 'air_bore = "4.2 mm"', 'mould_wall = "1 mm"', 'key = "11 mm"')


@pytest.mark.parametrize("row", LATE)
def test_what_is_found_after_reading_names_file_and_line(row: str, tmp_path: Path) -> None:
    """Of the brake's file or the workshop's, whichever gives it; an option has no line."""
    brake, shop = tmp_path / "mine.toml", tmp_path / "shop.toml"
    head = KAPTON.text.count("\n") + 3
    brake.write_text(f"{KAPTON.text}\n[build]\n{row}\n", "utf-8")
    with pytest.raises(FileError) as raised:
        lj.build(brake, out=tmp_path / "x")
    assert (raised.value.path, raised.value.line) == (str(brake), head)
    assert f"build.{row.split(maxsplit=1)[0]}: " in str(raised.value)
    shop.write_text(f"# ours\n\n[build]\ncutter = 'knife'\n{row}\n", "utf-8")
    with pytest.raises(FileError) as raised:
        lj.build(KAPTON, out=tmp_path / "x", workshop=shop)
    assert (raised.value.path, raised.value.line) == (str(shop), 5)
    assert sorted(tmp_path.iterdir()) == [brake, shop]


def test_the_brakes_file_is_named_where_it_counts_more_than_the_workshops(tmp_path: Path) -> None:
    brake, shop = tmp_path / "mine.toml", tmp_path / "shop.toml"
    brake.write_text(f'{KAPTON.text}\n[build]\ntie_depth = "5 mm"\n', "utf-8")
    shop.write_text('[build]\ntie_depth = "0.5 mm"\nkerf = "0.2 mm"\n', "utf-8")
    with pytest.raises(FileError, match=r"mine\.toml, line \d+: build\.tie_depth"):
        lj.build(brake, out=tmp_path / "x", workshop=shop)
    with pytest.raises(FileError, match=r"shop\.toml, line 3: build\.kerf: 0\.2 mm must be 0"):
        lj.build(KAPTON, out=tmp_path / "x", workshop=shop, cutter="knife")
    shop.write_text('[build]\ngap = "0.5 mm"\nkerf = "0.2 mm"\n', "utf-8")
    with pytest.raises(QuantityError, match=r"^build\.kerf: 0\.9 mm is not less than build\.gap"):
        lj.build(KAPTON, out=tmp_path / "x", workshop=shop, kerf="0.9 mm")


def test_sizes_and_counts_are_checked(tmp_path: Path) -> None:
    for more in ({"stock": "0.5x10mm"}, {"laser_bed": "600mm"}, {"parallel": 0}, {"kerf": "3 mm"}):
        with pytest.raises(QuantityError):
            lj.build(KAPTON, out=tmp_path / "x", **more)
    with pytest.raises(QuantityError, match="at most 100"):
        lj.build(KAPTON, out=tmp_path / "x", parallel=11, series=10)


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["--print-bed", "145x145x160mm"], 1, "too large for the printer by 6 mm along z"),
        (["--stock", "60x300mm"], 1, "exceeds the stock by"),
        (["--laser-bed", "90 mm x 50 mm"], 1, "exceeds the laser bed by"),
        (["--laser-bed", "100x50"], 2, "has no unit"),
        (["--kerf", "0.2"], 2, "has no unit"),
        (["--cutter", "axe"], 2, "unknown cutter"),
        (["--cutter", "knife", "--kerf", "0.1mm"], 2, "plotter applies its own offset"),
    ],
)
def test_refusals_on_the_command_line(
    words: list[str], code: int, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = str(tmp_path / "x")
    assert main(["build", "choi2018-kapton", "--out", out, "--no-step", *words, "--json"]) == code
    printed = capsys.readouterr()
    assert list(tmp_path.iterdir()) == []
    if code == 1:
        assert said in json.loads(printed.out)["reason"]
    else:
        assert printed.out == "" and said in printed.err and printed.err.count("\n") == 1


def test_a_folder_that_exists_is_not_touched(tmp_path: Path) -> None:
    place = tmp_path / "here"
    write_folder(place, {LIST: json.dumps({"files": [LIST, "cut/a"]}), "cut/a": b"1"})
    with pytest.raises(FileError, match="already exists"):
        check_folder(place, False)
    write_folder(place, {LIST: json.dumps({"files": [LIST]})}, overwrite=True)
    assert set(folder(place)) == {LIST}
    (place / "notes.txt").write_text("mine")
    with pytest.raises(FileError, match=r"contains notes\.txt, which `build` did not write"):
        write_folder(place, {LIST: "{}"}, overwrite=True)
    assert (place / "notes.txt").read_text() == "mine"
    assert [f.name for f in tmp_path.iterdir()] == ["here"]
    (tmp_path / "file").write_text("")
    for bad, said in (("file", "is a file"), ("no/such", "there is no folder")):
        with pytest.raises(FileError, match=said):
            check_folder(tmp_path / bad, True)


KILLED = """
import os, sys
from pathlib import Path
from layerjam.workshop.fabricate.folder import write_folder
content = {f"cut/{k}": os.urandom(20000) for k in range(300)}
content["build.json"] = '{"files": ' + str(sorted([*content, "build.json"])).replace("'", '"') + "}"
print("ready", flush=True)
while True:
    write_folder(Path(sys.argv[1]), content, overwrite=True)
"""


@pytest.mark.parametrize(
    "delays",
    [(0.01, 0.06), pytest.param((0.002, 0.03, 0.11), marks=pytest.mark.slow)],
    ids=["two", "three"],
)
def test_killed_at_any_moment_it_leaves_a_whole_folder_or_none(
    delays: tuple[float, ...], tmp_path: Path
) -> None:
    place = tmp_path / "k"
    for delay in delays:
        process = subprocess.Popen(
            [sys.executable, "-c", KILLED, str(place)], stdout=subprocess.PIPE, text=True
        )
        assert process.stdout is not None and process.stdout.readline() == "ready\n"
        time.sleep(delay)
        process.kill()
        process.wait()
        process.stdout.close()
        if place.exists():
            assert len(folder(place)) == 301
            assert all(len(data) == 20000 for n, data in folder(place).items() if n != LIST)


def test_without_the_extras(tmp_path: Path) -> None:
    code = """
import sys
class Block:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {blocked!r}:
            raise ImportError(name)
sys.meta_path.insert(0, Block())
from layerjam.cli.main import main
sys.exit(main(["build", "choi2018-kapton", "--out", {out!r}, "--no-step", "--json"]))
"""
    words = code.format(blocked=("manifold3d",), out=str(tmp_path / "x"))
    done = subprocess.run(
        [sys.executable, "-c", words], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2 and done.stdout == "" and "[build]" in done.stderr
    assert list(tmp_path.iterdir()) == []

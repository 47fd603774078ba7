"""The part Build of the brake's page without a browser: verdict, refusals, the folder."""

from __future__ import annotations

import asyncio
import base64
import io
import json
import multiprocessing
import subprocess
import sys
import zipfile

import numpy as np
import pytest

from layerjam.brake.device.load import load
from layerjam.core.installation import install_command
from layerjam.workbench.call import parameters
from layerjam.workbench.desk import Desk
from layerjam.workbench.pages.brake import Brake
from layerjam.workbench.pages.brake_build import checks_table
from layerjam.workbench.pages.brake_parts import UNIT
from layerjam.workbench.state import State
from layerjam.workshop.commands.build import build, judge_build
from layerjam.workshop.figures.build_scene import CORE, LEFT, PLATE, PRINTED, RIGHT, SILICONE
from printed import split_command
from workbench.standing import standing

pytest.importorskip("ezdxf")
pytest.importorskip("manifold3d")
pytest.importorskip("typst")


def page_of(brake: str = "choi2018-kapton", **settings) -> Brake:
    return Brake(Desk(State(brake=brake, settings={"brake": {"part": "build", **settings}})))


def shown(page: Brake):
    builds, found = page.compute()
    assert builds
    return found


@pytest.mark.slow
def test_the_verdict_is_the_commands(tmp_path):
    """What is shown before a file is made is what the folder's own list says."""
    page = page_of(cutter="knife")
    folder = page.making.write_folder()
    with zipfile.ZipFile(io.BytesIO(folder.content)) as archive:
        assert archive.testzip() is None
        names = archive.namelist()
        listed = json.loads(archive.read("choi2018-kapton-build/build.json"))
    assert sorted(names) == [f"choi2018-kapton-build/{name}" for name in folder.result.files]
    said = json.loads(shown(page).answer.result.json())
    for key in said.keys() - {"files", "warnings", "file"}:
        assert said[key] == listed[key], key
    assert {*said["warnings"]} <= {*listed["warnings"]}


def test_a_refusal_is_the_commands_and_makes_nothing(tmp_path):
    thin = load("choi2018-kapton").with_(width="7 mm")
    told = build(thin, out=tmp_path / "x")
    found = judge_build(thin)
    assert not found.feasible
    assert found.reason == told.reason
    page = page_of("choi2018-ptfe", cutter="laser")
    refused = shown(page).answer.result
    assert not refused.feasible
    assert refused.reason.startswith("C15: ")
    table = checks_table(refused)
    assert table.count("✗ refused") == 1
    assert "! check" in table  # what is only warned of
    folder = page.making.write_folder()
    assert (folder.content, folder.result.reason) == (b"", refused.reason)


def test_every_check_is_a_row_with_its_number_and_limit():
    result = shown(page_of()).answer.result
    rows = checks_table(result).split("<tr>")[2:]
    assert len(rows) == len(result.checks)
    words = {True: "✓ ok", False: "! check", None: "– not checked"}
    for row, check in zip(rows, result.checks, strict=True):
        assert words[check["ok"]] in row
        assert f"<td>{check['code']}</td>" in row
    (bearing,) = (r for r in rows if "bearing on the screw" in r)
    assert ">65.83 MPa<" in bearing
    assert ">69 MPa<" in bearing
    (girth,) = (r for r in rows if "over the head" in r)
    assert ">22.5%<" in girth


def volume(surface) -> float:
    """Inside the triangles that the browser is given [mm³]."""
    places = np.frombuffer(base64.b64decode(surface.corners), "<f4").reshape(-1, 3) * UNIT
    faces = np.frombuffer(base64.b64decode(surface.triangles), "<u4").reshape(-1, 3)
    a, b, c = (places[faces[:, k]].astype(float) for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def test_the_browser_is_given_the_parts_that_are_made():
    """Volumes by the triangles as sent, in 32 bits, and by the closed form of the solids."""
    found = shown(page_of(drawn="mould"))
    solid = {part.name: part.solid.volume for part in found.answer.result.record.parts}
    sent = {surface.colour: volume(surface) for surface in found.parts.surfaces}
    halves = solid["mould-top"] + solid["mould-bottom"]
    assert sent[PRINTED] == pytest.approx(halves, rel=2e-3)
    assert sent[CORE] == pytest.approx(solid["core"], rel=1e-5)
    apart = shown(page_of())
    sent = {surface.colour: volume(surface) for surface in apart.parts.surfaces}
    assert sent[PRINTED] == pytest.approx(2 * solid["cap"], rel=2e-3)
    assert sent[PLATE] == pytest.approx(2 * solid["plate"], rel=2e-3)
    assert sent[SILICONE] == pytest.approx(solid["sleeve"], rel=1e-5)
    lengths = apart.answer.result.record.lengths
    sheets = lengths.count * lengths.width * lengths.sheet_length * lengths.thickness
    assert 0.97 * sheets < sent[LEFT] + sent[RIGHT] < sheets  # holes and corners are missing
    assert shown(page_of("choi2018-ptfe", cutter="laser")).parts is None


def test_what_is_copied_writes_the_folder():
    page = page_of(cutter="knife", coupons="yes")
    (call,) = page.calls()
    assert call.command_line() == (
        "layerjam build choi2018-kapton --cutter knife --coupons --out choi2018-kapton-build "
        "--overwrite"
    )
    assert 'lj.build("choi2018-kapton", cutter="knife", coupons=True, out=' in call.python_code()
    assert [c.name for c in page_of(part="brake").calls()] == ["show", "force"]


def test_every_input_of_the_command_is_offered():
    """From its declaration; the folder is downloaded, so that it is nowhere to be replaced."""
    part = page_of().making
    offered = {p.name for p in part.more.inputs} | {"cutter", "coupons"}
    declared = {p.name for p in parameters("build").values() if not p.positional}
    assert offered == declared - {"out", "overwrite", "progress"}
    assert list(part.more.files) == ["workshop"]


SET = {
    "cutter": "laser",
    "coupons": "yes",
    "kerf": "0.15 mm",
    "stock": "300x200mm",
    "laser_bed": "600x400mm",
    "print_bed": "200x145x175mm",
    "parallel": "2",
    "series": "3",
    "no_step": True,
}


def test_what_is_set_counts_in_the_verdict():
    result = shown(page_of(**SET)).answer.result
    assert result.brakes == 6
    assert result.film_pieces == 2  # 66 sheets, three times eleven on a piece
    rows = {(check["code"], check["key"]): check for check in result.checks}
    assert rows["C2", "laser-bed"]["ok"]
    assert rows["C2", "print-bed"]["ok"]
    assert rows["C15", "film-and-laser"]["ok"]
    small = shown(page_of(**{**SET, "print_bed": "145x145x145mm"})).answer.result
    assert not small.feasible
    assert "too large for the printer" in small.reason


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["python", "command"])
def test_what_is_copied_runs_in_a_fresh_process(kind, tmp_path):
    page = page_of(**SET)
    (call,) = page.calls()
    if kind == "python":
        words = [sys.executable, "-c", call.python_code()]
    else:
        code = "from layerjam.cli.start import run; run()"
        words = [sys.executable, "-c", code, *split_command(call.command_line())[1:]]
    done = subprocess.run(words, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    listed = json.loads((tmp_path / call.out / "build.json").read_text("utf-8"))
    said = json.loads(shown(page).answer.result.json())
    for key in said.keys() - {"files", "warnings", "file"}:
        assert said[key] == listed[key], key
    assert (tmp_path / call.out / "cut" / "coupon.dxf").is_file()
    assert not (tmp_path / call.out / "cad").exists()


def test_without_the_extra_a_sentence_says_so(monkeypatch):
    monkeypatch.setitem(sys.modules, "manifold3d", None)
    found = shown(page_of())
    assert found.answer.result is None
    assert install_command("build") in found.answer.refusal


def test_the_brakes_page_loads_nothing_that_draws_or_builds():
    names = "('manifold3d', 'ezdxf', 'layerjam.workshop.fabricate.drawing')"
    code = "import sys, layerjam.workbench.pages.brake; "
    code += f"print([n for n in {names} if n in sys.modules])"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout.strip() == "[]"


def test_a_build_is_stopped(monkeypatch):
    maker = (part := page_of().making).maker
    tell, heard = maker.report_progress, []

    def stopped_at_once(what: str, share: float) -> None:
        heard.append(what)
        maker.stop()
        tell(what, share)

    monkeypatch.setattr(maker, "report_progress", stopped_at_once)
    monkeypatch.setattr(maker, "_elsewhere", asyncio.to_thread)
    asyncio.run(maker.request_result())
    assert heard == [""]  # before it began to draw
    assert not multiprocessing.active_children()
    assert part.folder is None
    assert part._trouble == "stopped"


def test_the_part_is_opened_and_refuses_in_words():
    async def drive() -> None:
        async with standing(Brake) as (user, pages):
            await user.should_see("Peak force of a pull at the site", retries=100)
            assert not pages[0].making.built
            pages[0].desk.put_setting("brake", "part", "build")
            await user.should_see("It can be built as drawn", retries=100)
            pages[0].desk.put_brake("choi2018-ptfe")
            pages[0].desk.put_setting("brake", "cutter", "laser")
            await user.should_see("It cannot be built as drawn", retries=100)
            await user.should_see("C15: ")
            await pages[0].wait_until_idle()
            assert not pages[0].making.button.enabled

    asyncio.run(drive())

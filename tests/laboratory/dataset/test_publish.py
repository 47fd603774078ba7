"""`publish` and `recompute`: a campaign stands alone, and what is changed in it is found."""

from __future__ import annotations

import csv
import hashlib
import json
import shutil
import sys
import zipfile
from datetime import datetime
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import pytest
from rocrate.rocrate import ROCrate

from laboratory.figures.brake_files import BRAKE, Campaign, campaign
from layerjam.core.errors import FileError, MissingExtraError
from layerjam.laboratory.commands.calibration import calibrate
from layerjam.laboratory.commands.left_out import LeftOut
from layerjam.laboratory.commands.publish import Published, Recomputed, publish, recompute
from layerjam.laboratory.measure.sidecar import Facts, write_facts

pytestmark = pytest.mark.slow
OLDER = Path(__file__).parent / "published-0.1.0.zip"
"""Of `layerjam 0.1.0`, without report.html, report.pdf and figures, which nothing is computed from;
its checksums name what is left."""


class Later(datetime):
    @classmethod
    def now(cls, tz: Any = None) -> Any:
        return datetime(2031, 2, 3, tzinfo=tz)


@pytest.fixture(scope="module")
def tests(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder as it lies beside a test machine: measurements, facts, a calibrated brake, notes."""
    folder = tmp_path_factory.mktemp("tests")
    made: Campaign = campaign(folder)
    for path in made.friction:
        write_facts(path, Facts(normal_force=2.45, brake=BRAKE, synthetic=True), overwrite=True)
    calibrate(BRAKE, made.pulls, out=folder / "calibrated.toml")
    (folder / "my notes ü.txt").write_text("the third pull was done after lunch\n")
    (folder / "run.ljrun").write_bytes(b"SQLite format 3\0 as it is")
    return folder


@pytest.fixture(scope="module")
def published(tests: Path, tmp_path_factory: pytest.TempPathFactory) -> Published:
    out = tmp_path_factory.mktemp("out") / "data set"
    people = ["Ada Lovelace,0000-0002-1825-0097", "Émilie du Châtelet"]
    return publish(tests, out=out, brake=BRAKE, line="choi2018", licence="CC-BY-4.0", author=people)


def again(published: Published, tmp_path: Path) -> Path:
    copy = tmp_path / "copy"
    shutil.copytree(published.folder, copy)
    return copy


def test_everything_is_there_and_nothing_was_touched(tests: Path, published: Published) -> None:
    root = Path(published.folder)
    for path in tests.iterdir():
        assert (root / "data" / path.name).read_bytes() == path.read_bytes()
    assert {"brake.toml", "line.toml", "brake-calibrated.toml", "README.md"} <= {*published.files}
    assert {"report/report.html", "report/results.json"} <= {*published.files}
    for line in (root / "checksums.sha256").read_text().splitlines():
        digest, name = line.split("  ", 1)
        assert hashlib.sha256((root / name).read_bytes()).hexdigest() == digest


def test_the_calibrated_brake_says_which_pulls_are_which(published: Published) -> None:
    counts = (published.friction_tests, published.calibrated_on, published.validated_on)
    assert counts == (3, 3, 8)
    assert [w.key for w in published.warnings] == ["synthetic"]


def test_no_path_of_this_machine_is_published(published: Published) -> None:
    root = Path(published.folder)
    for name in ("report/results.json", "report/report.html", "recipe.json", "brake.toml"):
        assert str(root.parent) not in (root / name).read_text(), name
        assert ".layerjam-" not in (root / name).read_text(), name


def test_the_description_is_an_ro_crate(published: Published) -> None:
    root = Path(published.folder)
    read = ROCrate(root)
    assert read.metadata.version == "1.1"
    assert read.license["identifier"] == "CC-BY-4.0"
    names = [one["name"] for one in read.root_dataset["author"]]
    assert names == ["Ada Lovelace", "Émilie du Châtelet"]
    described = {unquote(e.id): e for e in read.data_entities if e.type == "File"}
    assert {*described} == {*published.files} - {"ro-crate-metadata.json"}
    assert "sha256" not in described.pop("checksums.sha256")  # it holds that of the description
    for name, entity in described.items():
        assert entity["sha256"] == hashlib.sha256((root / name).read_bytes()).hexdigest()
    (action,) = [e for e in read.contextual_entities if e.type == "CreateAction"]
    assert len(action["object"]) == 1 + 3 + 3 + 8


def test_the_numbers_come_out_again(published: Published, tmp_path: Path) -> None:
    found = recompute(published.folder)
    assert found.equal and found.exit_code == 0
    assert found.numbers > 300
    assert not (found.differs or found.changed_files or found.added_files)
    packed = shutil.make_archive(str(tmp_path / "sent"), "zip", published.folder)
    assert recompute(packed).equal


def force_in(line: str) -> float:
    """The last cell of a row of numbers [N]."""
    (row,) = csv.reader([line]) if line.strip() else ([""],)
    return float(row[-1]) if row[-1].replace(".", "").isdigit() else 0.0


def test_one_digit_of_a_raw_file_is_found(published: Published, tmp_path: Path) -> None:
    copy = again(published, tmp_path)
    path = copy / "data" / "pull-2.csv"
    lines = path.read_text().splitlines(keepends=True)
    at = max(range(len(lines)), key=lambda i: force_in(lines[i]))
    (row,) = csv.reader([lines[at]])
    lines[at] = lines[at].replace(row[-1], "9" + row[-1][1:])  # 17x.y N becomes 97x.y N
    path.write_text("".join(lines))
    found = recompute(copy)
    assert not found.equal and found.exit_code == 1
    assert found.changed_files == ["data/pull-2.csv"]
    by = {one["number"]: one for one in found.differs}
    one = by["calibration.peak_force"]
    assert one["file"] == "report/results.json"
    assert one["share"] == pytest.approx(abs(one["recomputed"] / one["published"] - 1))
    assert not any(name.startswith("friction.") for name in by)


def test_a_published_number_that_was_polished_is_found(
    published: Published, tmp_path: Path
) -> None:
    copy = again(published, tmp_path)
    path = copy / "report" / "results.json"
    held: dict[str, Any] = json.loads(path.read_text())
    held["validation"]["mape"] /= 2
    path.write_text(json.dumps(held))
    found = recompute(copy)
    assert [(d["number"], round(d["share"], 9)) for d in found.differs] == [("validation.mape", 1)]
    assert found.changed_files == ["report/results.json"]


def test_a_dataset_published_on_another_day_recomputes(
    published: Published, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in ("laboratory.identify.provenance", "laboratory.commands.stages", "core.verdict"):
        monkeypatch.setattr(f"layerjam.{module}.datetime", Later)
    found = recompute(published.folder)
    assert found.equal, found.differs


def test_a_dataset_of_an_older_version_still_recomputes() -> None:
    found: Recomputed = recompute(OLDER)
    assert found.versions["published"]["layerjam"] == "0.1.0"
    assert found.numbers > 200 and not (found.changed_files or found.added_files)
    # intervals rest on the scatter between mountings since; no estimate moved
    stages = [one["number"] for one in found.differs if one["file"] == "report/results.json"]
    parts = ("intervals", "standard_errors", "bootstrap")
    assert all(number.split(".")[1] in parts for number in stages), stages
    assert {"recipe.json", "brake-calibrated.toml"} <= {*found.not_compared}
    assert found.equal is False and found.exit_code == 1


def test_an_accepted_failure_travels_and_recomputes(
    tests: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "tests"
    shutil.copytree(tests, folder)
    path = folder / "friction-2.csv"
    lines = path.read_text().split("\n")
    head = next(i for i, line in enumerate(lines) if "(N)" in line)
    for i, line in enumerate(lines[head + 1 :], head + 1):
        if line.count(",") == 2:
            rest, _, force = line.rpartition(",")
            lines[i] = f'{rest},"{float(force.strip(chr(34))) / 1000:.9f}"'
    path.write_text("\n".join(lines))
    out = tmp_path / "out"
    failed = publish(folder, out=out, brake=BRAKE)
    assert failed.exit_code == 4 and failed.folder is None
    assert sorted(p.name for p in tmp_path.iterdir()) == ["tests"]
    reasons = {row["name"]: "the sled was lifted" for row in failed.failed_checks}
    accepted = publish(folder, out=out, brake=BRAKE, accept=reasons)
    assert accepted.verdict == "accepted" and accepted.exit_code == 0
    assert "the sled was lifted" in (out / "README.md").read_text()
    for module in ("laboratory.identify.provenance", "laboratory.commands.stages", "core.verdict"):
        monkeypatch.setattr(f"layerjam.{module}.datetime", Later)
    again = recompute(out)
    assert again.equal and (again.verdict, again.exit_code) == ("accepted", 0)
    assert {row["reason"] for row in again.accepted} == {"the sled was lifted"}
    recipe = (out / "recipe.json").read_text()
    (out / "recipe.json").write_text(recipe.replace("the sled was lifted", "all is well"))
    found = recompute(out)
    assert {"README.md", "report/report.html"} <= {one["file"] for one in found.differs}


def test_options_and_files_left_out_are_part_of_it(tests: Path, tmp_path: Path) -> None:
    pulls = [tests / f"pull-{n}.csv" for n in (1, 2, 3)]
    out = tmp_path / "out"
    why = {str(pulls[2]): "the enclosure was torn"}
    found = publish(
        tests, out=out, brake=BRAKE, pulls=pulls, atmosphere="98 kPa", left_out=LeftOut(exclude=why)
    )
    said = json.loads((out / "recipe.json").read_text())
    assert said["options"] == {
        "atmosphere": 98e3,
        "exclude": {"data/pull-3.csv": "the enclosure was torn"},
    }
    assert {row["file"] for row in said["unused"]} == {
        *(f"data/friction-{n}.csv" for n in (1, 2, 3)),
        *(f"data/{p.name}" for p in tests.glob("check-*.csv")),
        "data/pull-3.csv",
    }
    assert found.calibrated_on == found.validated_on == 2
    assert recompute(out).equal


def test_a_missing_measurement_is_named(published: Published, tmp_path: Path) -> None:
    copy = again(published, tmp_path)
    (copy / "data" / "pull-3.csv").unlink()
    found = recompute(copy)
    assert not found.equal and found.changed_files == ["data/pull-3.csv"]


def test_only_a_dataset_is_replaced(tests: Path, published: Published, tmp_path: Path) -> None:
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.txt").write_text("mine")
    for overwrite in (False, True):
        with pytest.raises(FileError, match="not a dataset"):
            publish(tests, out=mine, brake=BRAKE, overwrite=overwrite)
    with pytest.raises(FileError, match="own folder"):
        publish(tests, out=tests / "dataset", brake=BRAKE)
    with pytest.raises(FileError, match="--overwrite"):
        publish(tests, out=published.folder, brake=BRAKE)
    assert [p.name for p in mine.parent.iterdir()] == ["mine"]


def test_a_pdf_is_not_passed_over_without_typst(
    published: Published, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "typst", None)
    with pytest.raises(MissingExtraError, match=r"\[publish\]"):
        recompute(published.folder)


def test_a_campaign_that_does_not_say_its_brake(tmp_path: Path) -> None:
    made = campaign(tmp_path)
    for path in [*made.pulls, *made.validate]:
        path.with_name(path.name + ".toml").unlink()
    with pytest.raises(FileError, match="--brake"):
        publish(tmp_path, out=tmp_path.parent / "never")
    assert not (tmp_path.parent / "never").exists()
    (tmp_path / "empty").mkdir()
    with pytest.raises(FileError, match="no readable measurement"):
        publish(tmp_path / "empty", out=tmp_path.parent / "never")


def test_a_refused_measurement_is_published_and_counts_nowhere(tmp_path: Path) -> None:
    folder = tmp_path / "tests"
    folder.mkdir()
    made = campaign(folder)
    broken = Path(made.pulls[0])
    broken.write_text("\n".join(broken.read_text().splitlines()[:40]) + "\n1,")
    found = publish(folder, out=tmp_path / "out", brake=BRAKE, holdout=["46.1kPa"])
    root = tmp_path / "out"
    said = json.loads((root / "recipe.json").read_text())
    (row,) = said["unused"]
    assert (row["file"], row["use"]) == (f"data/{broken.name}", "calibrate")
    assert f"data/{broken.name}" in said["calibrate"]
    assert found.calibrated_on == len(said["calibrate"]) - 1
    assert (root / "data" / broken.name).read_bytes() == broken.read_bytes()
    assert f"Not used: `data/{broken.name}`" in (root / "README.md").read_text()
    assert recompute(root).equal


def test_a_refusal_names_the_users_own_file(tmp_path: Path) -> None:
    folder = tmp_path / "tests"
    folder.mkdir()
    made = campaign(folder)
    for path in made.friction:
        path.with_name(path.name + ".toml").unlink(missing_ok=True)
    with pytest.raises(FileError, match="normal force|normal force") as refused:
        publish(folder, out=tmp_path / "out", brake=BRAKE, friction=made.friction)
    assert Path(refused.value.path).parent == folder


def test_a_broken_dataset_is_one_sentence(published: Published, tmp_path: Path) -> None:
    copy = again(published, tmp_path)
    (copy / "recipe.json").write_text("{")
    with pytest.raises(FileError, match=r"recipe\.json"):
        recompute(copy)
    with zipfile.ZipFile(tmp_path / "empty.zip", "w"):
        pass
    with pytest.raises(FileError, match="is not a dataset"):
        recompute(tmp_path / "empty.zip")

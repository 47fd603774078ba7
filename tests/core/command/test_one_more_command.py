"""One more command, declared here and nowhere else, is complete wherever commands are met."""

from __future__ import annotations

import importlib
import importlib.util
import json
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any

import pytest

import json_schema
from layerjam.brake.commands import drop as drop_command
from layerjam.cli.main import main
from layerjam.core.command.declare import REGISTRY, command, load_command
from layerjam.core.command.index import DECLARED, EXAMPLES, commands
from layerjam.core.command.results import Result, fact, number, result
from layerjam.core.command.schema import command_schema, schema
from layerjam.core.errors import QuantityError
from layerjam.core.units import QuantitySpec
from printed import split_command

ROOT = Path(__file__).parents[3]
DEPTH = QuantitySpec("m", "depth of the dive", lo=1e-3, hi=300, example="12m", symbol="z")
EXAMPLE = "layerjam dive --depth 12m"


@result
class Dive(Result):
    """What a diver feels."""

    pressure: float = number("Pa", "pressure above the surface's")
    feasible: bool = fact("whether a diver may go there")


@pytest.fixture
def dive(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """The command `dive`: one quantity, and its physics."""
    monkeypatch.setitem(EXAMPLES, "dive", [EXAMPLE])

    @command("predict")
    def dive(*, depth: Annotated[float | str, DEPTH]) -> Dive:
        """Pressure of water at a depth."""
        pressure = 1000 * 9.81 * depth
        return Dive(pressure=pressure, feasible=pressure < 4e5)

    yield dive
    del REGISTRY["dive"], DECLARED["dive"]


def said(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    code = main(words)
    out, err = capsys.readouterr()
    return code, re.sub(r"\s+", " ", out), err


@pytest.fixture
def generate() -> ModuleType:
    """docs/generate.py."""
    spec = importlib.util.spec_from_file_location("docs_generate", ROOT / "docs" / "generate.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_python_takes_text_and_si_and_checks_bounds(dive: Any) -> None:
    assert dive(depth="1200 cm").pressure == dive(depth=12).pressure == pytest.approx(117_720)
    for wrong, words in (
        ("12", "unit"),
        ("12 s", "depth"),
        (301.0, "at most 300 m"),
        (None, "missing"),
    ):
        with pytest.raises(QuantityError, match=words):
            dive(depth=wrong)
    assert repr(dive(depth=12)).split() == ["pressure", "117.7", "kPa", "feasible", "yes"]


def test_it_stands_in_the_index_under_its_group(dive: Any) -> None:
    entry = commands()["dive"]
    assert (entry.group, entry.summary) == ("predict", "Pressure of water at a depth.")
    assert load_command("dive").result is Dive
    grouped = [e.name for e in commands().values() if e.group == "predict"]
    assert grouped[-1] == "dive"


def test_the_command_line_has_it(dive: Any, capsys: pytest.CaptureFixture[str]) -> None:
    assert "dive Pressure of water at a depth" in said(capsys, "help", "all")[1]
    _, text, _ = said(capsys, "dive", "--help")
    assert "--depth Q Depth of the dive, e.g. 12m. [required]" in text and EXAMPLE in text
    assert said(capsys, *EXAMPLE.split()[1:])[:2] == (0, "pressure 117.7 kPa feasible yes ")
    code, text, _ = said(capsys, "dive", "--depth", "100m", "--json")
    assert code == 1
    assert json.loads(text) == {
        "pressure": pytest.approx(981e3),
        "feasible": False,
        "units": {"pressure": "Pa"},
        "warnings": [],
    }
    for wrong, words in (("12", "has no unit"), ("1km", "at most 300 m")):
        code, text, err = said(capsys, "dive", "--depth", wrong)
        assert (code, text) == (2, "") and words in err and err.count("\n") == 1


def test_its_answers_have_a_schema(dive: Any) -> None:
    about = command_schema(load_command("dive"))
    assert about["properties"]["pressure"] == {
        "type": "number",
        "description": "pressure above the surface's",
        "unit": "Pa",
    }
    whole = json.loads(schema("dive").json())
    answer = json.loads(dive(depth=12).json())
    assert json_schema.problems(answer, whole) == []
    assert json_schema.problems({**answer, "pressure": "high"}, whole)
    assert json_schema.problems({**answer, "depth": 12.0}, whole)


def test_the_page_has_its_control_and_copies_it(dive: Any) -> None:
    pytest.importorskip("nicegui")
    from layerjam.workbench import more
    from layerjam.workbench.call import Call, result_fields
    from layerjam.workbench.controls import control

    (depth,) = more.find_other_inputs("dive", ())
    assert depth.spec == DEPTH and "at most 300 m" in more.find_refusal(depth, "1 km")
    depth_control = control("dive", "depth", 12.0, (1.0, 40.0))
    assert depth_control.spec == DEPTH and "at most 300 m" in depth_control.help
    call = Call("dive", options={"depth": depth_control.text(12.0)})
    assert call.run().pressure == dive(depth=12).pressure
    assert split_command(call.command_line()) == ["layerjam", "dive", "--depth", "12 m"]
    assert 'lj.dive(depth="12 m")' in call.python_code()
    assert result_fields("dive")["pressure"] == "pressure above the surface's"


def patched(text: str, patch: str) -> str:
    """A text with the lines of a diff block, whose parts are apart by `...`."""
    at = 0
    for part in patch.split(" ...\n"):
        lines = part.splitlines(keepends=True)
        old = "".join(line[1:] for line in lines if line[0] in " -")
        new = "".join(line[1:] for line in lines if line[0] in " +")
        at = text.index(old, at)
        text = text[:at] + new + text[at + len(old) :]
    return text


def test_one_more_option_is_one_file_as_contributing_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    patch = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").split("```diff\n")[1]
    patch = patch.split("```")[0]
    assert sum(line.startswith("+") for line in patch.splitlines()) == 3 + 1  # and its physics
    text = patched(Path(drop_command.__file__).read_text(encoding="utf-8"), patch)
    (tmp_path / "sloping.py").write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setitem(REGISTRY, "drop", REGISTRY["drop"])
    drop = importlib.import_module("sloping").drop
    case: dict[str, Any] = {"mass": 1.0, "speed": "2.5 m/s", "vacuum": "94.5 kPa"}
    level = drop("choi2018-kapton", horizontal=True, **case).slip
    assert drop("choi2018-kapton", slope=0.0, **case).slip == pytest.approx(level)
    upright = drop_command.drop("choi2018-kapton", **case).slip
    slips = [drop("choi2018-kapton", slope=s, **case).slip for s in ("30 deg", "90 deg")]
    assert level < slips[0] < slips[1] == pytest.approx(upright)
    assert "--slope Q Slope of the rail, 90 deg is upright" in said(capsys, "drop", "--help")[1]
    for wrong, words in (("30", "no unit"), ("2rad", "at most 1.571 rad")):
        given = ("--mass", "1kg", "--speed", "2.5m/s", "--vacuum", "94.5kPa", "--slope", wrong)
        code, _, err = said(capsys, "drop", "choi2018-kapton", *given)
        assert code == 2 and words in err, err


def test_the_docs_have_it(dive: Any, generate: ModuleType) -> None:
    assert "[`dive`](#dive)" in generate.command_table()
    page = generate.described("dive")
    assert "| `--depth 12m` | Depth of the dive. Required. |" in page
    assert "JSON: `pressure`" in page
    assert "| $z$ | `depth` | m |" in generate.command_quantities()
    assert "dive, Dive" in generate.command_functions()

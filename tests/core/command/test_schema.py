"""JSON Schemas of results; that they hold for every command is tested in tests/docs."""

from __future__ import annotations

import contextlib
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import pytest

import json_schema
from layerjam.cli.main import main
from layerjam.core.command.index import commands
from layerjam.core.command.schema import DIALECT, schema, type_schema
from layerjam.core.errors import UnknownNameError


@dataclass
class Point:
    x: float
    name: str | None


@pytest.mark.parametrize(
    ("kind", "made"),
    [
        (float, {"type": "number"}),
        (int | None, {"type": ["integer", "null"]}),
        (Any, {}),
        (Any | None, {}),
        (Literal["a", "b"], {"enum": ["a", "b"]}),
        (Sequence[str], {"type": "array", "items": {"type": "string"}}),
        (list[Mapping[str, Any]], {"type": "array", "items": type_schema(dict[str, Any])}),
        (Mapping[str, bool], {"type": "object", "additionalProperties": {"type": "boolean"}}),
        (
            tuple[float, float] | None,
            {"anyOf": [type_schema(tuple[float, float]), {"type": "null"}]},
        ),
    ],
)
def test_types(kind: Any, made: dict[str, Any]) -> None:
    assert type_schema(kind) == made


def test_a_record_inside_a_result_is_an_object() -> None:
    made = type_schema(Sequence[Point])["items"]
    assert made["properties"] == {"x": {"type": "number"}, "name": {"type": ["string", "null"]}}
    assert json_schema.problems({"x": 1, "name": None}, made) == []
    assert json_schema.problems({"x": None, "name": "a"}, made)
    assert json_schema.problems({"x": 1}, made) and json_schema.problems([1], made)


def printed(*words: str) -> tuple[int, dict[str, Any]]:
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        code = main([*words, "--json"])
    return code, json.loads(out.getvalue())


def test_what_cannot_be_and_what_is_listed_hold_too() -> None:
    cannot = ("vacuum", "choi2018-kapton", "--slip", "20mm", "--force", "1kN")
    for words, exit_code in ((cannot, 1), (("scenario", "--list"), 0)):
        code, answer = printed(*words)
        _, whole = printed("schema", words[0])
        assert code == exit_code
        assert json_schema.problems(answer, whole) == []


def test_all_of_them_are_one_schema() -> None:
    code, whole = printed("schema")
    assert code == 0 and whole["$schema"] == DIALECT
    assert list(whole["$defs"]) == list(commands())
    assert [one["$ref"] for one in whole["anyOf"]] == [f"#/$defs/{n}" for n in commands()]
    for about in whole["$defs"].values():
        assert all(key["description"] for key in about["properties"].values())
    # the schema of schemas holds for them
    assert json_schema.problems(whole, json.loads(schema("schema").json())) == []


def test_for_people_there_are_lines_and_an_unknown_name_is_said() -> None:
    assert "  peak_force [N], number or null: maximum force on the mass" in str(schema("drop"))
    with pytest.raises(UnknownNameError, match="did you mean force"):
        schema("forse")

"""The versions that pyproject.toml allows: a lower bound for each, which the lock keeps to."""

from __future__ import annotations

import re
import tomllib

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from install.environment import ROOT
from install.versions import CORE, RUNNERS, requirements

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
LOCKED = {
    canonicalize_name(name): version
    for name, version in re.findall(
        r"^([\w.-]+)(?:\[[\w,]+\])?==([\w.+!-]+)", (ROOT / "requirements.lock").read_text(), re.M
    )
}
EXTRAS = PROJECT["optional-dependencies"]


def direct() -> list[Requirement]:
    every = [*PROJECT["dependencies"], *(text for some in EXTRAS.values() for text in some)]
    return [one for one in map(Requirement, every) if one.name != "layerjam"]


def test_every_requirement_has_a_lower_bound_and_the_lock_is_within() -> None:
    assert len(direct()) > 40
    for one in direct():
        assert any(bound.operator == ">=" for bound in one.specifier), one
        version = LOCKED.get(canonicalize_name(one.name))
        assert version is None or one.specifier.contains(version), (str(one), version)


def test_typst_below_015_is_not_allowed() -> None:
    """With 0.14 the demo ended in an error."""
    (typst,) = (one for one in direct() if one.name == "typst")
    assert not typst.specifier.contains("0.14.9") and typst.specifier.contains("0.15.0")


def test_what_the_versions_are_tried_with_exists() -> None:
    assert all((ROOT / "tests" / name).is_dir() for name in CORE)
    assert {Requirement(text).name for text in requirements(PROJECT)} == set(RUNNERS)


def names_of(extra: str) -> set[str]:
    """Distributions and extras that an extra asks for, through other extras too."""
    found = {extra}
    for one in map(Requirement, EXTRAS[extra]):
        inner = one.extras if one.name == "layerjam" else set()
        found |= {one.name}.union(*map(names_of, inner))
    return found


def test_all_leaves_out_the_library_for_step_files() -> None:
    heavy = "cadquery-ocp-novtk"
    assert heavy in names_of("step") and heavy in names_of("test")
    assert heavy not in names_of("all") and {"build", "manifold3d", "ezdxf"} <= names_of("all")

"""What `import layerjam as lj` offers: names that resolve, hide no folder, and have types."""

from __future__ import annotations

from pathlib import Path

import pytest

import layerjam
from layerjam.core.command.index import commands

HOME = Path(layerjam.__file__).parent


def test_every_public_name_can_be_had() -> None:
    assert len(layerjam.__all__) == len(set(layerjam.__all__)) > 40
    for name in layerjam.__all__:
        assert getattr(layerjam, name) is not None
    listed = dir(layerjam)
    assert {*layerjam.__all__, "design", "lab", "report"} <= {*listed}
    assert listed == sorted(set(listed)) and all(getattr(layerjam, n) is not None for n in listed)
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        _ = layerjam.nonsense


def test_no_name_hides_a_folder() -> None:
    import layerjam.core.drawing.style as style

    folders = {path.name for path in HOME.iterdir() if path.is_dir()}
    assert not folders & set(layerjam.__all__)
    assert style.__name__ == "layerjam.core.drawing.style"
    # what was typed before goes on working
    for name in ("design", "lab", "report"):
        assert callable(getattr(layerjam, name))


def test_every_command_is_a_public_function() -> None:
    functions = {entry.python_name for entry in commands().values()}
    known = {layerjam._EXPORTS[name][1] for name in layerjam.__all__}
    assert functions - known <= {"workbench", "schema"}
    for name in ("brake_force", "peak", "energy_capacity", "sleeve_mass", "parse_procedure"):
        assert callable(getattr(layerjam, name)), name

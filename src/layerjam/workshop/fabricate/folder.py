"""Folder of a build, whose files are written completely or not at all.

Paths inside the folder never depend on the name of the brake.
"""

import json
import os
from collections.abc import Mapping
from pathlib import Path

from layerjam._version import __version__
from layerjam.core.errors import FileError, MissingExtraError
from layerjam.core.system import check_file_name, report_failure
from layerjam.core.toml_files.folders import make_hidden_folder, replace_folder, write_files
from layerjam.workshop.fabricate.bom import bom_csv
from layerjam.workshop.fabricate.drawing import Drawing
from layerjam.workshop.fabricate.film import auxiliary_files
from layerjam.workshop.fabricate.mesh import make_mesh
from layerjam.workshop.fabricate.package import write_3mf, write_stl
from layerjam.workshop.fabricate.step import write_step

LIST = "build.json"
"""File that lists all other files of the folder."""


def check_folder(out: str | Path, overwrite: bool) -> Path:
    """Return the folder to create; raises FileError, before any computation, if this is impossible.

    With `overwrite`, an existing folder is replaced if it contains only files of an earlier build.
    """
    path = Path(out)
    check_file_name(path)
    with report_failure(out, "cannot be created"):
        if not path.name:
            raise FileError(path, "cannot be created as a folder; give a folder name")
        if os.path.lexists(path) and not path.is_dir():
            raise FileError(path, "is a file, not a folder")
        if path.is_symlink():
            raise FileError(path, "is a link; give the folder itself")
        if not path.parent.is_dir():
            raise FileError(path, f"cannot be created: there is no folder {path.parent}")
        if not os.access(path.parent, os.W_OK):
            raise FileError(path, f"cannot be created: the folder {path.parent} is read-only")
        with make_hidden_folder(path.parent):
            pass  # os.access is unreliable for administrators, so try to write
        if not path.is_dir():
            return path
        if not overwrite:
            raise FileError(path, "already exists; --overwrite replaces it")
        present = {f.relative_to(path).as_posix() for f in path.rglob("*") if not f.is_dir()}
        strange = sorted(present - _read_file_list(path))
    if strange:
        more_text = f" and {len(strange) - 1} more" if len(strange) > 1 else ""
        raise FileError(
            path,
            f"contains {strange[0]}{more_text}, which `build` did not write; move it or "
            "choose a different folder",
        )
    return path


def _read_file_list(path: Path) -> set[str]:
    try:
        names = json.loads((path / LIST).read_text(encoding="utf-8"))["files"]
    except (OSError, ValueError, KeyError, TypeError):
        return set()
    return {str(name) for name in names} if isinstance(names, list) else set()


def write_folder(out: Path, content: Mapping[str, str | bytes], overwrite: bool = False) -> None:
    """Write all files, {path inside `out`: content}, or none; raises FileError."""
    path = check_folder(out, overwrite)
    with report_failure(out, "cannot be written"), make_hidden_folder(path.parent) as hidden:
        write_files(hidden / "build", content)
        replace_folder(hidden / "build", path)


def require_extra() -> None:
    """Raise MissingExtraError if the `build` extra is not installed."""
    with MissingExtraError.raise_if_missing("building a brake (ezdxf, manifold3d, typst)", "build"):
        import ezdxf  # noqa: F401
        import manifold3d  # noqa: F401
        import matplotlib  # noqa: F401
        import typst  # noqa: F401


def make_files(drawing: Drawing, *, with_step: bool, coupons: bool) -> dict[str, str | bytes]:
    """Return {path: content} of film patterns, printed parts, CAD and parts list.

    Raises MissingExtraError if the `build` extra, or the `step` extra for STEP, is not installed.
    """
    content: dict[str, str | bytes] = {**drawing.film.files()}
    content |= auxiliary_files(
        drawing.build, drawing.lengths, drawing.parallel, drawing.series, coupons
    )
    meshes = [make_mesh(part.solid) for part in drawing.parts if part.printed]
    content["print/print.3mf"] = write_3mf(meshes, "layer-jamming brake")
    for surface in meshes:
        content[f"print/{surface.name}.stl"] = write_stl(surface)
    if with_step:
        for part in drawing.parts:
            content[f"cad/{part.name}.step"] = write_step(part.solid, __version__)
    return {"bom.csv": bom_csv(drawing, content), **content}

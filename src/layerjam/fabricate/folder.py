"""A folder of a build: all its files, and how it appears whole or not at all.

A path inside the folder never comes from the name of the brake.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path

from layerjam._version import __version__
from layerjam.errors import FileError, MissingExtraError
from layerjam.fabricate.bom import bom_csv
from layerjam.fabricate.drawing import Drawing
from layerjam.fabricate.film import more_files
from layerjam.fabricate.mesh import mesh
from layerjam.fabricate.package import stl, three_mf
from layerjam.fabricate.step import step
from layerjam.records.folders import hidden_folder, replace_folder, write_files

LIST = "build.json"
"""The file that names all others of the folder."""


def check_folder(out: str | Path, force: bool) -> Path:
    """The folder to make; raises FileError where it could not be, before anything is computed.

    An existing folder is replaced with `force` only, and only if it holds nothing but what an
    earlier build wrote.
    """
    path = Path(out)
    try:
        return _checked(path, force)
    except (OSError, ValueError) as err:
        reason = getattr(err, "strerror", None) or str(err)
        raise FileError(str(out)[:200], f"cannot be made: {reason}") from None


def _checked(path: Path, force: bool) -> Path:
    if not path.name:
        raise FileError(path, "is no folder that can be made; give it a name")
    if os.path.lexists(path) and not path.is_dir():
        raise FileError(path, "is a file, not a folder")
    if path.is_symlink():
        raise FileError(path, "is a link; give the folder itself")
    if not path.parent.is_dir():
        raise FileError(path, f"cannot be made: there is no folder {path.parent}")
    if not os.access(path.parent, os.W_OK):
        raise FileError(path, f"cannot be made: the folder {path.parent} is read-only")
    with hidden_folder(path.parent):
        pass  # an administrator may write anywhere, and yet not everywhere
    if path.is_dir():
        if not force:
            raise FileError(path, "exists already; --force replaces it")
        strange = sorted(_found(path) - _written(path))
        if strange:
            more = f" and {len(strange) - 1} more" if len(strange) > 1 else ""
            raise FileError(
                path,
                f"holds {strange[0]}{more}, which no build wrote; move it or take another folder",
            )
    return path


def _found(path: Path) -> set[str]:
    return {f.relative_to(path).as_posix() for f in path.rglob("*") if not f.is_dir()}


def _written(path: Path) -> set[str]:
    """Files that an earlier build says it wrote."""
    try:
        said = json.loads((path / LIST).read_text(encoding="utf-8"))["files"]
    except (OSError, ValueError, KeyError, TypeError):
        return set()
    return {str(name) for name in said} if isinstance(said, list) else set()


def write_folder(out: Path, content: Mapping[str, str | bytes], force: bool = False) -> None:
    """Write {path inside `out`: content}: `out` appears with all of it, or not at all.

    Raises FileError.
    """
    path = check_folder(out, force)
    try:
        with hidden_folder(path.parent) as hidden:
            write_files(hidden / "build", content)
            replace_folder(hidden / "build", path)
    except OSError as err:
        raise FileError(out, f"cannot be written: {err.strerror or err}") from None


def require() -> None:
    """Raise MissingExtraError where the extra `build` is not installed, before anything is done."""
    with MissingExtraError.raise_if_missing("building a brake (ezdxf, manifold3d, typst)", "build"):
        import ezdxf  # noqa: F401
        import manifold3d  # noqa: F401
        import matplotlib  # noqa: F401
        import typst  # noqa: F401


def files(made: Drawing, *, with_step: bool, coupons: bool) -> dict[str, str | bytes]:
    """{path: content} of film patterns, printed parts, CAD and parts list.

    Raises MissingExtraError without the extra `build`, or `step` where STEP is asked for.
    """
    content: dict[str, str | bytes] = {**made.film.files()}
    content |= more_files(made.build, made.lengths, made.parallel, made.series, coupons)
    meshes = [mesh(part.solid) for part in made.parts if part.printed]
    content["print/print.3mf"] = three_mf(meshes, "layer-jamming brake")
    for one in meshes:
        content[f"print/{one.name}.stl"] = stl(one)
    if with_step:
        for part in made.parts:
            content[f"cad/{part.name}.step"] = step(part.solid, __version__)
    return {"bom.csv": bom_csv(made, content), **content}

"""All files of a build by their path inside its folder; no path comes from the brake's name."""

from __future__ import annotations

from layerjam._version import __version__
from layerjam.errors import MissingExtraError
from layerjam.fabricate.bom import bom_csv
from layerjam.fabricate.drawing import Drawing
from layerjam.fabricate.film import more_files
from layerjam.fabricate.mesh import mesh
from layerjam.fabricate.package import stl, three_mf
from layerjam.fabricate.step import step


def require() -> None:
    """Raise MissingExtraError where the extra `build` is not installed, before anything is done."""
    with MissingExtraError.without("building a brake (ezdxf, manifold3d, typst)", "build"):
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

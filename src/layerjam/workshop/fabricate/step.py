"""A part as a STEP file, made by Open CASCADE without its viewer (extra `step`) [mm].

The format is AP214, with the product named after the part. The file depends only on the part, on
`version` and on the version of the library, which its header states.
"""

import tempfile
from contextlib import AbstractContextManager
from functools import cache
from pathlib import Path
from typing import Any

from layerjam.core.errors import MissingExtraError, raise_interrupt
from layerjam.workshop.fabricate.solid import PLANE, Axis, Ellipse, Prism, Section, Solid

STAMP = "2000-01-01T00:00:00"
"""Fixed time stamp, so that identical parts produce identical files."""
DIRECTIONS: dict[Axis, tuple[float, float, float]] = {
    "x": (1, 0, 0),
    "y": (0, 1, 0),
    "z": (0, 0, 1),
}


def is_available() -> bool:
    """Return whether the `step` extra is installed and its libraries can be loaded."""
    try:
        with _require_library():
            import OCP  # noqa: F401
    except MissingExtraError:
        return False
    return True


def _require_library() -> AbstractContextManager[None]:
    return MissingExtraError.raise_if_missing("a STEP file (Open CASCADE)", "step")


def write_step(part: Solid, version: str = "") -> bytes:
    """Return a part's STEP file; its header states `version` as the version of layerjam.

    Raises MissingExtraError if the `step` extra is not installed, and RuntimeError if the library
    fails, which would be a bug.
    """
    with _require_library():
        import OCP.STEPCAFControl  # noqa: F401
    _silence_library()
    shape = make_shape(part)
    with tempfile.TemporaryDirectory(prefix="layerjam-") as folder:
        path = Path(folder) / f"{part.name}.step"
        _write_solid(shape, part.name, path, version)
        return path.read_bytes()


def make_shape(part: Solid) -> Any:
    """Return the part as one Open CASCADE solid."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
    from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain
    from OCP.TopAbs import TopAbs_SOLID
    from OCP.TopExp import TopExp_Explorer

    bodies = [_sweep_prism(p) for p in part.prisms if not p.cut]
    cuts = [_sweep_prism(p) for p in part.prisms if p.cut]
    shape = bodies[0]
    if bodies[1:]:
        shape = _combine_shapes(BRepAlgoAPI_Fuse(), bodies[:1], bodies[1:])
    if cuts:
        shape = _combine_shapes(BRepAlgoAPI_Cut(), [shape], cuts)
    unifier = ShapeUpgrade_UnifySameDomain(shape, True, True, False)
    unifier.Build()
    explorer = TopExp_Explorer(unifier.Shape(), TopAbs_SOLID)
    solids = []
    while explorer.More():
        solids.append(explorer.Current())
        explorer.Next()
    if len(solids) != 1:
        raise RuntimeError(f"{part.name} consists of {len(solids)} solids, not one")
    return solids[0]


def _combine_shapes(operation: Any, arguments: list[Any], tools: list[Any]) -> Any:
    for put, shapes in ((operation.SetArguments, arguments), (operation.SetTools, tools)):
        shape_list = _make_shape_list()
        for shape in shapes:
            shape_list.Append(shape)
        put(shape_list)
    operation.SetRunParallel(False)
    operation.Build()
    if not operation.IsDone():
        raise RuntimeError("Open CASCADE could not combine two solids")
    return operation.Shape()


def _make_shape_list() -> Any:
    """Return an empty list of shapes, whose class depends on the version of the library."""
    try:
        from OCP.collections import List_TopoDS_Shape
    except ImportError as error:
        raise_interrupt(error)
        from OCP.TopTools import TopTools_ListOfShape

        return TopTools_ListOfShape()
    return List_TopoDS_Shape()


def _sweep_prism(prism: Prism) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
    from OCP.gp import gp_Vec

    face = BRepBuilderAPI_MakeFace(_draw_wire(prism, prism.section), True).Face()
    direction = gp_Vec(*DIRECTIONS[prism.axis]).Multiplied(prism.end - prism.start)
    return BRepPrimAPI_MakePrism(face, direction).Shape()


def _make_point(prism: Prism, u: float, v: float) -> Any:
    from OCP.gp import gp_Pnt

    first, second = PLANE[prism.axis]
    coordinates = {first: u, second: v, prism.axis: prism.start}
    return gp_Pnt(coordinates["x"], coordinates["y"], coordinates["z"])


def _draw_wire(prism: Prism, section: Section) -> Any:
    """Return the edge of a section at the start of its prism."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeWire

    if isinstance(section, Ellipse):
        curve = _round_edge(prism, section.centre, section.first, section.second)
        return BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(curve).Edge()).Wire()
    (a, b), (c, d), r = section.low, section.high, section.radius
    wire = BRepBuilderAPI_MakeWire()
    # straight pieces from `start` to `end`, then the arc about `centre` to the next piece
    pieces = [
        ((a + r, b), (c - r, b), (c - r, b + r)),
        ((c, b + r), (c, d - r), (c - r, d - r)),
        ((c - r, d), (a + r, d), (a + r, d - r)),
        ((a, d - r), (a, b + r), (a + r, b + r)),
    ]
    for (start, end, centre), (turn, _, _) in zip(pieces, [*pieces[1:], pieces[0]], strict=True):
        begin, stop = _make_point(prism, *end), _make_point(prism, *turn)
        wire.Add(BRepBuilderAPI_MakeEdge(_make_point(prism, *start), begin).Edge())
        if r:
            wire.Add(BRepBuilderAPI_MakeEdge(_round_edge(prism, centre, r, r), begin, stop).Edge())
    return wire.Wire()


def _round_edge(prism: Prism, centre: tuple[float, float], first: float, second: float) -> Any:
    """Return a circle or an ellipse in the plane of the section, longer half axis first."""
    from OCP.gp import gp_Ax2, gp_Circ, gp_Dir, gp_Elips

    towards = PLANE[prism.axis][0 if first >= second else 1]
    frame = gp_Ax2(
        _make_point(prism, *centre), gp_Dir(*DIRECTIONS[prism.axis]), gp_Dir(*DIRECTIONS[towards])
    )
    if first == second:
        return gp_Circ(frame, first)
    return gp_Elips(frame, max(first, second), min(first, second))


@cache
def _silence_library() -> None:
    """Keep Open CASCADE from printing transfer messages to standard output."""
    from OCP.Message import Message, Message_Gravity

    for printer in Message.DefaultMessenger_s().Printers():
        printer.SetTraceLevel(Message_Gravity.Message_Fail)


def _write_solid(shape: Any, name: str, path: Path, version: str) -> None:
    """Write one named solid, in its own document so that products are not numbered."""
    from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.Interface import Interface_Static
    from OCP.STEPCAFControl import STEPCAFControl_Writer
    from OCP.STEPControl import STEPControl_AsIs
    from OCP.TCollection import TCollection_ExtendedString, TCollection_HAsciiString
    from OCP.TDataStd import TDataStd_Name
    from OCP.TDocStd import TDocStd_Document
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    document = TDocStd_Document(TCollection_ExtendedString("XmlXCAF"))
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    label = tool.AddShape(shape, False)
    TDataStd_Name.Set_s(label, TCollection_ExtendedString(name))
    writer = STEPCAFControl_Writer()
    Interface_Static.SetCVal_s("write.step.schema", "AP214IS")
    Interface_Static.SetCVal_s("write.step.unit", "MM")
    if not writer.Transfer(document, STEPControl_AsIs):
        raise RuntimeError(f"{name} could not be converted to STEP")
    header = APIHeaderSection_MakeHeader(writer.ChangeWriter().Model())
    header.SetName(TCollection_HAsciiString(name))
    header.SetTimeStamp(TCollection_HAsciiString(STAMP))
    header.SetOriginatingSystem(TCollection_HAsciiString(f"layerjam {version}".strip()))
    if writer.Write(str(path)) != IFSelect_RetDone:
        raise RuntimeError(f"{path} could not be written")

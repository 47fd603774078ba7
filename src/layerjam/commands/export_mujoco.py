"""`export mujoco`: the brake as an actuator plugin of MuJoCo, with a model that opens."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated

from layerjam.commands.declare import Help, command
from layerjam.commands.export import Strict, holds, in_words, said
from layerjam.commands.quantities import BrakeInput, Overwrite, RopeStiffness
from layerjam.commands.results import Result, fact, number, result
from layerjam.errors import CompilerError
from layerjam.interop.tendon import Coupling
from layerjam.units import QuantitySpec

LAG = QuantitySpec("s", "time constant of the vacuum line", lo=1e-4, hi=1e4, example="2.25s")


@result
class ExportedMujoco(Result):
    """What was written; `record` holds the eight numbers."""

    kind: str = fact("what it was written for")
    feasible: bool = fact("whether it was written; false with --strict where the brake could snap")
    reason: str | None = fact("why not")
    files: Sequence[str] = fact("files in the folder")
    plugin: str = fact("name of the plugin in a model")
    library: str | None = fact("the compiled plugin; none with --no-build")
    mujoco_version: str | None = fact("the MuJoCo that it was compiled for")
    parameters: Mapping[str, float] = fact(
        "the eight numbers of the brake, SI units", shown=in_words
    )
    holds: float = number("N", "what it holds at rest at the site's full vacuum, c L2")

    @classmethod
    def table_units(cls) -> Mapping[str, str]:
        """{parameter: SI unit}."""
        from layerjam.kernel.parameters import UNITS

        return UNITS


@command(
    "share",
    place=30,
    under="export",
    examples=("layerjam export mujoco choi2018-kapton --out made --no-build",),
)
def export_mujoco(
    brake: BrakeInput,
    *,
    out: Annotated[str | Path, Help("Folder to write into.", metavar="DIR")],
    tendon: Annotated[str, Help("Name of the tendon that carries the brake.", metavar="NAME")] = (
        "cable"
    ),
    vacuum_lag: Annotated[float | str | None, LAG] = None,
    coupling: Annotated[
        Coupling, Help("How a step's force is found: limited softens what a step cannot carry.")
    ] = "limited",
    no_build: Annotated[bool, Help("Sources only; needs neither MuJoCo nor a compiler.")] = False,
    rope_stiffness: RopeStiffness | None = None,
    strict: Strict = False,
    force: Overwrite = False,
) -> ExportedMujoco:
    """Write the brake as an actuator plugin of MuJoCo whose control is the vacuum.

    `actuator.xml` is for `<include>` in a model that has the tendon, `brake.xml` is a model to look
    at. The library is compiled for the MuJoCo that is installed. Raises FileError where a file
    exists and `force` is not set, CompilerError, MissingExtraError, QuantityError for sheets that
    fan out, a speed law or a hyperelastic enclosure.
    """
    from layerjam.interop import mjcf
    from layerjam.interop.source import plugin_files
    from layerjam.kernel.parameters import parameters
    from layerjam.report.folder import check_folder, write_folder

    numbers = parameters(brake, rope_stiffness)
    actuator = mjcf.mjcf(
        brake, tendon, vacuum_lag=vacuum_lag, coupling=coupling, rope_stiffness=rope_stiffness
    )
    content: dict[str, str | bytes] = {
        "actuator.xml": actuator,
        "brake.xml": mjcf.scene(tendon, "actuator.xml"),
        **plugin_files(),
    }
    library, version = (None, None) if no_build else _library()
    if library is not None:
        content[library.name] = library.content
    check_folder(Path(out), force, list(content))
    notices, snaps = said(brake, numbers)
    stops = strict and snaps is not None
    if not stops:
        write_folder(Path(out), content)
    return ExportedMujoco(
        kind="mujoco",
        feasible=not stops,
        reason=str(snaps) if stops else None,
        files=[] if stops else sorted(content),
        plugin=mjcf.PLUGIN,
        library=None if stops or library is None else library.name,
        mujoco_version=version,
        parameters=numbers._asdict(),
        holds=holds(brake, numbers),
        warnings=notices,
        record=numbers,
    )


class _Built:
    """A compiled plugin."""

    def __init__(self, file: Path) -> None:
        self.name = f"liblayerjam_mujoco{file.suffix}"
        self.content = file.read_bytes()


def _library() -> tuple[_Built, str]:
    """The compiled plugin and MuJoCo's version."""
    from layerjam.interop.plugin import installed, plugin

    try:
        return _Built(plugin()), str(installed().__version__)
    except CompilerError as error:
        raise CompilerError(f"{error}; or give --no-build") from None

"""`export mujoco`: the brake as an actuator plugin of MuJoCo, with a model that opens."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from layerjam.commands.declare import Help, command
from layerjam.commands.export import ExportedNumbers, Strict, export_facts
from layerjam.commands.quantities import BrakeInput, Overwrite, RopeStiffness
from layerjam.commands.results import fact, result
from layerjam.errors import CompilerError
from layerjam.interop.tendon import Coupling
from layerjam.units import QuantitySpec

if TYPE_CHECKING:
    from layerjam.kernel.parameters import Parameters

LAG = QuantitySpec("s", "time constant of the vacuum line", lo=1e-4, hi=1e4, example="2.25s")


@result
class ExportedMujoco(ExportedNumbers):
    """What was written; `record` holds the eight numbers."""

    record: Parameters
    plugin: str = fact("name of the plugin in a model")
    library: str | None = fact("the compiled plugin; none with --no-build")
    mujoco_version: str | None = fact("the MuJoCo that it was compiled for")
    parameters: Mapping[str, float]
    holds: float


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
    vacuum_lag: Annotated[float | None, LAG] = None,
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
    known = export_facts("mujoco", brake, numbers, strict)
    if known["feasible"]:
        write_folder(Path(out), content)
    return ExportedMujoco(
        **known,
        files=sorted(content) if known["feasible"] else [],
        plugin=mjcf.PLUGIN,
        library=library.name if known["feasible"] and library is not None else None,
        mujoco_version=version,
        parameters=numbers._asdict(),
        record=numbers,
    )


class _Built:
    """A compiled plugin."""

    def __init__(self, file: Path) -> None:
        self.name = f"liblayerjam_mujoco{file.suffix}"
        self.content = file.read_bytes()


def _library() -> tuple[_Built, str]:
    """The compiled plugin and MuJoCo's version."""
    from layerjam.interop.plugin import import_mujoco, plugin

    try:
        return _Built(plugin()), str(import_mujoco().__version__)
    except CompilerError as error:
        raise CompilerError(f"{error}; or give --no-build") from None

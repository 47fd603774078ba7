"""`export`: the brake for other programs and for microcontrollers."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from layerjam.brake.commands.arguments import BrakeInput, Overwrite, RopeStiffness
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.kernel.parameters import Parameters
from layerjam.core.command.declare import Help, command
from layerjam.core.command.results import Result, fact, number, result
from layerjam.core.errors import CompilerError, Notice, QuantityError
from layerjam.core.outputs import outputs
from layerjam.core.units import QuantitySpec, show
from layerjam.interop.tendon import Coupling

Strict = Annotated[bool, Help("Write nothing if the brake is so compliant that it could snap.")]


def list_parameters(parameters: Mapping[str, float]) -> str:
    """Return the eight parameters with their units as text."""
    from layerjam.brake.kernel.parameters import UNITS

    return ", ".join(f"{key} {show(value, UNITS[key])}" for key, value in parameters.items())


@outputs
class Export:
    """Base of the results of all exports."""

    kind: str = fact("target of the export")
    feasible: bool = fact("whether files were written; false with --strict if the brake could snap")
    reason: str | None = fact("reason if none were written")
    files: Sequence[str] = fact("files in the folder")
    sheet_friction: float | None = number(
        "N", "kinetic friction of the sheets at rest at full vacuum at the site, c L2"
    )
    holds: float | None = number("N", "former name of sheet_friction", listed=False)


@result
class ExportedNumbers(Result, Export):
    """Result of an export with the eight parameters of the brake."""

    parameters: Mapping[str, float] = fact(
        "the eight parameters of the brake, in SI units", shown=list_parameters
    )

    @classmethod
    def table_units(cls) -> Mapping[str, str]:
        """Return {parameter: SI unit}."""
        from layerjam.brake.kernel.parameters import UNITS

        return UNITS


@result
class Exported(ExportedNumbers):
    """Files written; `record` holds the eight numbers."""

    record: Parameters
    parameters: Mapping[str, float]
    state_bytes: int = number("1", "bytes of memory for the state of a brake")
    sheet_friction: float
    holds: float


@command("share", parent="export")
def export_c(
    brake: BrakeInput,
    *,
    out: Annotated[str | Path, Help("Folder to write to.", metavar="DIR")],
    precision: Annotated[
        Literal["double", "single"],
        Help("Precision of all numbers. Use single if the chip lacks double precision."),
    ] = "double",
    rope_stiffness: RopeStiffness | None = None,
    strict: Strict = False,
    overwrite: Overwrite = False,
) -> Exported:
    """Write the brake as C source for a microcontroller or a simulator.

    The C99 code allocates nothing, has no global data and needs only `sqrt` (and `pow` with a
    pressure exponent). A rope is in series with the brake's stiffness. At rest the exported law
    resists up to c L2, without additional static friction. Raises FileError if a file exists unless
    `overwrite`, QuantityError for sheets that fan out, a speed law or a hyperelastic enclosure.
    """
    from layerjam.brake.kernel.kernel import state_bytes
    from layerjam.brake.kernel.parameters import parameters
    from layerjam.core.drawing.folder import check_folder, write_folder
    from layerjam.interop.source import NAMES, c_files

    numbers = parameters(brake, rope_stiffness)
    check_folder(Path(out), overwrite, NAMES)
    facts = common_results("c", brake, numbers, strict)
    if facts["feasible"]:
        write_folder(Path(out), dict(c_files(brake.name, numbers, precision, brake.mark())))
    return Exported(
        **facts,
        files=sorted(NAMES) if facts["feasible"] else [],
        parameters=numbers._asdict(),
        state_bytes=state_bytes(precision),
        record=numbers,
    )


@result
class ExportedFmu(Result, Export):
    """Result of an FMU export."""

    record: dict[str, float]
    files: Sequence[str] = fact("FMU file")
    bytes: int | None = number("B", "size of the FMU; null if it was not written")
    fmi_version: str = fact("version of the FMI standard")
    token: str = fact("instantiation token, the same for every brake")
    platforms: Sequence[str] = fact("platforms with a compiled library")
    compiler: str | None = fact("compiler of this machine's library; null with sources only")
    variables: Sequence[str] = fact("names of all variables")
    sheet_friction: float
    holds: float


@command("share", parent="export")
def export_fmu(
    brake: BrakeInput,
    *,
    out: Annotated[str | Path, Help("FMU file to write.", metavar="FILE.fmu")],
    fmi: Annotated[Literal["3", "2"], Help("Version of the standard, 3.0 or 2.0.")] = "3",
    platforms: Annotated[
        str | None,
        Help(
            "Platforms with a library, separated by commas: linux, linux-arm, windows, macos, "
            "macos-arm; default: this machine's own. Any other needs the extra fmu."
        ),
    ] = None,
    sources_only: Annotated[
        bool, Help("Do not include a compiled library; the importer compiles the sources.")
    ] = False,
    rope_stiffness: RopeStiffness | None = None,
    strict: Strict = False,
    overwrite: Overwrite = False,
) -> ExportedFmu:
    """Write the brake as a functional mock-up unit for Simulink, Dymola, OpenModelica and others.

    FMI 3.0 or 2.0, co-simulation and model exchange, compiled C, so the target needs no Python.
    Inputs are elongation, velocity and vacuum, outputs force, slip and energies; parameters carry
    the brake file's own names, units and bounds. Raises FileError if the file exists unless
    `overwrite`, QuantityError for sheets that fan out, a speed law or a hyperelastic enclosure, or
    an unknown platform; CompilerError if no compiler is found.
    """
    from layerjam.brake.kernel.compiler import find_compiler, read_version
    from layerjam.brake.kernel.parameters import parameters
    from layerjam.core.store import store_file
    from layerjam.interop import fmi as units
    from layerjam.interop.fmi_variables import list_variables, make_token

    numbers, values = parameters(brake, rope_stiffness), units.brake_values(brake, rope_stiffness)
    if sources_only and platforms is not None:
        raise QuantityError.of(
            "platforms", "sources are not built for a platform; omit the platforms"
        )
    platform_names = None if platforms is None else [name.strip() for name in platforms.split(",")]
    platform_choice = () if sources_only else units.choose_platforms(fmi, platform_names)
    facts, size = common_results("fmu", brake, numbers, strict), None
    if facts["feasible"]:
        binaries = {o: units.build_binary(fmi, o) for o in platform_choice}
        unit = units.build_fmu(fmi, brake.name, values, binaries, brake.mark())
        store_file(out, unit, overwrite)
        size = len(unit)
    is_own = units.find_platform() in platform_choice
    return ExportedFmu(
        **facts,
        files=[Path(out).name] if facts["feasible"] else [],
        bytes=size,
        fmi_version=f"{fmi}.0",
        token=make_token(),
        platforms=platform_choice,
        compiler=read_version(find_compiler()) if is_own else None,
        variables=[v.name for v in list_variables() if fmi == "3" or v.role != "local"],
        record=values,
    )


@result
class ExportedHtml(Result, Export):
    """File written; `record` is the brake's BrakeFile."""

    record: BrakeFile
    files: Sequence[str] = fact("HTML file")
    bytes: int | None = number("B", "size of the file; null if it was not written")
    live: bool = fact("whether the page computes; false for a law that the C kernel lacks")
    sheet_friction: float | None
    holds: float | None


@command("share", parent="export")
def export_html(
    brake: BrakeInput,
    *,
    out: Annotated[str | Path, Help("HTML file to write.", metavar="FILE.html")],
    rope_stiffness: RopeStiffness | None = None,
    strict: Strict = False,
    overwrite: Overwrite = False,
) -> ExportedHtml:
    """Write the brake as one page that computes in a browser, without Python or a network.

    The page has the brake to scale, its numbers with sources, and its accepted checks. The reader
    moves vacuum, slip, elongation, mass, speed and travel, and sees the force, the hysteresis of a
    pull, and the safe vacuum for a stop. For a brake with a law that the C kernel lacks, it states
    that law and does not compute. Raises FileError if the file exists unless `overwrite`,
    MissingExtraError if the extra `report` is not installed.
    """
    from layerjam.brake.figures.live_page import find_missing_law
    from layerjam.brake.kernel.parameters import parameters
    from layerjam.core.store import store_file
    from layerjam.interop.html import make_html

    missing_law, size = find_missing_law(brake), None
    if missing_law is None:
        facts = common_results("html", brake, parameters(brake, rope_stiffness), strict)
    else:
        notice = Notice(f"the page does not compute: {missing_law}", "not-live")
        facts = {"kind": "html", "feasible": True, "reason": None}
        facts |= {"sheet_friction": None, "holds": None}
        facts["warnings"] = [*brake.warnings(), notice]
    if facts["feasible"]:
        content = make_html(brake, rope_stiffness).encode()
        store_file(out, content, overwrite)
        size = len(content)
    return ExportedHtml(
        **facts,
        files=[Path(out).name] if facts["feasible"] else [],
        bytes=size,
        live=missing_law is None,
        record=brake,
    )


def common_results(kind: str, file: BrakeFile, numbers: Parameters, strict: bool) -> dict[str, Any]:
    """Return the data common to all exports: the fields of `Export`, and warnings."""
    notices, snap_notice = [*file.warnings()], None
    full_vacuum = file.brake.site.atmosphere
    # c [N/m] at the full vacuum at the site
    slope = numbers.contact * full_vacuum
    slope *= (full_vacuum / numbers.test_pressure) ** numbers.exponent
    if numbers.stiffness <= slope:
        snap_notice = Notice(
            f"the stiffness of {show(numbers.stiffness, 'N/m')} does not exceed "
            f"{show(slope, 'N/m')}, the rate at which friction falls with slip at the site's full "
            "vacuum: the brake would snap, and its force would jump",
            "snaps",
        )
        notices.append(snap_notice)
    if numbers.exponent:
        text = "the pressure exponent uses the pow function of the target's C library, so "
        text += "the last bits of a force may differ between machines"
        notices.append(Notice(text, "pow"))
    is_rejected = strict and snap_notice is not None
    return {
        "kind": kind,
        "feasible": not is_rejected,
        "reason": str(snap_notice) if is_rejected else None,
        "sheet_friction": slope * numbers.overlap,
        "holds": slope * numbers.overlap,
        "warnings": notices,
    }


LAG = QuantitySpec("s", "time constant of the vacuum line", lo=1e-4, hi=1e4, example="2.25s")


@result
class ExportedMujoco(ExportedNumbers):
    """Files written; `record` holds the eight numbers."""

    record: Parameters
    plugin: str = fact("name of the plugin in a model")
    library: str | None = fact("compiled plugin; null with --no-build")
    mujoco_version: str | None = fact("version of MuJoCo that it was compiled for")
    parameters: Mapping[str, float]
    sheet_friction: float
    holds: float


@command("share", parent="export")
def export_mujoco(
    brake: BrakeInput,
    *,
    out: Annotated[str | Path, Help("Folder to write to.", metavar="DIR")],
    tendon: Annotated[str, Help("Name of the tendon that carries the brake.", metavar="NAME")] = (
        "cable"
    ),
    vacuum_lag: Annotated[float | None, LAG] = None,
    coupling: Annotated[
        Coupling,
        Help(
            "Method for the force of a step: 'limited' softens stiffness that the time step "
            "cannot resolve."
        ),
    ] = "limited",
    no_build: Annotated[bool, Help("Sources only, without MuJoCo or a compiler.")] = False,
    rope_stiffness: RopeStiffness | None = None,
    strict: Strict = False,
    overwrite: Overwrite = False,
) -> ExportedMujoco:
    """Write the brake as an actuator plugin of MuJoCo whose control is the vacuum.

    `actuator.xml` is for `<include>` in a model that has the tendon, `brake.xml` is a model for
    viewing. The library is compiled for the installed MuJoCo. Raises FileError if a file exists
    unless `overwrite`, CompilerError, MissingExtraError, QuantityError for sheets that fan out, a
    speed law or a hyperelastic enclosure.
    """
    from layerjam.brake.kernel.parameters import parameters
    from layerjam.core.drawing.folder import check_folder, write_folder
    from layerjam.interop import mjcf
    from layerjam.interop.source import plugin_files

    numbers = parameters(brake, rope_stiffness)
    actuator = mjcf.mjcf(
        brake, tendon, vacuum_lag=vacuum_lag, coupling=coupling, rope_stiffness=rope_stiffness
    )
    content: dict[str, str | bytes] = {
        "actuator.xml": actuator,
        "brake.xml": mjcf.scene(tendon, "actuator.xml"),
        **plugin_files(),
    }
    libraries, version = ({}, None) if no_build else _find_plugin()
    content |= libraries
    check_folder(Path(out), overwrite, list(content))
    facts = common_results("mujoco", brake, numbers, strict)
    if facts["feasible"]:
        write_folder(Path(out), content)
    return ExportedMujoco(
        **facts,
        files=sorted(content) if facts["feasible"] else [],
        plugin=mjcf.PLUGIN,
        library=next(iter(libraries), None) if facts["feasible"] else None,
        mujoco_version=version,
        parameters=numbers._asdict(),
        record=numbers,
    )


def _find_plugin() -> tuple[dict[str, bytes], str]:
    """Return {name: content} of the compiled plugin, and MuJoCo's version."""
    from layerjam.interop.plugin import import_mujoco, plugin

    try:
        file = plugin()
    except CompilerError as error:
        raise CompilerError(f"{error}; or use --no-build") from None
    content = {f"liblayerjam_mujoco{file.suffix}": file.read_bytes()}
    return content, str(import_mujoco().__version__)

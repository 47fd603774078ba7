"""MuJoCo models with a brake: the actuator as MJCF or in a mujoco.MjSpec, and an example scene."""

from importlib.resources import files
from typing import Any
from xml.sax.saxutils import quoteattr

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.kernel.parameters import parameters
from layerjam.core.errors import QuantityError, UnknownNameError
from layerjam.interop.tendon import Coupling, check_coupling

AnyBrake = str | BrakeFile | Brake
INSTANCE = "layerjam"
PLUGIN = "layerjam.brake"
HELD = 50e3
"""Vacuum of the keyframe [Pa]."""


def load_brake_file(brake: AnyBrake) -> BrakeFile | Brake:
    """Return the file of a catalogue name or path; other arguments are returned unchanged."""
    from layerjam.brake.device.load import load

    return load(brake) if isinstance(brake, str) else brake


def highest_vacuum(brake: BrakeFile | Brake) -> float:
    """Return the highest possible vacuum [Pa]."""
    brake = brake.brake if isinstance(brake, BrakeFile) else brake
    return float(brake.site.atmosphere)


def plugin_attributes(
    brake: BrakeFile | Brake,
    coupling: Coupling = "limited",
    rest_length: float | None = None,
    *,
    rope_stiffness: float | None = None,
    over_joint: bool = False,
) -> dict[str, str]:
    """Return the plugin's attributes as text, with all digits of the numbers."""
    numbers = parameters(brake, rope_stiffness)._asdict()
    if over_joint:
        sheets = (brake.brake if isinstance(brake, BrakeFile) else brake).sheets
        numbers |= {"sheets": sheets.count, "width": sheets.width}
    attributes = {name: repr(float(value)) for name, value in numbers.items()}
    if rest_length is not None:
        if not 0 <= rest_length < float("inf"):
            raise QuantityError.of("rest_length", f"{rest_length} m is not allowed; use 0 or more")
        attributes["rest_length"] = repr(float(rest_length))
    return {**attributes, "coupling": check_coupling(coupling)}


def _lag_attributes(vacuum_lag: float | None) -> dict[str, str]:
    """Return the actuator's attributes for a first-order vacuum line, exact at any time step."""
    if vacuum_lag is None:
        return {}
    if not 0 < vacuum_lag < float("inf"):
        raise QuantityError.of("vacuum_lag", f"{vacuum_lag} s is not allowed; use more than zero")
    return {"dyntype": "filterexact", "dynprm": repr(float(vacuum_lag))}


def mjcf(
    brake: AnyBrake,
    tendon: str = "cable",
    rest_length: float | None = None,
    vacuum_lag: float | None = None,
    *,
    coupling: Coupling = "limited",
    rope_stiffness: float | None = None,
    name: str | None = None,
    over_joint: bool = False,
) -> str:
    """Return the brake as MJCF for `<include>`: the plugin's instance and an actuator on a tendon.

    `rest_length` [m] is the tendon's length at zero elongation, by default that at qpos0.
    `vacuum_lag` [s] is the time constant of the vacuum line. `name` is the actuator's name, by
    default the tendon's. With `over_joint`, the brake lies on the cylinder or sphere that the
    tendon wraps. Raises QuantityError, UnknownNameError.
    """
    file, name = load_brake_file(brake), name or tendon
    numbers = plugin_attributes(
        file, coupling, rest_length, rope_stiffness=rope_stiffness, over_joint=over_joint
    )
    keys = "\n".join(
        f"        <config key={quoteattr(key)} value={quoteattr(value)}/>"
        for key, value in numbers.items()
    )
    instance = f"{INSTANCE}-{name}"
    actuator = {
        "name": name,
        "plugin": PLUGIN,
        "instance": instance,
        "tendon": tendon,
        "ctrllimited": "true",
        "ctrlrange": f"0 {highest_vacuum(file)!r}",
        **_lag_attributes(vacuum_lag),
    }
    words = " ".join(f"{key}={quoteattr(value)}" for key, value in actuator.items())
    mark = file.mark().replace("--", "- -") if isinstance(file, BrakeFile) else ""
    comment = mark and f"  <!-- {mark} -->\n"
    return f"""<mujocoinclude>
{comment}  <!-- the control is the vacuum [Pa] -->
  <extension>
    <plugin plugin="{PLUGIN}">
      <instance name={quoteattr(instance)}>
{keys}
      </instance>
    </plugin>
  </extension>
  <actuator>
    <plugin {words}/>
  </actuator>
</mujocoinclude>
"""


def scene(tendon: str, include: str) -> str:
    """Return an example model: 1 kg on a cable, half a metre below the ceiling."""
    text = files("layerjam.interop").joinpath("scene.xml").read_text(encoding="utf-8")
    return text.format(include=quoteattr(include), tendon=quoteattr(tendon), held=HELD)


def attach(
    spec: Any,
    tendon: str,
    brake: AnyBrake,
    *,
    rest_length: float | None = None,
    vacuum_lag: float | None = None,
    coupling: Coupling = "limited",
    rope_stiffness: float | None = None,
    name: str | None = None,
    over_joint: bool = False,
) -> Any:
    """Add the brake to a mujoco.MjSpec as an actuator on a tendon; return the actuator.

    The actuator's control is the vacuum [Pa]; its name is by default the tendon's. The tendon
    itself must have no stiffness, which would be a second spring parallel to the brake. With
    `over_joint`, it wraps one cylinder or sphere, and the friction is that of
    `layerjam.laws.joint_friction` at the current wrap angle. The plugin is loaded. Raises
    UnknownNameError, QuantityError, MissingExtraError, CompilerError.
    """
    from layerjam.interop.plugin import import_mujoco, load

    mujoco = import_mujoco()
    load()
    target = next((item for item in spec.tendons if item.name == tendon), None)
    if target is None:
        names = [item.name for item in spec.tendons] or ["(the model has no tendon)"]
        raise UnknownNameError("tendon", tendon, names)
    for quantity in ("stiffness", "frictionloss", "springyield"):
        if any(float(value) != 0 for value in _list_floats(getattr(target, quantity, 0.0))):
            raise QuantityError.of(
                f"tendon '{tendon}'", f"{quantity} would add to the brake; omit it"
            )
    name = name or tendon
    if any(item.name == name for item in spec.actuators):
        raise QuantityError.of(
            "name", f"the model already has an actuator '{name}'; choose a different name"
        )
    file, lag = load_brake_file(brake), _lag_attributes(vacuum_lag)
    numbers = plugin_attributes(
        file, coupling, rest_length, rope_stiffness=rope_stiffness, over_joint=over_joint
    )
    spec.activate_plugin(PLUGIN)
    instance = spec.add_plugin(name=f"{INSTANCE}-{name}", plugin_name=PLUGIN, active=True)
    instance.config = numbers
    actuator = spec.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_TENDON, target=tendon)
    actuator.ctrllimited, actuator.ctrlrange = True, [0.0, highest_vacuum(file)]
    if lag:
        actuator.dyntype = mujoco.mjtDyn.mjDYN_FILTEREXACT
        actuator.dynprm[0] = vacuum_lag
    actuator.plugin = instance
    return actuator


def _list_floats(value: Any) -> list[float]:
    return list(value) if hasattr(value, "__len__") else [value]

"""The description of a functional mock-up unit: `modelDescription.xml` for FMI 3.0 and 2.0."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Literal
from xml.sax.saxutils import quoteattr

from layerjam._version import __version__
from layerjam.interop.fmi_variables import TURNING, Variable, list_variables, make_token

Version = Literal["3", "2"]
MODEL = "layerjam_brake"
"""Model identifier, which is also the name of the library."""
UNITS: Mapping[str, tuple[str, tuple[str, float] | None]] = {
    "s": ('s="1"', ("ms", 1e3)),
    "m": ('m="1"', ("mm", 1e3)),
    "m/s": ('m="1" s="-1"', ("mm/s", 1e3)),
    "Pa": ('kg="1" m="-1" s="-2"', ("kPa", 1e-3)),
    "N": ('kg="1" m="1" s="-2"', None),
    "N/m": ('kg="1" s="-2"', ("kN/m", 1e-3)),
    "J": ('kg="1" m="2" s="-2"', ("mJ", 1e3)),
}
"""{unit: (SI base units, (displayed unit, factor))}."""


def model_description(
    version: Version,
    name: str,
    values: Mapping[str, float],
    sources: Sequence[str],
    mark: str = "",
) -> str:
    """Return the XML of a brake called `name`, with `values` as start values of its parameters.

    Only FMI 2 lists the C files. `mark` is part of the description.
    """
    text = "Soft layer-jamming brake: force from elongation and vacuum"
    text += f" ({mark})" * bool(mark)
    head = (
        f"modelName={quoteattr(name)} "
        f"description={quoteattr(text)} "
        f'generationTool="layerjam {__version__}" variableNamingConvention="structured"'
    )
    lines = _build_fmi3(head, values) if version == "3" else _build_fmi2(head, values, sources)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + "\n".join(lines) + "\n"


def build_description(sources: Sequence[str]) -> str:
    """Return FMI 3's list of source files."""
    files = "".join(f'      <SourceFile name="{file}"/>\n' for file in sources)
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiBuildDescription fmiVersion="3.0">
  <BuildConfiguration modelIdentifier="{MODEL}">
    <SourceFileSet language="C99">
{files}    </SourceFileSet>
  </BuildConfiguration>
</fmiBuildDescription>
"""


def _build_fmi3(head: str, values: Mapping[str, float]) -> Iterator[str]:
    can = (
        f'modelIdentifier="{MODEL}" canGetAndSetFMUState="true" canSerializeFMUState="true" '
        'providesDirectionalDerivatives="true" providesAdjointDerivatives="true"'
    )
    yield f'<fmiModelDescription fmiVersion="3.0" {head} instantiationToken="{make_token()}">'
    yield f"  <ModelExchange {can}/>"
    yield f'  <CoSimulation {can} canHandleVariableCommunicationStepSize="true"/>'
    yield from _begin_variables()
    for v in list_variables():
        kind = "Boolean" if v.role == "flag" else "Float64"
        yield (
            f'    <{kind} name="{v.name}" valueReference="{v.reference}" '
            f"{_describe_variable(v)}{_unit_and_bounds(v)}{_format_start(v, values)}/>"
        )
    yield "  </ModelVariables>"
    yield "  <ModelStructure>"
    outputs = [v for v in list_variables() if v.role in ("output", "flag")]
    for tag in ("Output", "InitialUnknown"):
        for v in outputs:
            yield f'    <{tag} valueReference="{v.reference}"/>'
    yield f'    <EventIndicator valueReference="{TURNING}"/>'
    yield "  </ModelStructure>"
    yield "</fmiModelDescription>"


def _build_fmi2(head: str, values: Mapping[str, float], sources: Sequence[str]) -> Iterator[str]:
    can = (
        f'modelIdentifier="{MODEL}" canGetAndSetFMUstate="true" canSerializeFMUstate="true" '
        'providesDirectionalDerivative="true"'
    )
    names = "".join(f'<File name="{file}"/>' for file in sources)
    files = f"<SourceFiles>{names}</SourceFiles>"
    yield (
        f'<fmiModelDescription fmiVersion="2.0" {head} guid="{make_token()}" '
        'numberOfEventIndicators="1">'
    )
    yield f"  <ModelExchange {can}>{files}</ModelExchange>"
    yield (
        f'  <CoSimulation {can} canHandleVariableCommunicationStepSize="true">'
        f"{files}</CoSimulation>"
    )
    yield from _begin_variables()
    rows_ = [v for v in list_variables() if v.reference != TURNING]
    for v in rows_:
        kind = "Boolean" if v.role == "flag" else "Real"
        yield (
            f'    <ScalarVariable name="{v.name}" valueReference="{v.reference}" '
            f"{_describe_variable(v)}>"
            f"<{kind}{_unit_and_bounds(v)}{_format_start(v, values)}/></ScalarVariable>"
        )
    yield "  </ModelVariables>"
    yield "  <ModelStructure>"
    for tag in ("Outputs", "InitialUnknowns"):
        rows = (
            f'<Unknown index="{i}"/>'
            for i, v in enumerate(rows_, 1)
            if v.role in ("output", "flag")
        )
        yield f"    <{tag}>{''.join(rows)}</{tag}>"
    yield "  </ModelStructure>"
    yield "</fmiModelDescription>"


def _begin_variables() -> Iterator[str]:
    yield "  <UnitDefinitions>"
    for unit, (base, unit_) in UNITS.items():
        display = f'<DisplayUnit name="{unit_[0]}" factor="{unit_[1]:g}"/>' if unit_ else ""
        yield f'    <Unit name="{unit}"><BaseUnit {base}/>{display}</Unit>'
    yield "  </UnitDefinitions>"
    yield '  <DefaultExperiment startTime="0" stopTime="4" stepSize="0.01"/>'
    yield "  <ModelVariables>"


_ROLES = {
    "independent": 'causality="independent" variability="continuous"',
    "input": 'causality="input" variability="continuous"',
    "output": 'causality="output" variability="continuous" initial="calculated"',
    "flag": 'causality="output" variability="discrete" initial="calculated"',
    "local": 'causality="local" variability="continuous" initial="calculated"',
    "parameter": 'causality="parameter" variability="fixed" initial="exact"',
}


def _describe_variable(v: Variable) -> str:
    return f"description={quoteattr(v.text)} {_ROLES[v.role]}"


def _unit_and_bounds(v: Variable) -> str:
    """Return the XML attributes of unit and bounds; the bounds include a zero that means "none"."""
    text = ""
    if v.unit in UNITS:
        display = UNITS[v.unit][1]
        text += f' unit="{v.unit}"' + (f' displayUnit="{display[0]}"' if display else "")
    if v.least is not None and v.most is not None:
        lower_bound = min(0.0, v.least) if v.optional else v.least
        text += f' min="{float(lower_bound)!r}" max="{float(v.most)!r}"'
    return text


def _format_start(v: Variable, values: Mapping[str, float]) -> str:
    if v.role == "parameter":
        return f' start="{float(values[v.name])!r}"'
    return ' start="0"' if v.role == "input" else ""

"""The description of a functional mock-up unit: `modelDescription.xml` for FMI 3.0 and 2.0."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Literal
from xml.sax.saxutils import quoteattr

from layerjam._version import __version__
from layerjam.interop.fmi_variables import TURNING, Variable, token, variables

Version = Literal["3", "2"]
MODEL = "layerjam_brake"
"""The identifier that names the library."""
UNITS: Mapping[str, tuple[str, tuple[str, float] | None]] = {
    "s": ('s="1"', ("ms", 1e3)),
    "m": ('m="1"', ("mm", 1e3)),
    "m/s": ('m="1" s="-1"', ("mm/s", 1e3)),
    "Pa": ('kg="1" m="-1" s="-2"', ("kPa", 1e-3)),
    "N": ('kg="1" m="1" s="-2"', None),
    "N/m": ('kg="1" s="-2"', ("kN/m", 1e-3)),
    "J": ('kg="1" m="2" s="-2"', ("mJ", 1e3)),
}
"""{unit: (SI base units, (unit to show, factor))}."""


def model_description(
    version: Version,
    name: str,
    values: Mapping[str, float],
    sources: Sequence[str],
    mark: str = "",
) -> str:
    """The XML for a brake called `name` with its parameters' values; C files only FMI 2 lists.

    `mark` is said in its description.
    """
    head = _head(name, mark)
    lines = _fmi3(head, values) if version == "3" else _fmi2(head, values, sources)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + "\n".join(lines) + "\n"


def build_description(sources: Sequence[str]) -> str:
    """FMI 3's list of what to compile."""
    files = "".join(f'      <SourceFile name="{file}"/>\n' for file in sources)
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiBuildDescription fmiVersion="3.0">
  <BuildConfiguration modelIdentifier="{MODEL}">
    <SourceFileSet language="C99">
{files}    </SourceFileSet>
  </BuildConfiguration>
</fmiBuildDescription>
"""


def _head(name: str, mark: str) -> str:
    about = "Soft layer-jamming brake: force over elongation and vacuum"
    about += f" ({mark})" * bool(mark)
    return (
        f"modelName={quoteattr(name)} "
        f"description={quoteattr(about)} "
        f'generationTool="layerjam {__version__}" variableNamingConvention="structured"'
    )


def _fmi3(head: str, values: Mapping[str, float]) -> Iterator[str]:
    can = (
        f'modelIdentifier="{MODEL}" canGetAndSetFMUState="true" canSerializeFMUState="true" '
        'providesDirectionalDerivatives="true" providesAdjointDerivatives="true"'
    )
    yield f'<fmiModelDescription fmiVersion="3.0" {head} instantiationToken="{token()}">'
    yield f"  <ModelExchange {can}/>"
    yield f'  <CoSimulation {can} canHandleVariableCommunicationStepSize="true"/>'
    yield from _units()
    yield '  <DefaultExperiment startTime="0" stopTime="4" stepSize="0.01"/>'
    yield "  <ModelVariables>"
    for one in variables():
        kind = "Boolean" if one.role == "flag" else "Float64"
        yield (
            f'    <{kind} name="{one.name}" valueReference="{one.reference}" '
            f"{_said(one)}{_start(one, values)}/>"
        )
    yield "  </ModelVariables>"
    yield "  <ModelStructure>"
    outputs = [one for one in variables() if one.role in ("output", "flag")]
    for tag in ("Output", "InitialUnknown"):
        for one in outputs:
            yield f'    <{tag} valueReference="{one.reference}"/>'
    yield f'    <EventIndicator valueReference="{TURNING}"/>'
    yield "  </ModelStructure>"
    yield "</fmiModelDescription>"


def _fmi2(head: str, values: Mapping[str, float], sources: Sequence[str]) -> Iterator[str]:
    can = (
        f'modelIdentifier="{MODEL}" canGetAndSetFMUstate="true" canSerializeFMUstate="true" '
        'providesDirectionalDerivative="true"'
    )
    files = "".join(f'<File name="{file}"/>' for file in sources)
    files = f"<SourceFiles>{files}</SourceFiles>"
    yield (
        f'<fmiModelDescription fmiVersion="2.0" {head} guid="{token()}" '
        'numberOfEventIndicators="1">'
    )
    yield f"  <ModelExchange {can}>{files}</ModelExchange>"
    yield (
        f'  <CoSimulation {can} canHandleVariableCommunicationStepSize="true">'
        f"{files}</CoSimulation>"
    )
    yield from _units()
    yield '  <DefaultExperiment startTime="0" stopTime="4" stepSize="0.01"/>'
    yield "  <ModelVariables>"
    listed = [one for one in variables() if one.reference != TURNING]
    for one in listed:
        kind = "Boolean" if one.role == "flag" else "Real"
        yield (
            f'    <ScalarVariable name="{one.name}" valueReference="{one.reference}" '
            f"{_said(one, typed=False)}>"
            f"<{kind}{_typed(one)}{_start(one, values)}/></ScalarVariable>"
        )
    yield "  </ModelVariables>"
    yield "  <ModelStructure>"
    for tag in ("Outputs", "InitialUnknowns"):
        rows = (
            f'<Unknown index="{i}"/>'
            for i, one in enumerate(listed, 1)
            if one.role in ("output", "flag")
        )
        yield f"    <{tag}>{''.join(rows)}</{tag}>"
    yield "  </ModelStructure>"
    yield "</fmiModelDescription>"


def _units() -> Iterator[str]:
    yield "  <UnitDefinitions>"
    for unit, (base, shown) in UNITS.items():
        display = f'<DisplayUnit name="{shown[0]}" factor="{shown[1]:g}"/>' if shown else ""
        yield f'    <Unit name="{unit}"><BaseUnit {base}/>{display}</Unit>'
    yield "  </UnitDefinitions>"


_ROLES = {
    "independent": 'causality="independent" variability="continuous"',
    "input": 'causality="input" variability="continuous"',
    "output": 'causality="output" variability="continuous" initial="calculated"',
    "flag": 'causality="output" variability="discrete" initial="calculated"',
    "local": 'causality="local" variability="continuous" initial="calculated"',
    "parameter": 'causality="parameter" variability="fixed" initial="exact"',
}


def _said(one: Variable, *, typed: bool = True) -> str:
    said = f"description={quoteattr(one.text)} {_ROLES[one.role]}"
    return said + (_typed(one) if typed else "")


def _typed(one: Variable) -> str:
    """Unit and bounds; a zero that stands for "none" is inside them."""
    made = ""
    if one.unit in UNITS:
        shown = UNITS[one.unit][1]
        made += f' unit="{one.unit}"' + (f' displayUnit="{shown[0]}"' if shown else "")
    if one.least is not None and one.most is not None:
        least = min(0.0, one.least) if one.optional else one.least
        made += f' min="{float(least)!r}" max="{float(one.most)!r}"'
    return made


def _start(one: Variable, values: Mapping[str, float]) -> str:
    if one.role == "parameter":
        return f' start="{float(values[one.name])!r}"'
    return ' start="0"' if one.role == "input" else ""

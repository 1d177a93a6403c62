"""Systems for the tests: an FMU that adds up what reaches it, and .ssd files around it."""

import zipfile
from pathlib import Path

from cosimo.tests.scene_runs import finished
from fmpy.ssp import ssd
from lxml import etree

SCHEMAS = Path(ssd.__file__).with_name("schema")
SPACES = " ".join(
    f'xmlns:{letters}="http://ssp-standard.org/SSP1/SystemStructure{name}"'
    for letters, name in (("ssd", "Description"), ("ssc", "Common"), ("ssv", "ParameterValues"), ("ssm", "ParameterMapping"))
)
UNITS = {
    "m": 'm="1"',
    "mm": 'm="1" factor="0.001"',
    "inch": 'm="1" factor="0.0254"',
    "s": 's="1"',
    "K": 'K="1"',
    "degF": 'K="1" factor="0.5555555555555556" offset="255.3722222222222"',
}
STEP = (
    '<ssc:Annotation type="com.opensimulationplatform"><osp:Algorithm><osp:FixedStepAlgorithm baseStepSize="0.5"/>'
    "</osp:Algorithm></ssc:Annotation>"
)
HALF = 0.5  # s: macro step of the systems, so that integrals are exact


def definitions(prefix: str = "", *names: str) -> str:
    """Definitions of units, all of them without names."""
    units = "".join(f'<{prefix}Unit name="{n}"><{prefix}BaseUnit {UNITS[n]}/></{prefix}Unit>' for n in names or UNITS)
    return units


def description(u: str = "", y: str = "") -> str:
    """Model description of the adder, with units of measure of its input and its output y."""
    unit = {"u": f'unit="{u}"' if u else "", "y": f'unit="{y}"' if y else ""}
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="adder" guid="{{1}}">
  <CoSimulation modelIdentifier="adder" canHandleVariableCommunicationStepSize="true"/>
  <UnitDefinitions>{definitions()}</UnitDefinitions>
  <TypeDefinitions><SimpleType name="Mode"><Enumeration><Item name="idle" value="0"/><Item name="low" value="1"/>
    <Item name="high" value="4"/></Enumeration></SimpleType></TypeDefinitions>
  <DefaultExperiment stopTime="4" stepSize="{HALF}"/>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input"><Real start="0" {unit["u"]}/></ScalarVariable>
    <ScalarVariable name="x" valueReference="1" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="y" valueReference="2" causality="output"><Real {unit["y"]}/></ScalarVariable>
    <ScalarVariable name="gain" valueReference="3" causality="parameter" variability="fixed">
      <Real start="1" unit="mm"/></ScalarVariable>
    <ScalarVariable name="count" valueReference="0" causality="parameter" variability="fixed">
      <Integer start="0"/></ScalarVariable>
    <ScalarVariable name="mode" valueReference="1" causality="parameter" variability="fixed">
      <Enumeration declaredType="Mode" start="0"/></ScalarVariable>
    <ScalarVariable name="flag" valueReference="0" causality="parameter" variability="fixed">
      <Boolean start="false"/></ScalarVariable>
    <ScalarVariable name="text" valueReference="0" causality="parameter" variability="fixed"><String start=""/></ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="2" dependencies=""/><Unknown index="3" dependencies="1"/></Outputs>
    <InitialUnknowns><Unknown index="2"/><Unknown index="3"/></InitialUnknowns></ModelStructure>
</fmiModelDescription>
"""


def fmu(path: Path, library: Path, u: str = "", y: str = "") -> Path:
    """An FMU file of the adder."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("modelDescription.xml", description(u, y))
        file.write(library, "binaries/linux64/adder.so")
    return path


def connectors(text: str) -> str:
    """ "u< y> k!" as connectors: inputs, outputs, parameters of type Real; "u<[m]" with a unit of measure."""
    found = ""
    for word in text.split():
        name, mark, unit = word.partition("<") if "<" in word else word.partition(">") if ">" in word else word.partition("!")
        kind = {"<": "input", ">": "output", "!": "parameter"}[mark]
        inside = f'<ssc:Real unit="{unit[1:-1]}"/>' if unit else "<ssc:Real/>"
        found += f'<ssd:Connector name="{name}" kind="{kind}">{inside}</ssd:Connector>'
    return f"<ssd:Connectors>{found}</ssd:Connectors>" if found else ""


def component(name: str, ports: str = "u< y>", inside: str = "", source: str = "adder.fmu", more: str = "") -> str:
    """A Component element."""
    return f'<ssd:Component name="{name}" source="{source}" {more}>{connectors(ports)}{inside}</ssd:Component>'


def connection(start: str, end: str, inside: str = "", more: str = "") -> str:
    """A Connection element; "element.connector", or "connector" of the system itself."""
    ends = ""
    for label, text in (("start", start), ("end", end)):
        element, _, name = text.rpartition(".")
        ends += (f' {label}Element="{element}"' if element else "") + f' {label}Connector="{name}"'
    return f"<ssd:Connection{ends} {more}>{inside}</ssd:Connection>"


def system(name: str, elements: str, connections: str = "", ports: str = "", bindings: str = "") -> str:
    """A System element."""
    inner = f"<ssd:Connections>{connections}</ssd:Connections>" if connections else ""
    return f'<ssd:System name="{name}">{connectors(ports)}{bindings}<ssd:Elements>{elements}</ssd:Elements>{inner}</ssd:System>'


def parameter_set(values: str, units: str = "", spaces: str = "") -> str:
    """A ParameterSet of "name=Type:value" and "name=Real:value[unit]", separated by blanks."""
    rows = ""
    for word in values.split():
        name, _, rest = word.partition("=")
        type_, _, value = rest.partition(":")
        value, _, unit = value.partition("[")
        rows += (
            f'<ssv:Parameter name="{name}"><ssv:{type_} value="{value}"'
            + (f' unit="{unit[:-1]}"' if unit else "")
            + "/></ssv:Parameter>"
        )
    inner = f"<ssv:Units>{units}</ssv:Units>" if units else ""
    rows = f"<ssv:Parameters>{rows}</ssv:Parameters>"
    return f'<ssv:ParameterSet version="1.0" name="set" {spaces}>{rows}{inner}</ssv:ParameterSet>'


def bindings(*values: str, mapping: str = "", prefix: str = "", units: str = "") -> str:
    """ParameterBindings with one inline set for each text, all with the same mapping, prefix and units."""
    mapped = f'<ssm:ParameterMapping version="1.0">{mapping}</ssm:ParameterMapping>'
    rows = "".join(
        f'<ssd:ParameterBinding prefix="{prefix}">'
        f"<ssd:ParameterValues>{parameter_set(v, units)}</ssd:ParameterValues>"
        + (f"<ssd:ParameterMapping>{mapped}</ssd:ParameterMapping>" if mapping else "")
        + "</ssd:ParameterBinding>"
        for v in values
    )
    return f"<ssd:ParameterBindings>{rows}</ssd:ParameterBindings>"


def document(root: str, more: str = "", experiment: str = 'startTime="0" stopTime="1"', annotations: str = "") -> str:
    """An .ssd file around a System element; `more` stands before the default experiment."""
    inside = f"<ssd:Annotations>{annotations}</ssd:Annotations>" if annotations else ""
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<ssd:SystemStructureDescription version="1.0" name="test" {SPACES} '
        f'xmlns:osp="urn:osp" xmlns:oms="urn:oms">{root}{more}'
        f"<ssd:DefaultExperiment {experiment}>{inside}</ssd:DefaultExperiment></ssd:SystemStructureDescription>"
    )


def units(*names: str) -> str:
    """The Units element of an .ssd file."""
    return f"<ssd:Units>{definitions('ssc:', *names)}</ssd:Units>"


def validated(text: bytes | str, schema: str = "SystemStructureDescription.xsd") -> etree._Element:
    """The root of a text that is valid against a schema of SSP 1.0, as FMPy ships it."""
    root = etree.fromstring(text.encode() if isinstance(text, str) else text)
    etree.XMLSchema(etree.parse(str(SCHEMAS / schema))).assertValid(root)
    return root


PAIR = component("a") + component("b")


def values(scene):
    """Last value of each recorded output."""
    result = finished(scene)
    return {name: float(column[-1]) for name, column in result.columns.items()}


def read(load, root, more="", experiment='stopTime="1"', annotations=STEP, **options):
    return load(document(root, more, experiment, annotations), **options)

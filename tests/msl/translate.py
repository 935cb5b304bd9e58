"""Writes the ``.acm`` file of a Modelica Standard Library example from its JSON description.

Usage: ``python tests/msl/translate.py DESCRIPTION.json [SUBCIRCUITS.json] > case.acm``

The description lists components, modifiers, connections, equations and sub-circuits by name.
Package names are mapped by the rule of the library (sub-packages of one field fall together),
everything else is copied one to one.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

PACKAGES = [
    (
        r"Electrical\.Analog\.(Interfaces|Basic|Ideal|Semiconductors|Sources|Sensors|Lines)\.",
        "electrical.",
    ),
    (
        r"Electrical\.Digital\.(Interfaces|Basic|Gates|Delay|Converters|Sources)\.",
        "electrical.digital.",
    ),
    (
        r"Mechanics\.Translational\.(Interfaces|Components|Sources|Sensors)\.",
        "mechanical.translational.",
    ),
    (r"Mechanics\.Rotational\.(Interfaces|Components|Sources|Sensors)\.", "mechanical.rotational."),
    (r"Thermal\.HeatTransfer\.(Interfaces|Components|Sources|Sensors)\.", "thermal."),
    (r"Thermal\.HeatTransfer\.Celsius\.", "thermal.celsius."),
    (
        r"(?:Thermal\.)?FluidHeatFlow\.(Interfaces|Components|Sources|Sensors|Media)\.",
        "thermal.fluid.",
    ),
    (r"Electrical\.Spice3\.(Interfaces|Basic|Semiconductors|Sources)\.", "electrical.spice."),
    (
        r"Magnetic\.FluxTubes\.(Interfaces|Basic|Sources|Sensors|Shapes\.FixedShape)\.",
        "magnetic.",
    ),
    (r"Magnetic\.FluxTubes\.Shapes\.Force\.", "magnetic.force."),
    (r"Magnetic\.FluxTubes\.Shapes\.Leakage\.", "magnetic.leakage."),
    (
        r"Mechanics\.MultiBody\."
        r"(Interfaces\.|Parts\.|Joints\.(Assemblies\.)?|Forces\.|Sensors\.|Types\.|(?=World$))",
        "mechanical.multibody.",
    ),
    (r"Blocks\.Types\.", "blocks."),
    (r"Blocks\.Discrete\.", "blocks.sampled."),
    (r"Blocks\.MathBoolean\.", "blocks.math_boolean."),
    (r"Blocks\.MathInteger\.", "blocks.math_integer."),
    (r"Blocks\.Interaction\.Show\.", "blocks."),
    (r"Blocks\.(Interfaces|Continuous|Nonlinear|Math|Logical|Sources|Tables|Routing)\.", "blocks."),
    (r"Units\.SI\.", "si."),
    (r"Constants\.", "constants."),
]
# Names that sub-circuits use as seen from where they stand.
RECORDS = [
    (r"Material\.SoftMagnetic\.((?!BaseData)\w+\.)?", "magnetic.soft_magnetic."),
    (r"Material\.HardMagnetic\.", "magnetic.hard_magnetic."),
    (r"FluidHeatFlow\.Media\.", "thermal.fluid."),
]
# They do not change the equations: choices of symbolic processing, tables in files (ours are not).
IGNORED = {"homotopyType", "strict", "displayUnit", "tableOnFile"}
# Nor do these, which say how a body is drawn. (The width of a box is more than that.)
DRAWING = re.compile(
    r"anim\w*|show\w*|\w*[cC]olor(_\w)?|coilWidth|numberOfWindings|\w*[dD]iameter\w*"
    r"|length_a|cylinderLength\w*|default\w+_to_m|width"
)
DRAWN_BY_SIZE = ("BodyBox", "BodyCylinder")


def type_name(name: str) -> str:
    """Return our name of a class of the Modelica Standard Library."""
    if name == "Real":
        return name
    name = name.removeprefix("Modelica.").replace("AbsolutePressure", "Pressure")
    for pattern, ours in PACKAGES:
        name, found = re.subn("^" + pattern, ours, name)
        if found:
            return name
    return circuit_name(name)


def circuit_name(name: str) -> str:
    """Return the name of a sub-circuit, which must not be that of the example it stands in."""
    return name.rsplit(".", 1)[-1] + "Circuit"


def expression(text: str) -> str:
    """Return an expression with our names of constants and enumerations."""
    for pattern, ours in PACKAGES:
        text = re.sub(r"\bModelica\." + pattern, ours, text)
    for pattern, ours in RECORDS:
        text = re.sub(r"\b" + pattern, ours, text)
    text = text.replace("Modelica.Electrical.Machines.Thermal.Constants.alpha20Copper", "3.92e-3")
    text = text.replace("Examples.Utilities.Generate", "mechanical.translational.Generate")
    text = re.sub(r"(?<![\w.])L\.(?=')", "electrical.digital.Logic.", text)
    text = re.sub(r"(?<![\w.])pi\b", "constants.pi", text)
    return re.sub(r"(?<![\w.])Init\.", "blocks.Init.", text)


def modifiers(arguments: dict[str, Any], of: str = "") -> str:
    """Return ``(a = 1, b(start = 2))`` or nothing, of a component of the class ``of``."""
    parts = []
    for name, value in arguments.items():
        if name in IGNORED or name == "=":
            continue
        if "MultiBody" in of and DRAWING.fullmatch(name) and not of.endswith(DRAWN_BY_SIZE):
            continue
        if of.endswith("FixedRotation") and name in ("angle", "angles"):
            value = f"({value})*constants.deg"
        if isinstance(value, dict):
            own = f" = {expression(value['='])}" if "=" in value else ""
            if "MultiBody" in of and name in ("r_0", "v_0") and "fixed" in value:
                value = {k: v for k, v in value.items() if k != "fixed"} | {"each fixed": "true"}
            parts.append(f"{name}{modifiers(value)}{own}")
        else:
            parts.append(f"{name} = {expression(value)}")
    return f"({', '.join(parts)})" if parts else ""


def equation(text: str) -> str:
    """Return an equation; the message of an assert without the values in it."""
    check = re.match(r"assert\((.*?),\"", text)
    if check:
        return f'assert({expression(check[1])}, "outside of the range of the model")'
    return expression(text).replace("=", " = ")


def parameter_type(name: str, value: str) -> str:
    """Return the type of a parameter of an example, which its description does not name."""
    if re.match(r"L\.'", value):
        return "electrical.digital.Logic"
    if value in ("true", "false"):
        return "Boolean"
    material = re.match(r"Material\.(Soft|Hard)Magnetic\.", value)
    if material:
        return f"magnetic.{material[1].lower()}_magnetic.BaseData"
    kind = re.match(r"Modelica\.Blocks\.Types\.(\w+)\.", value)
    if kind:
        return f"blocks.{kind[1]}"
    medium = re.match(r"(?:Modelica\.Thermal\.)?FluidHeatFlow\.Media\.(\w+)\(", value)
    if medium:
        return f"thermal.fluid.{medium[1]}"
    return "Integer" if name in ("N", "order") else "Real"


def model(name: str, content: dict[str, Any]) -> str:
    """Return the text of one model."""
    description = content.get("description", "part of the example below")
    lines = [f'model {name} "{description}"']
    # A parameter that is solved for at the start only displays a result; its equation goes with it.
    solved = {k for k, v in content["parameters"].items() if isinstance(v, dict) and "fixed" in v}
    starts = [e for e in content["initial_equations"] if e.split("=")[0] not in solved]
    for key, value in content["parameters"].items():
        if key in solved or key == "animation":
            continue
        if value is None:
            lines.append(f"  parameter Real {key};")
            continue
        # What only has a start value is meant to be given where the class is used.
        value = value["start"] if isinstance(value, dict) else value
        lines.append(f"  parameter {parameter_type(key, value)} {key} = {expression(value)};")
    components = [c for c in content["components"] if ".Visualizers." not in c["type"]]
    drawings = {c["name"] for c in content["components"] if ".Visualizers." in c["type"]}
    for component in components:
        prefix = "".join(f"{p} " for p in component.get("prefix", []))
        lines.append(
            f"  {prefix}{type_name(component['type'])} {component['name']}"
            f"{component.get('dim', '')}"
            f"{modifiers(component.get('modifiers', {}), component['type'])};"
        )
    for variable in content["variables"]:
        binding = f" = {expression(variable['binding'])}" if "binding" in variable else ""
        lines.append(
            f"  {type_name(variable['type'])} {variable['name']}"
            f"{modifiers(variable.get('attributes', {}))}{binding};"
        )
    if starts:
        lines.append("initial equation")
        lines += [f"  {expression(e).replace('=', ' = ')};" for e in starts]
    lines.append("equation")
    lines += [f"  {equation(e)};" for e in content["equations"]]
    for a, b in content["connections"]:
        if not drawings & {a.split(".")[0], b.split(".")[0]}:
            lines.append(f"  connect({a}, {b});")
    if "experiment" in content:
        run = content["experiment"]
        lines.append(
            f"  annotation(experiment(StopTime = {run['stop']}, Interval = {run['interval']}, "
            f"Tolerance = {run['solver_tolerance']}));"
        )
    lines.append(f"end {name};")
    return "\n".join(lines) + "\n"


def translate(description: dict[str, Any], subcircuits: dict[str, Any]) -> str:
    """Return the text of a file with the example and the sub-circuits it is made of."""
    parts = [f"// {description['model']}, {description['library']}\n"]
    names = list(dict.fromkeys(description["subcircuits"]))
    for full_name in names:
        # A sub-circuit can be made of others.
        for component in subcircuits[full_name]["components"]:
            if component["type"] in subcircuits and component["type"] not in names:
                names.append(component["type"])
        parts.append(model(circuit_name(full_name), subcircuits[full_name]))
    parts.append(model(description["model"].rsplit(".", 1)[-1], description))
    return "\n".join(parts)


if __name__ == "__main__":
    circuits = json.loads(Path(sys.argv[2]).read_text()) if len(sys.argv) > 2 else {}
    sys.stdout.write(translate(json.loads(Path(sys.argv[1]).read_text()), circuits))

"""The library agrees with itself: descriptions, units, names, defaults, nothing said twice."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import fields

import pytest

from acausal.compiler import compile_class
from acausal.connections.spanning import instantiate_rooted
from acausal.diagnostics import AcausalError
from acausal.flattening.flatten import flatten
from acausal.modeling.classes import Builtin, ClassDef, Constant, find_name
from acausal.modeling.library import Root, classes_of, standard_library
from acausal.modeling.listing import declared, unit_of
from acausal.modeling.load import load_text
from acausal.reference.catalogue import all_classes
from acausal.reference.examples import used_classes
from acausal.reference.fields import FIELDS, direction_of, field_of
from acausal.reference.write import icon_diagnostics
from acausal.syntax import tree
from acausal.syntax.formatter import format_expression
from acausal.syntax.parser import parse_text
from tests.coverage import undescribed, without_unit

#: Components that cannot stand alone with their defaults, and why.
NOT_ALONE: dict[str, str] = {}

#: Pairs of which one has all equations of the other without extending it, and why.
ALIKE: dict[tuple[str, str], str] = dict.fromkeys(
    (
        ("electrical.SignalCurrent", "electrical.SignalVoltage"),
        ("electrical.SignalCurrent", "magnetic.Converter"),
        ("electrical.SignalVoltage", "magnetic.Converter"),
    ),
    "an input has the name that OnePort gives to its voltage or current",
)


@pytest.fixture(scope="module")
def root() -> Root:
    return standard_library()


@pytest.fixture(scope="module")
def classes(root: Root) -> list[ClassDef]:
    found = list(all_classes(root))
    assert len(found) > 800
    return found


# --- descriptions and units ----------------------------------------------------------------


def test_everything_has_a_description(classes: list[ClassDef]) -> None:
    missing = [
        f"{c.full_name}{'.' * bool(name)}{name}"
        for c in classes
        if c.kind != "package"
        for name in undescribed(c)
    ]
    assert missing == []


def test_descriptions_are_short_phrases(classes: list[ClassDef]) -> None:
    wrong = [
        c.full_name
        for c in classes
        if c.tree.description.endswith(".") or c.tree.description[:1].isspace()
    ]
    # An annotation that has slipped into the string before it draws nothing.
    wrong += [
        f"{c.full_name}.{d.name}"
        for c in classes
        for d in c.tree.components
        if "annotation(" in d.description
    ]
    assert wrong == []


def test_values_with_units_belong_to_types_with_units(classes: list[ClassDef]) -> None:
    assert [f"{c.full_name}: {names}" for c in classes if (names := without_unit(c))] == []


_IN_A_UNIT = re.compile(
    r"\bin (m|mm|s|V|A|K|Pa|bar|N|N\.m|kg|J|W|Wb|T|Ohm|rad|Hz|m2|m3|m/s|rad/s|kg/s|deg|eV)\b"
)


def test_no_number_hides_its_unit_in_its_description(classes: list[ClassDef]) -> None:
    """A table may hold several quantities; a single number says its unit by its type."""
    wrong = []
    for c in classes:
        for component in c.tree.components:
            type_class = find_name(c, component.type_name, skip_components=True)
            plain = isinstance(type_class, Builtin) and type_class.name == "Real"
            if c.kind == "function" or not plain or component.dimensions:
                continue
            if not unit_of(component, type_class)[0] and _IN_A_UNIT.search(component.description):
                wrong.append(f"{c.full_name}.{component.name}: {component.description}")
    assert wrong == []


# --- connectors and equations are said once --------------------------------------------------


def _connector_contents(connector: ClassDef) -> frozenset[tuple[str, str, str]]:
    found = set()
    for item in declared(connector):
        words = ("across", "through", "stream", "input", "output")
        flow = next((p for p in words if p in item.component.prefixes), "")
        if not flow and isinstance(item.type_class, ClassDef):
            flow = direction_of(item.type_class)
        unit = unit_of(item.component, item.type_class)[0]
        found.add((item.component.name, flow, unit))
    return frozenset(found)


def _related(a: ClassDef, b: ClassDef) -> bool:
    """Whether two classes have an ancestor in common (themselves included)."""
    return bool({c.full_name for c in a.ancestors()} & {c.full_name for c in b.ancestors()})


def test_connectors_are_defined_once(classes: list[ClassDef]) -> None:
    groups: dict[frozenset[tuple[str, str, str]], list[ClassDef]] = defaultdict(list)
    for c in classes:
        if c.kind == "connector" and (contents := _connector_contents(c)):
            groups[contents].append(c)
    assert len(groups) > 8
    twice = [
        (a.full_name, b.full_name)
        for members in groups.values()
        for k, a in enumerate(members)
        for b in members[k + 1 :]
        if not _related(a, b)
    ]
    assert twice == []


def test_every_connector_belongs_to_a_field(classes: list[ClassDef]) -> None:
    unknown = [c.full_name for c in classes if c.kind == "connector" and field_of(c) == "other"]
    assert unknown == []
    assert len({f.color for f in FIELDS.values()}) >= len(FIELDS) - 2


def _equation_texts(definition: ClassDef) -> frozenset[str]:
    """Return the class's own equations, their sides and sums in a fixed order."""
    found = set()
    pending: list[tree.Equation] = list(definition.tree.equations)
    while pending:
        equation = pending.pop()
        match equation:
            case tree.SimpleEquation():
                sides = sorted((_normal(equation.left), _normal(equation.right)))
                found.add(" = ".join(sides))
            case tree.ForEquation():
                pending += equation.body
            case tree.IfEquation() | tree.WhenEquation():
                for _, body in equation.branches:
                    pending += body
                if isinstance(equation, tree.IfEquation):
                    pending += equation.otherwise
    return frozenset(found)


def _normal(expression: tree.Expression) -> str:
    """Return an expression as text, the terms of a sum and the factors of a product sorted."""
    if isinstance(expression, tree.Binary) and expression.operator in ("+", "*"):
        terms: list[str] = []
        pending: list[tree.Expression] = [expression]
        while pending:
            item = pending.pop()
            if isinstance(item, tree.Binary) and item.operator == expression.operator:
                pending += [item.left, item.right]
            else:
                terms.append(_normal(item))
        return "(" + expression.operator.join(sorted(terms)) + ")"
    if isinstance(expression, tree.Binary):
        left, right = _normal(expression.left), _normal(expression.right)
        return f"({left}{expression.operator}{right})"
    if isinstance(expression, tree.Call) and not expression.named and not expression.indices:
        return f"{expression.function}({', '.join(map(_normal, expression.arguments))})"
    return format_expression(expression)


def _copied(definitions: list[ClassDef]) -> dict[tuple[str, str], list[str]]:
    """Return pairs of classes of which one has all equations of the other without extending it.

    Less than three equations say little: many have ``v = der(s)`` and ``flange_a.f = 0``.
    """
    texts = [(c, _equation_texts(c)) for c in definitions]
    by_equation: dict[str, list[int]] = defaultdict(list)
    for number, (_, equations) in enumerate(texts):
        for equation in sorted(equations):
            by_equation[equation].append(number)
    shared: dict[tuple[int, int], list[str]] = defaultdict(list)
    for equation, members in by_equation.items():
        for k, a in enumerate(members):
            for b in members[k + 1 :]:
                shared[a, b].append(equation)
    found: dict[tuple[str, str], list[str]] = {}
    for (a, b), equations in sorted(shared.items()):
        first, second = texts[a][0], texts[b][0]
        whole = len(equations) in (len(texts[a][1]), len(texts[b][1]))
        if whole and len(equations) >= 3 and not _inherits(first, second):
            names = tuple(sorted((first.full_name, second.full_name)))
            found[names[0], names[1]] = sorted(equations)
    return found


def _inherits(a: ClassDef, b: ClassDef) -> bool:
    """Whether one class is a base of the other."""
    names = {c.full_name for c in a.ancestors()}, {c.full_name for c in b.ancestors()}
    return a.full_name in names[1] or b.full_name in names[0]


def test_no_equations_are_copied(classes: list[ClassDef]) -> None:
    models = [c for c in classes if c.kind in ("model", "block", "class")]
    found = _copied(models)
    assert {p: e for p, e in found.items() if p not in ALIKE} == {}


def test_copies_would_be_seen() -> None:
    text = """
    model A Real power; Real force; Real speed;
    equation power = force*speed; force = 3*speed + 1; speed = sin(time + power); end A;
    model B Real power; Real force; Real speed;
    equation speed*force = power; 1 + speed*3 = force; speed = sin(power + time); end B;
    model C extends A; Real more; equation more = 2*power; end C;
    """
    made = list(load_text(text)[0].values())
    assert list(_copied(made)) == [("A", "B")]


# --- every name means something ----------------------------------------------------------


def _names(definition: ClassDef) -> Iterator[tree.Reference]:
    """Yield the classes and functions that a class names."""
    for clause in definition.tree.extends:
        yield clause.base
    for component in definition.tree.components:
        yield component.type_name
    for node in _nodes(definition.tree):
        if isinstance(node, tree.Call):
            yield node.function


def _nodes(root_node: tree.Node) -> Iterator[tree.Node]:
    pending: list[object] = [root_node]
    while pending:
        item = pending.pop()
        if isinstance(item, tuple):
            pending += item
        elif isinstance(item, tree.Node):
            if isinstance(item, (tree.Annotation, tree.Span)):
                continue
            if isinstance(item, tree.ClassDefinition) and item is not root_node:
                continue
            yield item
            pending += [getattr(item, f.name) for f in fields(item)]


#: Functions of the language.
_LANGUAGE = """
    der pre edge change initial terminal sample reinit noEvent smooth homotopy delay assert
    terminate abs sign sqrt div mod rem ceil floor integer sin cos tan asin acos atan atan2 sinh
    cosh tanh exp log log10 min max sum product size ndims scalar vector matrix identity diagonal
    zeros ones fill linspace outerProduct symmetric cross skew transpose cat Integer String
    Connections.branch Connections.root Connections.potentialRoot Connections.isRoot
    Connections.rooted semiLinear
"""


def test_all_names_exist(classes: list[ClassDef]) -> None:
    language = set(_LANGUAGE.split())
    wrong = []
    for c in classes:
        for name in _names(c):
            if str(name) in language:
                continue
            found = find_name(c, name)
            if found is None or (isinstance(found, Constant) and len(name.parts) > 1):
                wrong.append(f"{c.full_name}: {name} in line {name.span.line}")
    assert wrong == []


def test_icons_are_well_formed(root: Root) -> None:
    assert [f"{d.span}: {d.code} {d.message}" for d in icon_diagnostics(root)] == []


# --- defaults ------------------------------------------------------------------------------


def _outer(definition: ClassDef, seen: dict[str, str], done: set[str]) -> dict[str, str]:
    """Collect the ``outer`` components that a class and its parts need: name -> class."""
    if definition.full_name in done:
        return seen
    done.add(definition.full_name)
    for found in declared(definition):
        if "outer" in found.component.prefixes and isinstance(found.type_class, ClassDef):
            seen.setdefault(found.component.name, found.type_class.full_name)
    for inner in used_classes(definition):
        _outer(inner, seen, done)
    return seen


def _components(classes: list[ClassDef]) -> list[ClassDef]:
    return [
        c
        for c in classes
        if c.kind in ("model", "block", "class")
        and not c.tree.partial
        and "." in c.full_name
        and not isinstance(c.parent, ClassDef)
    ]


def _alone(definition: ClassDef, root: Root, fix_all: bool = False) -> str:
    """Flatten a model with one component without modifiers; return what is said against it.

    The first frame of a body in space is fixed, as an orientation must come from somewhere; all of
    them where the component does not hand it on.
    """
    surroundings = _outer(definition, {}, set())
    lines = [f"inner {type_name} {name};" for name, type_name in surroundings.items()]
    equations = []
    if definition.full_name not in surroundings.values():
        lines.append(f"{definition.full_name} component;")
        frames = [
            d.component.name + "[1]" * bool(d.component.dimensions)
            for d in declared(definition)
            if isinstance(d.type_class, ClassDef)
            and d.type_class.full_name.startswith("mechanical.multibody.Frame")
            and d.component.public
        ]
        if frames:
            lines.append(f"mechanical.multibody.Fixed fixed[{len(frames)}];")
            lines.append("inner mechanical.multibody.World world;" * ("world" not in surroundings))
            connections = [f"connect(fixed[{k}].frame_b, component.{f});"
                           for k, f in enumerate(frames, 1)]  # fmt: skip
            equations += connections if fix_all else connections[:1]
    text = "\n".join(("model Alone", *lines, "equation", *equations, "end Alone;"))
    try:
        model = classes_of(parse_text(text, "<alone>"), root)["Alone"]
        templates, given = instantiate_rooted(model, {})
        flatten(templates, given)
    except AcausalError as error:
        first = error.diagnostics[0]
        if first.code == "C108" and not fix_all:
            return _alone(definition, root, fix_all=True)
        return f"{first.code} {first.message}"
    return ""


def test_components_make_sense_without_modifiers(classes: list[ClassDef], root: Root) -> None:
    said = {c.full_name: text for c in _components(classes) if (text := _alone(c, root))}
    assert {n: t for n, t in said.items() if n not in NOT_ALONE} == {}
    assert sorted(set(NOT_ALONE) - set(said)) == [], "they can stand alone now"


# --- laziness ------------------------------------------------------------------------------

CIRCUIT = """
model Circuit
  electrical.SineVoltage source(V = 10[V], f = 50[Hz]);
  electrical.Resistor r(R = 100[Ohm]);
  electrical.Ground ground;
equation
  connect(source.p, r.p);
  connect(r.n, source.n, ground.p);
end Circuit;
"""


def test_a_circuit_reads_no_hydraulics() -> None:
    found, library = load_text(CIRCUIT)
    compile_class(found["Circuit"])
    packages = {p.parent.name for p in library.sources}
    assert {"electrical", "si"} <= packages
    assert not packages & {"hydraulic", "pneumatic", "vehicle", "magnetic", "multibody", "fluid"}
    assert len(library.sources) == len(set(library.sources))

"""From class templates to the flat model: ids for everything, rows for every equation."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from acausal.connections.junctions import Junctions, find_junctions
from acausal.connections.spanning import SpanningForest, spanning_forest
from acausal.diagnostics import Diagnostic, fail
from acausal.expressions import build
from acausal.expressions.nodes import Expr, slot
from acausal.flattening.balance import check_class
from acausal.flattening.discrete import discrete_part, discrete_variables
from acausal.flattening.experiment import experiment_of
from acausal.flattening.families import FamilyBuilder, LiteralPool
from acausal.flattening.loops import cut_origins, loop_rows
from acausal.flattening.model import (
    Assertion,
    Base,
    Discrete,
    EquationFamily,
    FlatModel,
    Ids,
    Operand,
    RowKind,
    StateSelect,
    Variables,
)
from acausal.flattening.names import NumberingNames
from acausal.flattening.parameters import attribute_values, parameter_values
from acausal.flattening.signals import SignalNumbering
from acausal.instantiation.numbering import Numbering
from acausal.instantiation.template import Template
from acausal.units.dimension import Dimension, format_dimension
from acausal.units.unit import parse_unit

_X, _Y = slot(0), slot(1)


@dataclass
class Flattened:
    """A flat model with what it was made from, for inspection and the connection graph.

    Attributes:
        model: The flat model.
        numbering: Numbers of all instances.
        known_junctions: The junctions, or None once they have been forgotten.
        given: Parameter values by path or pattern.
    """

    model: FlatModel
    numbering: Numbering
    known_junctions: Junctions | None
    given: dict[str, float] = field(default_factory=dict)

    @property
    def junctions(self) -> Junctions:
        """The cuts and how they are joined; found again if they were forgotten."""
        if self.known_junctions is None:
            self.known_junctions = find_junctions(self.numbering)
        return self.known_junctions

    def forget_junctions(self) -> None:
        """Free the junctions: a quarter of a large flat model, and seldom needed again."""
        self.known_junctions = None


def flatten(templates: list[Template], given: dict[str, float] | None = None) -> Flattened:
    """Return the flat model of the last template.

    Args:
        templates: All class templates, components before their owners.
        given: Parameter values by path or pattern; they win over the model's own.

    Raises:
        AcausalError: ``N1xx`` for missing or circular values and unknown parameters, ``B1xx``
            for unbalanced classes.
    """
    numbering = Numbering(templates)
    names = NumberingNames(numbering)
    warnings: list[Diagnostic] = []
    literals = LiteralPool(numbering.n_parameters)
    signals = SignalNumbering(numbering)
    base, is_discrete = discrete_variables(numbering)
    builder = FamilyBuilder(numbering, literals, signals)
    junctions = find_junctions(numbering)
    n_rows = 0
    for group in reversed(numbering.groups):
        for e in group.template.equations:
            n_rows += builder.add_class_equation(
                group.template, e.residual, e.domain, n_rows, e.span, e.text, RowKind.DECLARED,
                e.owner,
            )  # fmt: skip
    # After the equations: a subscript out of range explains more than a wrong count.
    for group in numbering.groups:
        if group.count:
            check_class(group.template)
    equal = FamilyBuilder(numbering, literals, signals)
    forest = spanning_forest(numbering, junctions)
    n_rows = _junction_rows(builder, equal, junctions, forest, is_discrete, n_rows)
    if forest is not None:
        n_rows = loop_rows(builder, numbering, junctions, forest, n_rows)
    start_builder = FamilyBuilder(numbering, literals, signals)
    n_initial = 0
    for group in reversed(numbering.groups):
        for e in group.template.initial_equations:
            n_initial += start_builder.add_class_equation(
                group.template, e.residual, e.domain, n_initial, e.span, e.text, RowKind.INITIAL,
                e.owner,
            )  # fmt: skip
    assertions = _assertions(numbering, literals, signals)
    discrete = discrete_part(numbering, literals, signals, base, is_discrete, equal.build())
    values = parameter_values(numbering, builder, names, given_ids(names, given or {}), warnings)
    variables = _attributes(numbering, builder, values, base)
    families, initial = builder.build(), start_builder.build()
    root = templates[-1]
    model = FlatModel(
        root.name,
        root.definition.tree.description,
        variables,
        numbering.derivative(),
        np.concatenate([values, *literals.values]),
        families,
        n_rows,
        initial,
        n_initial,
        assertions,
        names,
        experiment_of(root.definition),
        tuple(warnings),
        discrete if _happens(discrete, (*families, *initial)) else None,
    )
    return Flattened(model, numbering, junctions, dict(given or {}))


def _happens(discrete: Discrete, families: tuple[EquationFamily, ...]) -> bool:
    """Return whether a model has a discrete part."""
    return bool(
        discrete.discrete.any()
        or discrete.n_signals > 2
        or discrete.reinits
        or discrete.terminations
        or any(kind > Operand.PARAMETER for family in families for kind in family.kinds)
    )


def given_ids(names: NumberingNames, given: dict[str, float]) -> dict[int, float]:
    """Return values by parameter id.

    Raises:
        AcausalError: ``N119`` for unknown parameters, ``U108`` for values in a wrong unit.
    """
    result: dict[int, float] = {}
    for path, value in given.items():
        found = names.find_parameters(path)
        if not found:
            close = names.suggestions(path)
            fail("N119", f"there is no parameter {path}",
                 notes=[f"did you mean {' or '.join(close)}?"] if close else [],
                 help="acausal inspect shows the parameters of a model")  # fmt: skip
        for _, parameter in found:
            _check_unit(names, path, parameter, getattr(value, "dimension", None))
            result[parameter] = value
    return result


def _check_unit(
    names: NumberingNames, path: str, parameter: int, dimension: Dimension | None
) -> None:
    """Refuse a value that was given with a unit which does not fit the parameter."""
    unit = names.parameter_unit(parameter)
    if dimension is None or not unit or parse_unit(unit).dimension == dimension:
        return
    fail("U108", f"{path} is in {unit}, not in {format_dimension(dimension)}",
         names.parameter_declaration(parameter),
         help=f"give it a value in {unit}, or a number without a unit")  # fmt: skip


def _attributes(
    numbering: Numbering,
    builder: FamilyBuilder,
    parameters: NDArray[np.float64],
    base: NDArray[np.int8],
) -> Variables:
    def attribute(name: str, default: float) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        return attribute_values(numbering, builder, parameters, name, default)

    start, start_given = attribute("start", 0.0)
    # The first value of an enumeration is 1.
    start[(base == Base.ENUMERATION) & (start < 1.0)] = 1.0
    return Variables(
        start,
        start_given,
        attribute("fixed", 0.0)[0] != 0.0,
        np.abs(attribute("nominal", 1.0)[0]),
        attribute("min", -np.inf)[0],
        attribute("max", np.inf)[0],
        attribute("stateSelect", float(StateSelect.DEFAULT))[0].astype(np.int8),
    )


def _assertions(
    numbering: Numbering, literals: LiteralPool, signals: SignalNumbering
) -> tuple[Assertion, ...]:
    result: list[Assertion] = []
    for group in reversed(numbering.groups):
        for a in group.template.asserts:
            own = FamilyBuilder(numbering, literals, signals)
            own.add_class_equation(
                group.template, a.condition, a.domain, 0, a.span, a.text, RowKind.DECLARED,
                group.template.name,
            )  # fmt: skip
            result += [Assertion(f, a.message, a.warning) for f in own.build()]
    return tuple(result)


def _ranks(labels: Ids, chosen: NDArray[np.bool_]) -> Ids:
    """Return consecutive numbers for the labels of the chosen members, -1 elsewhere."""
    n = int(labels.max()) + 1 if len(labels) else 0
    used = np.zeros(n, np.bool_)
    used[labels[chosen]] = True
    rank = np.where(used, np.cumsum(used) - 1, -1)
    return np.where(chosen, rank[labels], -1)


def _junction_rows(
    builder: FamilyBuilder,
    equal: FamilyBuilder,
    junctions: Junctions,
    forest: SpanningForest | None,
    discrete: NDArray[np.bool_],
    n_rows: int,
) -> int:
    """Add rows ``sum of through = 0`` and ``across = across``; return the new number of rows.

    Where both sides only change at events there is no row but an equality in ``equal``.
    """
    cuts = np.arange(junctions.count)
    members = np.bincount(junctions.junction, minlength=2 * junctions.count)
    for number, interface in enumerate(junctions.interfaces):
        own = junctions.interface == number
        outer = junctions.junction[0::2]
        inner = junctions.junction[1::2]
        # A row for every junction of two faces or more, and for every lonely outer face.
        faces = np.concatenate([cuts[own], cuts[own]])
        labels = np.concatenate([outer[own], inner[own]])
        is_inner = np.repeat([False, True], int(own.sum()))
        alone = members[labels] == 1
        has_row = ~(alone & is_inner)
        row = _ranks(labels, has_row)
        n_junctions = int(row.max()) + 1 if len(row) else 0
        for leaf, (path, size, through) in enumerate(interface.leaves):
            ids = interface.ids[leaf]
            if through:
                for lonely in (False, True):
                    for inside, template in ((False, _X), (True, build.neg(_X))):
                        pick = has_row & (is_inner == inside) & (alone == lonely)
                        _contributions(builder, junctions, ids, faces[pick], row[pick], size,
                                       template, n_rows, path, lonely)  # fmt: skip
                n_rows += n_junctions * size
            else:
                node = junctions.node
                if forest is not None and path[0] in forest.records:
                    node = forest.label[forest.records.index(path[0])]
                n_rows = _across_rows(
                    builder, equal, junctions, node, ids, cuts[own], size, discrete, n_rows, path
                )
    return n_rows


def _contributions(
    builder: FamilyBuilder, junctions: Junctions, ids: Ids, cuts: Ids, rows: Ids, size: int,
    template: Expr, first: int, path: tuple[str, ...], lonely: bool,
) -> None:  # fmt: skip
    if not len(cuts):
        return
    operands = ids[cuts].reshape(1, -1)
    targets = first + (rows[:, None] * size + np.arange(size)).reshape(-1)
    name = ".".join(path)
    if lonely:
        kind, text = RowKind.UNCONNECTED, f"{name} = 0 (nothing is connected)"
    else:
        kind, text = RowKind.JUNCTION, f"the sum of {name} at the junction is 0"
    builder.add(
        template, (Operand.VARIABLE,), operands, targets,
        cut_origins(junctions, np.repeat(cuts, size), kind, text),
    )  # fmt: skip


def _across_rows(
    builder: FamilyBuilder, equal: FamilyBuilder, junctions: Junctions, nodes: Ids, ids: Ids,
    cuts: Ids, size: int, discrete: NDArray[np.bool_], n_rows: int, path: tuple[str, ...],
) -> int:  # fmt: skip
    # Discrete cuts first: what is continuous there follows from one of them.
    first = np.argsort(~discrete[ids[cuts]].any(axis=1), kind="stable")
    cuts = cuts[first]
    node = nodes[cuts]
    first_of, inverse = np.unique(node, return_index=True, return_inverse=True)[1:]
    reference = cuts[first_of[inverse]]
    other = reference != cuts
    if not other.any():
        return n_rows
    a, b = ids[reference[other]].reshape(-1), ids[cuts[other]].reshape(-1)
    name = ".".join(path)
    text = f"{name} is the same at the junction"
    owners = np.repeat(cuts[other], size)
    held = discrete[a] & discrete[b]
    for chosen, target in ((~held, builder), (held, equal)):
        if not chosen.any():
            continue
        rows = n_rows + np.arange(int(chosen.sum())) if target is builder else a[chosen]
        target.add(
            build.sub(_X, _Y), (Operand.VARIABLE, Operand.VARIABLE),
            np.stack([a[chosen], b[chosen]]), rows,
            cut_origins(junctions, owners[chosen], RowKind.JUNCTION, text),
        )  # fmt: skip
    return n_rows + int((~held).sum())

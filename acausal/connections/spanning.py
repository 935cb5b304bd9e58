"""How overdetermined records, such as orientations, hang together (Modelica 3.6, section 9.4).

The records of all cuts are the nodes of a graph. ``Connections.branch`` and roots are edges that
have to stay, connect equations are edges that can be taken out. A spanning forest keeps every node
within reach of one root; where a connect equation closes a loop of bodies it is taken out, and the
``equalityConstraint`` of the record states what is left of it. Where no root is in reach, the
potential root with the smallest priority becomes one.

Complexity: Kruskal's minimum spanning forest, O(e log e) for e edges (SciPy); ties go by the order
of the connect equations, so that the last one of a loop is taken out.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.connections.components import connected_components
from acausal.connections.junctions import Junctions, find_junctions
from acausal.diagnostics import Span, fail
from acausal.instantiation.instantiate import Given, instantiate
from acausal.instantiation.numbering import Ids, Numbering
from acausal.instantiation.overdetermined import constraint_of
from acausal.instantiation.places import instance_places
from acausal.instantiation.template import Ask, Domain, NodeRef, Template
from acausal.modeling.classes import ClassDef


@dataclass(frozen=True)
class SpanningForest:
    """How the overdetermined records of a model hang together.

    A node is numbered ``record * cuts + cut``.

    Attributes:
        records: Names of the records.
        label: What equates the records: equal for nodes whose variables are the same, shape
            ``(records, cuts)``.
        broken: Nodes on both sides of the connect equations that are taken out, ``(n, 2)``.
        is_root: Of each node.
        nearer: The neighbour of each node on its way to the root, -1 for roots and for what is
            no node.
    """

    records: tuple[str, ...]
    label: Ids
    broken: Ids
    is_root: NDArray[np.bool_]
    nearer: Ids


def instantiate_rooted(
    definition: ClassDef, given: Given | None = None
) -> tuple[list[Template], Given]:
    """Elaborate a model, classes that ask where their orientation comes from included.

    What such a class asks is known when the whole model is, so that the model is elaborated
    twice then; others once.

    Raises:
        AcausalError: As :func:`acausal.instantiation.instantiate.instantiate`; ``C107``,
            ``C108``, ``C109`` for orientations that hang together in no useful way.
    """
    templates, left = instantiate(definition, given)
    if not any(t.asks for t in templates):
        return templates, left
    numbering = Numbering(templates)
    junctions = find_junctions(numbering)
    forest = spanning_forest(numbering, junctions)
    if forest is None:
        return templates, left
    answers = dict(_answers(numbering, junctions, forest))
    if not answers:
        return templates, left
    return instantiate(definition, given, answers)


def spanning_forest(numbering: Numbering, junctions: Junctions) -> SpanningForest | None:
    """Return how overdetermined records hang together, None if the model has none.

    Raises:
        AcausalError: ``C107`` if branches and roots close a loop, ``C108`` if nothing can set a
            record.
    """
    records = _records(numbering)
    if not records:
        return None
    graph = _Graph(numbering, junctions, records)
    n = graph.size
    fixed, connects = graph.fixed_edges(), graph.connect_edges()
    # The node after the last one stands for the ground that all roots stand on.
    edges = np.concatenate([fixed, connects])
    kept = _spanning(edges, n + 1)
    lost = np.flatnonzero(~kept[: len(fixed)])
    if len(lost):
        _refuse_loop(graph, int(lost[0]))
    same = connects[kept[len(fixed) :]]
    label = connected_components(same[:, 0], same[:, 1], n)[1]
    broken = connects[~kept[len(fixed) :]]
    # Two connect equations that say the same are no loop.
    pairs = np.sort(label[broken], axis=1)
    apart = pairs[:, 0] != pairs[:, 1]
    _, first = np.unique(pairs[apart], axis=0, return_index=True)
    broken = broken[apart][np.sort(first)]
    chosen = graph.choose_roots(edges)
    edges = np.concatenate([edges[kept], np.stack([np.full(len(chosen), n), chosen], axis=1)])
    nearer = _towards(edges, n)
    is_root = nearer == n
    nearer[is_root] = -1
    return SpanningForest(tuple(records), label.reshape(len(records), -1), broken, is_root, nearer)


class _Graph:
    """Nodes and edges of the records of a model."""

    def __init__(
        self, numbering: Numbering, junctions: Junctions, records: dict[str, set[int]]
    ) -> None:
        self.numbering = numbering
        self.junctions = junctions
        self.records = records
        self.names = list(records)
        self.cuts = junctions.count
        self.size = len(records) * self.cuts
        #: Declarations by the first of their edges or potential roots, for messages.
        self.spans: list[tuple[int, Span]] = []
        self.exists = np.zeros(self.size, np.bool_)
        for k, templates in enumerate(records.values()):
            own = np.isin(junctions.group, sorted(templates))
            self.exists[k * self.cuts : (k + 1) * self.cuts] = own

    def nodes(self, template: Template, node: NodeRef, domain: Domain) -> Ids:
        """Return the nodes that a class names, for all instances and passes."""
        return node_numbers(self.numbering, self.junctions, self.names, template, node, domain)

    def fixed_edges(self) -> Ids:
        """Return branches, and edges from the ground (``size``) to the roots."""
        found: list[Ids] = [np.zeros((0, 2), np.int64)]
        count = 0
        for group in self.numbering.groups:
            if not group.count:
                continue
            template = group.template
            for branch in template.branches:
                ends = [self.nodes(template, e, branch.domain) for e in (branch.tail, branch.head)]
                self.spans.append((count, branch.span))
                found.append(np.stack(ends, axis=1))
                count += len(found[-1])
            for root in template.roots:
                if root.priority is None:
                    own = self.nodes(template, root.node, root.domain)
                    self.spans.append((count, root.span))
                    found.append(np.stack([np.full(len(own), self.size), own], axis=1))
                    count += len(own)
        return np.concatenate(found)

    def connect_edges(self) -> Ids:
        """Return the edges of connect equations, each pair once, in their order."""
        cuts = np.sort(self.junctions.edges // 2, axis=1)
        cuts = cuts[cuts[:, 0] != cuts[:, 1]]
        _, first = np.unique(cuts, axis=0, return_index=True)
        cuts = cuts[np.sort(first)]
        shifts = np.arange(len(self.names)) * self.cuts
        edges = (cuts[None, :, :] + shifts[:, None, None]).reshape(-1, 2)
        found: Ids = edges[self.exists[edges].all(axis=1)]
        return found

    def choose_roots(self, edges: Ids) -> Ids:
        """Return the potential roots that become roots: one for each part without a root."""
        count, part = connected_components(edges[:, 0], edges[:, 1], self.size + 1)
        rooted = np.zeros(count, np.bool_)
        rooted[part[self.size]] = True
        rooted |= ~np.isin(np.arange(count), part[:-1][self.exists])
        nodes: list[Ids] = [np.zeros(0, np.int64)]
        priorities: list[Ids] = [np.zeros(0, np.int64)]
        for group in self.numbering.groups:
            for root in group.template.roots if group.count else ():
                if root.priority is not None:
                    own = self.nodes(group.template, root.node, root.domain)
                    nodes.append(own)
                    priorities.append(np.full(len(own), root.priority))
        node, priority = np.concatenate(nodes), np.concatenate(priorities)
        order = np.lexsort([node, priority])
        node = node[order]
        _, first = np.unique(part[node], return_index=True)
        chosen = node[first]
        chosen = np.sort(chosen[~rooted[part[chosen]]])
        rooted[part[chosen]] = True
        if not rooted.all():
            self._refuse_unrooted(part, int(np.flatnonzero(~rooted)[0]))
        return chosen

    def _refuse_unrooted(self, part: Ids, lost: int) -> None:
        node = int(np.flatnonzero((part[:-1] == lost) & self.exists)[0])
        fail("C108", f"nothing sets {self.path(node)}",
             help="connect it to a component that sets it: one fixed in space, a joint that leads "
             "there, or a body that can move freely")  # fmt: skip

    def path(self, node: int) -> str:
        """Return the path of a node."""
        record, cut = divmod(node, self.cuts)
        here = np.array([self.junctions.instance[cut]])
        place = instance_places(self.numbering, int(self.junctions.group[cut]), here)[0]
        return f"{place.paths()[0]}.{self.names[record]}"


def _records(numbering: Numbering) -> dict[str, set[int]]:
    """Return the connector templates that have an overdetermined record, by its name."""
    result: dict[str, set[int]] = {}
    for group in numbering.groups:
        if group.template.is_connector and group.count:
            for name, child in group.template.children.items():
                if constraint_of(child.template) is not None:
                    result.setdefault(name, set()).add(group.template.number)
    return result


def node_numbers(
    numbering: Numbering, junctions: Junctions, records: list[str], template: Template,
    node: NodeRef, domain: Domain,
) -> Ids:  # fmt: skip
    """Return node numbers, instance by instance, pass by pass, shape ``(count * length,)``."""
    where, here = numbering.instances(template, node.cut.path, node.cut.outer, domain)
    count = numbering.groups[template.number].count
    first = int(np.searchsorted(junctions.group, where.number))
    cuts = np.broadcast_to(first + here, (count, domain.length)).reshape(-1)
    return records.index(node.record) * junctions.count + cuts


def _spanning(edges: Ids, n_nodes: int) -> NDArray[np.bool_]:
    """Mark the edges of a spanning forest; earlier ones come first."""
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import minimum_spanning_tree

    kept = np.zeros(len(edges), np.bool_)
    if not len(edges):
        return kept
    ends = np.sort(edges, axis=1)
    single = np.flatnonzero(ends[:, 0] != ends[:, 1])
    _, first = np.unique(ends[single], axis=0, return_index=True)
    single = single[np.sort(first)]
    weights = (single + 1).astype(np.float64)
    graph = csr_matrix((weights, tuple(ends[single].T)), shape=(n_nodes, n_nodes))
    tree = minimum_spanning_tree(graph)
    kept[np.rint(tree.data).astype(np.int64) - 1] = True
    return kept


def _towards(edges: Ids, ground: int) -> Ids:
    """Return the neighbour of each node on its way to the ground, -1 without one."""
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import breadth_first_order

    graph = csr_matrix(
        (np.ones(len(edges), np.int8), (edges[:, 0], edges[:, 1])), shape=(ground + 1, ground + 1)
    )
    found = breadth_first_order(graph, ground, directed=False)[1][:-1]
    return np.where(found < 0, -1, found).astype(np.int64)


def _refuse_loop(graph: _Graph, edge: int) -> None:
    firsts = [first for first, _ in graph.spans]
    span = graph.spans[int(np.searchsorted(firsts, edge, "right")) - 1][1]
    fail("C107", "this sets an orientation a second time", span,
         help="leave out one of the branches or roots around the loop: a component that closes "
         "a loop states its constraints without a branch")  # fmt: skip


def _answers(
    numbering: Numbering, junctions: Junctions, forest: SpanningForest
) -> Iterator[tuple[tuple[str, ...], bool]]:
    """Yield what classes ask, by path of the instance and question."""
    for group in numbering.groups:
        if not group.count:
            continue
        for ask in group.template.asks.values():
            holds = _holds(numbering, junctions, forest, group.template, ask)
            for place in instance_places(numbering, group.template.number, np.arange(group.count)):
                own = holds[place.members]
                if ask.operator == "isRoot" and own.any() and not own.all():
                    _refuse_mixed(group.template, place.paths(), own)
                # Both forms of a class that asks `rooted` mean the same.
                yes = own.all() if ask.operator == "isRoot" else own.any()
                yield (*(name for name, _ in place.steps), ask.text), bool(yes)


def _holds(
    numbering: Numbering, junctions: Junctions, forest: SpanningForest, template: Template, ask: Ask
) -> NDArray[np.bool_]:
    def nodes(node: NodeRef) -> Ids:
        return node_numbers(numbering, junctions, list(forest.records), template, node, Domain())

    own = nodes(ask.node)
    if ask.operator == "isRoot":
        return forest.is_root[own]
    result = np.zeros(len(own), np.bool_)
    for branch in template.branches:
        for here, there in ((branch.tail, branch.head), (branch.head, branch.tail)):
            if here == ask.node:
                result |= forest.nearer[nodes(there)] == own
    return result


def _refuse_mixed(template: Template, paths: list[str], roots: NDArray[np.bool_]) -> None:
    one, other = paths[int(np.argmax(roots))], paths[int(np.argmin(roots))]
    fail("C109", f"{one} has to set its own orientation, {other} has not", template.span,
         help=f"declare {one} apart from the array, or lead a joint with six degrees of freedom "
         "to it")  # fmt: skip

"""The connection graph: which component meets which, for questions about a model.

Nodes are components (path) and junctions (number); every cut is an edge between its component and
the junction it meets. A component made of others does not stand in the graph itself: a cut that it
only hands through to its inside is an edge between the junction outside and the one inside.

:func:`connections` gives the same as arrays, by vectorised index arithmetic; it takes a second for
a million cuts. :func:`connection_graph` makes a networkx graph of it, about one kilobyte per cut:
for models of more than some 100 000 cuts the arrays are the better answer.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from acausal.connections.junctions import Junctions
from acausal.diagnostics import fail
from acausal.diagnostics.suggest import nearest
from acausal.expressions.traverse import slots
from acausal.instantiation.numbering import Ids, Numbering
from acausal.instantiation.places import instance_places
from acausal.instantiation.template import Ref, Template
from acausal.memory import no_garbage_collection

if TYPE_CHECKING:
    import networkx


class Connected(Protocol):
    """What has cuts that meet: the result of flattening."""

    numbering: Numbering

    @property
    def junctions(self) -> Junctions:
        """The cuts and how they are joined."""


@dataclass(frozen=True)
class Connections:
    """The edges of the connection graph as arrays.

    Attributes:
        component_group, component_instance: Group and instance of each component that stands in
            the graph, each of shape ``(components,)``.
        n_junctions: Number of junctions; they are numbered in the order of their cuts.
        cut: Number of the cut of each edge between a component and a junction, ``(edges,)``.
        component: Its component, as an index into the components.
        junction: Its junction.
        physical: Its cut has a through variable, shape ``(edges,)``; others carry signals.
        passage: Number of each cut that is handed through, shape ``(passages,)``.
        passage_junctions: Junctions outside and inside, shape ``(passages, 2)``.
    """

    component_group: Ids
    component_instance: Ids
    n_junctions: int
    cut: Ids
    component: Ids
    junction: Ids
    physical: NDArray[np.bool_]
    passage: Ids
    passage_junctions: Ids

    @property
    def n_components(self) -> int:
        """Number of components."""
        return len(self.component_group)

    def islands(self) -> tuple[int, Ids, Ids]:
        """Return the parts that nothing connects.

        Returns:
            Their number, the island of each component and of each junction; islands are
            numbered in the order of their first components.
        """
        n = self.n_components
        tails = np.concatenate([self.component, n + self.passage_junctions[:, 0]])
        heads = np.concatenate([n + self.junction, n + self.passage_junctions[:, 1]])
        total = n + self.n_junctions
        if not total:
            return 0, np.zeros(0, np.int64), np.zeros(0, np.int64)
        from scipy.sparse import coo_matrix
        from scipy.sparse.csgraph import connected_components

        graph = coo_matrix((np.ones(len(tails), np.int8), (tails, heads)), shape=(total, total))
        count, label = connected_components(graph.tocsr(), directed=False)
        _, first, inverse = np.unique(label, return_index=True, return_inverse=True)
        rank = np.argsort(np.argsort(first))[inverse.reshape(-1)].astype(np.int64)
        return int(count), rank[:n], rank[n:]


def connections(flattened: Connected) -> Connections:
    """Return the edges of the connection graph of a flattened model."""
    numbering, junctions = flattened.numbering, flattened.junctions
    whole = np.flatnonzero(junctions.interface >= 0)
    owner_group, owner_instance, own_use = _owners(numbering, junctions, whole)
    outer, inner = junctions.junction[2 * whole], junctions.junction[2 * whole + 1]
    faces = np.bincount(junctions.junction, minlength=2 * junctions.count + 1)
    handed = faces[inner] > 1
    root = len(numbering.groups) - 1
    attached = ~handed | own_use
    # A cut of the model itself meets nothing outside: only its inner face counts.
    own_cut = owner_group == root
    outside = np.where(own_cut, inner, outer)
    passes = handed & ~own_cut
    attached &= ~own_cut | own_use

    used = np.zeros(2 * junctions.count + 1, np.bool_)
    used[outside[attached]] = True
    used[outer[passes]] = used[inner[passes]] = True
    used[inner[own_cut & handed]] = True
    number = np.cumsum(used) - 1
    base = np.cumsum([0, *(g.count for g in numbering.groups)])
    global_owner = (base[owner_group] + owner_instance)[attached]
    components, component = np.unique(global_owner, return_inverse=True)
    group = np.searchsorted(base, components, "right") - 1
    through = np.array([any(t for _, _, t in i.leaves) for i in junctions.interfaces], np.bool_)
    return Connections(
        group,
        components - base[group],
        int(used.sum()),
        whole[attached],
        component.reshape(-1),
        number[outside[attached]],
        through[junctions.interface[whole[attached]]],
        whole[passes],
        np.stack([number[outer[passes]], number[inner[passes]]], axis=1),
    )


def _owners(
    numbering: Numbering, junctions: Junctions, cuts: Ids
) -> tuple[Ids, Ids, NDArray[np.bool_]]:
    """Return group and instance of the component of each cut, and whether its equations use it."""
    group_of = np.full(len(cuts), -1, np.int64)
    instance_of = np.zeros(len(cuts), np.int64)
    used = np.zeros(len(cuts), np.bool_)
    groups = junctions.group[cuts]
    for number in np.unique(groups).tolist():
        own = np.flatnonzero(groups == number)
        instance = junctions.instance[cuts[own]]
        blocks = numbering.groups[number].blocks
        which = np.searchsorted(np.array([b.first for b in blocks]), instance, "right") - 1
        firsts, sizes, owners, uses = (
            np.array(x)
            for x in zip(
                *((b.first, b.size, b.owner, _uses(numbering, b.owner, b.name)) for b in blocks),
                strict=True,
            )
        )
        group_of[own] = owners[which]
        instance_of[own] = (instance - firsts[which]) // sizes[which]
        used[own] = uses[which]
    return group_of, instance_of, used


def _uses(numbering: Numbering, owner: int, cut: str) -> bool:
    """Tell whether the equations of a class refer to one of its cuts."""
    template: Template = numbering.groups[owner].template
    return any(
        isinstance(ref, Ref) and not ref.outer and len(ref.path) > 0 and ref.path[0].name == cut
        for equation in template.equations
        for ref in slots(equation.residual)
    )


def cut_paths(numbering: Numbering, junctions: Junctions, cuts: Ids) -> list[str]:
    """Return the paths of cuts."""
    return instance_paths(numbering, junctions.group[cuts], junctions.instance[cuts])


def instance_paths(numbering: Numbering, groups: Ids, instances: Ids) -> list[str]:
    """Return the paths of instances of any groups, each of shape ``(n,)``."""
    result = np.empty(len(groups), object)
    for number in np.unique(groups).tolist():
        own = np.flatnonzero(groups == number)
        for place in instance_places(numbering, number, instances[own]):
            result[own[place.members]] = place.paths()
    found: list[str] = result.tolist()
    return found


def connection_graph(flattened: Connected) -> networkx.MultiGraph[Any]:
    """Return the connection graph of a flattened model, a ``networkx.MultiGraph``.

    Component nodes are paths (the model itself is the empty one) with ``kind="component"`` and
    ``type``, their class; junction nodes are numbers with ``kind="junction"``. The key of an
    edge is the path of its cut. It carries ``kind`` (``cut``, or ``passage`` for one that a
    composite component hands to its inside), ``cut``, ``connector`` (its class), ``junction``
    and ``physical`` (it has a through variable; others carry signals). Two cuts of one component
    at one junction are two edges.
    """
    with no_garbage_collection():
        return _graph(flattened)


def _graph(flattened: Connected) -> networkx.MultiGraph[Any]:
    import networkx

    numbering, junctions = flattened.numbering, flattened.junctions
    edges = connections(flattened)
    graph: networkx.MultiGraph[Any] = networkx.MultiGraph()
    paths = instance_paths(numbering, edges.component_group, edges.component_instance)
    types = [g.template.name for g in numbering.groups]
    graph.add_nodes_from(
        (path, {"kind": "component", "type": types[g]})
        for path, g in zip(paths, edges.component_group.tolist(), strict=True)
    )
    graph.add_nodes_from((k, {"kind": "junction"}) for k in range(edges.n_junctions))
    connectors = [types[g] for g in junctions.group[edges.cut].tolist()]
    graph.add_edges_from(
        (paths[c], j, cut, _edge("cut", cut, connector, j, physical))
        for c, j, cut, connector, physical in zip(
            edges.component.tolist(),
            edges.junction.tolist(),
            cut_paths(numbering, junctions, edges.cut),
            connectors,
            edges.physical.tolist(),
            strict=True,
        )
    )
    connectors = [types[g] for g in junctions.group[edges.passage].tolist()]
    through = [any(t for _, _, t in i.leaves) for i in junctions.interfaces]
    graph.add_edges_from(
        (a, b, cut, _edge("passage", cut, connector, a, through[interface]))
        for (a, b), cut, connector, interface in zip(
            edges.passage_junctions.tolist(),
            cut_paths(numbering, junctions, edges.passage),
            connectors,
            junctions.interface[edges.passage].tolist(),
            strict=True,
        )
    )
    return graph


def _edge(kind: str, cut: str, connector: str, junction: int, physical: bool) -> dict[str, object]:
    return {
        "kind": kind, "cut": cut, "connector": connector, "junction": junction,
        "physical": physical,
    }  # fmt: skip


def islands(graph: networkx.MultiGraph[Any]) -> list[list[str]]:
    """Return the components of every part of a connection graph that nothing connects.

    Parts and components come in the order of the graph's nodes.
    """
    import networkx

    part_of = {
        node: k for k, part in enumerate(networkx.connected_components(graph)) for node in part
    }
    found: dict[int, list[str]] = {}
    for node in graph:
        if isinstance(node, str):
            found.setdefault(part_of[node], []).append(node)
    return list(found.values())


def loops(graph: networkx.MultiGraph[Any]) -> list[list[str]]:
    """Return a basis of the loops of a connection graph, each as the components along it.

    A component with two cuts at one junction is a loop of its own.
    """
    import networkx

    simple = networkx.Graph(graph)
    found = [
        [node for node in cycle if isinstance(node, str)] for cycle in networkx.cycle_basis(simple)
    ]
    for a, b in simple.edges():
        for _ in range(graph.number_of_edges(a, b) - 1):
            found.append([node for node in (a, b) if isinstance(node, str)])
    return found


def neighbours(graph: networkx.MultiGraph[Any], component: str) -> dict[str, list[str]]:
    """Return, for every cut of a component, the other cuts it meets.

    Cuts that a composite component hands through are passed by: what lies behind them counts.

    Raises:
        AcausalError: ``N102`` if there is no such component.
    """
    if component not in graph or not isinstance(component, str):
        close = nearest(component, [n for n in graph if isinstance(n, str)])
        fail(
            "N102",
            f"there is no component {component} with cuts of its own",
            notes=[f"did you mean {' or '.join(close)}?"] if close else [],
            help="a component made of others hands its cuts through; ask for one inside",
        )
    result: dict[str, list[str]] = {}
    for _, junction, cut in graph.edges(component, keys=True):
        met: list[str] = []
        pending, seen = [junction], {junction}
        while pending:
            here = pending.pop(0)
            for _, there, key, kind in graph.edges(here, keys=True, data="kind"):
                if kind == "passage":
                    if there not in seen:
                        seen.add(there)
                        pending.append(there)
                elif key != cut:
                    met.append(key)
        result[cut] = met
    return result

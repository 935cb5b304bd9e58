"""Graphs with components on their edges and nodes become models."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NoReturn

from acausal.compose.component import Component, ComponentType
from acausal.compose.model import Model
from acausal.compose.names import RESERVED
from acausal.compose.places import here
from acausal.diagnostics import AcausalError, Span, fail
from acausal.diagnostics.suggest import nearest
from acausal.netlists.cut_pairs import cut_pair, cuts_of, single_cut
from acausal.netlists.identifiers import identifier
from acausal.netlists.packages import package

if TYPE_CHECKING:
    import networkx

#: What data of edges and nodes mean; all other data are parameters.
_EDGE_KEYS = ("component", "name", "cuts", "parameters", "description")
_NODE_KEYS = ("component", "components", "name", "cut", "parameters", "description")


def from_graph(
    graph: networkx.Graph[Any],
    name: str = "network",
    *,
    component: Any = None,
    ignore: Iterable[str] = (),
    description: str = "",
) -> Model:
    """Make a model of a graph whose edges and nodes carry components.

    An edge joins the first cut of its component to its tail and the second one to its head. Its
    data are

    - ``component``: a class, or its name such as ``"electrical.Resistor"``;
    - ``name``: its name in the model; by default class and nodes, as in ``resistor_in_out``;
    - ``cuts``: two names of cuts for tail and head, or a dictionary ``{node: cut}``; by default
      ``p`` and ``n``, ``flange_a`` and ``flange_b``, ``port_a`` and ``port_b``, ``frame_a`` and
      ``frame_b``, ... or the only two;
    - ``description``, and ``parameters`` as a dictionary. All other data are parameters, too.

    A node carries nothing, or a component whose cut is joined to the node: ``component``, ``name``,
    ``cut``, ``parameters`` as for edges; ``components`` is a list of classes or of such
    dictionaries. In an undirected graph the tail of an edge is the node that was added first.

    Args:
        graph: A graph, directed or not, with or without parallel edges.
        name: Name of the model.
        component: Class of edges that have none.
        ignore: Names of data that are no parameters, such as ``weight``.
        description: Description of the model.

    Returns:
        A model that can be changed; its parts stand in the order of nodes, then edges.

    Raises:
        AcausalError: ``N150`` and ``N103`` for unknown classes and parameters, ``N160`` and
            ``N161`` for other data that make no component, ``C101`` where unlike cuts meet; all
            name the edge or node.

    Example:
        >>> import acausal as ac
        >>> import networkx as nx
        >>> from acausal.library import electrical as el
        >>> graph = nx.DiGraph()
        >>> graph.add_edge("in", 0, component=el.ConstantVoltage, V=10, name="source")
        >>> graph.add_edge("in", "out", component="electrical.Resistor", R=100)
        >>> graph.add_edge("out", 0, component="electrical.Resistor", R=300)
        >>> graph.add_node(0, component=el.Ground)
        >>> divider = ac.from_graph(graph, "divider")
        >>> float(divider.simulate(stop_time=1)["resistor_out_0.v"].values[-1])
        7.5
    """
    import networkx

    if not isinstance(graph, networkx.Graph):
        fail("N160", f"{graph!r} is no graph", here(), help="give a graph of networkx")
    return _Network(graph, Model(name, description), component, frozenset(ignore)).model


class _Network:
    """A graph that becomes a model."""

    def __init__(
        self, graph: networkx.Graph[Any], model: Model, default: Any, ignore: frozenset[str]
    ) -> None:
        self.model = model
        self.default = default
        self.ignore = ignore
        self.span = here()
        self.names: set[str] = set()
        self.count: dict[str, int] = {}
        #: Cuts that meet at each node.
        self.cuts: dict[Hashable, list[Any]] = {node: [] for node in graph.nodes}
        edges = list(graph.edges(data=True))
        # Names that are asked for come first; made ones keep out of their way.
        for what, data in self._all(graph, edges):
            self._reserve(data, what)
        self.order = {node: k for k, node in enumerate(graph.nodes)}
        for node, data in graph.nodes(data=True):
            self._node(node, data)
        for tail, head, data in edges:
            if not graph.is_directed() and self.order[head] < self.order[tail]:
                tail, head = head, tail
            self._edge(tail, head, data)
        for node, cuts in self.cuts.items():
            if len(cuts) > 1:
                try:
                    model.connect(*cuts)
                except AcausalError as error:
                    raise _at(error, f"at node {node!r}") from None

    def _all(self, graph: Any, edges: list[Any]) -> Iterable[tuple[str, Any]]:
        for node, data in graph.nodes(data=True):
            yield f"node {node!r}", data
            for part in data.get("components") or () if isinstance(data, dict) else ():
                if isinstance(part, Mapping):
                    yield f"node {node!r}", part
        for tail, head, data in edges:
            yield f"edge ({tail!r}, {head!r})", data

    def _reserve(self, data: Any, what: str) -> None:
        asked = data.get("name")
        if asked is None or not (data.get("component") or data.get("components") or self.default):
            return
        if not isinstance(asked, str):
            fail("N160", f"the name {asked!r} of {what} is no text", self.span,
                 help='give a name such as "r1", or none')  # fmt: skip
        if asked in self.names:
            fail("N105", f"two components are called {asked}", self.span, label=f"one at {what}",
                 help="give each its own name, or none")  # fmt: skip
        self.names.add(asked)

    def _name(self, kind: Any, where: str) -> str:
        """Return a name made of class and nodes; parallel edges are numbered from the second."""
        title = kind.title.rpartition(".")[2]
        base = f"{title[0].lower()}{title[1:]}_{where}"
        count = self.count.get(base, 0) + 1
        found = base if count == 1 else f"{base}_{count}"
        while found in self.names or found in RESERVED or hasattr(Model, found):
            count += 1
            found = f"{base}_{count}"
        self.count[base] = count
        self.names.add(found)
        return found

    def _edge(self, tail: Hashable, head: Hashable, data: dict[str, Any]) -> None:
        what = f"edge ({tail!r}, {head!r})"
        given = data.get("component", self.default)
        if given is None:
            fail("N160", f"{what} has no component", self.span,
                 help='write add_edge(a, b, component="electrical.Resistor", R=100), or give '
                 "from_graph a component for all edges")  # fmt: skip
        part = self._part(given, data, _EDGE_KEYS, what)
        kind = part._kind
        wanted = data.get("cuts")
        if isinstance(wanted, Mapping) and set(wanted) == {tail, head} and tail != head:
            wanted = (wanted[tail], wanted[head])
        if wanted is None:
            wanted = cut_pair(kind)
            if wanted is None:
                fail("N161", f"which cuts of {kind.title} are joined to the ends of {what}?",
                     self.span, label=f"it has {', '.join(cuts_of(kind)) or 'no cuts'}",
                     help="give the edge cuts=(first, second)")  # fmt: skip
        if isinstance(wanted, str) or not isinstance(wanted, Iterable) or len(list(wanted)) != 2:
            fail("N161", f"cuts={wanted!r} of {what} are not two", self.span,
                 help='write cuts=("p", "n"), or cuts={node: "p", other: "n"}')  # fmt: skip
        first, second = wanted
        self._add(part, data, f"{identifier(str(tail), '')}_{identifier(str(head), '')}", what)
        self._join(tail, part, first, what)
        self._join(head, part, second, what)

    def _node(self, node: Hashable, data: dict[str, Any]) -> None:
        what = f"node {node!r}"
        parts: list[Any] = []
        if data.get("component") is not None:
            parts.append(data)
        several = data.get("components") or ()
        if isinstance(several, str | Mapping) or not isinstance(several, Iterable):
            fail("N160", f"components of {what} are no list", self.span,
                 help="give a list of classes or of dictionaries")  # fmt: skip
        for item in several:
            parts.append(item if isinstance(item, Mapping) else {"component": item})
        for item in parts:
            if "component" not in item:
                fail("N160", f"{what} has data without a component", self.span,
                     help='write dict(component="electrical.Ground")')  # fmt: skip
            part = self._part(item["component"], item, _NODE_KEYS, what)
            cut = item.get("cut") or single_cut(part._kind)
            if cut is None:
                fail("N161", f"which cut of {part._kind.title} is joined to {what}?", self.span,
                     label=f"it has {', '.join(cuts_of(part._kind)) or 'no cuts'}",
                     help="give the node cut=...")  # fmt: skip
            self._add(part, item, identifier(str(node), ""), what)
            self._join(node, part, cut, what)

    def _part(
        self, given: Any, data: Mapping[str, Any], keys: tuple[str, ...], what: str
    ) -> Component:
        """Return the component of an edge or node."""
        cls = component_class(given, self.span, what)
        parameters = {k: v for k, v in data.items() if k not in keys and k not in self.ignore}
        more = data.get("parameters") or {}
        if not isinstance(more, Mapping):
            fail("N160", f"parameters of {what} are no dictionary", self.span,
                 help="write parameters=dict(R=100)")  # fmt: skip
        for key in (*parameters, *more):
            if not isinstance(key, str):
                fail("N160", f"{key!r} of {what} is no name of a parameter", self.span,
                     help="names are texts; leave out other data with ignore=[...]")  # fmt: skip
        try:
            part: Component = cls(
                **parameters, **more, description=str(data.get("description") or "")
            )
        except TypeError as error:
            fail("N160", f"{what}: {error}", self.span, help="give each parameter once")
        except AcausalError as error:
            raise _at(error, f"at {what}; data that are no parameters are left out with "
                      "ignore=[...]") from None  # fmt: skip
        return part

    def _add(self, part: Component, data: Mapping[str, Any], where: str, what: str) -> None:
        name = data.get("name") or self._name(part._kind, where)
        try:
            self.model.add(name, part)
        except AcausalError as error:
            raise _at(error, f"at {what}") from None

    def _join(self, node: Hashable, part: Component, cut: Any, what: str) -> None:
        member = part._kind.member(cut) if isinstance(cut, str) else None
        if member is None or not member.kind.is_connector:
            known = cuts_of(part._kind)
            close = nearest(str(cut), known)
            fail("N161", f"{part._kind.title} at {what} has no cut {cut}", self.span,
                 notes=[f"did you mean {close[0]}?"] if close else [],
                 help=f"it has {', '.join(known)}" if known else "it has none")  # fmt: skip
        self.cuts[node].append(getattr(part, cut))


def component_class(given: Any, span: Span, what: str) -> Any:
    """Return a component class that is given as such or by its name.

    Args:
        given: The class, or a name such as ``"electrical.Resistor"``.
        span: The place, for messages.
        what: The edge or node, for messages.

    Raises:
        AcausalError: ``N150`` for a name that does not exist, ``N160`` for something else.
    """
    if isinstance(given, ComponentType) and issubclass(given, Component):
        return given
    if not isinstance(given, str):
        made = "a component that is made already" if isinstance(given, Component) else repr(given)
        fail("N160", f"{what} has {made} instead of a class", span,
             help='give the class or its name, component="electrical.Resistor", and the '
             "parameters as further data")  # fmt: skip
    found = _by_name.get(given)
    if found is None:
        found = _by_name[given] = _library_class(given, span, what)
    return found


_by_name: dict[str, Any] = {}


def _library_class(name: str, span: Span, what: str) -> Any:
    from acausal.compose.assembly import shared_library

    home, _, last = name.rpartition(".")
    where: Any = shared_library()
    done = ""
    for part in name.split("."):
        names = list(where.names()) if hasattr(where, "names") else []
        if part not in names:
            _no_class(name, done, part, names, span, what)
        done += f"{part}."
        where = where.find(part)
    found = getattr(package(home), last)
    if not (isinstance(found, ComponentType) and issubclass(found, Component)):
        fail("N160", f"{name} at {what} is no component class", span,
             help="name a model or block of the library")  # fmt: skip
    return found


def _no_class(name: str, done: str, part: str, names: list[str], span: Span, what: str) -> NoReturn:
    close = nearest(part, names)
    suggested = [done + c + name[len(done + part) :] for c in close]
    fail(
        "N150",
        f"the library has no {name or 'class without a name'}",
        span,
        label=f"at {what}",
        notes=[f"did you mean {' or '.join(suggested)}?"] if close else [],
        help=f"write {suggested[0]}, if that is what you mean"
        if close
        else "names have their package, as in electrical.Resistor; acausal list shows all",
    )


def _at(error: AcausalError, where: str) -> AcausalError:
    """Return an error that tells the edge or node."""
    return type(error)([replace(d, notes=(*d.notes, where)) for d in error.diagnostics])

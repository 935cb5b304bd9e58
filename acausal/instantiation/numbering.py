"""Groups: every class template with all its instances, numbered by array arithmetic.

A component of shape ``s`` in a class with ``K`` instances takes ``K * prod(s)`` consecutive numbers
in the group of its own class, so that instance ``k``'s component ``j`` has number
``first + k * prod(s) + j``. Nothing here grows with the number of instances.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from acausal.expressions.build import number_of
from acausal.expressions.nodes import Expr
from acausal.expressions.traverse import slots
from acausal.instantiation.domain import checked, over
from acausal.instantiation.template import BindingDecl, Domain, Ref, Step, Template, VariableDecl

Ids = NDArray[np.int64]


@dataclass(frozen=True)
class Block:
    """Where a component of one class stands in the group of its own class.

    Attributes:
        owner: Number of the class template it is declared in.
        name: Name of the component.
        first: Number of the first instance.
        size: Instances in one instance of the owner.
        shape: Array dimensions.
    """

    owner: int
    name: str
    first: int
    size: int
    shape: tuple[int, ...]


@dataclass
class Group:
    """A class template and its instances."""

    template: Template
    count: int = 0
    blocks: list[Block] = field(default_factory=list)

    @cached_property
    def firsts(self) -> list[int]:
        """First instance numbers of the blocks, ascending."""
        return [b.first for b in self.blocks]


@dataclass(frozen=True)
class VariableBlock:
    """Consecutive ids of one declared variable (or parameter) of a group.

    Attributes:
        group: Number of the group.
        declaration: The declaration.
        order: Order of the time derivative.
        first: First id.
        count: Number of ids.
    """

    group: int
    declaration: VariableDecl
    order: int
    first: int
    count: int


class Numbering:
    """Ids of all instances, variables and parameters of a model.

    Attributes:
        groups: Groups by template number; the last one is the model itself.
        variables: Blocks of variable ids, ascending; derivatives after all others.
        parameters: Blocks of parameter ids, ascending.
        n_declared: Number of scalar variables that are not derivatives.
        n_variables, n_parameters: Numbers of scalars.
    """

    def __init__(self, templates: list[Template]) -> None:
        self.groups = [Group(t) for t in templates]
        self._child_first: dict[tuple[int, str], int] = {}
        self._outer: dict[tuple[int, str], Ids] = {}
        #: Bindings by parameter or not, attribute, and weakness, outermost first; made when asked.
        self.bindings: dict[tuple[bool, str, bool], list[tuple[Template, BindingDecl]]] = {}
        self.groups[-1].count = 1
        for group in reversed(self.groups):
            self._place_children(group)
        self.variables: list[VariableBlock] = []
        self.parameters: list[VariableBlock] = []
        self._variable_first: dict[tuple[int, str, int], int] = {}
        self._parameter_first: dict[tuple[int, str], int] = {}
        self.n_variables = 0
        self.n_parameters = 0
        self._number_scalars()
        self.n_declared = self.n_variables
        self._number_derivatives()

    def __getstate__(self) -> dict[str, object]:
        """Return what paths are made of; bindings have done their work when a model is stored."""
        return {**self.__dict__, "bindings": {}}

    def _place_children(self, group: Group) -> None:
        if not group.count:
            return
        number = group.template.number
        for child in group.template.children.values():
            if not child.size:
                continue
            inside = self.groups[child.template.number]
            inside.blocks.append(Block(number, child.name, inside.count, child.size, child.shape))
            self._child_first[number, child.name] = inside.count
            inside.count += group.count * child.size

    def _number_scalars(self) -> None:
        for group in reversed(self.groups):
            number = group.template.number
            for name, declaration in group.template.variables.items():
                count = group.count * declaration.size
                self._variable_first[number, name, 0] = self.n_variables
                self.variables.append(
                    VariableBlock(number, declaration, 0, self.n_variables, count)
                )
                self.n_variables += count
            for name, declaration in group.template.parameters.items():
                count = group.count * declaration.size
                self._parameter_first[number, name] = self.n_parameters
                self.parameters.append(
                    VariableBlock(number, declaration, 0, self.n_parameters, count)
                )
                self.n_parameters += count

    def _number_derivatives(self) -> None:
        orders: dict[tuple[int, str], int] = {}
        for group in self.groups:
            template = group.template
            for expr in _expressions(template):
                for ref in slots(expr):
                    if isinstance(ref, Ref) and ref.order:
                        where = self.owner(template, ref)
                        orders[where.number, ref.name] = max(
                            ref.order, orders.get((where.number, ref.name), 0)
                        )
        for block in list(self.variables):
            highest = orders.get((block.group, block.declaration.name), 0)
            for order in range(1, highest + 1):
                key = (block.group, block.declaration.name, order)
                self._variable_first[key] = self.n_variables
                self.variables.append(
                    VariableBlock(
                        block.group, block.declaration, order, self.n_variables, block.count
                    )
                )
                self.n_variables += block.count

    def derivative(self) -> Ids:
        """Return the id of each variable's derivative, or -1, shape ``(n_variables,)``."""
        result = np.full(self.n_variables, -1, np.int64)
        for block in self.variables:
            key = (block.group, block.declaration.name, block.order + 1)
            first = self._variable_first.get(key)
            if first is not None:
                result[block.first : block.first + block.count] = np.arange(
                    first, first + block.count
                )
        return result

    def first_of(self, owner: Template, name: str) -> int:
        """Return the number of the first instance of a component, in the group of its class."""
        return self._child_first.get((owner.number, name), 0)

    def first_parameter(self, template: Template, name: str) -> int:
        """Return the id of a parameter of the first instance of a class."""
        return self._parameter_first[template.number, name]

    # --- from references to ids ----------------------------------------------------------

    def owner(self, template: Template, ref: Ref) -> Template:
        """Return the template that declares what a reference in ``template`` leads to."""
        if ref.outer:
            template = _outer(template, ref.outer)
        for step in ref.path:
            template = template.children[step.name].template
        return template

    def instances(
        self, template: Template, path: tuple[Step, ...], outer: str, domain: Domain
    ) -> tuple[Template, Ids]:
        """Return the instances at the end of a path, for all instances and passes.

        Returns:
            The template there and instance numbers, broadcastable to
            ``(count of template, domain.length)``.

        Raises:
            IndexError: If a subscript is out of range.
        """
        number = template.number
        if self.groups[number].count == 1 and not domain.names and not outer:
            # Elements of arrays that are connected one by one: plain numbers are faster.
            single = 0
            for step in path:
                child = template.children[step.name]
                first = self._child_first.get((template.number, step.name), 0)
                single = first + single * child.size + _place(step.index, child.shape)
                template = child.template
            return template, np.full((1, 1), single, np.int64)
        here: Ids = np.arange(self.groups[number].count)[:, None]
        if outer:
            here = self.outer_instances(number, outer)[:, None]
            template = _outer(template, outer)
        for step in path:
            child = template.children[step.name]
            first = self._child_first.get((template.number, step.name), 0)
            here = first + here * child.size + linear(step.index, child.shape, domain)
            template = child.template
        return template, here

    def single_instance(
        self, template: Template, path: tuple[Step, ...]
    ) -> tuple[Template, int] | None:
        """Return the only instance at the end of a path from the only instance of a class.

        None if there is an array on the way, or more instances of the class.
        """
        if self.groups[template.number].count != 1:
            return None
        here = 0
        for step in path:
            child = template.children[step.name]
            if child.shape:
                return None
            here += self._child_first.get((template.number, step.name), 0)
            template = child.template
        return template, here

    def single_id(self, template: Template, ref: Ref, domain: Domain) -> int | None:
        """Return the id of a scalar of the only instance of a class, found without arrays.

        None for anything else: arrays, loops, ``outer`` references, classes with more instances.
        """
        if domain.names or ref.outer or ref.index:
            return None
        found = self.single_instance(template, ref.path)
        if found is None:
            return None
        template, here = found
        if ref.parameter:
            declaration = template.parameters[ref.name]
            first = self._parameter_first[template.number, ref.name]
        else:
            declaration = template.variables[ref.name]
            first = self._variable_first[template.number, ref.name, ref.order]
        return None if declaration.shape else first + here

    def ids(self, template: Template, ref: Ref, domain: Domain) -> Ids:
        """Return the ids of a reference, instance by instance, pass by pass.

        Returns:
            Variable or parameter ids, shape ``(count * domain.length,)``.

        Raises:
            IndexError: If a subscript is out of range.
        """
        count = self.groups[template.number].count
        owner, here = self.instances(template, ref.path, ref.outer, domain)
        table = owner.parameters if ref.parameter else owner.variables
        declaration = table[ref.name]
        first = (
            self._parameter_first[owner.number, ref.name]
            if ref.parameter
            else self._variable_first[owner.number, ref.name, ref.order]
        )
        result = first + here * declaration.size + linear(ref.index, declaration.shape, domain)
        return np.broadcast_to(result, (count, domain.length)).reshape(-1)

    def outer_instances(self, number: int, name: str) -> Ids:
        """Return the instance that each instance of a group sees as an ``outer`` one.

        It is that of the ``inner`` component, or of the class that declares an ``inner`` variable.
        """
        known = self._outer.get((number, name))
        if known is not None:
            return known
        group = self.groups[number]
        result = np.zeros(group.count, np.int64)
        for block in group.blocks:
            owner = self.groups[block.owner]
            child = owner.template.children.get(name)
            if child is not None and child.inner and name != block.name:
                seen = self._child_first[block.owner, name] + np.arange(owner.count)
            elif name in owner.template.inner_values:
                seen = np.arange(owner.count)
            else:
                seen = self.outer_instances(block.owner, name)
            total = owner.count * block.size
            result[block.first : block.first + total] = np.repeat(seen, block.size)
        self._outer[number, name] = result
        return result

    # --- and back to paths -----------------------------------------------------------------

    def path(self, number: int, instance: int) -> str:
        """Return the path of an instance, empty for the model itself."""
        parts: list[str] = []
        while number != len(self.groups) - 1:
            group = self.groups[number]
            block = group.blocks[bisect_right(group.firsts, instance) - 1]
            instance, place = divmod(instance - block.first, block.size)
            parts.append(block.name + subscript_text(place, block.shape))
            number = block.owner
        return ".".join(reversed(parts))


def _outer(template: Template, name: str) -> Template:
    found = template.outers.get(name)
    return template.outer_values[name] if found is None else found


def subscript_text(place: int, shape: tuple[int, ...]) -> str:
    """Return ``[i,j]`` for a row-major place, empty for a scalar."""
    if not shape:
        return ""
    return "[" + ",".join(str(int(i) + 1) for i in np.unravel_index(place, shape)) + "]"


def _place(index: tuple[Expr, ...], shape: tuple[int, ...]) -> int:
    """Return the row-major place of constant subscripts.

    Raises:
        IndexError: If a subscript is out of range.
    """
    place = 0
    for expr, n in zip(index, shape, strict=True):
        place = place * n + int(checked(np.array([number_of(expr)]), n)[0])
    return place


def linear(index: tuple[Expr, ...], shape: tuple[int, ...], domain: Domain) -> Ids:
    """Return row-major places of subscripts for all passes, shape ``(1, length)`` or ``(1, 1)``.

    Raises:
        IndexError: If a subscript is out of range.
    """
    place = np.zeros((1, 1), np.int64)
    for expr, n in zip(index, shape, strict=True):
        if expr.op == "const":
            own = checked(np.array([number_of(expr)]), n)
        else:
            own = checked(over(domain, expr), n)
        place = place * n + own[None, :]
    return place


def _expressions(template: Template) -> list[Expr]:
    return [
        *(e.residual for e in template.equations),
        *(e.residual for e in template.initial_equations),
        *(a.condition for a in template.asserts),
        *(b.value for b in template.bindings),
        *(d.value for d in (*template.discrete, *template.initial_discrete)),
        *(operand for s in template.signals for operand in s.operands),
        *(part for r in template.reinits for part in (r.state, r.value, r.fires)),
        *(t.fires for t in template.terminates),
    ]

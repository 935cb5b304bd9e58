"""Paths of scalars, made from the numbering when asked for."""

from __future__ import annotations

import itertools
import re
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from typing import TypeVar

from acausal.diagnostics import Span
from acausal.diagnostics.suggest import nearest
from acausal.instantiation.numbering import Numbering, VariableBlock, subscript_text
from acausal.instantiation.template import Template, VariableDecl

_PART = re.compile(r"([^.\[\]]+)(?:\[([^\]]*)\])?(?:\.|$)")


class NumberingNames:
    """Implements :class:`acausal.flattening.model.Names` on a numbering."""

    def __init__(self, numbering: Numbering) -> None:
        self._numbering = numbering
        self._variable_firsts = [b.first for b in numbering.variables]
        self._parameter_firsts = [b.first for b in numbering.parameters]
        self._variable_blocks = {
            (b.group, b.declaration.name, b.order): b for b in numbering.variables
        }
        self._parameter_blocks = {(b.group, b.declaration.name): b for b in numbering.parameters}

    def _block(self, variable: int) -> VariableBlock:
        blocks = self._numbering.variables
        # Empty blocks share their first id with the next one: the last of equals is meant.
        return blocks[bisect_right(self._variable_firsts, variable) - 1]

    def _parameter_block(self, parameter: int) -> VariableBlock:
        blocks = self._numbering.parameters
        return blocks[bisect_right(self._parameter_firsts, parameter) - 1]

    def _path(self, block: VariableBlock, scalar: int) -> str:
        instance, place = divmod(scalar - block.first, block.declaration.size)
        owner = self._numbering.path(block.group, instance)
        name = block.declaration.name + subscript_text(place, block.declaration.shape)
        return f"{owner}.{name}" if owner and name else owner or name

    def variable(self, variable: int) -> str:
        """Return the path of a scalar variable."""
        block = self._block(variable)
        return "der(" * block.order + self._path(block, variable) + ")" * block.order

    def parameter(self, parameter: int) -> str:
        """Return the path of a scalar parameter; literals of loops have none."""
        if parameter >= self._numbering.n_parameters:
            return f"(number {parameter - self._numbering.n_parameters} of a loop)"
        return self._path(self._parameter_block(parameter), parameter)

    def unit(self, variable: int) -> str:
        """Return the unit text of a variable, derivatives included."""
        block = self._block(variable)
        unit = block.declaration.unit
        if not block.order:
            return unit
        from acausal.units.dimension import divide, format_dimension
        from acausal.units.unit import parse_unit

        if not unit:
            return ""
        dimension = parse_unit(unit).dimension
        second = parse_unit("s").dimension
        for _ in range(block.order):
            dimension = divide(dimension, second)
        return format_dimension(dimension)

    def parameter_unit(self, parameter: int) -> str:
        """Return the unit text of a parameter."""
        return self._parameter_block(parameter).declaration.unit

    def description(self, variable: int) -> str:
        """Return the description string of a variable."""
        return self._block(variable).declaration.description

    def declaration(self, variable: int) -> Span | None:
        """Return the place to mend: where the model declares the variable's component.

        A variable of the model itself is declared there; one of a component leads to the
        component's declaration in the model, not into the library.
        """
        block = self._block(variable)
        root = self._numbering.groups[-1].template
        instance = (variable - block.first) // max(block.declaration.size, 1)
        path = self._numbering.path(block.group, instance)
        child = root.children.get(path.split(".")[0].split("[")[0])
        return block.declaration.span if child is None else child.span

    def parameter_declaration(self, parameter: int) -> Span | None:
        """Return where the parameter is declared."""
        return self._parameter_block(parameter).declaration.span

    def instance_path(self, group: int, instance: int) -> str:
        """Return the path of an instance, empty for the model itself."""
        return self._numbering.path(group, instance)

    def all_variables(self) -> Sequence[str]:
        """Return the paths of all declared variables in id order."""
        return [
            self._path(block, scalar)
            for block in self._numbering.variables
            if not block.order
            for scalar in range(block.first, block.first + block.count)
        ]

    def find_variables(self, pattern: str) -> list[tuple[str, int]]:
        """Return (path, id) of the variables that match.

        A pattern is a path. ``*`` and ``?`` match within one name, ``[*]`` or a missing subscript
        all elements of an array; a last name ``*`` matches everything below. ``der(...)``
        around a pattern asks for derivatives.
        """
        order = 0
        while pattern.startswith("der(") and pattern.endswith(")"):
            pattern, order = pattern[4:-1], order + 1
        found = []
        for path, group, declaration, scalar, parameter in self._match(pattern):
            if parameter:
                continue
            block = self._variable_blocks.get((group, declaration.name, order))
            if block is not None:
                found.append(("der(" * order + path + ")" * order, block.first + scalar))
        return found

    def find_parameters(self, pattern: str) -> list[tuple[str, int]]:
        """Return (path, id) of the parameters that match, see :meth:`find_variables`."""
        return [
            (path, self._parameter_blocks[group, declaration.name].first + scalar)
            for path, group, declaration, scalar, parameter in self._match(pattern)
            if parameter
        ]

    def _match(self, pattern: str) -> Iterator[tuple[str, int, VariableDecl, int, bool]]:
        parts: list[tuple[str, str | None]] = []
        position = 0
        while position < len(pattern):
            match = _PART.match(pattern, position)
            if match is None:
                return
            parts.append((match[1], match[2]))
            position = match.end()
        if parts:
            root = self._numbering.groups[-1].template
            yield from self._walk(root, 0, "", parts)

    def _walk(
        self, template: Template, instance: int, prefix: str, parts: list[tuple[str, str | None]]
    ) -> Iterator[tuple[str, int, VariableDecl, int, bool]]:
        (name, subscript), rest = parts[0], parts[1:]
        everything = name == "*" and subscript is None and not rest
        if template.primitive_connector:
            return
        for table, parameter in ((template.variables, False), (template.parameters, True)):
            if rest:
                continue
            for declaration in _matching(table, name):
                for place in _places(declaration.shape, subscript):
                    path = prefix + declaration.name + subscript_text(place, declaration.shape)
                    scalar = instance * declaration.size + place
                    yield path, template.number, declaration, scalar, parameter
        for child in _matching(template.children, name):
            inside = child.template
            first = self._numbering.first_of(template, child.name)
            for place in _places(child.shape, subscript):
                below = first + instance * child.size + place
                path = prefix + child.name + subscript_text(place, child.shape)
                if inside.primitive_connector:
                    if not rest:
                        own = inside.variables[""]
                        yield path, inside.number, own, below, False
                elif rest or everything:
                    yield from self._walk(inside, below, path + ".", rest or [("*", None)])

    def suggestions(self, path: str) -> list[str]:
        """Return the nearest paths to a misspelt one, best first."""
        parts = path.split(".")
        for k in range(len(parts), 0, -1):
            known = ".".join(parts[: k - 1])
            template = self._template_at(known)
            if template is None:
                continue
            names = [*template.variables, *template.parameters, *template.children]
            head = known + "." if known else ""
            wanted = parts[k - 1].split("[")[0]
            return [
                head + ".".join([n, *parts[k:]]) for n in nearest(wanted, [n for n in names if n])
            ]
        return []

    def _template_at(self, path: str) -> Template | None:
        template = self._numbering.groups[-1].template
        for part in filter(None, path.split(".")):
            child = template.children.get(part.split("[")[0])
            if child is None:
                return None
            template = child.template
        return template


_Member = TypeVar("_Member")


def _matching(table: Mapping[str, _Member], name: str) -> list[_Member]:
    if "*" in name or "?" in name:
        return [v for k, v in table.items() if fnmatchcase(k, name)]
    return [table[name]] if name in table else []


def _places(shape: tuple[int, ...], subscript: str | None) -> Iterator[int]:
    if not shape:
        if subscript is None:
            yield 0
        return
    chosen: list[Sequence[int]] = []
    given = subscript.split(",") if subscript is not None else []
    for n, text in itertools.zip_longest(shape, given[: len(shape)]):
        text = (text or "*").strip()
        if text in ("*", ":"):
            chosen.append(range(n))
        elif ":" in text:
            low, high = (int(x) if x.strip().isdigit() else 0 for x in text.split(":", 1))
            chosen.append(range(max(low, 1) - 1, min(high or n, n)))
        elif text.isdigit() and 1 <= int(text) <= n:
            chosen.append((int(text) - 1,))
        else:
            return
    for combination in itertools.product(*chosen):
        place = 0
        for i, n in zip(combination, shape, strict=True):
            place = place * n + i
        yield place

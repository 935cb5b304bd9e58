"""Order of a kernel's instructions, and which of them only run inside a branch.

A ``select`` computes both sides, which is cheapest as long as they are arithmetic. Where a side
calls the mathematical library, what only that side needs moves into a real branch. Selects by the
same condition that do not depend on one another share one branch, so the derivatives of a
conditional expression are computed beside its value.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from acausal.codegen.ir import Instruction


@dataclass
class _Group:
    """Selects that become one branch, and the regions (see ``_Regions``) around and inside it."""

    condition: int
    members: list[int]
    outer: int
    inner: tuple[int, int]


@dataclass
class _Regions:
    """Where each instruction lives: region 0 is the loop body, others the sides of branches."""

    of: list[int]
    groups: list[_Group] = field(default_factory=list)
    group_of_select: dict[int, int] = field(default_factory=dict)
    group_of_region: dict[int, int] = field(default_factory=dict)


def schedule(
    instructions: Sequence[Instruction], roots: Sequence[int]
) -> tuple[list[Instruction], list[Instruction]]:
    """Return prologue and body of the kernel that accumulates ``roots``.

    Args:
        instructions: Pure instructions, each after its arguments; ``result`` is its position.
        roots: The value of each output.
    """
    live = _live(instructions, roots)
    invariant = [False] * len(instructions)
    for item in instructions:
        invariant[item.result] = item.op != "load" and all(invariant[a] for a in item.args)
    prologue = [item for item in instructions if live[item.result] and invariant[item.result]]
    varying = [i.result for i in instructions if live[i.result] and not invariant[i.result]]
    regions = _regions(instructions, varying, set(roots))
    outputs: dict[int, list[int]] = {}
    for output, root in enumerate(roots):
        outputs.setdefault(root, []).append(output)
    body = [
        Instruction("accumulate", -1, (root,), output)
        for root, ports in outputs.items()
        if invariant[root]
        for output in ports
    ]
    for item in _ordered(instructions, varying, regions):
        body.append(item)
        if item.result in outputs:
            body += [
                Instruction("accumulate", -1, (item.result,), output)
                for output in outputs[item.result]
            ]
    return prologue, _merges_first(body)


def _live(instructions: Sequence[Instruction], roots: Iterable[int]) -> list[bool]:
    live = [False] * len(instructions)
    for root in roots:
        live[root] = True
    for item in reversed(instructions):
        if live[item.result]:
            for argument in item.args:
                live[argument] = True
    return live


def _merges_first(body: list[Instruction]) -> list[Instruction]:
    """Put the merges of a branch right after its end, before outputs that use them."""
    result: list[Instruction] = []
    waiting: list[Instruction] = []
    merging = False
    for item in body:
        if item.op == "end":
            merging = True
        elif merging and item.op == "accumulate":
            waiting.append(item)
            continue
        elif item.op != "merge":
            merging = False
            result += waiting
            waiting = []
        result.append(item)
    return result + waiting


def _regions(
    instructions: Sequence[Instruction], varying: Sequence[int], roots: set[int]
) -> _Regions:
    """Find the branches, outermost first, and assign each instruction to the innermost one."""
    regions = _Regions(of=[0] * len(instructions))
    costly = [False] * len(instructions)
    level = [0] * len(instructions)  # number of candidate selects on the longest path below
    candidates: dict[int, list[int]] = {}
    for number in varying:
        item = instructions[number]
        costly[number] = item.op == "math" or any(costly[a] for a in item.args)
        level[number] = max((level[a] for a in item.args), default=0)
        if item.op == "select" and (costly[item.args[1]] or costly[item.args[2]]):
            level[number] += 1
            candidates.setdefault(level[number], []).append(number)
    if not candidates:
        return regions
    users: list[list[int]] = [[] for _ in instructions]
    for number in varying:
        for argument in instructions[number].args:
            users[argument].append(number)
    is_varying = [False] * len(instructions)
    for number in varying:
        is_varying[number] = True
    region_count = 1
    for _, selects in sorted(candidates.items(), reverse=True):
        together: dict[tuple[int, int], list[int]] = {}
        for number in selects:
            together.setdefault((instructions[number].args[0], regions.of[number]), []).append(
                number
            )
        for (condition, outer), members in together.items():
            sides = [
                _exclusive(instructions, users, is_varying, roots, members, side) for side in (1, 2)
            ]
            if not any(instructions[n].op == "math" for side in sides for n in side):
                continue
            inner = (region_count, region_count + 1)
            for region, side in zip(inner, sides, strict=True):
                regions.group_of_region[region] = len(regions.groups)
                for number in side:
                    regions.of[number] = region
            for number in members:
                regions.group_of_select[number] = len(regions.groups)
            regions.groups.append(_Group(condition, members, outer, inner))
            region_count += 2
    return regions


def _exclusive(
    instructions: Sequence[Instruction],
    users: Sequence[Sequence[int]],
    is_varying: Sequence[bool],
    roots: set[int],
    members: Sequence[int],
    side: int,
) -> set[int]:
    """Return the instructions that nothing but this side of the selects needs."""
    ours = set(members)
    reached: set[int] = set()
    stack = [instructions[number].args[side] for number in members]
    while stack:
        number = stack.pop()
        if is_varying[number] and number not in reached:
            reached.add(number)
            stack.extend(instructions[number].args)
    exclusive: set[int] = set()
    for number in sorted(reached, reverse=True):  # users come later than what they use
        if number in roots:
            continue
        for user in users[number]:
            if user in exclusive:
                continue
            args = instructions[user].args
            if user not in ours or args[side] != number or args.count(number) > 1:
                break
        else:
            exclusive.add(number)
    return exclusive


def _ordered(
    instructions: Sequence[Instruction], varying: Sequence[int], regions: _Regions
) -> list[Instruction]:
    """Return the instructions in an order that respects dependences, with branch markers."""
    if not regions.groups:
        return [instructions[number] for number in varying]
    first_group = len(instructions)  # a branch as a whole is scheduled as one unit

    def unit(number: int) -> int:
        group = regions.group_of_select.get(number)
        return number if group is None else first_group + group

    needs: dict[int, list[int]] = {}
    members: dict[int, list[int]] = {}
    is_varying = set(varying)
    for number in varying:
        members.setdefault(regions.of[number], []).append(unit(number))
        own_group = regions.group_of_select.get(number)
        for argument in instructions[number].args:
            region = regions.of[argument]
            if argument not in is_varying:
                continue
            if region and regions.group_of_region[region] == own_group:
                continue  # the value of a side, needed only at the end of the branch
            user, at = unit(number), regions.of[number]
            while at != region:
                group = regions.group_of_region[at]
                user, at = first_group + group, regions.groups[group].outer
            if user != unit(argument):
                needs.setdefault(user, []).append(unit(argument))
    order = {region: _topological(units, needs) for region, units in members.items()}

    result: list[Instruction] = []
    stack: list[int | Instruction] = list(reversed(order.get(0, [])))
    while stack:
        item = stack.pop()
        if isinstance(item, Instruction):
            result.append(item)
        elif item < first_group:
            result.append(instructions[item])
        else:
            group_record = regions.groups[item - first_group]
            then, otherwise = group_record.inner
            sequence: list[int | Instruction] = [
                Instruction("if", -1, (group_record.condition,)),
                *order.get(then, []),
                Instruction("else", -1),
                *order.get(otherwise, []),
                Instruction("end", -1),
            ]
            sequence += [
                Instruction("merge", number, instructions[number].args)
                for number in group_record.members
            ]
            stack.extend(reversed(sequence))
    return result


def _topological(units: Sequence[int], needs: dict[int, list[int]]) -> list[int]:
    """Return ``units`` once each, after what they need, else in the order given."""
    order: list[int] = []
    done: set[int] = set()
    for start in units:
        stack = [(start, False)]
        while stack:
            item, expanded = stack.pop()
            if item in done:
                continue
            if expanded:
                done.add(item)
                order.append(item)
                continue
            stack.append((item, True))
            stack.extend((n, False) for n in reversed(needs.get(item, ())) if n not in done)
    return order

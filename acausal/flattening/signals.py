"""Ids of signals: a class's declarations, times instances, times passes of the loops."""

from __future__ import annotations

import numpy as np

from acausal.flattening.model import Ids
from acausal.instantiation.numbering import Numbering
from acausal.instantiation.template import INITIAL, TERMINAL, Domain, Signal, Template

#: Ids of the two signals that every model has.
INITIAL_ID, TERMINAL_ID = 0, 1


class SignalNumbering:
    """Consecutive ids by declaration, then instance, then pass.

    Attributes:
        count: Number of signals, those of the first and the last instant included.
    """

    def __init__(self, numbering: Numbering) -> None:
        self._numbering = numbering
        self._first: dict[tuple[int, int], int] = {}
        self.count = 2
        for group in reversed(numbering.groups):
            for k, declaration in enumerate(group.template.signals):
                self._first[group.template.number, k] = self.count
                self.count += group.count * declaration.domain.length

    def all(self, template: Template, number: int) -> Ids:
        """Return the ids of all elements of a declaration, instance by instance."""
        count = self._numbering.groups[template.number].count
        size = count * template.signals[number].domain.length
        return self._first[template.number, number] + np.arange(size)

    def ids(self, template: Template, signal: Signal, domain: Domain) -> Ids:
        """Return the ids that a use inside ``domain`` means, instance by instance, pass by pass."""
        count = self._numbering.groups[template.number].count
        if signal.number in (INITIAL, TERMINAL):
            one = INITIAL_ID if signal.number == INITIAL else TERMINAL_ID
            return np.full(count * domain.length, one)
        declared = template.signals[signal.number].domain
        first = self._first[template.number, signal.number]
        here = np.arange(count)[:, None] * declared.length + _passes(declared, domain)[None, :]
        return (first + here).reshape(-1)


def _passes(declared: Domain, used: Domain) -> Ids:
    """Return the pass of the declaration's loops for every pass of a use.

    The loops of a use are those of the declaration and perhaps more; passes meet where the loop
    indices that both know have the same values.
    """
    if not declared.names:
        return np.zeros(used.length, np.int64)
    if declared is used:
        return np.arange(used.length)
    missing = [name for name in declared.names if name not in used.names]
    assert not missing, f"a signal of the loops {declared.names} is used without {missing}"
    there = used.values[[used.names.index(name) for name in declared.names]]
    if there.shape == declared.values.shape and np.array_equal(there, declared.values):
        return np.arange(used.length)
    both = np.concatenate([declared.values, there], axis=1)
    _, code = np.unique(both, axis=1, return_inverse=True)
    code = np.asarray(code).reshape(-1)
    own, wanted = code[: declared.length], code[declared.length :]
    order = np.argsort(own, kind="stable")
    found = order[np.minimum(np.searchsorted(own[order], wanted), declared.length - 1)]
    assert np.array_equal(own[found], wanted), "a signal has no element for a pass of its use"
    return found

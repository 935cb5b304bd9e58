"""Chains: copies of a component, each joined to the one before."""

from __future__ import annotations

from typing import Any

from acausal.compose.component import Component
from acausal.compose.model import Model
from acausal.compose.places import here
from acausal.diagnostics import fail
from acausal.netlists.cut_pairs import cut_pair, cuts_of, single_cut


def chain(
    links: Component,
    *,
    start: Component | None = None,
    end: Component | None = None,
    cuts: tuple[str, str] | None = None,
    name: str = "chain",
) -> Model:
    """Make a model of an array of components, the end of each joined to the beginning of the next.

    Args:
        links: The array, made with ``shape=n``; the part ``link`` of the model.
        start: What the first one begins at; the part ``start``.
        end: What the last one ends at; the part ``end_``.
        cuts: Beginning and end of a link; by default ``p`` and ``n``, ``flange_a`` and
            ``flange_b``, ``pivot`` and ``tip``, ... or the only two cuts.
        name: Name of the model.

    Returns:
        A model that can be changed: add what the links need besides.

    Raises:
        AcausalError: ``N160`` for links that are no array of one dimension, ``N161`` if their cuts
            are not known, ``C101`` for unlike cuts.

    Example:
        >>> import acausal as ac
        >>> from acausal.library.mechanical import planar as pl
        >>> pendulums = ac.chain(pl.Pendulum(shape=10), start=pl.Anchor())
        >>> pendulums.world = pl.PlanarWorld()
        >>> pendulums.compile().name
        'chain'
    """
    span = here()
    shape = getattr(links, "_shape", None)
    if not isinstance(links, Component) or not isinstance(shape, tuple) or len(shape) != 1:
        fail("N160", "the links of a chain are no array of components", span,
             help="make them with shape=, for example Pendulum(length=1, shape=10)")  # fmt: skip
    kind: Any = links._kind
    pair = cuts or cut_pair(kind)
    if pair is None:
        fail("N161", f"which cuts of {kind.title} are joined in a chain?", span,
             label=f"it has {', '.join(cuts_of(kind)) or 'no cuts'}",
             help="give cuts=(beginning, end)")  # fmt: skip
    first, last = pair
    model = Model(name)
    array: Any = model.add("link", links)
    if not isinstance(shape[0], int) or shape[0] > 1:
        model.connect(getattr(array[:-1], last), getattr(array[1:], first))
    if start is not None:
        model.add("start", start)
        model.connect(_only_cut(start), getattr(array[0], first))
    if end is not None:
        model.add("end_", end)
        model.connect(getattr(array[-1], last), _only_cut(end))
    return model


def _only_cut(part: Component) -> Any:
    """Return the cut by which something is put at the beginning or end of a chain."""
    cut = single_cut(part._kind)
    if cut is None:
        fail("N161", f"which cut of {part._kind.title} is joined to the chain?", here(),
             label=f"it has {', '.join(cuts_of(part._kind)) or 'no cuts'}",
             help="make the chain without it, and connect it yourself")  # fmt: skip
    return getattr(part, cut)

"""What notebooks show of a compiled model: counts, states, parameters, equations as formulas."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING

from acausal.inspection.equations import EquationForms
from acausal.inspection.inspect import Compilation, states_of
from acausal.inspection.operands import Names
from acausal.inspection.summary import summary
from acausal.results.display import table_html
from acausal.results.plot import pretty_unit

if TYPE_CHECKING:
    from acausal.flattening.flatten import Flattened

_STYLE = "padding:.25em .1em;overflow-x:auto;overflow-y:hidden"
#: Rows of a table, and equations, that are shown.
SHOWN = 40


@dataclass(frozen=True)
class Equations:
    r"""The equations of a model, shown as formulas in notebooks.

    Attributes:
        lines: LaTeX of each form of equation, index ranges behind it; ``&`` before the sign.
        more: How many forms are not among them.
        mathml: Turns LaTeX into MathML.

    Example:
        >>> print(compiled.equations.latex)
    """

    lines: tuple[str, ...]
    more: int
    mathml: Callable[[str], str]

    @property
    def latex(self) -> str:
        r"""An ``aligned`` environment, for use inside of ``\[ \]``."""
        body = " \\\\\n".join(f"  {line}" for line in self.lines)
        return f"\\begin{{aligned}}\n{body}\n\\end{{aligned}}"

    def __str__(self) -> str:
        return self.latex

    def __len__(self) -> int:
        return len(self.lines) + self.more

    def _repr_latex_(self) -> str:
        return f"$$\n{self.latex}\n$$"

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<div style='{_STYLE}'>{self.mathml(line.replace('&', ''))}</div>"
            for line in self.lines
        )
        more = f"<div><small>and {self.more} more</small></div>" if self.more else ""
        return f"<div>{rows}{more}</div>"


def equations_of(flattened: Flattened, mathml: Callable[[str], str]) -> Equations:
    """Return the equations as they were written and connected."""
    model = flattened.model
    forms = EquationForms(model.families, Names(flattened.numbering, model))
    shown = min(forms.count, SHOWN)
    lines = tuple(forms.form(number).latex() for number in range(shown))
    return Equations(lines, forms.count - shown, mathml)


def compiled_html(stages: Compilation) -> str:
    """Return a compiled model as HTML: counts, states, parameters."""
    flattened, system = stages.flattened, stages.system
    assert flattened is not None and system is not None
    counts = str(summary(stages)).splitlines()
    head = f"<b>{escape(system.name)}</b>"
    head += f" &ndash; {escape(system.description)}" if system.description else ""
    facts = "; ".join(line.strip() for line in counts[1:7])
    parts = [f"<div>{head}<br><small>{escape(facts)}</small></div>"]
    names = system.names
    states = states_of(system)
    declared = [] if states is None else states[states < len(system.representative)].tolist()
    rows = [
        [f"<code>{escape(names.variable(i))}</code>", escape(pretty_unit(names.unit(i))),
         escape(names.description(i))]
        for i in declared[:SHOWN]
    ]  # fmt: skip
    if rows:
        parts.append(_section("States", len(declared), ("state", "unit", "description"), rows))
    found = names.find_parameters("*")
    rows = [
        [f"<code>{escape(path)}</code>", f"{float(system.parameters[number]):g}",
         escape(pretty_unit(names.parameter_unit(number)))]
        for path, number in found[:SHOWN]
    ]  # fmt: skip
    if rows:
        parts.append(_section("Parameters", len(found), ("parameter", "value", "unit"), rows))
    return "".join(parts)


def _section(title: str, count: int, head: tuple[str, ...], rows: list[list[str]]) -> str:
    more = f"<small>and {count - len(rows)} more</small>" if count > len(rows) else ""
    opened = " open" if len(rows) <= 12 else ""
    return (
        f"<details{opened}><summary>{title} ({count})</summary>{table_html(head, rows)}{more}"
        "</details>"
    )

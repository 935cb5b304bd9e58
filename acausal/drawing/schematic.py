"""The schematic of a compiled model, to look at and to keep."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from acausal.diagnostics import fail
from acausal.drawing.diagram import diagram, parts_of
from acausal.drawing.layout import Layout, lay_out
from acausal.drawing.paint import paint

if TYPE_CHECKING:
    from acausal.instantiation.template import Template

SUFFIXES = (".svg", ".png")
#: Parts of the largest schematic.
MOST_PARTS = 300


@dataclass(frozen=True)
class Drawing:
    """A schematic.

    Attributes:
        title: What it shows.
        layout: Parts, wires and names with coordinates.
    """

    title: str
    layout: Layout

    @cached_property
    def svg(self) -> str:
        """The picture as SVG that needs nothing but itself; the same model gives the same text."""
        return paint(self.layout, self.title)

    def __repr__(self) -> str:
        return f"<Drawing of {self.title}>"

    def _repr_svg_(self) -> str:
        return self.svg

    def write(self, path: str | os.PathLike[str], scale: float = 2.0) -> None:
        """Write the picture as ``.svg`` or ``.png``.

        Args:
            path: The file; its suffix says the kind.
            scale: Pixels of a PNG for one of the SVG.

        Raises:
            AcausalError: ``F201`` unknown suffix, ``F202`` cannot write, ``F203`` disk full,
                ``F205`` if what draws PNG files is not installed.
        """
        from acausal.results.files import check_suffix, whole_file

        suffix = check_suffix(path, SUFFIXES)
        data = (self.svg + "\n").encode() if suffix == ".svg" else _png(self.svg, scale)
        with whole_file(path) as unfinished:
            Path(unfinished).write_bytes(data)


def schematic(template: Template, depth: int = 1, title: str = "") -> Drawing:
    """Return the schematic of a class.

    Args:
        template: The class as it was compiled.
        depth: Levels of components; at 1 every component is one symbol, above that components that
            are made of others are frames around what they are made of.
        title: What the picture is called; the name of the class if empty.

    Raises:
        AcausalError: ``F111`` for a depth below 1, ``F112`` for more than :data:`MOST_PARTS`.
    """
    if depth < 1:
        fail("F111", f"a schematic has no depth of {depth}", help="the least is 1")
    shown = diagram(template, depth)
    count = parts_of(shown)
    if count > MOST_PARTS:
        fail(
            "F112",
            f"a schematic of {count} parts is nothing that a person can read",
            notes=[f"at most {MOST_PARTS} parts are drawn; an array counts as one"],
            help="put components together in classes of their own, or in arrays",
        )
    return Drawing(title or template.name, lay_out(shown))


def _png(svg: str, scale: float) -> bytes:
    from acausal.results.files import needs

    with needs("resvg-py", "PNG files of schematics"):
        import resvg_py
    import matplotlib

    fonts = Path(matplotlib.get_data_path()) / "fonts" / "ttf"
    return bytes(
        resvg_py.svg_to_bytes(
            svg_string=svg,
            zoom=scale,
            background="#ffffff",
            font_dirs=[str(fonts)],
            font_family="DejaVu Sans",
            sans_serif_family="DejaVu Sans",
            skip_system_fonts=True,
        )
    )

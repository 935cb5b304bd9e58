"""The pages: HTML that needs nothing but itself."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import Final

from acausal.modeling.classes import ClassDef
from acausal.reference.catalogue import Package
from acausal.reference.entries import ClassEntry, Item, class_entry
from acausal.reference.equations import Line
from acausal.reference.fields import FIELDS, field_of
from acausal.reference.graphics import Graphic
from acausal.reference.mathml import mathml
from acausal.reference.svg import content, hatchings, view_box
from acausal.reference.symbols import DRAWN_KINDS, symbol

_HERE: Final = Path(__file__).parent
#: Groups of a page in order: title, and which classes belong there.
_GROUPS: Final = (
    "Components",
    "Partial classes",
    "Connectors",
    "Records",
    "Types and enumerations",
    "Functions",
)


@dataclass
class Site:
    """What all pages share.

    Attributes:
        packages: All packages of the library, also those whose pages are not made.
        examples: Class -> files of examples that use it.
        search: One line for every class: name, package, description.
    """

    packages: Sequence[Package]
    examples: Mapping[str, Sequence[str]]
    search: list[tuple[str, str, str]] = field(default_factory=list)
    heirs: dict[str, list[ClassDef]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for package in self.packages:
            for definition in package.classes:
                about = definition.tree.description
                self.search.append((definition.name, package.name, about))
                for base, _ in definition.bases:
                    if isinstance(base, ClassDef):
                        self.heirs.setdefault(base.full_name, []).append(definition)


def index_page(site: Site) -> str:
    """Return the page that lists all packages and finds all classes."""
    cards = []
    count = 0
    graphics: list[Graphic] = []
    for package in site.packages:
        shown = [c for c in package.classes if _group(c) == "Components"]
        count += len(package.classes)
        drawings = [symbol(c) for c in shown]
        drawings = [s for s in drawings if s.drawn][:: max(1, len(shown) // 5)][:5]
        icons = "".join(
            f'<svg class="icon" viewBox="{view_box(s)}">{content(s)}</svg>' for s in drawings
        )
        graphics += [g for s in drawings for g in s.graphics]
        what = _counts(package)
        cards.append(
            f'<a href="{package.name}.html"><b>{_breakable(package.name)}</b><span>{what}</span>'
            f"<p>{icons}</p></a>"
        )
    body = (
        f"{_hidden(hatchings(tuple(graphics)))}<main><h1>Component library</h1>"
        f'<p class="lead">{count} classes in {len(site.packages)} packages. Search above, by name '
        "or by any word of a description; the key / leads there.</p>"
        f'<div class="packages">{"".join(cards)}</div></main>'
    )
    return _document("Component library", body, site, "")


def package_page(package: Package, site: Site) -> str:
    """Return the page of one package.

    Raises:
        AcausalError: If a name in the package is not found.
    """
    groups: dict[str, list[ClassDef]] = {g: [] for g in _GROUPS}
    for definition in package.classes:
        groups[_group(definition)].append(definition)
    writer = _Writer(package, site)
    navigation: list[str] = []
    sections: list[str] = []
    for title, members in groups.items():
        if not members:
            continue
        links = "".join(f'<a href="#{_id(c)}">{escape(c.name)}</a>' for c in members)
        navigation.append(f"<b>{title}</b>{links}")
        sections.append(f"<h2>{title}</h2>")
        if title == "Components":
            sections.append(writer.tiles(members))
        if title == "Types and enumerations":
            sections.append(writer.types([c for c in members if c.tree.enumeration is None]))
            members = [c for c in members if c.tree.enumeration is not None]
        sections += [writer.section(c) for c in members]
    constants = writer.constants()
    overview = "".join(f'<p class="lead">{_inline(p)}</p>' for p in package.overview)
    inner = [p for p in site.packages if p.name.startswith(package.name + ".")]
    if inner:
        links = ", ".join(f'<a href="{p.name}.html">{p.name}</a>' for p in inner)
        overview += f'<p class="lead">Packages inside: {links}.</p>'
    body = (
        f'{writer.definitions()}<div class="page"><nav>{"".join(navigation)}</nav>'
        f"<main><h1>{package.name}</h1>{overview}"
        f"{constants}{''.join(sections)}</main></div>"
    )
    return _document(package.name, body, site, package.name)


def _group(definition: ClassDef) -> str:
    kind = definition.kind
    if kind in ("model", "block", "class"):
        return "Partial classes" if definition.tree.partial else "Components"
    return {"connector": "Connectors", "record": "Records", "function": "Functions"}.get(
        kind, "Types and enumerations"
    )


def _counts(package: Package) -> str:
    words = {
        "Components": "component",
        "Connectors": "connector",
        "Records": "record",
        "Types and enumerations": "type",
        "Functions": "function",
    }
    said = []
    for group, word in words.items():
        count = sum(_group(c) == group for c in package.classes)
        if count:
            said.append(f"{count} {word}{'s' * (count > 1)}")
    if package.constants is not None:
        said.append(f"{len(package.constants.tree.components)} constants")
    return ", ".join(said)


def _id(definition: ClassDef) -> str:
    return escape(definition.name.strip("'"))


def _inline(text: str) -> str:
    """Return a paragraph of Markdown as HTML: code, emphasis, links as their text."""
    text = escape(text, quote=False)
    text = re.sub(r"\[([^\]]+)\]\([^)]+\)", r"\1", text)
    text = re.sub(r"`([^`]+)`", r"<code>\1</code>", text)
    text = re.sub(r"\*\*([^*]+)\*\*", r"<b>\1</b>", text)
    return re.sub(r"(?<!\w)[*_]([^*_]+)[*_](?!\w)", r"<em>\1</em>", text)


def _breakable(name: str) -> str:
    """Return a name that may break where a word begins in it or behind a dot."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[_.])", "<wbr>", escape(name))


def unit_text(unit: str) -> str:
    """Return a unit as people write it: ``kg.m2/s`` as kg·m²/s."""
    raised = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
    unit = re.sub(r"(?<=[A-Za-z)])(-?\d+)", lambda m: m[1].translate(raised), unit)
    return re.sub(r"\bOhm\b", "Ω", unit).replace(".", "·")


@dataclass
class _Writer:
    """Writes the classes of one package."""

    package: Package
    site: Site
    drawn: dict[str, str] = field(default_factory=dict)
    graphics: list[Graphic] = field(default_factory=list)

    def definitions(self) -> str:
        """Return the drawings that the page uses, each once."""
        symbols = "".join(self.drawn.values())
        return _hidden(hatchings(tuple(self.graphics)) + symbols)

    def icon(self, definition: ClassDef) -> str:
        name = "s-" + _id(definition)
        if name not in self.drawn:
            drawing = symbol(definition)
            self.graphics += drawing.graphics
            self.drawn[name] = (
                f'<symbol id="{name}" viewBox="{view_box(drawing)}">{content(drawing)}</symbol>'
            )
        return f'<svg class="icon" role="img" aria-label="symbol"><use href="#{name}"/></svg>'

    def tiles(self, members: Iterable[ClassDef]) -> str:
        tiles = (f'<a href="#{_id(c)}">{self.icon(c)}{_breakable(c.name)}</a>' for c in members)
        return f'<div class="tiles">{"".join(tiles)}</div>'

    def section(self, definition: ClassDef) -> str:
        entry = class_entry(definition)
        kind = definition.kind if definition.tree.enumeration is None else "enumeration"
        drawn = definition.kind in DRAWN_KINDS
        icon = self.icon(definition) if drawn else ""
        about = []
        bases = [b for b in entry.bases if isinstance(b, ClassDef)]
        if bases:
            about.append("extends " + ", ".join(self.link(b) for b in bases))
        heirs = self.site.heirs.get(definition.full_name, [])
        if heirs:
            about.append("extended by " + ", ".join(self.link(h) for h in heirs))
        parts = [
            f'<section id="{_id(definition)}"><div class="head">{icon}<div>'
            f'<h3><a href="#{_id(definition)}">{escape(definition.name)}</a>'
            f'<span class="kind">{"partial " * definition.tree.partial}{kind}</span></h3>'
            f"<p>{escape(definition.tree.description)}</p>",
            f'<p class="about">{"; ".join(about)}</p>' if about else "",
            "</div></div>",
            self.body(entry),
        ]
        examples = self.site.examples.get(definition.full_name, ())
        if examples:
            names = ", ".join(f"<code>{escape(e)}</code>" for e in examples)
            parts.append(f"<h4>Examples</h4><p class=about>{names}</p>")
        return "".join(parts) + "</section>"

    def body(self, entry: ClassEntry) -> str:
        if entry.literals:
            rows = [(f"<code>{escape(n)}</code>", escape(d)) for n, d in entry.literals]
            return _table("Values", ("", ""), rows)
        if entry.code:
            return f"<pre>{escape(entry.code)}</pre>"
        connector = entry.definition.kind == "connector"
        parts = [
            self.ports(entry.ports),
            self.items("Parameters", entry.parameters, with_default=True),
            self.items("Parts", entry.parts, with_default=False),
            self.laws(entry),
            self.items("Variables", entry.variables, with_default=False, with_flow=connector),
            self.items("Constants", entry.constants, with_default=True),
        ]
        return "".join(parts)

    def ports(self, ports: Sequence[Item]) -> str:
        rows = []
        for port in ports:
            connector = port.type_class
            assert connector is not None
            color = FIELDS[field_of(connector)].color.hexadecimal
            about = escape(port.description) + self.origin(port)
            if port.condition:
                about += f'<span class="note">if {escape(port.condition)}</span>'
            rows.append(
                (f"<dot style=--c:{color}></dot><code>{escape(port.name)}</code>",
                 self.link(connector, port.type_name), about)
            )  # fmt: skip
        return _table("Ports", ("name", "connector", ""), rows)

    def items(
        self, title: str, items: Sequence[Item], *, with_default: bool, with_flow: bool = False
    ) -> str:
        rows = []
        own_first = sorted(items, key=lambda i: i.origin is not None)
        for item in own_first:
            name = f"<code>{escape(item.name)}</code>"
            about = escape(item.description) + self.origin(item)
            if item.structural:
                about += '<span class="note" title="decides sizes or structure">structural</span>'
            if item.condition:
                about += f'<span class="note">if {escape(item.condition)}</span>'
            type_name = item.type_name
            shown = self.link(item.type_class, type_name) if item.type_class else type_name
            row = [name, shown, unit_text(escape(item.unit))]
            if with_default:
                row.append(_default(item.default))
            if with_flow:
                row.append(item.flow)
            rows.append((*row, about))
        head = ["name", "type", "unit"] + ["default"] * with_default + [""] * with_flow
        return _table(title, (*head, ""), rows)

    def origin(self, item: Item) -> str:
        if item.origin is None:
            return ""
        return f' <span class="from">({self.link(item.origin)})</span>'

    def laws(self, entry: ClassEntry) -> str:
        groups = []
        for laws in entry.laws:
            group = ""
            if laws.origin is not None:
                group = f'<p class="from">from {self.link(laws.origin)}</p>'
            group += _lines(laws.lines) if laws.lines else ""
            if laws.initial:
                group += f'<p class="from">at the start</p>{_lines(laws.initial)}'
            groups.append(f"<div>{group}</div>")
        parts = []
        if groups:
            parts = [f'<h4>Equations</h4><div class="all">{"".join(groups)}</div>']
        if entry.limits:
            limits = "".join(
                f"<li>{mathml(limit.latex)}<small> {escape(limit.message)}</small></li>"
                for limit in entry.limits
            )
            parts.append(f'<h4>Valid for</h4><ul class="plain">{limits}</ul>')
        return "".join(parts)

    def types(self, members: Sequence[ClassDef]) -> str:
        rows = []
        for definition in members:
            entry = class_entry(definition)
            base = entry.bases[0] if entry.bases else None
            shown = self.link(base) if isinstance(base, ClassDef) else base.name if base else ""
            rows.append(
                (f'<code id="{_id(definition)}">{escape(definition.name)}</code>', shown,
                 unit_text(escape(entry.unit)), escape(definition.tree.description))
            )  # fmt: skip
        table = _table("", ("type", "is a", "unit", ""), rows)
        return f"<section>{table}</section>" if rows else ""

    def constants(self) -> str:
        if self.package.constants is None:
            return ""
        entry = class_entry(self.package.constants)
        return f"<section>{self.items('Constants', entry.constants, with_default=True)}</section>"

    def link(self, definition: ClassDef, text: str = "") -> str:
        """Return a link to a class; its name alone if it has no place in the reference."""
        owner, _, name = definition.full_name.rpartition(".")
        shown = escape(text or (name if owner == self.package.name else definition.full_name))
        if owner == self.package.name:
            return f'<a href="#{_id(definition)}">{shown}</a>'
        if any(p.name == owner for p in self.site.packages):
            return f'<a href="{owner}.html#{_id(definition)}">{shown}</a>'
        return shown


def _lines(lines: Sequence[Line]) -> str:
    rows = []
    for line in lines:
        depth = f' style="--d:{line.depth}"' if line.depth else ""
        words = f"<i>{escape(line.words)}</i>" if line.words else ""
        mathematics = mathml(line.latex) if line.latex else ""
        code = f"<code>{escape(line.code)}</code>" if line.code else ""
        about = f"<small>{escape(line.description)}</small>" if line.description else ""
        rows.append(f"<div{depth}>{words}{mathematics}{code}{about}</div>")
    return f'<div class="laws">{"".join(rows)}</div>'


def _hidden(definitions: str) -> str:
    """Return definitions that other drawings of the page refer to."""
    style = 'width="0" height="0" style="position:absolute" aria-hidden="true"'
    return f"<svg {style}>{definitions}</svg>" if definitions else ""


def _default(text: str) -> str:
    """Return a value in short: ``1e5[Pa]``, not ``100000.0[Pa]``."""
    if not text:
        return ""
    text = re.sub(r"(?<![\w.])\d+\.\d+(?:e[+-]?\d+)?|\d+(?:\.\d+)?e[+-]?\d+", _short, text)
    wide = ' class="wide"' if len(text) > 16 else ""
    return f"<code{wide}>{escape(text)}</code>"


def _short(number: re.Match[str]) -> str:
    text = f"{float(number[0]):.12g}"
    mantissa, exponent, power = text.partition("e")
    if not exponent and re.fullmatch(r"[1-9]\d?0{4,}", text):
        power = str(len(text) - 1)
        mantissa = text.rstrip("0")
        mantissa = mantissa[0] + ("." + mantissa[1:] if len(mantissa) > 1 else "")
    return f"{mantissa}e{int(power)}" if power else text


def _table(title: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table under a title; a column that is empty everywhere is left out."""
    if not rows:
        return ""
    kept = [k for k in range(len(head)) if any(row[k] for row in rows)]
    top = "".join(f"<th>{head[k]}" for k in kept)
    body = "".join("<tr>" + "".join(f"<td>{row[k]}" for k in kept) for row in rows)
    named = f"<h4>{title}</h4>" if title else ""
    return f"{named}<table><tr>{top}{body}</table>"


def _document(title: str, body: str, site: Site, here: str) -> str:
    style = (_HERE / "style.css").read_text(encoding="utf-8")
    script = (_HERE / "search.js").read_text(encoding="utf-8")
    names = site.search if not here else [s for s in site.search if s[1] == here]
    data = json.dumps(names, ensure_ascii=False, separators=(",", ":")).replace("</", "<\\/")
    place = json.dumps(here)
    hint = f"Search in {here}" if here else "Search all components"
    back = '<a href="index.html">Component library</a>'
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width,initial-scale=1">'
        f"<title>{escape(title)} · acausal</title><style>{style}</style></head><body>"
        f'<header>{back}<div class="find"><input id="q" type="search" placeholder="{hint}" '
        f'aria-label="{hint}" autocomplete="off"><ul id="hits"></ul></div></header>'
        f"{body}<script>const NAMES={data},HERE={place};{script}</script></body></html>\n"
    )

"""Which classes of the library the tests, the examples and the benchmarks use.

Models in ``.acm`` files are parsed. Models in the text of Python tests often are pieces that are
put together when the test runs, so their declarations are sought as text: ``Type name(``; a place
that an f-string, ``{word}`` or ``$word$`` fills may be any word of a string of the same file.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from dataclasses import fields
from pathlib import Path

from acausal.diagnostics import AcausalError
from acausal.modeling.classes import ClassDef, find_name
from acausal.modeling.library import Root, classes_of, standard_library
from acausal.reference.catalogue import all_classes
from acausal.reference.examples import used_classes
from acausal.syntax import tree
from acausal.syntax.cache import parse_cached

TESTS = Path(__file__).parent
ROOT = TESTS.parent

#: Stands for what is filled in.
_GAP = "\N{SECTION SIGN}"
_FILLED = re.compile(r"\{\w+\}|\$\w+\$")
_TYPE = rf"(?:[a-z{_GAP}][\w{_GAP}]*\.)*[\w{_GAP}']+"
_DECLARATION = re.compile(rf"(?<![\w.])({_TYPE})\s+[\w{_GAP}]+\s*(?=[(\[;,=\"]|if\b|$)")
_EXTENDS = re.compile(rf"\bextends\s+({_TYPE})")
_CALL = re.compile(rf"(?<![\w.])((?:[a-z{_GAP}][\w{_GAP}]*\.)+[\w{_GAP}]+)\(")
_IMPORT = re.compile(rf"\bimport\s+({_TYPE}(?:\.\*)?)\s*;")
_WORD = re.compile(r"(?:[A-Za-z_]\w*\.)*[A-Za-z_]\w*")


def used_in_tests(root: Root | None = None) -> dict[str, str]:
    """Return the full names of all classes that some model uses -> where that is.

    What a used class is made of counts as used: components, bases, functions.
    """
    root = root or standard_library()
    known = {c.full_name: c for c in all_classes(root)}
    used: dict[str, str] = {}
    for path, names in [*_used_in_models(root), *_used_in_texts(known)]:
        for name in names:
            if name in known:
                used.setdefault(name, str(path.relative_to(ROOT)))
    pending = list(used)
    while pending:
        name = pending.pop()
        for inner in {c.full_name for c in _made_of(known[name])}:
            if inner in known and inner not in used:
                used[inner] = used[name]
                pending.append(inner)
    return used


def _made_of(definition: ClassDef) -> Iterator[ClassDef]:
    yield from used_classes(definition)
    for call in _calls(definition.tree):
        found = find_name(definition, call.function)
        if isinstance(found, ClassDef):
            yield found


def _calls(node: object) -> Iterator[tree.Call]:
    pending = [node]
    while pending:
        item = pending.pop()
        if isinstance(item, tuple):
            pending += item
        elif isinstance(item, tree.Node) and not isinstance(item, tree.Annotation):
            if isinstance(item, tree.Call):
                yield item
            pending += [getattr(item, f.name) for f in fields(item)]


def _used_in_models(root: Root) -> Iterator[tuple[Path, set[str]]]:
    folders = (TESTS, ROOT / "examples", ROOT / "benchmarks")
    for path in (p for folder in folders for p in sorted(folder.rglob("*.acm"))):
        if "bad_input" in path.parts:
            continue
        names: set[str] = set()
        try:
            for model in classes_of(parse_cached(path), root).values():
                names |= {c.full_name for c in _made_of(model)}
        except AcausalError:
            continue  # a file of another package of the tests
        yield path, names


def _used_in_texts(known: dict[str, ClassDef]) -> Iterator[tuple[Path, set[str]]]:
    for path in sorted(TESTS.rglob("test_*.py")):
        texts = list(_strings(ast.parse(path.read_text(encoding="utf-8"))))
        neighbours = [
            text
            for other in sorted(path.parent.glob("*.py"))
            if not other.name.startswith("test_")
            for text in _strings(ast.parse(other.read_text(encoding="utf-8")))
        ]
        yield path, set(_declared([*texts, *neighbours], known))


def _strings(module: ast.Module) -> Iterator[str]:
    inside: set[int] = set()
    for node in ast.walk(module):
        if isinstance(node, ast.JoinedStr):
            parts = []
            for value in node.values:
                if isinstance(value, ast.Constant):
                    inside.add(id(value))
                    parts.append(str(value.value))
                else:
                    parts.append(_GAP)
            yield _FILLED.sub(_GAP, "".join(parts))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            if id(node) in inside:
                continue
            yield _FILLED.sub(_GAP, node.value)


def _declared(texts: list[str], known: dict[str, ClassDef]) -> Iterator[str]:
    words = {word for text in texts for word in _WORD.findall(text)}
    imports = {p for text in texts for p in _IMPORT.findall(text)}
    packages = {p.removesuffix(".*") for p in imports if p.endswith(".*")}
    single = {p.rpartition(".")[2]: p for p in imports if not p.endswith(".*")}
    for text in texts:
        if text in known:
            yield text
        if text.isascii() and ("\n" not in text and " " not in text):
            continue
        for pattern in (_DECLARATION, _EXTENDS, _CALL):
            for name in pattern.findall(text):
                yield from _resolved(name, known, words, packages, single)


def _resolved(
    name: str,
    known: dict[str, ClassDef],
    words: set[str],
    packages: set[str],
    single: dict[str, str],
) -> Iterator[str]:
    candidates = [name, single.get(name, name), *(f"{p}.{name}" for p in sorted(packages))]
    for candidate in dict.fromkeys(candidates):
        if _GAP not in candidate:
            if candidate in known:
                yield candidate
            continue
        if not candidate.replace(_GAP, "").strip("."):
            continue
        pieces = [re.escape(p) for p in candidate.split(_GAP)]
        pattern = re.compile(r"([\w.]*)".join(pieces))
        for full in known:
            match = pattern.fullmatch(full)
            if match and all(not g or g.isdigit() or g in words for g in match.groups()):
                yield full


def unused(names: Iterable[str]) -> list[str]:
    """Return those of some classes that nothing uses."""
    used = used_in_tests()
    return [name for name in names if name not in used]

"""LaTeX mathematics as MathML that browsers draw without help, written as short as possible."""

from __future__ import annotations

import re
from functools import lru_cache
from html import escape, unescape
from typing import Final

#: Words of several letters come letter by letter from the converter.
_LETTERS: Final = re.compile(r'(?:<mi mathvariant="(?:normal|italic|monospace)">[^<]+</mi>){2,}')
_LETTER: Final = re.compile(r'<mi mathvariant="(\w+)">([^<]+)</mi>')
_SINGLE_ROW: Final = re.compile(r"<mrow>(<(m[ino]|mtext)(?: [^<>]*)?>[^<]*</\2>)</mrow>")
_ROW_IN_ROW: Final = re.compile(r"<mrow><mrow>((?:(?!</?mrow>).)*)</mrow></mrow>")
#: Bars do not grow by themselves, and a sign behind an operator is no subtraction.
_BAR: Final = re.compile(r'<mo stretchy="true" fence="true" form="(prefix|postfix)">\|</mo>')
_SIGN: Final = re.compile(r"(<mo>(?:[=(≤≥≠∧∨,]|&lt;|&gt;)</mo>)<mo>−</mo>")
_ENTITY: Final = re.compile(r"&#x([0-9A-Fa-f]+);")


@lru_cache(maxsize=4096)
def mathml(latex: str) -> str:
    """Return a ``math`` element for LaTeX mathematics.

    Names of several letters have the class ``v`` if they are variables, for slanted letters.
    """
    from latex2mathml.converter import convert

    text: str = convert(latex, display="block")
    text = re.sub(r"^<math[^>]*>", "", text).removesuffix("</math>")
    text = _ENTITY.sub(lambda m: escape(unescape(m[0])), text)
    text = _LETTERS.sub(_joined, text)
    text = text.replace(' mathvariant="normal"', "").replace(' mathvariant="italic"', "")
    text = _BAR.sub(r"<mo stretchy=true form=\1>|</mo>", text)
    text = text.replace(' stretchy="true" fence="true"', "").replace(' columnalign="left"', "")
    text = text.replace(' width="0.167em" /', " width=.24em /").replace(' form="prefix"', "")
    text = text.replace(' form="postfix"', "")
    text = _SIGN.sub(r"\1<mo form=prefix>−</mo>", text)
    before = ""
    while before != text:
        before = text
        text = _ROW_IN_ROW.sub(r"<mrow>\1</mrow>", _SINGLE_ROW.sub(r"\1", text))
    if text.startswith("<mrow>") and text.endswith("</mrow>") and text.count("<mrow>") == 1:
        text = text.removeprefix("<mrow>").removesuffix("</mrow>")
    return f"<math displaystyle=true>{text}</math>"


def _joined(match: re.Match[str]) -> str:
    letters = _LETTER.findall(match[0])
    words: list[list[str]] = []
    for variant, letter in letters:
        if words and words[-1][0] == variant:
            words[-1][1] += letter
        else:
            words.append([variant, letter])
    marks = {"italic": " class=v"}
    return "".join(f"<mi{marks.get(variant, '')}>{word}</mi>" for variant, word in words)

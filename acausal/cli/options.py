"""Arguments and options that several commands share."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar

import click

F = TypeVar("F", bound=Callable[..., Any])

json_errors = click.option(
    "--json-errors",
    is_flag=True,
    expose_value=False,
    help="Write messages as JSON, for tools.",
)

# A missing file is told by the reader as a coded message, so click does not look.
file_argument = click.argument(
    "file", type=click.Path(path_type=Path, allow_dash=False, readable=False)
)
model_argument = click.argument("model", required=False)

parameter_option = click.option(
    "-p",
    "--parameter",
    "parameters",
    multiple=True,
    metavar="NAME=VALUE",
    help="Set a parameter, e.g. r.R=1[kOhm]. May be repeated.",
)

_NAME = re.compile(
    r"\s*([^\W\d]\w*(?:\[[\d,\s:]+\])?(?:\.[^\W\d]\w*(?:\[[\d,\s:]+\])?)*)\s*=\s*(.*\S)\s*",
    re.DOTALL,
)


def read_parameters(texts: Iterable[str]) -> dict[str, float | str]:
    """Return values by parameter path; what is more than a plain number stays text.

    Raises:
        click.BadParameter: If a text is no ``name=value`` or a name is set twice.
    """
    values: dict[str, float | str] = {}
    for text in texts:
        match = _NAME.fullmatch(text)
        if match is None:
            raise click.BadParameter(
                f"'{text}' is not of the form name=value, e.g. r.R=1[kOhm]",
                param_hint="'-p'",
            )
        name, value = match[1].replace(" ", ""), match[2]
        if name in values:
            raise click.BadParameter(f"{name} is set twice", param_hint="'-p'")
        try:
            values[name] = float(value) if not value[0].isalpha() else value
        except ValueError:
            values[name] = value
    return values


def split_patterns(texts: Iterable[str]) -> tuple[str, ...]:
    """Split ``--variables a,b`` too, but not at the commas of ``a[1,2]`` and ``max(a, b)``."""
    patterns: list[str] = []
    for text in texts:
        depth, word = 0, ""
        for c in text:
            depth += (c in "[({") - (c in "])}")
            if c == "," and depth == 0:
                patterns.append(word.strip())
                word = ""
            else:
                word += c
        patterns.append(word.strip())
    return tuple(p for p in patterns if p)

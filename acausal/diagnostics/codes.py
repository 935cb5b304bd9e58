"""All message codes with their meaning, and the page of the manual that lists them.

``python -m acausal.diagnostics.codes > docs/messages.md`` writes the page.
"""

from __future__ import annotations

#: Stage letter -> what the codes with that letter are about.
STAGES = {
    "P": "Reading text",
    "N": "Names",
    "T": "Types and sizes",
    "U": "Units",
    "C": "Connections",
    "B": "Balance of equations and unknowns",
    "S": "Structure of the system",
    "I": "Initialisation",
    "E": "Events",
    "R": "Running a simulation",
    "F": "Files and command line",
}

#: Code -> meaning, one line, in the order of stages and numbers.
CODES: dict[str, str] = {
    "F110": "The component library is missing from the installation.",
}


def manual_page() -> str:
    """Return ``docs/messages.md``."""
    lines = [
        "# Messages",
        "",
        "Every message carries a code; its letter tells the stage it comes from.",
        "(This page is generated from `acausal/diagnostics/codes.py`.)",
    ]
    for letter, stage in STAGES.items():
        rows = [f"| `{c}` | {meaning} |" for c, meaning in CODES.items() if c[0] == letter]
        if rows:
            lines += ["", f"## {letter}: {stage}", "", "| code | meaning |", "|---|---|", *rows]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(manual_page(), end="")

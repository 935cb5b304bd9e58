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
    "P001": "Something stands where it cannot stand.",
    "P002": "A semicolon is missing.",
    "P003": "A class or block is not closed.",
    "P004": "An `end` closes nothing, or names another class than the open one.",
    "P005": "A keyword is missing: `then`, `loop`, `else`, `in`.",
    "P006": "`=` in an algorithm, or `:=` among equations.",
    "P007": "Brackets do not match.",
    "P008": "A character that is no part of the language.",
    "P009": "A string or a quoted name is not closed.",
    "P010": "A comment is not closed.",
    "P011": "A reserved word is used as a name.",
    "P012": "`connect` has fewer than two cuts.",
    "P013": "An equation stands before the word `equation`.",
    "P014": "`==` in place of `=`, or `=` in place of `==`.",
    "P015": "The unit behind a number is not written as `10[kOhm]`.",
    "P016": "Text outside of a class.",
    "P017": "The expression is empty.",
    "P018": "Operators that cannot follow each other, or are none.",
    "P019": "An expression stands where an equation is expected.",
    "P020": "A prefix that cannot stand here.",
    "P021": "A declaration stands among equations or statements.",
    "P022": "A number is badly written or too large.",
    "P023": "An unknown escape sequence in a string.",
    "P024": "`end` outside of a subscript, or a list of targets without a call.",
    "P025": "A construct of Modelica that is not supported.",
    "P026": "Brackets, blocks or conditions are nested too deeply.",
    "P027": "An import or `within` is not at the top of the file.",
    "P030": "The file is not UTF-8 text.",
    "P035": "The file is binary or UTF-16.",
    "F101": "The file does not exist.",
    "F102": "A directory stands where a file is expected.",
    "F103": "The file cannot be read.",
    "F104": "The file is too large.",
    "F106": "The file holds no class.",
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

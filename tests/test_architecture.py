"""Stages import one way only, and every file stays within what a reader can take in."""

from __future__ import annotations

import ast
from pathlib import Path

import acausal

PACKAGE = Path(acausal.__file__).parent

#: Later stages may import earlier ones, never the other way round. A result is a record that the
#: simulation fills, so ``results`` comes before it; solvers are used to find a consistent start.
ORDER = (
    "version",
    "memory",
    "diagnostics",
    "units",
    "storage",
    "syntax",
    "modeling",
    "expressions",
    "instantiation",
    "connections",
    "flattening",
    "events",
    "elimination",
    "structural",
    "codegen",
    "assembly",
    "diagnosis",
    "solvers",
    "initialization",
    "results",
    "simulation",
    "inspection",
    "reference",
    "drawing",
    "reporting",
    "compiler",
    "animation",
    "runs",
    "compose",
    "library",
    "netlists",
    "cli",
    "__main__",
)


def imported(tree: ast.Module) -> list[tuple[int, str]]:
    """Return (line, module) of all imports of acausal's own modules."""
    found: list[tuple[int, str]] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found += [(node.lineno, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"line {node.lineno}: a relative import hides the stage"
            module = node.module or ""
            if module == "acausal":
                found += [(node.lineno, f"acausal.{alias.name}") for alias in node.names]
            else:
                found.append((node.lineno, module))
    return [(line, name) for line, name in found if name.split(".")[0] == "acausal"]


def stage_of(module: str) -> str:
    return module.split(".")[1]


def violations(path: Path, source: str) -> list[str]:
    """Return the imports in a file that point to a later stage."""
    here = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
    if here == "__init__":
        return []
    assert here in ORDER, f"{here} is a new stage: give it a place in the order"
    wrong = []
    for line, module in imported(ast.parse(source)):
        there = stage_of(module) if "." in module else "version"
        assert there in ORDER, f"{path}:{line} imports unknown stage {there}"
        if ORDER.index(there) > ORDER.index(here):
            wrong.append(f"{path.relative_to(PACKAGE)}:{line} imports {module}")
    return wrong


def test_stages_import_one_way():
    files = sorted(PACKAGE.rglob("*.py"))
    assert len(files) > 30
    wrong = [v for path in files for v in violations(path, path.read_text(encoding="utf-8"))]
    assert wrong == []


def test_the_check_sees_a_wrong_import():
    path = PACKAGE / "units" / "unit.py"
    source = "def f():\n    from acausal.solvers.ida import x\n"
    assert violations(path, source) == ["units/unit.py:2 imports acausal.solvers.ida"]
    assert violations(path, "from acausal import cli\n") == ["units/unit.py:1 imports acausal.cli"]
    assert violations(path, "import acausal.diagnostics\n") == []


def test_no_file_is_too_long():
    """A file this long has two subjects; 600 lines already are a sign of it."""
    long = {
        str(path.relative_to(PACKAGE)): lines
        for path in sorted(PACKAGE.rglob("*.py"))
        if (lines := path.read_text(encoding="utf-8").count("\n")) > 700
    }
    assert long == {}

"""Writes the tutorials with fresh outputs."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from tests.tutorials.notebooks import NOTEBOOKS, execute, kernel, read, stored_form, write

for path in NOTEBOOKS:
    if len(sys.argv) == 1 or any(part in path.name for part in sys.argv[1:]):
        notebook = read(path)
        with tempfile.TemporaryDirectory() as folder, kernel(Path(folder)) as manager:
            execute(notebook, manager)
        write(stored_form(notebook), path)
        print(f"{path.name}: {path.stat().st_size / 1000:.0f} kB")

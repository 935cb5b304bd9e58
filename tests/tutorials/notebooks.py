"""Execution of the tutorials, as Jupyter does it; their stored form is the one that tests expect.

``python -m tests.tutorials`` executes all and writes them with their outputs,
``python -m tests.tutorials 02`` only those whose name contains ``02``.
"""

from __future__ import annotations

import base64
import io
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import nbformat
from jupyter_client import KernelManager
from nbclient import NotebookClient
from nbformat import NotebookNode, v4
from PIL import Image, ImageSequence

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "docs" / "tutorials"
NOTEBOOKS = tuple(sorted(FOLDER.glob("*.ipynb")))
#: What a notebook needs and nothing that an editor or a machine adds.
METADATA = {
    "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
    "language_info": {"name": "python"},
}
COLOUR = re.compile(r"\x1b\[[\d;]*m")


def read(path: Path) -> NotebookNode:
    return nbformat.read(path, as_version=4)


@contextmanager
def kernel(folder: Path) -> Iterator[KernelManager]:
    """Start a kernel for any number of notebooks; a start takes longer than most of them.

    Args:
        folder: Where the kernel works and IPython keeps its files.
    """
    paths = (str(ROOT), os.environ.get("PYTHONPATH", ""))
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(path for path in paths if path),
        "IPYTHONDIR": str(folder / "ipython"),
    }
    manager = KernelManager(kernel_name="python3")
    manager.start_kernel(cwd=str(folder), env=environment)
    try:
        yield manager
    finally:
        manager.shutdown_kernel(now=True)


def execute(notebook: NotebookNode, manager: KernelManager, allow_errors: bool = False) -> None:
    """Fill in the outputs of a notebook; what earlier notebooks have defined is forgotten.

    Raises:
        CellExecutionError: If a cell raises and may not.
    """
    client = NotebookClient(
        notebook, km=manager, timeout=120, allow_errors=allow_errors, coalesce_streams=True
    )
    forget = v4.new_code_cell("%reset -f")
    notebook.cells.insert(0, forget)
    try:
        client.execute(reset_kc=True)
    finally:
        notebook.cells.remove(forget)


def stored_form(notebook: NotebookNode) -> NotebookNode:
    """Return a notebook without what differs from run to run and without what editors add."""
    notebook.metadata = nbformat.from_dict(METADATA)
    number = 0
    for k, cell in enumerate(notebook.cells, start=1):
        cell.id = f"cell-{k}"
        cell.metadata = nbformat.from_dict({})
        if cell.cell_type != "code":
            continue
        number += 1
        cell.execution_count = number
        for output in cell.outputs:
            if "metadata" in output:
                output.metadata = nbformat.from_dict({})
            if "image/gif" in output.get("data", {}):
                output.data["image/png"] = animated_png(output.data.pop("image/gif"))
            if "image/png" in output.get("data", {}):
                output.data["image/png"] = small_png(output.data["image/png"])
            if output.output_type == "execute_result":
                output.execution_count = number
    return notebook


def animated_png(text: str) -> str:
    """Return a GIF, base64, as a PNG that moves: code hosts show those, and no GIFs."""
    picture = Image.open(io.BytesIO(base64.b64decode(text)))
    frames = [frame.convert("RGB") for frame in ImageSequence.Iterator(picture)]
    # One palette without dithering: what does not move is not stored again.
    palette = frames[len(frames) // 2].quantize(32)
    first, *others = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    buffer = io.BytesIO()
    first.save(
        buffer, "PNG", save_all=True, append_images=others, duration=picture.info["duration"],
        loop=0, optimize=True,
    )  # fmt: skip
    return base64.b64encode(buffer.getvalue()).decode()


def small_png(text: str) -> str:
    """Return a picture, base64, with a palette: plots need half of the bytes."""
    picture = Image.open(io.BytesIO(base64.b64decode(text)))
    if picture.mode == "P" or getattr(picture, "is_animated", False):
        return text
    buffer = io.BytesIO()
    picture.convert("RGB").quantize(256).save(buffer, "PNG", optimize=True)
    return base64.b64encode(buffer.getvalue()).decode()


def texts(notebook: NotebookNode) -> list[tuple[int, str]]:
    """Return (cell, text) for all outputs that are text, pictures by their names."""
    found = []
    for k, cell in enumerate(notebook.cells):
        for output in cell.get("outputs", ()):
            text = output.get("text") or output.get("data", {}).get("text/plain", "")
            found.append((k, COLOUR.sub("", text).strip()))
    return found


def write(notebook: NotebookNode, path: Path) -> None:
    nbformat.validate(notebook)
    nbformat.write(notebook, path)

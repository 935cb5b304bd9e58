"""The whole reference, as files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from acausal.diagnostics import Diagnostic
from acausal.modeling.library import Root, standard_library
from acausal.modeling.library_path import library_path
from acausal.reference.catalogue import all_classes, packages
from acausal.reference.examples import used_by_files
from acausal.reference.icons import check_icon
from acausal.reference.pages import Site, index_page, package_page


def reference_pages(names: Sequence[str] = (), root: Root | None = None) -> dict[str, str]:
    """Return the pages of the reference by file name, the index first.

    Args:
        names: Packages to write about; all if empty. The index lists all of them in any case.
        root: The library; the standard one if None.

    Raises:
        AcausalError: ``N150`` for a package that does not exist, or a mistake in the library.
    """
    root = root or standard_library()
    chosen = packages(root, names)
    examples = used_by_files((library_path().parent / "examples").glob("*.acm"))
    site = Site(packages(root) if names else chosen, examples)
    pages = {"index.html": index_page(site)}
    for package in chosen:
        pages[f"{package.name}.html"] = package_page(package, site)
    return pages


def write_reference(
    folder: Path, names: Sequence[str] = (), root: Root | None = None
) -> list[Path]:
    """Write the pages into a folder, made if it is not there; return their paths.

    Raises:
        AcausalError: As :func:`reference_pages`.
        OSError: If a file cannot be written.
    """
    pages = reference_pages(names, root)
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, text in pages.items():
        path = folder / name
        path.write_text(text, encoding="utf-8")
        written.append(path)
    return written


def icon_diagnostics(root: Root | None = None) -> list[Diagnostic]:
    """Return what is wrong with icons and placements in the whole library."""
    classes = all_classes(root or standard_library())
    return [diagnostic for definition in classes for diagnostic in check_icon(definition)]

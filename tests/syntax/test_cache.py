"""The cache of parse trees: it saves time and can do nothing else."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from pathlib import Path

import pytest

from acausal.diagnostics import AcausalError
from acausal.storage.cache_directory import cache_directory, read, write
from acausal.syntax.cache import dump_tree, load_tree, parse_cached
from acausal.syntax.formatter import format_file
from acausal.syntax.parser import parse_file, parse_text

MODEL = """
model A "text"
  parameter Real k(min = 0) = 10[kOhm] "gain";
  Real x[3](each start = 1), y if use;
equation
  for i loop
    x[i] = k*sum(j for j in 1:i);
  end for;
  (y, ) = f(x[end], n = true);
end A;
"""


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "cache"
    monkeypatch.setenv("ACAUSAL_CACHE", str(folder))
    return folder


@pytest.fixture
def source(tmp_path: Path) -> Path:
    path = tmp_path / "a.acm"
    path.write_text(MODEL)
    return path


def entries(folder: Path) -> list[Path]:
    return sorted((folder / "syntax").iterdir())


def test_same_tree(cache: Path, source: Path) -> None:
    first = parse_cached(source)
    assert first == parse_file(source)
    assert len(entries(cache)) == 1
    assert parse_cached(source) == first


def test_second_start_does_not_import_lark(cache: Path, source: Path) -> None:
    program = (
        "import sys; from acausal.syntax.cache import parse_cached;"
        "parse_cached(sys.argv[1]); print('lark' in sys.modules)"
    )
    runs = [
        subprocess.run(
            [sys.executable, "-c", program, str(source)], capture_output=True, text=True, check=True
        ).stdout.strip()
        for _ in range(2)
    ]
    assert runs == ["True", "False"]


def test_moved_file_has_the_new_name_in_its_spans(cache: Path, source: Path) -> None:
    parse_cached(source)
    moved = source.with_name("b.acm")
    source.rename(moved)
    assert parse_cached(moved).classes[0].components[0].span.source == str(moved)
    assert len(entries(cache)) == 1


def test_changed_file_is_parsed_again(cache: Path, source: Path) -> None:
    parse_cached(source)
    source.write_text(MODEL.replace("A", "B"))
    assert parse_cached(source).classes[0].name == "B"


def test_errors_are_not_cached(cache: Path, source: Path) -> None:
    source.write_text("model A")
    for _ in range(2):
        with pytest.raises(AcausalError):
            parse_cached(source)
    assert not (cache / "syntax").exists() or not entries(cache)


@pytest.mark.parametrize("damage", ["cut", "flip", "empty", "pickle", "directory"])
def test_damaged_entry_is_ignored_and_replaced(cache: Path, source: Path, damage: str) -> None:
    expected = parse_cached(source)
    (entry,) = entries(cache)
    data = entry.read_bytes()
    if damage == "cut":
        entry.write_bytes(data[: len(data) // 2])
    elif damage == "flip":
        entry.write_bytes(data[:-9] + bytes([data[-9] ^ 1]) + data[-8:])
    elif damage == "empty":
        entry.write_bytes(b"")
    elif damage == "pickle":
        entry.write_bytes(pickle.dumps([expected]))
    else:
        entry.unlink()
        entry.mkdir()
    assert parse_cached(source) == expected
    if damage != "directory":
        assert entries(cache)[0].read_bytes() == data


def test_damaged_parser_tables_are_ignored(cache: Path, source: Path) -> None:
    program = "import sys; from acausal.syntax.cache import parse_cached; parse_cached(sys.argv[1])"
    subprocess.run([sys.executable, "-c", program, str(source)], check=True)
    (tables,) = (cache / "grammar").iterdir()
    good = tables.read_bytes()
    tables.write_bytes(good[:1000])
    source.write_text(MODEL + "\n// changed")
    subprocess.run([sys.executable, "-c", program, str(source)], check=True)
    assert len(tables.read_bytes()) > len(good) // 2


def test_foreign_classes_are_refused() -> None:
    class Bomb:
        def __reduce__(self) -> tuple[object, tuple[str]]:
            return (os.system, ("echo harm",))

    assert load_tree(pickle.dumps([Bomb()]), "x") is None
    assert load_tree(pickle.dumps([{"a": 1}]), "x") is None
    assert load_tree(b"", "x") is None


def test_deep_trees_can_be_stored() -> None:
    # A sum of many terms is a tree as deep as it is long; comparing such trees recurses, printing
    # them does not.
    text = "model A\nequation\n  y = " + " + ".join(f"x{i}" for i in range(20_000)) + ";\nend A;"
    first = parse_text(text, "a")
    again = load_tree(dump_tree(first), "a")
    assert again is not None
    assert format_file(again) == format_file(first)


@pytest.mark.parametrize("setting", ["", "off", "OFF"])
def test_switched_off(
    setting: str, source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ACAUSAL_CACHE", setting)
    monkeypatch.chdir(tmp_path)
    assert cache_directory() is None
    parse_cached(source)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.acm"]


def test_folder_that_cannot_be_made(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("ACAUSAL_CACHE", str(tmp_path / "file" / "cache"))
    assert cache_directory() is None
    assert parse_cached(source).classes[0].name == "A"


def test_default_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ACAUSAL_CACHE", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache_directory() == tmp_path / "xdg" / "acausal"
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    assert cache_directory() == tmp_path / "home" / ".cache" / "acausal"
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert cache_directory() == tmp_path / "home" / ".cache" / "acausal"


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="permissions of POSIX")
def test_private_folders_and_entries(cache: Path) -> None:
    write("kind", "key", b"data")
    assert cache.stat().st_mode & 0o777 == 0o700
    assert (cache / "kind").stat().st_mode & 0o777 == 0o700
    assert (cache / "kind" / "key").stat().st_mode & 0o777 == 0o600
    assert read("kind", "key") == b"data"
    (cache / "kind" / "key").chmod(0o666)
    assert read("kind", "key") is None
    cache.chmod(0o777)
    assert cache_directory() is None


@pytest.mark.skipif(not hasattr(os, "symlink"), reason="links of POSIX")
def test_links_are_not_followed(cache: Path) -> None:
    write("kind", "one", b"data")
    (cache / "kind" / "two").symlink_to(cache / "kind" / "one")
    assert read("kind", "two") is None


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="needs chown")
def test_entry_of_another_user_is_ignored(cache: Path) -> None:
    write("kind", "key", b"data")
    os.chown(cache / "kind" / "key", 12345, -1)
    assert read("kind", "key") is None


def test_full_disk(cache: Path, source: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*arguments: object) -> None:
        raise OSError(28, "No space left on device")

    parse_cached(source)
    source.write_text(MODEL.replace("A", "B"))
    monkeypatch.setattr(os, "replace", refuse)
    assert parse_cached(source).classes[0].name == "B"
    assert len(entries(cache)) == 1  # nothing half written stays behind


@pytest.mark.parametrize("name", ["../x", "a/b", "", ".hidden", "a b"])
def test_names_cannot_leave_the_folder(cache: Path, name: str) -> None:
    with pytest.raises(ValueError, match="cache entry"):
        write("kind", name, b"")
    with pytest.raises(ValueError, match="cache entry"):
        read(name, "key")

"""What is finished stays finished: every component of tier A is there, tested, and documented."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from tests.coverage import FINISHED, LISTS, Row, coverage, main, table, totals


@pytest.fixture(scope="module")
def rows() -> list[Row]:
    return coverage()


def incomplete(rows: Sequence[Row], name: str) -> list[str]:
    chosen = [r for r in rows if r.list == name and r.tier == "A"]
    return table(chosen, missing=True)


def test_lists_name_every_component_once(rows: list[Row]) -> None:
    assert len(rows) > 700
    paths = [r.path for r in rows]
    assert sorted(p for p in set(paths) if paths.count(p) > 1) == []
    assert {r.tier for r in rows} == {"A", "B", "C"}


@pytest.mark.parametrize("name", FINISHED)
def test_tier_a_is_complete(rows: list[Row], name: str) -> None:
    assert (LISTS / f"{name}.csv").is_file()
    assert incomplete(rows, name) == []


def test_what_is_missing_is_seen() -> None:
    row = Row("electrical", "A", "Basic", "Flux", "electrical.Flux", False, False, False, False,
              False)  # fmt: skip
    whole = Row("electrical", "A", "Basic", "R", "electrical.R", True, True, True, True, True)
    assert table([row, whole], missing=True) == [
        "electrical: Basic",
        "  A  electrical.Flux  -       -      -         -     -",
    ]
    assert totals([row, whole])[1].split() == ["electrical", "A", "2", "1", "1", "1", "1", "1"]


def test_known_components_are_found(rows: list[Row]) -> None:
    by_path = {r.path: r for r in rows}
    resistor = by_path["electrical.Resistor"]
    assert resistor.present and resistor.tested and resistor.described and resistor.units
    assert by_path["mechanical.translational.Mass"].tested
    assert not by_path["electrical.quasi_static.Admittance"].present


def test_the_command_prints_totals(capsys: pytest.CaptureFixture[str]) -> None:
    code = main(["thermal", "--missing"])
    printed = capsys.readouterr().out
    assert "list" in printed and "thermal" in printed
    assert code in (0, 1)

"""Where words go: JSON alone on standard output, nothing but failures where a verb is to be quiet."""

from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

from casa_assets import registry
from casa_assets.cli.main import app
from casa_assets.cli.output import Output
from casa_assets.registry.families import families, object_names


def test_json_has_standard_output_for_itself_and_quiet_tells_what_failed(capsys: pytest.CaptureFixture[str]) -> None:
    said = "a [bold]line\na detail\nit failed\n"
    for as_json, quiet, expected in (
        (False, False, (said, "no result\n")),
        (True, False, ('{"id": "mug"}\n', f"{said}no result\n")),
        (False, True, ("", "it failed\nno result\n")),
        (True, True, ('{"id": "mug"}\n', "it failed\nno result\n")),
    ):
        output = Output(as_json, quiet, verbose=not quiet)
        output.row({"id": "mug"})
        output.line("a [bold]line")
        output.detail("a detail")
        output.wrong("it failed")
        output.error("no result")
        assert capsys.readouterr() == expected


def rows(*words: str) -> list[dict[str, object]]:
    result = CliRunner().invoke(app, [*words, "--json"])
    assert result.exit_code == 0, result.output
    return [json.loads(line) for line in result.stdout.splitlines()]


def test_every_category_and_what_builds_it_is_listed() -> None:
    found = {str(row["id"]): row for row in rows("categories", "list")}
    known = registry.load()
    assert found.keys() == {*known.categories, *known.fixtures}
    assert found["mug"]["class"] == "drinkware"
    assert found["mug"]["looks_like"] == ["coffee_cup"]
    assert found["mug"]["mass"] == known.categories["mug"].mass_kg.typical
    assert found["mug"]["size"] == [side.typical for side in known.categories["mug"].extents]
    built = [command for row in found.values() for command in row["built_by"]]  # type: ignore[attr-defined]
    assert set(built) == {
        *(f"families build {name}" for name in families()),
        *(f"objects build {name}" for name in object_names()),
    }

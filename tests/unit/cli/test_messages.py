"""What a user stumbles over: places that cannot be written to, folders that are none, tables in a narrow window."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import typer

from casa_assets import registry
from casa_assets.cli.main import app
from casa_assets.errors import UnknownId
from tests.program import called as casa

# Paths below a file that is no folder are refused for root as well.
NO_PLACE = "/dev/null/place"


def test_a_name_like_no_other_is_told_what_there_is() -> None:
    assert str(UnknownId("plan", "zzz", ["galley", "l_small"])) == "unknown plan 'zzz'; there are galley, l_small"
    assert str(UnknownId("plan", "galey", ["galley"])).endswith("did you mean galley?")
    assert str(UnknownId("plan", "zzz", [])).endswith("there are none")
    assert str(UnknownId("plan", "zzz", map(str, range(100, 109)))).endswith("and 3 more")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["textures", "make", "oak_natural_plank", "--out", NO_PLACE, "--width-px", "64"], "cannot be written to"),
        (["families", "show", "microwave", "--preset", "stel", "--out", NO_PLACE], "did you mean steel?"),
        (["report", "--library", "{empty}"], "is no library"),
        (["report", "--library", "{empty}", "--out", "report.json"], "name a file that ends in .html"),
        (["preview", "{file}"], "is no MJCF"),
        (["articulate", "{empty}"], "no mesh found"),
        (["ingest", "{empty}", "--library", "{empty}/library"], "no mesh found in"),
        (["articulate", "{file}", "--up", "sideways"], "--up"),
        (["articulate", "{file}", "--decisions", "{empty}"], "--decisions"),
        (["scenes", "preview", "l_small__coastal", "--out", "{empty}"], "casa-assets scenes build l_small__coastal"),
        (["preview", "{empty}"], "no asset found"),
    ],
)
def test_misuse_is_told_in_a_line_and_leaves_nothing(arguments: list[str], message: str, tmp_path: Path) -> None:
    empty, file = tmp_path / "empty", tmp_path / "box.obj"
    empty.mkdir()
    file.write_text("v 0 0 0\n", encoding="ascii")
    done = casa(*(a.format(empty=empty, file=file) for a in arguments))
    assert done.returncode == 2, done.stderr
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert list(empty.iterdir()) == []


def test_the_help_of_ingest_shows_the_limits_of_the_registry(subtests: pytest.Subtests) -> None:
    for option, limit, unit in [
        ("timeout", "input_seconds", 1),
        ("memory", "input_memory_bytes", 1e9),
        ("max_size", "input_bytes", 1e6),
        ("max_faces", "input_faces", 1),
        ("max_texture", "input_texture_px", 1),
        ("max_pixels", "input_texture_pixels", 1e6),
    ]:
        with subtests.test(option=option, limit=limit, unit=unit):
            command = typer.main.get_command(app).commands["ingest"]  # type: ignore[attr-defined]
            told = re.search(r"; ([\d.]+) by default\.$", next(p.help for p in command.params if p.name == option))
            assert told
            assert float(told[1]) == registry.load().limits[limit] / unit

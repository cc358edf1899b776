"""Nothing outside the input is read, nothing outside the library is written, nothing is run, nobody is called."""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.support.hostile.access_audit import Watch, untouched
from tests.support.hostile.exfiltration_inputs import SECRET, listener, make_inputs, make_outside
from tests.support.hostile.hostile_set import Said
from tests.support.library.libraries import casa, tree

pytestmark = pytest.mark.slow


class EscapeRun(NamedTuple):
    """One run over all inputs of `exfiltration_inputs`, and what was seen to be touched."""

    said: dict[str, Said]
    folder: Path
    watch: Watch
    touched: list[str]
    called: list[str]
    before: dict[str, bytes | None]
    after: dict[str, bytes | None]


@pytest.fixture(scope="module")
def escape_run(tmp_path_factory: pytest.TempPathFactory) -> EscapeRun:
    folder = tmp_path_factory.mktemp("escape_run")
    outside = make_outside(folder / "outside")
    watch = Watch(folder / "watch")
    with listener() as (port, called):
        inputs = make_inputs(folder / "in", outside, port)
        before = tree(outside)
        pairs = ((inputs, folder / "library"), (inputs / "slip.zip", folder / "library_of_zip"))
        options = ("--json", "--keep-duplicates")
        with untouched(outside) as touched:
            runs = [casa("ingest", source, "--library", made, *options, **watch.environment) for source, made in pairs]
        after = tree(outside)
    said: dict[str, Said] = {}
    for run in runs:
        assert run.returncode == 1, run.stderr
        for line in run.stdout.splitlines():
            one = Said.of(json.loads(line))
            said[f"{one.path}:{one.code}" if one.path in said else one.path] = one
    return EscapeRun(said, folder, watch, touched, called, before, after)


def test_the_witnesses_can_see(tmp_path: Path) -> None:
    """The hook and the kernel tell of a run whose input is the canary itself; else their silence would mean nothing."""
    outside = make_outside(tmp_path / "outside")
    watch = Watch(tmp_path / "watch")
    with untouched(outside) as touched:
        casa("ingest", outside / "secret.txt", "--library", tmp_path / "library", "--json", **watch.environment)
    assert any(name.endswith("secret.txt") for name in touched)
    seen = {Path(event.target).name for event in watch.escapes([], [tmp_path / "library"])}
    assert "secret.txt" in seen


def test_nothing_outside_is_touched_and_nobody_is_called(escape_run: EscapeRun) -> None:
    assert escape_run.touched == []
    assert escape_run.after == escape_run.before
    assert escape_run.called == []
    outputs = [escape_run.folder / "library", escape_run.folder / "library_of_zip"]
    assert escape_run.watch.escapes([escape_run.folder / "in"], outputs) == []


def test_no_secret_is_in_the_library(escape_run: EscapeRun) -> None:
    pictures = set()
    for name in ("library", "library_of_zip"):
        for path, data in tree(escape_run.folder / name).items():
            assert data is None or SECRET.encode() not in data, path
            if path.endswith(".png"):
                pictures.add(Path(path).parent.name)
    assert "textures" not in pictures, "all pictures of these inputs lie outside"


def test_every_input_has_its_verdict_and_what_was_not_followed_is_told(escape_run: EscapeRun) -> None:
    assert not [one for one in escape_run.said.values() if one.code.startswith("RUN00") and one.code != "RUN006"]
    refused = {path: one.code for path, one in escape_run.said.items() if not one.accepted}
    for number in range(17):
        assert refused[f"buffer_{number:02d}.gltf"] in ("SRC016", "SRC017", "SRC018", "SRC020"), number
    for name in ("entity_file", "entity_parameter", "doctype_http", "doctype_file", "laughs"):
        assert refused[f"{name}.dae"] == "SRC022"
    for name in ("linked.obj", "link_secret.obj"):
        assert refused[name] == "SRC018"
    assert refused["slip.zip"] == "SRC016", "an archive is looked into, in a folder too"
    assert refused["slip.zip:SRC016"] == "SRC016", "and where it is named itself"
    taken = {path for path, one in escape_run.said.items() if one.accepted}
    assert {"libraries.obj", "pictures.obj", "images.gltf", "stylesheet.dae", "include.dae", "picture.ply"} <= taken
    for name in ("libraries.obj", "pictures.obj", "images.gltf", "picture.ply", "stylesheet.dae"):
        assert {"SRC041", "SRC046"} & set(escape_run.said[name].warnings), name
    assert "SRC055" in escape_run.said["libraries.obj"].warnings
    codes = sorted(one.code for one in escape_run.said.values() if one.path == "manifest.jsonl")
    assert set(codes) <= {"MAN003", "SRC016", "SRC018", "SRC017", "SRC020"}
    assert {"MAN003", "SRC016", "SRC018"} <= set(codes)

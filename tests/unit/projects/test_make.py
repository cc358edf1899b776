"""`casa-assets init` writes a project that `casa-assets make` makes; slips in its runs are told with their lines."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import casa_assets
from casa_assets.errors import CasaError
from tests.support.library.libraries import ROOT
from tests.support.library.libraries import called as casa
from tests.support.library.pictures import write_pictures


def test_a_starter_shows_its_commands_and_is_not_written_over(tmp_path: Path) -> None:
    done = casa("init", "My kitchens", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "cd 'My kitchens' && casa-assets make" in done.stderr
    starter = tmp_path / "My kitchens"
    done = casa("make", "--dry-run", "--json", folder=starter)
    assert done.returncode == 0, done.stderr
    assert [json.loads(line)["id"] for line in done.stdout.splitlines()] == [
        "casa-assets scenes build --out=out/scenes -- loft__workshop",
        "casa-assets scenes check --out=out/scenes -- loft__workshop",
        "casa-assets families build --library=out/library -- hob",
        "casa-assets objects build --count=4 --library=out/library -- enamel_mug",
    ]
    assert not (starter / "out").exists()
    settings = starter / "casa.yaml"
    settings.write_text("name: ours\n", encoding="utf-8")
    (starter / "limits.yaml").unlink()
    done = casa("init", starter, folder=starter.parent)
    assert done.returncode == 2
    assert all(words in done.stderr for words in ("casa.yaml", "is there already"))
    assert settings.read_text(encoding="utf-8") == "name: ours\n"
    assert not (starter / "limits.yaml").exists()


def test_an_option_may_be_switched_off(tmp_path: Path) -> None:
    runs = "  - families build: {names: [hob], library: out/library, pictures: false, all: true}\n"
    (tmp_path / "casa.yaml").write_text(f"name: ours\nruns:\n{runs}", encoding="utf-8")
    done = casa("make", "--dry-run", "--json", folder=tmp_path)
    command = json.loads(done.stdout)["id"]
    assert command == "casa-assets families build --library=out/library --no-pictures --all -- hob"


WALLS = "  - textures make: {names: [stucco_white], out: out/walls, width-px: 64}\n"


def test_commands_are_called_in_the_folder_of_the_project(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "ours"
    folder.mkdir()
    (folder / "casa.yaml").write_text(f"name: ours\nruns:\n{WALLS}  - find: {{query: mug}}\n", encoding="utf-8")
    done = casa("make", "--project", folder, "--quiet", folder=tmp_path, PYTHONPATH=str(ROOT))
    assert len(list((folder / "out" / "walls").rglob("*.png"))) == 3
    assert done.returncode == 2, "there is no library in which to find anything"
    assert "does not exist" in capfd.readouterr().err, "each is a process"


def test_from_python(tmp_path: Path) -> None:
    """Each run with what it made; one that something was left out of is told, one that cannot work is an error."""
    folder = tmp_path / "ours"
    write_pictures(folder / "pictures", 1)
    (folder / "pictures" / "broken.png").write_bytes(b"no picture")
    pack = "  - textures ingest: {source: pictures, surface: wall, tile: [1, 1], licence: CC0-1.0}\n"
    (folder / "casa.yaml").write_text(f"name: ours\nruns:\n{WALLS}{pack}", encoding="utf-8")
    project = casa_assets.Project(folder)
    first, second = project.make()
    assert (first.passed, first.exit_code) == (True, 0)
    assert first.command == "casa-assets textures make --out=out/walls --width-px=64 -- stucco_white"
    assert [row["id"] for row in first.rows] == ["stucco_white"]
    assert len(list((folder / "out" / "walls").rglob("*.png"))) == 3
    assert (second.passed, second.exit_code) == (False, 1)
    assert [row["verdict"] for row in second.rows] == ["accepted", "rejected"]
    (folder / "casa.yaml").write_text(f"name: ours\nruns:\n  - find: {{query: mug}}\n{pack}")
    with pytest.raises(CasaError, match=r"^casa-assets find .*: .*does not exist"):
        project.make()
    with pytest.raises(CasaError, match=r"it has no casa\.yaml; write one with"):
        casa_assets.Project(tmp_path / "nowhere")


def test_slips_in_the_runs_are_told(tmp_path: Path) -> None:
    for runs, message in [
        ("[{ingst: {}}]", "casa.yaml:2: runs.0.ingst: expected 'ingest', or another one of"),
        ("[{scenes build: {scense: [a]}}]", "casa.yaml:2: runs.0.scenes build.scense: expected 'scenes', or another"),
        ("[{scenes build: {all: 3}}]", "casa.yaml:2: runs.0.scenes build.all: expected true or false, got 3"),
        ("[{scenes build: {scenes: [[a]]}}]", "casa.yaml:2: runs.0.scenes build.scenes: expected a text or a number"),
        ("[{textures ingest: {tile: 1.2}}]", "casa.yaml:2: runs.0.textures ingest.tile: expected 2 values, got 1.2"),
        ("[]", "casa.yaml: lists no runs"),
    ]:
        (tmp_path / "casa.yaml").write_text(f"name: ours\nruns: {runs}\n", encoding="utf-8")
        done = casa("make", folder=tmp_path)
        assert done.returncode == 2, runs
        assert message in done.stderr

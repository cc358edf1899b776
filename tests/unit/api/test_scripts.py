"""The package from scripts in a fresh folder, in which nothing appears; three of them are processes without a guard."""

from __future__ import annotations

import io
import os
import subprocess
import sys
import textwrap
from contextlib import chdir, redirect_stdout
from pathlib import Path

import pytest

from tests.support.library.libraries import ROOT, no_workers

pytestmark = pytest.mark.content("code", "api", keep=0)

MUG = ROOT / "examples" / "meshes" / "mug.obj"
OVEN = ROOT / "examples" / "appliances" / "oven.glb"


def run(code: str, place: Path, *, cache: Path | None = None, notebook: bool = False) -> str:
    """Standard output of a script that runs in `place/work`, which has to stay empty.

    Args:
        cache: of built things; None: the one that all tests share.
        notebook: run it by `exec` in a module `__main__` without a file, as a notebook runs its cells.
    """
    work = place / "work"
    work.mkdir(exist_ok=True)
    script = place / "script.py"
    script.write_text(textwrap.dedent(code), encoding="utf-8")
    start = f"exec(compile(open({str(script)!r}).read(), '<cell>', 'exec'))"
    done = subprocess.run(
        [sys.executable, "-c", start] if notebook else [sys.executable, str(script)],
        cwd=work,
        env={**os.environ, "PYTHONPATH": str(ROOT), **({"CASA_ASSETS_CACHE": str(cache)} if cache else {})},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert list(work.iterdir()) == []
    return done.stdout


def here(code: str, place: Path) -> str:
    """As `run`, in this process."""
    work = place / "work"
    work.mkdir(exist_ok=True)
    with no_workers(), chdir(work), redirect_stdout(io.StringIO()) as said:
        exec(compile(textwrap.dedent(code), "<script>", "exec"), {"__name__": "script"})
    assert list(work.iterdir()) == []
    return said.getvalue()


# In a fresh cache all of a kitchen is made.
@pytest.mark.parametrize("notebook", [True, pytest.param(False, marks=pytest.mark.certify)])
def test_kitchen(tmp_path: Path, notebook: bool) -> None:
    code = """
        import casa_assets as casa

        kitchen = casa.kitchen("one_wall_small", "scandinavian", seed=3, surfaces={"floor": "oak_ebony"})
        model, spec = kitchen.to_mjmodel(), kitchen.with_detail("light").to_mjspec()
        robot = spec.worldbody.add_body(name="robot")
        robot.add_geom(size=[0.1, 0, 0])
        robot.add_freejoint()
        print(kitchen.id, model.nkey, spec.compile().body("robot").id > 0, len(kitchen.scene.placements) > 20)
        import multiprocessing
        print(multiprocessing.active_children())
    """
    fresh = None if notebook else tmp_path / "cache"
    told = run(code, tmp_path, cache=fresh, notebook=notebook).splitlines()
    assert told[0].startswith("one_wall_small__scandinavian__s3__t")
    assert told[0].endswith(" 3 True True")
    assert told[1] == "[]"
    assert fresh is None or fresh.is_dir()


def test_one_asset(tmp_path: Path) -> None:
    code = """
        import casa_assets as casa

        drawn = casa.build("microwave", seed=1)
        assert drawn == casa.build("microwave", seed=1) != casa.build("microwave", seed=1, index=1)
        named = casa.build("microwave", "steel", width=0.6)
        assert named.to_mjmodel().nlight > named.to_mjspec().compile().nlight == 0, "one stands on a lit floor"
        print(named.check().passed, drawn.check().passed, round(float(named.to_trimesh().extents[0]), 1))
        print(casa.build("jar") == casa.build("objects/jar"), casa.build("apple", seed=2) == casa.build("apple"))
        print(casa.build("plant", "basil", seed=3) == casa.build("plant", "basil", seed=4))
    """
    assert here(code, tmp_path).splitlines() == ["True True 0.6", "False False", "False"]


@pytest.mark.parametrize("notebook", [False, pytest.param(True, marks=pytest.mark.certify)])
def test_ingest(tmp_path: Path, notebook: bool) -> None:
    code = f"""
        import casa_assets as casa

        done = casa.ingest({str(MUG)!r}, category="mug")
        print(done.accepted, done.rejection, done.report.passed, done.folder, len(done.asset.root.colliders) > 4)
    """
    assert run(code, tmp_path, notebook=notebook) == "True None True None True\n"


def test_articulate(tmp_path: Path) -> None:
    code = f"""
        import casa_assets as casa

        done = casa.articulate({str(OVEN)!r}, category="wall_oven")
        print(done.rejection is None, sorted(j.kind.value for j in done.asset.joints)[0])
    """
    assert run(code, tmp_path) == "True hinge\n"


def test_library_of_meshes_in_memory(tmp_path: Path) -> None:
    broken = tmp_path / "broken.obj"
    broken.write_text("o nothing\n", encoding="utf-8")
    code = f"""
        import trimesh
        import casa_assets as casa

        board = trimesh.creation.box(extents=(0.3, 0.2, 0.02))
        bottle = trimesh.Scene([trimesh.creation.cylinder(0.03, 0.2)])
        bottle.metadata["name"] = "bottle"
        library = casa.Library({str(tmp_path / "library")!r})
        named = casa.MeshInput(board, "my board", category="cutting_board", up="z")
        for _ in range(2):
            results = library.ingest([named, trimesh.Trimesh()], bottle, {str(broken)!r}, jobs=1)
            for result in sorted(results, key=lambda result: result.source):
                assert (result.asset_id is None) == (result.status == "rejected") == bool(result.reasons), result
                is_kept = result.folder is not None and result.folder.is_dir()
                print(result.source, result.status, is_kept, *(reason.code for reason in result.reasons))
        assert sorted(entry.category for entry in library) == ["bottle", "cutting_board"]
        done = casa.ingest(board, "cutting_board", name="my board", up="z", library=library.path)
        assert done.asset == casa.ingest(board, "cutting_board", name="my board", up="z").asset
        assert (done.accepted, done.folder.is_dir(), len(library)) == (True, True, 2)
        (found,) = library.search("bottle")
        assert found.id in library and casa.load(library.folder(found.id)) == library.get(found.id)
        misspelt = casa.MeshInput(board, category="cuting_board")
        for wrong in (lambda: library.get("mog_0123456789"), lambda: list(library.ingest(misspelt))):
            try:
                wrong()
            except casa.UnknownId as error:
                print(isinstance(error, casa.CasaError), "cutting_board" in error.nearest)
    """
    told = here(code, tmp_path).splitlines()
    rejects = ["broken.obj rejected True SRC001", "mesh rejected False SRC012"]
    assert told[:4] == ["bottle accepted True", *rejects, "my board accepted True"]
    assert told[4:] == ["bottle skipped True", *rejects, "my board skipped True", "True False", "True True"]

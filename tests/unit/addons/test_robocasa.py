"""A library becomes a folder of objects whole or not at all, and says why where it does not."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from casa_assets.addons.robocasa.run import ExportResult, export
from casa_assets.errors import OutputError
from casa_assets.library.entry_files import CERTIFICATE
from casa_assets.model.asset.asset import Split, split_of
from tests.support.library.built_libraries import TEST, TRAIN, keep, loose_and_fixed, slice_of_bread
from tests.support.library.libraries import differences, tree

SLICES = [f"sandwich_bread_{digest[:10]}" for digest in (TRAIN, TEST)]


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return keep(tmp_path_factory.mktemp("library") / "lib", loose_and_fixed())


@pytest.fixture
def library(source: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(source, tmp_path / "lib"))


def run(library: Path, out: Path, name: str = "casa") -> list[ExportResult]:
    return list(export(library, out, name))


def test_every_loose_object_is_there_and_books_agree(library: Path, tmp_path: Path) -> None:
    out = tmp_path / "new" / "out"
    every = run(library, out, "acme")
    assert [one.id for one in every if not one.model] == ["microwave_0123456789"]
    assert "fixture" in next(one.message for one in every if not one.model)
    done = {one.id: one for one in every if one.model}
    models = sorted(path.relative_to(out).as_posix() for path in out.rglob("model.xml"))
    assert models == sorted(one.model for one in done.values())
    assert sorted(path.parent.name for path in out.rglob("model_upright.xml")) == SLICES
    assert {path.name for path in out.iterdir()} == {
        *("objects", "categories_v0_2.json", "categories_v1_0.json", "export.json", "splits.json"),
        *("casa_objects.py", "README.md", "ATTRIBUTION.md"),
    }
    assert [p.name for p in out.parent.iterdir()] == ["out"]
    rows = {row["id"]: row for row in json.loads((out / "export.json").read_text())["assets"]}
    splits = json.loads((out / "splits.json").read_text())
    assert rows.keys() == done.keys() == {*splits["train"], *splits["test"]}
    assert splits["train"] == [SLICES[0]]
    assert all(row["split"] == split_of(row["sha256"]).value for row in rows.values())
    assert rows[SLICES[0]]["mass_kg"] == 0.04
    assert rows[SLICES[0]]["size_m"] == [0.12, 0.11, 0.0145]
    assert rows[SLICES[0]]["model"].startswith("objects/acme/sandwich_bread/")
    for generation in ("v0_2", "v1_0"):
        table = json.loads((out / f"categories_{generation}.json").read_text())
        assert set(table) == {row["category"] for row in rows.values()}
        assert table["mug"]["acme"]["model_folders"] == ["acme/mug"]
    assert "5 objects in 4 categories (1 train, 4 test)" in (out / "README.md").read_text()
    assert SLICES[0] in (out / "ATTRIBUTION.md").read_text()
    assert "microwave" not in (out / "ATTRIBUTION.md").read_text()


def test_the_same_library_gives_the_same_bytes_and_an_earlier_export_is_replaced(library: Path, tmp_path: Path) -> None:
    out = tmp_path / "a"
    run(library, out)
    run(library, tmp_path / "b")
    assert differences(out, tmp_path / "b") == []
    shutil.rmtree(library / "mug")
    run(library, out)
    assert not (out / "objects" / "casa" / "mug").exists()
    assert (out / "objects" / "casa" / "orange").exists()


def test_an_instance_never_changes_sides(library: Path, tmp_path: Path) -> None:
    """Nor does its folder, whoever else comes or goes."""
    before = {one.id: one for one in run(library, tmp_path / "a")}
    keep(library, [slice_of_bread(f"{i:08x}" * 8) for i in range(20, 24)])
    after = {one.id: one for one in run(library, tmp_path / "b")}
    assert len(after) == len(before) + 4
    assert {name: (after[name].split, after[name].model) for name in before} == {
        name: (one.split, one.model) for name, one in before.items()
    }
    # Splits follow the digest alone.
    sides = [split_of(f"{i:08x}" + "0" * 56) for i in range(1000)]
    assert sides.count(Split.TEST) == 200
    assert split_of(TRAIN) is Split.TRAIN
    assert split_of(TEST) is Split.TEST


def corrupt(folder: Path, how: str) -> str:
    """Name of the file that is then complained of."""
    model, certificate = folder / "model.xml", folder / CERTIFICATE
    text = certificate.read_text()
    {
        "gone": model.unlink,
        "changed": lambda: model.write_text("<mujoco/>"),
        "cut": lambda: certificate.write_text(text[: len(text) // 2]),
        "no asset": lambda: certificate.write_text("{}"),
        "moved": lambda: folder.rename(folder.with_name("mug_other")),
    }[how]()
    return "model.xml" if how in ("gone", "changed") else CERTIFICATE


@pytest.mark.parametrize("how", ["gone", "changed", "cut", "no asset", "moved"])
def test_a_damaged_entry_is_named_and_nothing_is_written(library: Path, tmp_path: Path, how: str) -> None:
    out = tmp_path / "out"
    run(library, out)
    before = tree(out)
    named = corrupt(library / "mug" / "mug_0123456789", how)
    if how == "gone":
        out.rename(tmp_path / ".out.4194305.old")  # as a run leaves it that is killed between its two renames
    with pytest.raises(OutputError, match=named):
        run(library, out)
    assert tree(out) == before
    assert sorted(p.name for p in tmp_path.iterdir()) == ["lib", "out"]


def test_a_folder_that_is_no_library_or_holds_fixtures_alone(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    for folder in ("empty", "missing"):
        with pytest.raises(OutputError, match="holds no accepted asset"):
            run(tmp_path / folder, tmp_path / "out")
    for name in ("", "Casa", "a/b", "..", "a__b", "1st", "a b"):
        with pytest.raises(OutputError, match="no name of a registry"):
            list(export(None, tmp_path / "out", name))
    library = keep(tmp_path / "lib", [loose_and_fixed()[-1]])
    with pytest.raises(OutputError, match="no loose object"):
        run(library, tmp_path / "out")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["empty", "lib"]


def test_what_is_not_ours_is_left_alone(library: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    run(library, out)
    (out / "__pycache__").mkdir()
    run(library, out)
    assert not (out / "__pycache__").exists()
    (out / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"notes\.txt"):
        run(library, out)
    assert (out / "notes.txt").read_text() == "mine"
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "cat.png").write_bytes(b"cat")
    (tmp_path / "file").write_bytes(b"mine")
    (tmp_path / "link").symlink_to(tmp_path / "photos")
    for place in ("photos", "file", "link", "lib", "lib/sub", "."):
        with pytest.raises(OutputError, match="name another"):
            run(library, tmp_path / place)
    assert (tmp_path / "photos" / "cat.png").read_bytes() == b"cat"
    assert (tmp_path / "file").read_bytes() == b"mine"


def test_a_run_that_is_broken_off_leaves_nothing_and_what_a_killed_one_left_is_swept(
    library: Path, tmp_path: Path
) -> None:
    running = export(library, tmp_path / "out")
    next(running)
    assert len(list(tmp_path.iterdir())) == 2
    running.close()
    assert [p.name for p in tmp_path.iterdir()] == ["lib"]
    (tmp_path / ".out.4194305").mkdir()  # above the greatest number that Linux gives a process
    run(library, tmp_path / "out")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["lib", "out"]

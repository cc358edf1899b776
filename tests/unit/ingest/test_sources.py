"""What is found in folders and packages, and what an input may reach on disk."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from unittest.mock import Mock

import pytest

from casa_assets.errors import CasaError, Rejected, UnknownId
from casa_assets.ingest.sources import objaverse
from casa_assets.ingest.sources.discover import collect, discover
from casa_assets.ingest.sources.places import Found
from casa_assets.ingest.sources.rows import spdx_id
from casa_assets.model import rejection_codes
from casa_assets.model.source import SourceKind
from tests.support.mesh.mesh_files import LIMITS, OBJ_TRIANGLE, QUARTERS, Gltf, codes_of, inputs_of, load_path, png

UID = "0" * 31 + "1"


def write(path: Path, data: bytes | str | object) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    if not isinstance(data, (bytes, str)):
        data = json.dumps(data)
    path.write_bytes(data.encode() if isinstance(data, str) else data)
    return path


def refusals(root: Path) -> list[str]:
    return [one.code for one in inputs_of(root)[1]]


def found(root: Path) -> dict[str, Found]:
    return {one.source.path: one for one in inputs_of(root)[0]}


def test_folder_yields_meshes_only_sorted_and_with_hints(tmp_path: Path) -> None:
    others = "a.glb b/x.mtl b/x.png README.md .hidden/y.obj __MACOSX/z.obj b/p.json"
    for name in ("b/Tea Pot.OBJ", *others.split()):
        write(tmp_path / name, OBJ_TRIANGLE)
    assert list(found(tmp_path)) == ["a.glb", "b/Tea Pot.OBJ"]
    source = found(tmp_path)["b/Tea Pot.OBJ"].source
    assert (source.kind, source.hints[:2], source.licence) == (SourceKind.FOLDER, ("Tea Pot", "b"), "unknown")
    assert refusals(tmp_path) == []


def test_objaverse_package(tmp_path: Path) -> None:
    root = tmp_path / "objaverse"
    write(root / f"glbs/000-041/{UID}.glb", Gltf().glb())
    entry = {"name": "Old Mug", "license": "by-nc-sa", "tags": [{"name": "cup"}], "user": {"displayName": "An\nn"}}
    write(root / "annotations.json", {UID: {**entry, "uid": "../../etc", "uri": "https://x"}})
    write(root / "lvis-annotations.json", {"mug": [UID], "zebra": [UID]})
    paths = {UID: f"glbs/000-041/{UID}.glb", "gone": "glbs/0/gone.glb", "evil": "../../x.glb"}
    write(root / "object-paths.json", paths)
    write(root / "loose/spoon.stl", OBJ_TRIANGLE)
    inputs = found(tmp_path)
    assert list(inputs) == [f"objaverse/glbs/000-041/{UID}.glb", "objaverse/loose/spoon.stl"]
    one = inputs[f"objaverse/glbs/000-041/{UID}.glb"]
    source = one.source
    assert (one.root, one.main) == (root, f"glbs/000-041/{UID}.glb")
    assert (source.kind, source.uid, source.title) == (SourceKind.OBJAVERSE, UID, "Old Mug")
    assert (source.licence, source.author, source.category) == ("CC-BY-NC-SA-4.0", "An?n", "mug")
    assert source.hints == ("Old Mug", "cup")
    assert sorted(refusals(tmp_path)) == [rejection_codes.PATH_TRAVERSAL, rejection_codes.MISSING_FILE]


def test_objaverse_xl_list(tmp_path: Path) -> None:
    write(tmp_path / "me__repo/1a/cup.obj", OBJ_TRIANGLE)
    row = {"fileIdentifier": "https://g/cup.obj", "source": "github", "license": "MIT License", "fileType": "obj"}
    rows = [{**row, "sha256": "ab", "name": "A cup", "path": "me__repo/1a/cup.obj"}, {**row, "path": "../x.obj"}, 3]
    write(tmp_path / "annotations.json", rows)
    (one,) = found(tmp_path).values()
    assert (one.source.kind, one.source.licence) == (SourceKind.OBJAVERSE_XL, "MIT")
    assert (one.source.uri, one.source.hints) == ("https://g/cup.obj", ("A cup", "cup", "1a", "me__repo"))
    assert refusals(tmp_path) == [rejection_codes.PATH_TRAVERSAL, rejection_codes.BAD_ROW]


def test_text_to_3d_manifest_and_plain_manifest(tmp_path: Path) -> None:
    write(tmp_path / "t/a/model.glb", Gltf().glb())
    write(tmp_path / "p/toaster.obj", OBJ_TRIANGLE)
    row = {"id": "a1", "prompt": "a red mug", "category": "mug", "generator": "G", "license": "MIT"}
    row["file"] = "a/model.glb"
    write(tmp_path / "t/manifest.jsonl", b"\xef\xbb\xbf" + json.dumps(row).encode() + b"\r\n\r\n")
    write(tmp_path / "p/list.json", [{"id": "t1", "name": "Toaster", "file": "toaster.obj", "category": "toaster"}])
    inputs = found(tmp_path)
    made, plain = inputs["t/a/model.glb"].source, inputs["p/toaster.obj"].source
    assert (made.kind, made.uid, made.prompt) == (SourceKind.TEXT_TO_3D, "a1", "a red mug")
    assert (made.generator, made.category, made.licence) == ("G", "mug", "MIT")
    assert (plain.kind, plain.uid, plain.title) == (SourceKind.MANIFEST, "t1", "Toaster")
    assert len(inputs) == 2
    assert refusals(tmp_path) == []


def test_bad_rows_are_listed_with_their_line_and_the_others_go_on(tmp_path: Path) -> None:
    write(tmp_path / "m.obj", OBJ_TRIANGLE)
    good = '{"id": "%s", "file": "m.obj", "seed": ' + "9" * 5000 + ', "scale": 1e999, "x": NaN}'
    rows = [
        (good % "one", ""),
        (good % "one", rejection_codes.DUPLICATE_ID),
        ('{"id": "cut", "fi', rejection_codes.BAD_ROW),
        ("[1, 2]", rejection_codes.BAD_ROW),
        ("null", rejection_codes.BAD_ROW),
        ('{"id": "b", "file": "gone.obj"}', rejection_codes.MISSING_FILE),
        ('{"id": "c", "file": "../../etc/passwd"}', rejection_codes.PATH_TRAVERSAL),
        ('{"id": "d", "file": "/etc/passwd"}', rejection_codes.PATH_TRAVERSAL),
        ('{"id": "e", "file": "C:\\\\x.obj"}', rejection_codes.PATH_TRAVERSAL),
        ('{"id": "../e", "file": "m.obj"}', rejection_codes.BAD_ID),
        ('{"id": 17, "file": ["m.obj"]}', rejection_codes.BAD_ROW),
        ('{"id": "f", "file": "m.obj", "prompt": ["a"]}', rejection_codes.BAD_ROW),
        ('{"id": "g", "file": "m\\u0000.obj"}', rejection_codes.BAD_ROW),
        ('{"id": "h", "file": "\\ud800.obj"}', rejection_codes.BAD_NAME),
        ('{"id": "i", "x": ' + "[" * 100_000, rejection_codes.BAD_ROW),
        (good % "two", ""),
    ]
    write(tmp_path / "set.jsonl", "\n".join(row for row, _ in rows))
    good_rows, refused = inputs_of(tmp_path)
    assert [one.code for one in refused] == [code for _, code in rows if code]
    lines = [i for i, (_, code) in enumerate(rows, start=1) if code]
    assert all(f"line {line}:" in one.message for line, one in zip(lines, refused, strict=True))
    assert [one.source.uid for one in good_rows] == ["one", "two"]


def test_a_manifest_that_the_user_names_must_be_one(tmp_path: Path) -> None:
    write(tmp_path / "m.obj", OBJ_TRIANGLE)
    assert refusals(write(tmp_path / "x.json", {"a": 1})) == [rejection_codes.BAD_MANIFEST]
    assert refusals(write(tmp_path / "y.json", "{")) == [rejection_codes.BAD_MANIFEST]
    assert len(found(write(tmp_path / "z.json", [{"id": "a", "file": "m.obj"}]))) == 1
    assert refusals(tmp_path) == []


def test_what_is_no_file_is_refused_and_never_opened(tmp_path: Path) -> None:
    root, outside = tmp_path / "in", tmp_path / "out"
    write(outside / "far.obj", OBJ_TRIANGLE)
    root.mkdir()
    os.mkfifo(root / "a_pipe.obj")
    (root / "b_dir.glb").mkdir()
    (root / "c_out.obj").symlink_to(outside / "far.obj")
    (root / "d_loop.obj").symlink_to("d_loop.obj")
    (root / "e_dev.stl").symlink_to("/dev/zero")
    (root / "f_loop").symlink_to(".")
    (root / "g_far").symlink_to(outside)
    write(Path(os.fsdecode(os.fsencode(root) + b"/h_\xff.glb")), b"x")
    no_file, outside_link = rejection_codes.NOT_A_FILE, rejection_codes.LINK_OUTSIDE
    assert refusals(root) == [no_file, no_file, outside_link, no_file, outside_link, rejection_codes.BAD_NAME]
    assert found(root) == {}
    assert refusals(root / "b_dir.glb") == [rejection_codes.NOT_A_FILE]
    assert refusals(tmp_path / "nowhere") == [rejection_codes.MISSING_FILE]
    for one in inputs_of(root)[1]:
        one.path.encode("utf-8")


def test_size_is_refused_without_reading_and_two_roots_are_no_two_inputs(tmp_path: Path) -> None:
    path = write(tmp_path / "a/x.glb", b"glTF")
    os.truncate(path, 20 * 1024**3)
    (one,) = discover([tmp_path, path, tmp_path / "a"])
    assert isinstance(one, Found)
    with pytest.raises(Rejected, match=rejection_codes.TOO_LARGE):
        collect(one, LIMITS)


def obj_with_map(root: Path, name: str) -> Path:
    write(root / "m.mtl", f"newmtl m\nmap_Kd {name}\n")
    return write(root / "x.obj", "vt 0 0\nmtllib m.mtl\nusemtl m\n" + OBJ_TRIANGLE.replace("f 1 2 3", "f 1/1 2/1 3/1"))


def test_pictures_are_found_inside_the_package_only(subtests: pytest.Subtests, tmp_path: Path) -> None:
    cases = [
        ("my tex.png", "my tex.png", ""),
        ("-o 0 0 0 -bm 1 my tex.png", "my tex.png", ""),
        ("my%20tex.png", "my tex.png", ""),
        ("sub\\tex.png", "sub/tex.png", ""),
        ("Tex.PNG", "tex.png", rejection_codes.CASE_MISMATCH),
        ("C:\\Users\\bob\\tex.png", "tex.png", rejection_codes.FOUND_BY_BASE_NAME),
        ("/srv/bob/tex.png", "textures/tex.png", rejection_codes.FOUND_BY_BASE_NAME),
        ("gone.png", "", rejection_codes.REFERENCE_MISSING),
        ("../../../etc/passwd", "", rejection_codes.REFERENCE_IGNORED),
        ("..%2f..%2f..%2fetc/passwd", "", rejection_codes.REFERENCE_IGNORED),
        ("/etc/passwd", "", rejection_codes.REFERENCE_IGNORED),
        ("file:///etc/passwd", "", rejection_codes.REFERENCE_IGNORED),
        ("http://127.0.0.1:9/t.png", "", rejection_codes.REFERENCE_IGNORED),
        ("\\\\127.0.0.1\\share\\t.png", "", rejection_codes.REFERENCE_IGNORED),
        ("/dev/zero", "", rejection_codes.REFERENCE_IGNORED),
    ]
    for number, (written, there, code) in enumerate(cases):
        with subtests.test(written=written, there=there, code=code):
            root = tmp_path / str(number) / "package"
            path = obj_with_map(root, written)
            if there:
                write(root / there, png(QUARTERS))
            model = load_path(path)
            assert (model.parts[0].material.base_color_texture is not None) is bool(there)
            assert codes_of(model) == ({code} if code else set())


def test_links_out_of_the_package_are_not_followed(tmp_path: Path) -> None:
    root = tmp_path / "package"
    path = obj_with_map(root, "link.png")
    (root / "link.png").symlink_to(write(tmp_path / "secret.png", png(QUARTERS)))
    assert codes_of(load_path(path)) == {rejection_codes.LINK_IGNORED}
    (root / "link.png").unlink()
    (root / "far").symlink_to(tmp_path)
    assert codes_of(load_path(obj_with_map(root, "far/secret.png"))) == {rejection_codes.LINK_IGNORED}


def test_a_gltf_without_its_buffer_is_refused(subtests: pytest.Subtests, tmp_path: Path) -> None:
    for uri, code in [
        ("gone.bin", rejection_codes.MISSING_FILE),
        ("../../../../etc/passwd", rejection_codes.PATH_TRAVERSAL),
        ("%2e%2e/%2e%2e/%2e%2e/%2e%2e/etc/passwd", rejection_codes.PATH_TRAVERSAL),
        ("/etc/passwd", rejection_codes.PATH_TRAVERSAL),
        ("file:///etc/passwd", rejection_codes.PATH_TRAVERSAL),
        ("/dev/zero", rejection_codes.PATH_TRAVERSAL),
        ("http://127.0.0.1:9/x.bin", rejection_codes.NETWORK_URI),
    ]:
        with subtests.test(uri=uri, code=code):
            path = write(tmp_path / "x.gltf", Gltf().text(uri))
            with pytest.raises(Rejected, match=code):
                load_path(path)
    write(tmp_path / "my buffer.bin", Gltf().binary)
    assert load_path(write(tmp_path / "x.gltf", Gltf().text("my%20buffer.bin"))).format == "gltf"


def test_licence_words(subtests: pytest.Subtests) -> None:
    for word, licence in [
        ("by", "CC-BY-4.0"),
        ("by-nc-nd", "CC-BY-NC-ND-4.0"),
        ("CC-BY-4.0", "CC-BY-4.0"),
        ("cc by-sa 3.0", "CC-BY-SA-3.0"),
        ("Apache License 2.0", "Apache-2.0"),
        ("BSD-3-Clause", "BSD-3-Clause"),
        ("", "unknown"),
        ("my own words", "my own words"),
    ]:
        with subtests.test(word=word, licence=licence):
            assert spdx_id(word) == licence


def test_download_says_what_is_missing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "objaverse", None)
    with pytest.raises(CasaError, match="pip install objaverse"):
        objaverse.download(["a"], "", 1, tmp_path)
    fetched: list[str] = []
    fake = Mock(load_lvis_annotations=lambda: {"Mug": ["b", "a", "c"]}, load_objects=fetched.extend)
    fake.load_annotations.return_value = {}
    monkeypatch.setitem(sys.modules, "objaverse", fake)
    assert objaverse.download([], "mug", 2, tmp_path) == tmp_path / "hf-objaverse-v1"
    assert fetched == ["a", "b"]
    with pytest.raises(UnknownId, match="Mug"):
        objaverse.download([], "mugg", 2, tmp_path)
    fake.load_objects = Mock(side_effect=OSError("no route"))
    with pytest.raises(CasaError, match="network"):
        objaverse.download(["a"], "", 1, tmp_path)

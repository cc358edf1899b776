"""Shards of WebDataset: what the JSON of a sample says of its mesh, and what a shard may hold."""

from __future__ import annotations

import gzip
import io
import json
import tarfile
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from casa_assets.formats.read import load
from casa_assets.ingest.sources import archive
from casa_assets.ingest.sources.discover import collect
from casa_assets.model import rejection_codes as codes
from casa_assets.model.source import SourceKind
from tests.support.mesh.mesh_files import LIMITS, OBJ_TRIANGLE, inputs_of

OBJ = OBJ_TRIANGLE.encode()


def shard(*members: tuple[str, bytes | dict[str, Any]]) -> bytes:
    """A tar of members in their order; dictionaries are JSON."""
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w") as packed:
        for name, content in members:
            data = content if isinstance(content, bytes) else json.dumps(content).encode()
            info = tarfile.TarInfo(name)
            info.size = len(data)
            packed.addfile(info, io.BytesIO(data))
    return out.getvalue()


@pytest.mark.parametrize("suffix", ["tar", "tar.gz"])
def test_a_sample_is_what_its_json_says(tmp_path: Path, suffix: str) -> None:
    said = {"uid": "m7", "name": "Blue mug", "category": "mug", "license": "by", "tags": ["cup"], "author": "Ann"}
    data = shard(
        ("000001.obj", OBJ),
        ("000001.json", said),
        ("000001.txt", b"a mug"),
        ("000001.cls", b"3"),
        ("000001.png", b"no picture"),
        ("000002.json", {"title": "Kettle", "prompt": "a kettle", "__key__": "000002"}),
        ("000002.obj", OBJ + b"# 2\n"),
        ("000003.obj", OBJ + b"# 3\n"),
        ("000004.json", {"name": "no mesh"}),
    )
    (tmp_path / f"shard-000000.{suffix}").write_bytes(gzip.compress(data) if suffix == "tar.gz" else data)
    others: Counter[str] = Counter()
    found, refused = inputs_of(tmp_path, others)
    assert refused == []
    assert [one.source.path for one in found] == [f"shard-000000.{suffix}!00000{n}.obj" for n in (1, 2, 3)]
    mug, kettle, bare = (one.source for one in found)
    assert (mug.uid, mug.title, mug.category, mug.licence) == ("m7", "Blue mug", "mug", "CC-BY-4.0")
    assert (mug.author, mug.kind, mug.hints[:2]) == ("Ann", SourceKind.MANIFEST, ("Blue mug", "cup"))
    assert (kettle.uid, kettle.title, kettle.prompt, kettle.kind) == ("", "Kettle", "a kettle", SourceKind.TEXT_TO_3D)
    assert (bare.uid, bare.title, bare.kind) == ("", "", SourceKind.FOLDER)
    assert +others == {"texts": 1, "other files": 1, "pictures": 1, "tables and settings": 3}
    for one in found:
        assert len(load(collect(one, LIMITS), LIMITS).parts) == 1


def test_a_row_that_is_wrong_is_refused_alone(
    subtests: pytest.Subtests, tmp_path_factory: pytest.TempPathFactory
) -> None:
    for text, code in [
        (b"{broken", codes.BAD_ROW),
        (b"[1]", codes.BAD_ROW),
        (b'{"name": 7}', codes.BAD_ROW),
        (b'{"uid": "../../x"}', codes.BAD_ID),
        (b'{"uid": "taken"}', codes.DUPLICATE_ID),
        (b"[" * 100_000, codes.BAD_ROW),
        (b'{"name": "' + b"x" * (1 << 20) + b'"}', codes.TOO_LARGE),
    ]:
        with subtests.test(text=text, code=code):
            tmp_path = tmp_path_factory.mktemp("case")
            members = [("a.obj", OBJ), ("a.json", {"uid": "taken"}), ("b.obj", OBJ), ("b.json", text), ("c.obj", OBJ)]
            (tmp_path / "s.tar").write_bytes(shard(*members))
            found, refused = inputs_of(tmp_path)
            assert [one.main for one in found] == ["a.obj", "c.obj"]
            assert [(one.path, one.code) for one in refused] == [("s.tar", code)]
            assert refused[0].message.startswith("s.tar!b.json: ")


def test_the_json_of_a_shard_is_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(archive, "MAX_TEXTS_BYTES", 50)
    members = [
        (f"{n}.{kind}", content) for n in "abc" for kind, content in (("json", {"name": "x" * 20}), ("obj", OBJ))
    ]
    (tmp_path / "s.tar").write_bytes(shard(*members))
    found, refused = inputs_of(tmp_path)
    assert [one.main for one in found] == ["a.obj"]
    assert [one.code for one in refused] == [codes.TOO_LARGE] * 2


def test_a_member_is_read_where_it_begins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A worker reads one header, not those of all members before it."""
    (tmp_path / "s.tar").write_bytes(shard(*((f"{n:04}.obj", OBJ + b"# %d\n" % n) for n in range(300))))
    found, _ = inputs_of(tmp_path)
    headers: list[str] = []
    following = tarfile.TarFile.next

    def counted(archive: tarfile.TarFile) -> tarfile.TarInfo | None:
        info = following(archive)
        if info is not None:
            headers.append(info.name)
        return info

    monkeypatch.setattr(tarfile.TarFile, "next", counted)
    assert collect(found[250], LIMITS).files["0250.obj"].endswith(b"# 250\n")
    assert headers[0] == "0250.obj"
    # `next` returns the first member of each of the two archives twice, and reads it once.
    assert len(headers) - 2 == 301, "and the list of all, for an OBJ may have companions"


def test_a_tar_that_has_changed_is_searched(tmp_path: Path) -> None:
    (tmp_path / "s.tar").write_bytes(shard(("a.obj", OBJ), ("b.obj", OBJ)))
    found, _ = inputs_of(tmp_path)
    (tmp_path / "s.tar").write_bytes(shard(("x.obj", OBJ), ("y.obj", OBJ), ("b.obj", OBJ + b"# new\n")))
    assert collect(found[1], LIMITS).files["b.obj"].endswith(b"# new\n")

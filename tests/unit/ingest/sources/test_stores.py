"""Sources on stores: the same inputs and library as of the disk, within the same bounds, whatever the store does."""

from __future__ import annotations

import gzip
import json
import pickle
import time
from collections import Counter
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from fsspec.implementations.memory import MemoryFile

from casa_assets.cache import cache_key
from casa_assets.errors import CasaError, Rejected
from casa_assets.ingest.run.inputs import LIBRARY_FILES, discover_inputs, state_of
from casa_assets.ingest.run.run import Options, ingest
from casa_assets.ingest.run.shards import SHARD_FILE, Shard
from casa_assets.ingest.sources import stores
from casa_assets.ingest.sources.discover import collect, discover
from casa_assets.ingest.sources.places import Found, Refused, StoreRoot, hide_secrets, root_of
from casa_assets.library import attribution, library_report
from casa_assets.model import rejection_codes as codes
from tests.support.library.libraries import BOXES, box_obj
from tests.support.library.sharded_inputs import public_differences
from tests.support.library.source_stores import PROTOCOL, TrialSystem, put, web_server
from tests.support.mesh.format_files import tarred, zipped
from tests.support.mesh.mesh_files import LIMITS, OBJ_TRIANGLE, QUARTERS, Gltf, png

pytestmark = pytest.mark.content("code", "ingest.sources", keep=0)

OBJ = OBJ_TRIANGLE.encode()
WITH_MTL = (OBJ_TRIANGLE.replace("f ", "vt 0 0\nusemtl m\nf ") + "mtllib A.MTL\n").encode()
ROOT = f"{PROTOCOL}://data/things"


@pytest.fixture(autouse=True)
def sound(monkeypatch: pytest.MonkeyPatch) -> None:
    TrialSystem.begin()
    monkeypatch.setattr(stores, "PAUSE_S", 0.001)


def make_tree(root: Path) -> Path:
    """Every layout of sources, with companions, hidden files and defects."""
    uid = "0" * 31 + "1"
    obj = OBJ + b"# %d\n"
    files: dict[str, bytes] = {
        "b/Tea Pot.OBJ": WITH_MTL,
        "b/a.mtl": b"newmtl m\nKd 1 0 0\nmap_Kd textures/%41.png\n",
        "b/textures/A.png": png(QUARTERS),
        "b/.hidden.obj": OBJ,
        "a.glb": Gltf().glb(),
        "c/chair.max": b"",
        "c/half.glb": b"glTF\x02\0\0\0\xff\0\0\0",
        "c/empty.obj": b"",
        "robot/meshes/arm.obj": WITH_MTL.replace(b"A.MTL", b"../materials/arm.mtl"),
        "robot/materials/arm.mtl": b"newmtl m\nKd 0 1 0\n",
        "deliveries/manifest.jsonl": b'{"id": "x", "file": "y.obj", "name": "Pan"}\n{"id": "z", "file": "../a.glb"}\n',
        "deliveries/y.obj": obj % 1,
        f"objaverse/glbs/000-1/{uid}.glb": Gltf([(0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.0, 1.0, 0.0)]).glb(),
        "objaverse/metadata/000-1.json.gz": gzip.compress(json.dumps({uid: {"name": "Cup"}}).encode(), mtime=0),
        "pack.zip": zipped(**{"x/q.obj": obj % 2, "deep/w.obj": WITH_MTL, "deep/a.mtl": b"newmtl m\nKd 0 0 1\n"}),
        "shard.tar": gzip.decompress(tarred(**{"1.json": b'{"name": "Mug"}', "1.obj": obj % 3, "2.obj": obj % 4})),
        "shard.tar.gz": tarred(**{"1.json": b"{broken", "1.obj": obj % 5, "k.obj": obj % 6}),
        "cut.zip": b"PK\x03\x04",
        "per cent %41#?.obj": obj % 7,
    }
    for name, data in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_bytes(data)
    return root


def said(root: Path | StoreRoot) -> tuple[list[tuple[str, ...]], dict[str, int]]:
    """All that is found under a root and what becomes of it, in its order, and the counts of other files."""
    others: Counter[str] = Counter()
    out: list[tuple[str, ...]] = []
    for one in discover([root], others):
        if isinstance(one, Refused):
            out.append((one.path, one.code, one.message))
            continue
        try:
            bundle = collect(one, LIMITS)
            notes = [note.to_json() for note in bundle.notes]
            out.append((one.source.to_json(), bundle.sha256, bundle.main, *sorted(bundle.files), *notes))
        except Rejected as error:
            out.append((one.source.to_json(), error.code, error.message))
    return out, +others


@pytest.mark.parametrize(
    "place",
    ["", "b", "a.glb", "pack.zip", "shard.tar", "shard.tar.gz", "deliveries/manifest.jsonl", "robot/meshes/arm.obj"],
)
def test_a_store_and_a_web_server_give_what_the_disk_gives(tmp_path: Path, place: str) -> None:
    disk = make_tree(tmp_path / "data/things")
    on_disk, counts = said(disk / place)
    assert said(root_of(f"{put(disk)}/{place}")) == (on_disk, counts)
    assert len(on_disk) >= 1
    (disk / "b/.hidden.obj").unlink()  # counted alone
    with web_server(tmp_path) as url:
        on_store = said(root_of(f"{url}/data/things/{place}"))
    assert on_store == said(disk / place)


def test_a_web_server_without_parts_gives_loose_files(tmp_path: Path) -> None:
    make_tree(tmp_path / "data/things")
    with web_server(tmp_path, has_parts=False) as url:
        assert len(said(root_of(f"{url}/data/things/b"))[0]) == 1
        (refused,) = discover([root_of(f"{url}/data/things/pack.zip")])
    assert isinstance(refused, Refused)
    assert refused.code == codes.STORE_FAILED
    assert "gives no parts of files; download it" in refused.message


def found_on(url: str = ROOT) -> list[Found]:
    return [one for one in discover([root_of(url)]) if isinstance(one, Found)]


def write(**files: bytes) -> None:
    for name, data in files.items():
        TrialSystem().pipe_file(f"{ROOT}/{name.replace('__', '.')}", data)


def test_what_fails_twice_is_asked_for_again() -> None:
    write(a__obj=OBJ)
    (one,) = found_on()
    fails = [OSError("reset by peer"), TimeoutError("slow")]

    def before(name: str, path: str) -> None:
        if name == "cat_file" and fails:
            raise fails.pop()

    TrialSystem.before = staticmethod(before)
    assert collect(one, LIMITS).files["a.obj"] == OBJ
    assert fails == []


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (OSError("reset by peer"), codes.STORE_FAILED),
        (RuntimeError("throttled"), codes.STORE_FAILED),
        (FileNotFoundError("gone"), codes.MISSING_FILE),
        (PermissionError("denied"), codes.UNREADABLE),
    ],
)
def test_one_object_that_fails_takes_no_other_with_it(error: Exception, code: str) -> None:
    write(a__obj=OBJ, b__obj=OBJ)
    first, second = found_on()

    def before(name: str, path: str) -> None:
        if name == "cat_file" and path.endswith("a.obj"):
            raise error

    TrialSystem.before = staticmethod(before)
    with pytest.raises(Rejected) as refused:
        collect(first, LIMITS)
    assert refused.value.code == code
    assert f"{ROOT}/a.obj" in refused.value.message
    assert collect(second, LIMITS).files["b.obj"] == OBJ


def test_a_call_without_an_answer_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    write(a__obj=OBJ)
    (one,) = found_on()
    monkeypatch.setattr(stores, "REQUEST_S", 0.05)
    TrialSystem.before = staticmethod(lambda name, _path: time.sleep(0.3 if name == "cat_file" else 0))
    begin = time.monotonic()
    with pytest.raises(Rejected, match=f"{codes.STORE_FAILED}: .*no answer within"):
        collect(one, LIMITS)
    assert time.monotonic() - begin < 2.0


def test_a_part_of_an_object_is_not_taken_for_the_whole() -> None:
    write(a__obj=OBJ)
    (one,) = found_on()
    cuts = [1, 2]
    TrialSystem.changed = staticmethod(lambda _path, data: data[: -cuts.pop()] if cuts else data)
    assert collect(one, LIMITS).files["a.obj"] == OBJ
    TrialSystem.changed = staticmethod(lambda _path, data: data[:-1])
    with pytest.raises(Rejected, match=f"{codes.STORE_FAILED}: .*gave {len(OBJ) - 1} of {len(OBJ)} bytes"):
        collect(one, LIMITS)
    TrialSystem.changed = staticmethod(lambda _path, data: data + b"# more\n")
    with pytest.raises(Rejected, match="changed while it was being read"):
        collect(one, LIMITS)


def test_no_more_is_read_than_an_input_may_have(monkeypatch: pytest.MonkeyPatch) -> None:
    write(a__obj=OBJ + b"#" * 3000)
    (one,) = found_on()
    with pytest.raises(Rejected, match=codes.TOO_LARGE):
        collect(one, {**LIMITS, "input_bytes": 1000})
    assert TrialSystem.reads == []
    monkeypatch.setattr(stores, "PIECE_BYTES", 1000)
    for size in (999, 1000, 1001, 2000, 3500):
        write(a__obj=OBJ.ljust(size, b"#"))
        (one,) = found_on()
        TrialSystem.reads.clear()
        assert collect(one, LIMITS).files["a.obj"] == OBJ.ljust(size, b"#")
        assert max(end - start for _, start, end in TrialSystem.reads) <= 1001
        assert TrialSystem.reads[-1][2] == size + 1


def test_names_that_no_folder_can_hold_are_refused() -> None:
    system = TrialSystem()
    for path in ("../up.obj", "x/../../up.obj", "./a.obj", "b//c.obj", "d", "d/e.obj", "/".join("f" * 70) + ".obj"):
        system.store[f"/data/things/{path}"] = MemoryFile(system, path, OBJ)
    refused = {one.path: one.code for one in discover([root_of(ROOT)]) if isinstance(one, Refused)}
    assert refused["../up.obj"] == refused["x/../../up.obj"] == refused["./a.obj"] == codes.PATH_TRAVERSAL
    assert refused["b//c.obj"] == refused["d"] == codes.BAD_NAME
    assert codes.UNREADABLE in refused.values(), "folders nested too deep"
    assert [one.source.path for one in found_on()] == ["d/e.obj"]


def test_a_store_that_is_down_is_an_error() -> None:
    with pytest.raises(CasaError, match="check the store and the network"):
        list(discover([root_of("http://127.0.0.1:9/meshes")]))
    with pytest.raises(CasaError, match="doctor"):
        list(discover([root_of("nonsense://x/y")]))


def test_secrets_are_told_to_nobody(tmp_path: Path) -> None:
    url = "https://ann:pass@example.org/a/b.zip?X-Amz-Signature=secret&x=1"
    root = root_of(url)
    assert isinstance(root, StoreRoot)
    assert str(root) == "https://example.org/a/b.zip"
    told = [str(root / "c"), repr(root), str(root.parent), root.hide(f"failed: {url}!"), hide_secrets(url)]
    assert pickle.loads(pickle.dumps(root)).query == "?X-Amz-Signature=secret&x=1"
    make_tree(tmp_path / "data/things")
    log: list[str] = []
    with web_server(tmp_path, log=log) as place:
        address = place.replace("//", "//ann:pass@")
        every = list(discover([root_of(f"{address}/data/things/c/?key=secret")]))
        with pytest.raises(CasaError, match="nothing at this address") as error:
            list(discover([root_of(f"{address}/data/things/gone.glb?key=secret")]))
    for text in (*told, repr(every), str(error.value)):
        assert "pass" not in text
        assert "secret" not in text
    assert any("half.glb?key=secret" in line for line in log), "the server is given it"


def test_paths_and_addresses() -> None:
    for text, path in (("a/b.glb", "a/b.glb"), ("C:/x", "C:/x"), ("file:///a/b%20c", "/a/b c")):
        assert root_of(text) == Path(path)
    s3 = root_of("s3://bucket/a/b/")
    assert isinstance(s3, StoreRoot)
    shown = [str(s3), s3.name, str(s3 / "c" / "d"), (s3 / "c").name, str(s3.parent), str((s3 / "c").parent)]
    assert shown == ["s3://bucket/a/b", "b", "s3://bucket/a/b/c/d", "c", "s3://bucket/a", "s3://bucket/a/b"]


def states(one: Found) -> dict[str, str]:
    looked_at: set[str] = set()
    collect(one, LIMITS, looked_at)
    return {path: state_of(path) for path in looked_at}


def test_the_state_of_objects_changes_with_them() -> None:
    write(a__obj=WITH_MTL.replace(b"A.MTL", b"a.mtl"))
    (one,) = found_on()
    before = states(one)
    assert before[f"{ROOT}/a.mtl"] == ""
    assert before[f"{ROOT}/a.obj"].startswith("store ")
    (one,) = found_on()
    assert states(one) == before
    write(a__mtl=b"newmtl m\n")
    (one,) = found_on()
    assert states(one)[f"{ROOT}/a.mtl"] != ""
    write(a__obj=OBJ)
    (one,) = found_on()
    assert states(one)[f"{ROOT}/a.obj"] != before[f"{ROOT}/a.obj"]
    assert state_of(f"{PROTOCOL}://elsewhere/x") == stores.UNKNOWN


def test_a_library_on_a_store_is_no_source_below_a_root() -> None:
    assert LIBRARY_FILES == (library_report.NAME, attribution.NAME)
    write(a__obj=OBJ)
    for name in (*LIBRARY_FILES, "mug/mug_1/meshes/b.obj", "near.obj"):
        TrialSystem().pipe_file(f"{ROOT}/library/{name}", OBJ)
    TrialSystem().pipe_file(f"{ROOT}/other/{LIBRARY_FILES[0]}", b"")
    TrialSystem().pipe_file(f"{ROOT}/other/c.obj", OBJ)

    def paths(url: str) -> list[str]:
        inputs = discover_inputs([root_of(url)], Path("library"))
        return [one.source.path for one in inputs if isinstance(one, Found)]

    assert paths(ROOT) == ["a.obj", "other/c.obj"]
    assert paths(f"{ROOT}/library") == ["near.obj", "mug/mug_1/meshes/b.obj"]


def test_what_carries_bytes_takes_no_part_in_keys() -> None:
    packages = cache_key.reach("casa_assets.ingest.run.steps:work").packages
    assert "trimesh" in packages
    assert not {"fsspec", "s3fs", "aiohttp", "pyarrow"} & set(packages)


@pytest.mark.slow
@pytest.mark.content("code", "ingest.run", keep=0)
def test_a_run_over_a_store_makes_the_library_of_the_disk(tmp_path: Path) -> None:
    folder = tmp_path / "in/things"
    folder.mkdir(parents=True)
    said = json.dumps({"category": "cutting_board", "name": "Oak"}).encode()
    board = box_obj(BOXES["cutting_board"]).encode()
    shard = gzip.decompress(tarred(**{"1.json": said, "1.obj": board, "2.json": b"{", "2.obj": board + b"#\n"}))
    (folder / "shard-000000.tar").write_bytes(shard)
    # Refused without a mesh, refused once read, and refused for its form: nothing that takes long.
    pq.write_table(pa.table({"id": ["cut"], "glb": [b"glTF\x02\0\0\0\xff\0\0\0"]}), folder / "t.parquet")
    (folder / "sheet.obj").write_bytes(OBJ)
    disk = list(ingest([folder], Options(tmp_path / "disk", jobs=1)))
    assert sorted(event.kind for event in disk) == ["accepted", "rejected", "rejected", "rejected"]
    log: list[str] = []
    with web_server(tmp_path / "in", log=log) as url:
        roots = [root_of(f"{url.replace('//', '//ann:pass@')}/things/?key=secret")]
        events = list(ingest(roots, Options(tmp_path / "store", jobs=1)))
        assert [event.kind for event in events] == [event.kind for event in disk]
        assert public_differences(tmp_path / "disk", tmp_path / "store") == []
        log.clear()
        again = list(ingest(roots, Options(tmp_path / "store", jobs=1)))
        assert {event.kind for event in again} == {"kept"}
        assert not any(line.startswith('"GET') and "sheet.obj" in line for line in log), "read although it is known"
        list(ingest(roots, Options(tmp_path / "shard", jobs=1, shard=Shard(1, 1000))))
    assert url in (tmp_path / "shard" / SHARD_FILE).read_text()
    for path in tmp_path.rglob("*"):
        if path.is_file() and not path.is_relative_to(tmp_path / "in"):
            data = path.read_bytes()
            assert b"ann:pass" not in data, path
            assert b"key=secret" not in data, path

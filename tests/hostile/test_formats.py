"""Broken and hostile files of the formats that libraries read, and archives: each ends as it should, soon and small."""

from __future__ import annotations

import gzip
import io
import re
import resource
import struct
import tarfile
import time
import zipfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from casa_assets import registry
from casa_assets.errors import Rejected
from casa_assets.formats.read import load
from casa_assets.ingest.clean import clean
from casa_assets.ingest.sources.discover import collect, discover
from casa_assets.ingest.sources.places import Found, Refused
from casa_assets.model import rejection_codes as codes
from tests.support.hostile.access_audit import Watch
from tests.support.hostile.hostile_set import Said
from tests.support.library.libraries import casa, input_rows
from tests.support.mesh import format_files as made
from tests.support.mesh.mesh_files import OBJ_TRIANGLE, UASTC, Gltf

SOUND = "sound"
OUTSIDE = "/etc/passwd"


@dataclass(frozen=True)
class Hostile:
    """An input: its main file, what may become of it (`sound`, or a code), and the files beside it."""

    name: str
    data: bytes
    wanted: tuple[str, ...]
    beside: dict[str, bytes] = field(default_factory=dict)


# The same as a tuple: name, data, and what may become of it.
Row = Hostile | tuple[Any, ...]


def _usda(head: str = "", old: str = "", new: str = "") -> bytes:
    text = made.usda(head=head)
    assert old in text
    return (text.replace(old, new) if old else text).encode()


def _usd() -> Iterator[Row]:
    crate, broken = made.usdc(), (codes.SCENE_UNREADABLE, codes.TRUNCATED, codes.LENGTH_MISMATCH)
    at = crate.index(b"SPECS\0", 16)
    at = struct.unpack_from("<q", crate, at + 16)[0]
    yield "usd_lies_about_specs.usdc", crate[:at] + struct.pack("<Q", 2**33) + crate[at + 8 :], codes.LENGTH_MISMATCH
    yield "usd_cut.usdc", crate[: len(crate) // 2], *broken
    yield "usd_noise.usdc", b"PXR-USDC" + np.random.default_rng(1).bytes(4000), *broken
    yield "usd_lies_about_its_table.usdc", crate[:16] + struct.pack("<q", 2**62) + crate[24:], *broken
    yield "usd_cut.usda", made.usda().encode()[:900], *broken
    yield "usd_of_itself.usda", _usda("references = @usd_of_itself.usda@</thing>"), SOUND, *broken, codes.NO_GEOMETRY
    yield "usd_refers_to_the_machine.usda", _usda(f"references = @{OUTSIDE}@"), codes.PATH_TRAVERSAL
    yield "usd_refers_up.usda", _usda(f"payload = @{'../' * 20}etc/passwd@"), codes.PATH_TRAVERSAL
    yield "usd_refers_to_the_network.usda", _usda("references = @http://127.0.0.1:9/x.usda@"), codes.NETWORK_URI
    yield "usd_refers_to_nothing.usda", _usda("references = @gone.usda@"), codes.MISSING_FILE
    written = _usda('references = @`"${HOME}/x.usda"`@')
    yield "usd_computes_a_path.usda", written, codes.PATH_TRAVERSAL, codes.MISSING_FILE
    written = _usda(
        'variants = { string v = "q" }\n prepend variantSets = "v"',
        "    def Mesh",
        f'    variantSet "v" = {{ "q" (references = @{OUTSIDE}@) {{ }} }}\n    def Mesh',
    )
    yield "usd_in_a_variant.usda", written, codes.PATH_TRAVERSAL
    layer = b'<?xml version="1.0"?><materialx xmlns:xi="x"><xi:include href="/etc/passwd"/></materialx>'
    yield Hostile("usd_of_another_format.usda", _usda("references = @x.mtlx@"), broken, {"x.mtlx": layer})
    clips = f'clips = {{\ndictionary default = {{\nasset[] assetPaths = [@{OUTSIDE}@]\nstring primPath = "/a"\n}}\n}}'
    yield "usd_clips_of_the_machine.usda", _usda(clips), SOUND
    yield "usd_picture_of_the_machine.usda", _usda("", "@a.png@", f"@{OUTSIDE}@"), SOUND
    counts = "faceVertexCounts = ["
    yield "usd_endless_polygon.usda", _usda("", f"{counts}3", f"{counts}2000000000"), codes.OUT_OF_BOUNDS
    written = _usda("", f"{counts}3, 3", f"{counts}-3, -2147483648")
    yield "usd_negative_counts.usda", written, SOUND, codes.NO_FACES, codes.OUT_OF_BOUNDS
    corners = ", ".join(map(str, made.BOX.faces.ravel()))
    written = _usda("", corners, ", ".join("7654321" for _ in made.BOX.faces.ravel()))
    yield "usd_no_such_points.usda", written, codes.NO_FACES
    yield "usd_nan.usda", made.usda(", ".join("(nan, inf, -inf)" for _ in made.BOX.vertices)).encode(), codes.NON_FINITE
    deep = "".join(f'def Xform "a{n}" {{\n' for n in range(400)) + "}\n" * 400
    yield "usd_nested_deep.usda", f"#usda 1.0\n{deep}".encode(), *broken
    yield "usd_instances_by_the_million.usda", _instances(7, 10), codes.TOO_LARGE


def _instances(levels: int, width: int) -> bytes:
    """Each level uses the one below ten times."""
    rows = ["#usda 1.0", 'class "level0"', "{", 'def Mesh "m" {', "point3f[] points = [(0,0,0),(1,0,0),(0,1,0)]",
            "int[] faceVertexCounts = [3]", "int[] faceVertexIndices = [0,1,2]", "}", "}"]  # fmt: skip
    for level in range(1, levels + 1):
        rows += [f'{"class" if level < levels else "def Xform"} "level{level}"', "{"]
        for n in range(width):
            rows += [f'def Xform "u{n}" (', "instanceable = true", f"references = </level{level - 1}>", ")", "{", "}"]
        rows += ["}"]
    return "\n".join(rows).encode() + b"\n"


def _usdz() -> Iterator[Row]:
    yield "usdz_leaves_its_folder.usdz", made.usdz(**{"../../evil.usda": b"#usda 1.0\n"}), codes.PATH_TRAVERSAL
    yield "usdz_refers_outside.usdz", made.usdz(made.usda(head=f"references = @{OUTSIDE}@")), codes.PATH_TRAVERSAL
    yield Hostile("usdz_refers_beside_itself.usdz", made.usdz(made.usda(head="references = @../box.usda@")),
                  (codes.MISSING_FILE, codes.PATH_TRAVERSAL), {"box.usda": made.usda().encode()})  # fmt: skip
    small = made.zipped(**{"a.usda": b"\0" * 1000})
    at = small.index(b"PK\x01\x02") + 24
    yield "usdz_claims_gigabytes.usdz", small[:at] + struct.pack("<I", 2**31) + small[at + 4 :], codes.TOO_LARGE
    yield "usdz_cut.usdz", made.usdz()[:-30], codes.WRONG_TYPE, codes.BAD_ARCHIVE
    yield "usdz_of_a_program.usdz", made.zipped(**{"a.usda": b"#!/bin/sh\n"}), codes.SCENE_UNREADABLE


def _fbx() -> Iterator[Row]:
    text = made.fbx()
    broken = (codes.SCENE_UNREADABLE, codes.TRUNCATED)
    yield "fbx_cut.fbx", text[: len(text) // 2], *broken, codes.NO_GEOMETRY
    head = b"Kaydara FBX Binary  \0\x1a\0"
    yield "fbx_noise.fbx", head + struct.pack("<I", 7400) + np.random.default_rng(2).bytes(4000), *broken
    yield "fbx_lies_about_lengths.fbx", head + struct.pack("<IIII", 7400, 2**31, 2**31, 2**31) + b"\7Objects", *broken
    count = text.replace(f"PolygonVertexIndex: *{made.BOX.faces.size}".encode(), b"PolygonVertexIndex: *4294967295")
    assert count != text
    yield "fbx_lies_about_counts.fbx", count, SOUND, *broken, codes.NO_FACES, codes.NO_GEOMETRY
    written = made.fbx(indices="0,1,-99999999,2,70000000,-3")
    yield "fbx_no_such_points.fbx", written, *broken, codes.NO_FACES, codes.NON_FINITE, SOUND
    corners = re.compile(rb"PolygonVertexIndex: \*\d+ \{\s+a: [^}]*\}")
    assert corners.search(text)
    written = corners.sub(b"PolygonVertexIndex: *0 { a: }", text)
    yield "fbx_points_alone.fbx", written, *broken, codes.NO_FACES, codes.NO_GEOMETRY
    yield "fbx_nan.fbx", made.fbx(points=",".join("nan" for _ in made.BOX.vertices.ravel())), *broken, codes.NON_FINITE
    yield "fbx_of_itself.fbx", text.replace(b'C: "OO",11,0', b'C: "OO",11,11'), SOUND, *broken, codes.NO_GEOMETRY
    yield "fbx_nested_deep.fbx", b"; FBX 7.4.0 project file\n" + b"A: { " * 50_000, *broken
    yield "fbx_picture_of_the_machine.fbx", text.replace(b'"a.png"', f'"../../../../../../..{OUTSIDE}"'.encode()), SOUND


def _x3d() -> Iterator[Row]:
    text = made.x3d()
    doctype = text[text.index("<!DOCTYPE") : text.index("<X3D")]
    laughs = "".join(f'<!ENTITY a{n + 1} "{f"&a{n};" * 10}">' for n in range(12))
    bomb = text.replace(doctype, f'<!DOCTYPE X3D [<!ENTITY a0 "ha">{laughs}]>').replace("<head>", "<head>&a12;")
    yield "x3d_billion_laughs.x3d", bomb.encode(), codes.XML_ENTITY
    file = text.replace(doctype, f'<!DOCTYPE X3D [<!ENTITY x SYSTEM "file://{OUTSIDE}">]>')
    yield "x3d_file_as_entity.x3d", file.replace("<head>", "<head>&x;").encode(), codes.XML_ENTITY
    written = text.replace("<Scene>", "<Scene>" + "<Group>" * 2000).encode()
    yield "x3d_nested_deep.x3d", written, codes.XML_DEPTH, codes.BAD_XML, codes.SCENE_UNREADABLE
    yield "x3d_cut.x3d", text[:-80].encode(), codes.TRUNCATED
    doubled = "".join(f"<Group DEF='g{n + 1}'><Group USE='g{n}'/><Group USE='g{n}'/></Group>" for n in range(40))
    uses = text.replace("<Scene>", "<Scene><Group DEF='g0'><Shape USE='thing'/></Group>")
    uses = uses.replace("</Scene>", f"{doubled}</Scene>")
    yield "x3d_used_by_the_billion.x3d", uses.encode(), codes.BAD_SCENE_GRAPH
    own = text.replace("<Shape DEF", "<Transform USE='place'/><Shape DEF")
    yield "x3d_of_itself.x3d", own.encode(), codes.BAD_SCENE_GRAPH
    points = "<IndexedFaceSet coordIndex='0 1 2 -1'><Coordinate point='nan 0 0 inf 0 0 0 1e999 0'/></IndexedFaceSet>"
    yield "x3d_nan.x3d", made.x3d(points).encode(), codes.NON_FINITE
    far = "<IndexedFaceSet coordIndex='0 99999999 2 -1 -7 1 2'><Coordinate point='0 0 0 1 0 0 0 1 0'/></IndexedFaceSet>"
    yield "x3d_no_such_points.x3d", made.x3d(far).encode(), codes.NO_FACES
    strips = "<IndexedTriangleStripSet index='0 1 2 -1 -1 5'><Coordinate point='0 0 0'/></IndexedTriangleStripSet>"
    yield "x3d_broken_strips.x3d", made.x3d(strips).encode(), codes.NO_FACES, codes.NO_GEOMETRY
    inline = f'<Inline url=\'"http://127.0.0.1:9/x.x3d" "{OUTSIDE}"\'/>'
    yield "x3d_brings_in_others.x3d", made.x3d(inline).encode(), codes.NO_GEOMETRY
    script = "<Scene><Script><![CDATA[ecmascript: function initialize() { open('x'); }]]></Script>"
    yield "x3d_with_a_script.x3d", text.replace("<Scene>", script).encode(), SOUND


def _wrl() -> Iterator[Row]:
    text = made.wrl()
    yield "wrl_cut.wrl", text[:-20].encode(), codes.TRUNCATED
    yield "wrl_nested_deep.wrl", ("#VRML V2.0 utf8\n" + "Group { children [ " * 20_000).encode(), codes.SCENE_UNREADABLE
    doubled = "".join(f"DEF g{n + 1} Group {{ children [ USE g{n} USE g{n} ] }}\n" for n in range(40))
    written = f"{text}DEF g0 Group {{ children USE thing }}\n{doubled}".encode()
    yield "wrl_used_by_the_billion.wrl", written, codes.BAD_SCENE_GRAPH
    yield "wrl_of_itself.wrl", text.replace("children [", "children [ USE place ", 1).encode(), codes.BAD_SCENE_GRAPH
    yield "wrl_of_1995.wrl", b"#VRML V1.0 ascii\nSeparator { Cube { } }", codes.UNSUPPORTED_VERSION
    yield "wrl_brackets.wrl", b"#VRML V2.0 utf8\n" + b"[{" * 50_000, codes.TRUNCATED, codes.NO_GEOMETRY
    yield "wrl_of_one_word.wrl", b"#VRML V2.0 utf8\n" + b"x" * 3_000_000, codes.TRUNCATED, codes.NO_GEOMETRY


def _max3ds() -> Iterator[Row]:
    data = made.max3ds()
    yield "3ds_cut.3ds", data[: len(data) // 2], codes.TRUNCATED
    yield "3ds_long_chunk.3ds", data[:8] + struct.pack("<I", 2**31) + data[12:], codes.LENGTH_MISMATCH
    yield "3ds_empty_chunk.3ds", made.chunk(0x4D4D, made.chunk(0x3D3D, b"\0" * 60)), codes.LENGTH_MISMATCH
    yield "3ds_lies_about_counts.3ds", made.max3ds(65535), codes.LENGTH_MISMATCH
    yield "3ds_no_such_points.3ds", made.max3ds(0), codes.OUT_OF_BOUNDS
    many = made.chunk(0x4D4D, made.chunk(0x3D3D, made.chunk(0x4000, b"a\0") * 150_000))
    yield "3ds_endless_chunks.3ds", many, codes.TOO_LARGE


def _gltf() -> Iterator[Row]:
    data = made.draco_glb()
    at = data.index(b"DRACO")
    written = data[: at + 12] + b"\xff" * 100 + data[at + 112 :]
    yield "draco_noise.glb", written, codes.TRUNCATED, codes.LENGTH_MISMATCH, codes.NO_FACES
    yield "draco_lies_about_counts.glb", data.replace(b'"count": 8', b'"count": 9', 1), codes.LENGTH_MISMATCH
    for name, picture in (
        ("ktx2_of_a_terapixel.glb", UASTC[:20] + struct.pack("<II", 2**20, 2**20) + UASTC[28:]),
        ("ktx2_cut.glb", UASTC[:90]),
        ("ktx2_lies_about_lengths.glb", UASTC[:80] + struct.pack("<QQQ", 2**60, 2**60, 2**60) + UASTC[104:]),
    ):
        painted = Gltf()
        painted.paint(picture)
        yield name, painted.glb(), SOUND


def _zip() -> Iterator[Row]:
    obj = OBJ_TRIANGLE.encode()
    yield "zip_leaves_its_folder.zip", made.zipped(**{"../../a.obj": obj}), codes.PATH_TRAVERSAL
    yield "zip_of_a_root.zip", made.zipped(**{OUTSIDE: obj, "a.obj": obj}), codes.PATH_TRAVERSAL
    yield "zip_of_a_drive.zip", made.zipped(**{"C:\\a.obj": obj}), codes.PATH_TRAVERSAL
    yield "zip_bomb.zip", made.zipped(**{"a.obj": b"v 0 0 0\n" * 3_000_000}), codes.TOO_LARGE
    yield "zip_of_many.zip", made.zipped(**{f"{n}.obj": b"" for n in range(21_000)}), codes.TOO_LARGE
    whole = made.zipped(**{"a.obj": obj})
    yield "zip_cut.zip", whole[: len(whole) // 2], codes.BAD_ARCHIVE
    locked = bytearray(whole)
    for at in (6, whole.index(b"PK\x01\x02") + 8):
        locked[at] |= 1
    yield "zip_locked.zip", bytes(locked), codes.BAD_ARCHIVE
    at = whole.index(b"PK\x01\x02") + 24
    written = whole[:at] + struct.pack("<I", 10) + whole[at + 4 :]
    yield "zip_lies_about_size.zip", written, codes.BAD_ARCHIVE, codes.NO_FACES, codes.BAD_NUMBER
    yield "zip_in_a_zip.zip", made.zipped(**{"b.zip": whole}), codes.BAD_ARCHIVE
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as packed:
        link = zipfile.ZipInfo("a.obj")
        link.external_attr = 0o120777 << 16
        packed.writestr(link, OUTSIDE)
    yield "zip_with_a_link.zip", out.getvalue()


def _tar() -> Iterator[Row]:
    obj = OBJ_TRIANGLE.encode()
    yield "tar_leaves_its_folder.tar", gzip.decompress(made.tarred(**{"../../a.obj": obj})), codes.PATH_TRAVERSAL
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w") as packed:
        for number, kind in enumerate((tarfile.SYMTYPE, tarfile.LNKTYPE, tarfile.CHRTYPE, tarfile.FIFOTYPE)):
            info = tarfile.TarInfo(f"{number}.obj")
            info.type, info.linkname = kind, OUTSIDE
            packed.addfile(info)
    yield "tar_with_links.tar", out.getvalue()
    yield "tar_bomb.tar.gz", made.tarred(**{"a.obj": b"v 0 0 0\n" * 3_000_000}), codes.TOO_LARGE, codes.BAD_ARCHIVE
    header = bytearray(tarfile.TarInfo("x").tobuf(tarfile.PAX_FORMAT)[:512])
    header[124:136], header[156:157] = b"77777777777\0", b"x"
    header[148:156] = b"%06o\0 " % (sum(header[:148]) + 256 + sum(header[156:]))
    written = gzip.compress(bytes(header) + b"\0" * 20_000_000)
    yield "tar_with_a_long_header.tar.gz", written, codes.BAD_ARCHIVE, codes.TOO_LARGE
    yield "tar_cut.tgz", made.tarred(**{"a.obj": obj * 9000})[:-60], codes.BAD_ARCHIVE
    sparse = bytearray(tarfile.TarInfo("a.obj").tobuf(tarfile.GNU_FORMAT)[:512])
    sparse[156:157], sparse[483:495] = b"S", b"77777777777\0"
    sparse[148:156] = b"%06o\0 " % (sum(sparse[:148]) + 256 + sum(sparse[156:]))
    yield "tar_with_a_hole.tar", bytes(sparse) + b"\0" * 1024


ROWS = [*_usd(), *_usdz(), *_fbx(), *_x3d(), *_wrl(), *_max3ds(), *_gltf(), *_zip(), *_tar()]
INPUTS = [row if isinstance(row, Hostile) else Hostile(row[0], row[1], row[2:]) for row in ROWS]
assert len({one.name for one in INPUTS}) == len(INPUTS)
SECONDS = 10.0
MEMORY_BYTES = 2_500_000_000


def put(one: Hostile, folder: Path) -> Path:
    """The input on disk, with what lies beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, data in {one.name: one.data, **one.beside}.items():
        (folder / name).write_bytes(data)
    return folder / one.name


def verdicts(path: Path) -> list[str]:
    """What becomes of all inputs in a file."""
    limits = registry.load().limits
    out = []
    for found in discover([path], Counter()):
        if isinstance(found, Refused):
            out.append(found.code)
            continue
        assert isinstance(found, Found)
        try:
            load(collect(found, limits), limits)
            out.append(SOUND)
        except Rejected as error:
            out.append(error.code)
    return out


@pytest.mark.parametrize("one", INPUTS, ids=lambda one: one.name)
def test_a_hostile_input_ends_as_it_should(tmp_path: Path, one: Hostile) -> None:
    path = put(one, tmp_path)
    begin = time.process_time()
    said = verdicts(path)
    assert time.process_time() - begin < SECONDS
    assert set(said) <= set(one.wanted), said
    assert said or not one.wanted
    assert set(said) - {SOUND} <= registry.load().rejections.keys()
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 < MEMORY_BYTES


@pytest.mark.slow
@pytest.mark.parametrize("step", [9, pytest.param(1, marks=pytest.mark.certify)])
def test_many_of_them_in_one_run(tmp_path: Path, step: int) -> None:
    """Nobody goes beyond the folders, no worker dies, and every input is told."""
    inputs = INPUTS[::step]
    for one in inputs:
        put(one, tmp_path / "in" / one.name.replace(".", "_"))
    watch, library = Watch(tmp_path / "watch"), tmp_path / "library"
    done = casa("ingest", tmp_path / "in", "--library", library, "--json", "--memory", 2, **watch.environment)
    assert done.returncode == 1, done.stderr[-2000:]
    said = [Said.of(row) for row in input_rows(done.stdout)]
    assert not [one for one in said if one.code in ("RUN001", "RUN002", "RUN003", "RUN004")]
    assert {one.path.split("!")[0].rpartition("/")[2] for one in said} >= {one.name for one in inputs if one.wanted}
    assert watch.escapes([tmp_path / "in"], [library]) == []


def test_sound_files_are_sound(tmp_path: Path) -> None:
    """The specimens that the hostile ones are made from: else their rejections would mean nothing."""
    from tests.support.fuzz.fuzz_corpus import packed_specimens, specimens

    limits = registry.load().limits
    for name, files in {**specimens(), **packed_specimens()}.items():
        folder = tmp_path / name
        folder.mkdir()
        for file, data in files.items():
            (folder / file).write_bytes(data)
        for found in discover([folder / next(iter(files))]):
            assert isinstance(found, Found)
            draft = clean(load(collect(found, limits), limits))
            assert sum(len(part.mesh.faces) for part in draft.parts) == 12, name

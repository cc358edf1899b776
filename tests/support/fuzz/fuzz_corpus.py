"""The seed corpus of fuzzing: small sound files of every format and dialect, made in code."""

from __future__ import annotations

import gzip
import struct

import numpy as np

from tests.support.hostile.exfiltration_inputs import dae_of_box
from tests.support.mesh import format_files
from tests.support.mesh.format_files import BOX as SHARED
from tests.support.mesh.mesh_files import QUARTERS, Gltf, png
from tests.support.mesh.meshes import box_mesh, some

BOX = box_mesh((0.08, 0.1, 0.06), (0.0, 0.05, 0.0))
Files = dict[str, bytes]


def specimens() -> dict[str, Files]:
    """Name -> files of one input, its main file first."""
    return {
        "glb_plain": {"a.glb": Gltf(SHARED.vertices.tolist(), SHARED.faces.ravel().tolist()).glb()},
        "glb_rich": {"a.glb": _rich_glb()},
        "obj": {"a.obj": _obj(), "a.mtl": b"newmtl m\nKd 0.5 0.2 0.1\nd 0.9\nmap_Kd a.png\n", "a.png": png(QUARTERS)},
        "ply_text": {"a.ply": _ply("ascii")},
        "ply_little": {"a.ply": _ply("binary_little_endian")},
        "ply_big": {"a.ply": _ply("binary_big_endian")},
        "stl_binary": {"a.stl": _stl_binary()},
        "stl_text": {"a.stl": _stl_text()},
        "dae": {"a.dae": dae_of_box(), "a.png": png(QUARTERS)},
        "draco": {"a.glb": format_files.draco_glb()},
        "usda": {"a.usda": format_files.usda().encode(), "a.png": png(QUARTERS)},
        "usdc": {"a.usdc": format_files.usdc()},
        "usdz": {"a.usdz": format_files.usdz()},
        "fbx": {"a.fbx": format_files.fbx(png(QUARTERS))},
        "x3d": {"a.x3d": format_files.x3d().encode(), "a.png": png(QUARTERS)},
        "wrl": {"a.wrl": format_files.wrl().encode()},
        "3ds": {"a.3ds": format_files.max3ds(), "a.png": png(QUARTERS)},
    }


def packed_specimens() -> dict[str, Files]:
    """As `specimens`, archives of inputs: they have to be opened before they can be read."""
    obj, material = _obj(), b"newmtl m\nKd 0.5 0.2 0.1\n"
    return {
        "zip": {"a.zip": format_files.zipped(**{"a.obj": obj, "a.mtl": material, "b.stl": _stl_binary()})},
        "tar": {"a.tar": gzip.decompress(format_files.tarred(**{"a.obj": obj, "a.mtl": material}))},
        "tar_gz": {"a.tar.gz": format_files.tarred(**{"a.obj": obj, "a.mtl": material})},
    }


def _rich_glb() -> bytes:
    """Uv, normals, colours, a picture, a skin, a sparse accessor, two nodes."""
    thing = Gltf(BOX.vertices.tolist(), BOX.faces.ravel().tolist())
    count = len(BOX.vertices)
    thing.attributes["TEXCOORD_0"] = thing.add(some(BOX.uv).astype("<f4"), "VEC2")
    thing.attributes["NORMAL"] = thing.add(some(BOX.normals).astype("<f4"), "VEC3")
    thing.attributes["COLOR_0"] = thing.add(np.full((count, 4), 200, dtype="u1"), "VEC4", normalized=True)
    thing.attributes["JOINTS_0"] = thing.add(np.zeros((count, 4), dtype="u1"), "VEC4")
    thing.attributes["WEIGHTS_0"] = thing.add(np.tile(np.array([1, 0, 0, 0], dtype="<f4"), (count, 1)), "VEC4")
    places = {"bufferView": thing.view(np.array([0, 3], dtype="<u2").tobytes()), "componentType": 5123}
    values = {"bufferView": thing.view(BOX.vertices[[0, 3]].astype("<f4").tobytes())}
    thing.accessors[0]["sparse"] = {"count": 2, "indices": places, "values": values}
    thing.paint(png(QUARTERS))
    bones = thing.add(np.eye(4, dtype="<f4").reshape(1, 16), "MAT4")
    thing.document["skins"] = [{"joints": [1], "inverseBindMatrices": bones}]
    thing.node["skin"] = 0
    bone = {"name": "bone", "translation": [0, 0.01, 0]}
    thing.document["nodes"] = [thing.node, bone, {"children": [0], "scale": [1, 1, 2]}]
    thing.document["scenes"] = [{"nodes": [2, 1]}]
    thing.document["animations"] = [{"channels": [], "samplers": []}]
    return thing.glb()


def _obj() -> bytes:
    rows = ["mtllib a.mtl", "o box"]
    rows += [f"v {x:.4g} {y:.4g} {z:.4g}" for x, y, z in SHARED.vertices]
    rows += ["vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1", "vn 0 0 1", "usemtl m", "g side"]
    quads = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5)]
    rows += ["f " + " ".join(f"{v}/{t}/1" for v, t in zip(q, (1, 2, 3, 4), strict=True)) for q in quads]
    rows += ["s 1", "f -7 -5 -1", "f -7 -1 -3 # negative"]
    return ("\n".join(rows) + "\n").encode()


def _ply(kind: str) -> bytes:
    head = ["ply", f"format {kind} 1.0", "comment TextureFile a.png", f"element vertex {len(SHARED.vertices)}"]
    head += [*(f"property float {a}" for a in "xyz"), *(f"property uchar {c}" for c in ("red", "green", "blue"))]
    head += [f"element face {len(SHARED.faces)}", "property list uchar int vertex_indices", "end_header"]
    data = ("\n".join(head) + "\n").encode()
    if kind == "ascii":
        rows = [" ".join(f"{v:.5g}" for v in p) + " 9 90 200" for p in SHARED.vertices]
        rows += ["3 " + " ".join(map(str, f)) for f in SHARED.faces]
        return data + ("\n".join(rows) + "\n").encode()
    order = "<" if "little" in kind else ">"
    data += b"".join(struct.pack(f"{order}3f3B", *p, 9, 90, 200) for p in SHARED.vertices)
    return data + b"".join(struct.pack(f"{order}B3i", 3, *f) for f in SHARED.faces)


def _stl_binary() -> bytes:
    corners = SHARED.vertices[SHARED.faces]
    rows = (struct.pack("<12fH", 0, 0, 1, *corner.ravel(), 0) for corner in corners)
    return b"box".ljust(80, b"\0") + struct.pack("<I", len(corners)) + b"".join(rows)


def _stl_text() -> bytes:
    rows = ["solid box"]
    for corner in SHARED.vertices[SHARED.faces]:
        rows += ["facet normal 0 0 1", "outer loop", *(f"vertex {x:.5g} {y:.5g} {z:.5g}" for x, y, z in corner)]
        rows += ["endloop", "endfacet"]
    return ("\n".join([*rows, "endsolid box"]) + "\n").encode()

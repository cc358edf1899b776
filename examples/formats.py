"""Surfaces -> bytes of OBJ, STL, PLY, glTF, GLB and COLLADA files. They write what they are told, mistakes included."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from shapes import Array, Index, Surface

GLTF_FROM_Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


@dataclass(frozen=True)
class Look:
    """How a part looks: linear base colour, metallic, roughness, and PNG bytes with their file name or none."""

    name: str
    color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    metallic: float = 0.0
    roughness: float = 0.6
    image: bytes = b""
    image_name: str = ""


Part = tuple[Surface, Look]


def exact(values: Array) -> Array:
    """Values rounded to a millionth, so that the last bit of a sine does not reach the file."""
    return np.round(values, 6) + 0.0


class Buffer:
    """A glTF buffer that grows, with the views and accessors that describe it."""

    def __init__(self) -> None:
        self.blob = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def view(self, data: bytes, **more: int) -> int:
        """Append bytes, aligned to four; the index of their view."""
        self.blob.extend(b"\0" * (-len(self.blob) % 4))
        self.views.append({"buffer": 0, "byteOffset": len(self.blob), "byteLength": len(data), **more})
        self.blob.extend(data)
        return len(self.views) - 1

    def vectors(self, values: Array) -> int:
        """Append (N, 2) or (N, 3) vectors as float32; the index of their accessor."""
        rows = exact(values).astype("<f4")
        self.accessors.append(
            {
                "bufferView": self.view(rows.tobytes(), target=34962),
                "componentType": 5126,
                "count": len(rows),
                "type": f"VEC{rows.shape[1]}",
                "min": rows.min(axis=0).tolist(),
                "max": rows.max(axis=0).tolist(),
            }
        )
        return len(self.accessors) - 1

    def indices(self, faces: Index) -> int:
        """Append triangles as 16 bit indices; the index of their accessor."""
        view = self.view(faces.astype("<u2").tobytes(), target=34963)
        self.accessors.append({"bufferView": view, "componentType": 5123, "count": faces.size, "type": "SCALAR"})
        return len(self.accessors) - 1


def gltf(parts: list[Part], name: str, scale: tuple[float, float, float] | None = None) -> tuple[dict[str, Any], bytes]:
    """glTF document and buffer, one primitive per part, vertices as given (file units, file axes).

    Args:
        parts: surfaces and how they look; an image without a file name goes into the buffer.
        name: of the node and mesh.
        scale: of the node.
    """
    buffer = Buffer()
    primitives: list[dict[str, Any]] = []
    materials: list[dict[str, Any]] = []
    textures: list[dict[str, Any]] = []
    images: list[dict[str, Any]] = []
    for surface, look in parts:
        attributes = {"POSITION": buffer.vectors(surface.vertices)}
        color: dict[str, Any] = {"baseColorFactor": [*look.color, 1.0]}
        if look.image:
            attributes["TEXCOORD_0"] = buffer.vectors(surface.uv * [1, -1] + [0, 1])  # glTF counts v from the top
            color["baseColorTexture"] = {"index": len(textures)}
            textures.append({"source": len(images)})
            inside = {} if look.image_name else {"bufferView": buffer.view(look.image), "mimeType": "image/png"}
            images.append(inside or {"uri": look.image_name})
        primitives.append(
            {"attributes": attributes, "indices": buffer.indices(surface.faces), "material": len(materials)}
        )
        color |= {"metallicFactor": look.metallic, "roughnessFactor": look.roughness}
        materials.append({"name": look.name, "pbrMetallicRoughness": color})
    document: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": name, "mesh": 0, **({"scale": list(scale)} if scale else {})}],
        "meshes": [{"name": name, "primitives": primitives}],
        "materials": materials,
        **({"textures": textures, "images": images} if images else {}),
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
    }
    buffer.blob.extend(b"\0" * (-len(buffer.blob) % 4))
    return {**document, "buffers": [{"byteLength": len(buffer.blob)}]}, bytes(buffer.blob)


def glb(parts: list[Part], name: str) -> bytes:
    """Binary glTF with its images inside."""
    document, blob = gltf(parts, name)
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(blob), b"BIN\0") + blob
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def obj(parts: list[Part], library: str) -> bytes:
    """Wavefront OBJ that refers to the material library `library`."""
    lines = [f"mtllib {library}"]
    start = 1
    for number, (surface, look) in enumerate(parts):
        lines.append(f"o part{number}")
        lines += [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in exact(surface.vertices)]
        lines += [f"vt {u:.4f} {v:.4f}" for u, v in exact(surface.uv)]
        lines.append(f"usemtl {look.name}")
        lines += [f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in surface.faces + start]
        start += len(surface.vertices)
    return ("\n".join(lines) + "\n").encode()


def mtl(looks: list[Look]) -> bytes:
    """Wavefront material library."""
    lines = []
    for look in looks:
        r, g, b = look.color
        lines += [f"newmtl {look.name}", f"Kd {r:g} {g:g} {b:g}", "Ks 0.1 0.1 0.1", "Ns 40", "d 1"]
        lines += [f"map_Kd {look.image_name}"] if look.image_name else []
    return ("\n".join(lines) + "\n").encode()


def stl(surface: Surface) -> bytes:
    """Binary STL."""
    corners = exact(surface.vertices)[surface.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    rows = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    rows["normal"], rows["corners"] = exact(normals / np.maximum(length, 1e-12)), corners
    return b"sample".ljust(80, b" ") + struct.pack("<I", len(rows)) + rows.tobytes()


def ply(surface: Surface, colors: npt.NDArray[np.uint8]) -> bytes:
    """Binary PLY with (V, 3) vertex colours."""
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(surface.vertices)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\n"
        f"element face {len(surface.faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    points = np.zeros(len(surface.vertices), dtype=[("p", "<f4", 3), ("c", "u1", 3)])
    points["p"], points["c"] = exact(surface.vertices), colors
    faces = np.zeros(len(surface.faces), dtype=[("n", "u1"), ("i", "<i4", 3)])
    faces["n"], faces["i"] = 3, surface.faces
    return header.encode() + points.tobytes() + faces.tobytes()


def dae(surface: Surface, look: Look, unit: tuple[str, float], up: str) -> bytes:
    """COLLADA 1.4.1 with one mesh; `unit` is its name and its length in metres, `up` is X_UP, Y_UP or Z_UP."""
    points = " ".join(f"{n:.6g}" for n in exact(surface.vertices).ravel())
    indices = " ".join(str(n) for n in surface.faces.ravel())
    color = " ".join(f"{n:g}" for n in (*look.color, 1.0))
    return f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2024-01-01T00:00:00</created><modified>2024-01-01T00:00:00</modified>
<unit name="{unit[0]}" meter="{unit[1]}"/><up_axis>{up}</up_axis></asset>
<library_effects><effect id="fx"><profile_COMMON><technique sid="common"><phong>
<diffuse><color>{color}</color></diffuse>
</phong></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m" name="{look.name}"><instance_effect url="#fx"/></material></library_materials>
<library_geometries><geometry id="g" name="{look.name}"><mesh>
<source id="p"><float_array id="pa" count="{surface.vertices.size}">{points}</float_array>
<technique_common><accessor source="#pa" count="{len(surface.vertices)}" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
</accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="{len(surface.faces)}" material="s"><input semantic="VERTEX" source="#v" offset="0"/>
<p>{indices}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene"><node id="n"><instance_geometry url="#g"><bind_material>
<technique_common><instance_material symbol="s" target="#m"/></technique_common>
</bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>
""".encode()

"""Inputs that try to make the program read, write, run or fetch what lies outside their folder, and their targets."""

from __future__ import annotations

import base64
import json
import socketserver
import threading
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from tests.support.library.libraries import box_obj
from tests.support.mesh.mesh_files import Gltf, png

SECRET = "s3cret_canary_7f1d"
RED = np.full((8, 8, 3), (251, 3, 7), dtype=np.uint8)


@contextmanager
def listener() -> Iterator[tuple[int, list[str]]]:
    """A port of this machine, and what came there."""
    heard: list[str] = []

    class Caller(socketserver.BaseRequestHandler):
        def handle(self) -> None:
            heard.append(str(self.client_address))

    with socketserver.TCPServer(("127.0.0.1", 0), Caller) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.1,))
        thread.start()
        try:
            yield server.server_address[1], heard
        finally:
            server.shutdown()
            thread.join()


def make_outside(folder: Path) -> Path:
    """What must never be opened: a mesh, a material, a picture, a buffer and a text, each fit to be taken in."""
    folder.mkdir(parents=True)
    (folder / "secret.obj").write_text(f"o {SECRET}\n" + box_obj((0.1, 0.1, 0.1)), encoding="ascii")
    (folder / "secret.mtl").write_text(f"newmtl {SECRET}\nKd 0.98 0.01 0.03\nmap_Kd secret.png\n", encoding="ascii")
    (folder / "secret.png").write_bytes(png(RED))
    (folder / "secret.bin").write_bytes(Gltf().binary + SECRET.encode())
    (folder / "secret.txt").write_text(SECRET, encoding="ascii")
    (folder / "textures").mkdir()
    (folder / "textures" / "secret.png").write_bytes(png(RED))
    return folder


def ways(outside: Path, port: int, name: str) -> list[str]:
    """Spellings that lead to a file outside, or to the network."""
    place = (outside / name).as_posix()
    return [
        f"../{outside.name}/{name}",
        f"sub/../../{outside.name}/{name}",
        f"..\\{outside.name}\\{name}",
        f"%2e%2e/{outside.name}/{name}",
        f"%2e%2e%2f{outside.name}%2f{name}",
        f"....//{outside.name}/{name}",
        place,
        f"file://{place}",
        f"file:{place}",
        f"FILE://localhost{place}",
        f"http://127.0.0.1:{port}/{name}",
        f"HTTPS://127.0.0.1:{port}/{name}",
        f"//127.0.0.1:{port}/{name}",
        f"\\\\127.0.0.1@{port}\\share\\{name}",
        f"/proc/self/root{place}",
        f"link_{name}",
        f"linked/{name}",
    ]


def make_inputs(folder: Path, outside: Path, port: int) -> Path:
    """One folder of files of all formats that reach out in every way that is known."""
    folder.mkdir(parents=True)
    for name in ("secret.obj", "secret.mtl", "secret.png", "secret.bin", "secret.txt"):
        (folder / f"link_{name}").symlink_to(outside / name)
    (folder / "linked").symlink_to(outside)
    (folder / "linked.obj").symlink_to(f"../{outside.name}/secret.obj")
    _objs(folder, outside, port)
    _gltfs(folder, outside, port)
    _others(folder, outside, port)
    rows = [
        {"id": "../../evil", "file": "libraries.obj"},
        {"id": "a", "file": f"../{outside.name}/secret.obj"},
        {"id": "b", "file": str(outside / "secret.obj")},
        {"id": "c", "file": "linked/secret.obj"},
        {"id": "d", "file": "link_secret.obj"},
        {"id": "e", "file": f"http://127.0.0.1:{port}/secret.obj", "uri": f"http://127.0.0.1:{port}/"},
    ]
    (folder / "manifest.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows), encoding="ascii")
    with zipfile.ZipFile(folder / "slip.zip", "w") as archive:
        archive.writestr(f"../{outside.name}/dropped.obj", box_obj((0.1, 0.1, 0.1)))
    return folder


def _box(width: float) -> tuple[list[list[str]], list[list[str]]]:
    """Points of a box and its triangles, counted from 0, as words."""
    rows = [line.split() for line in box_obj((width, 0.1, 0.1)).splitlines()]
    faces = [[str(int(v) - 1) for v in row[1:]] for row in rows if row[0] == "f"]
    return [row[1:] for row in rows if row[0] == "v"], faces


def _objs(folder: Path, outside: Path, port: int) -> None:
    lines = [f"mtllib {way}" for way in ways(outside, port, "secret.mtl")]
    lines += [f"call {outside}/secret.obj", f"csh touch {outside}/pwned", f"shadow_obj {outside}/secret.obj"]
    lines += [f"trace_obj ../{outside.name}/secret.obj", "usemtl thing"]
    (folder / "libraries.obj").write_text("\n".join(lines) + "\n" + box_obj((0.11, 0.1, 0.1)), encoding="utf-8")
    pictures = ways(outside, port, "secret.png")
    looks = [f"newmtl m{i}\nmap_Kd -s 1 1 1 {way}\nmap_Bump {way}\nnorm {way}" for i, way in enumerate(pictures)]
    (folder / "pictures.mtl").write_text("\n".join(looks) + "\n", encoding="utf-8")
    corners, faces = [], []
    for line in box_obj((0.12, 0.1, 0.1)).splitlines():
        (faces if line.startswith("f") else corners).append(line)
    body = ["mtllib pictures.mtl", *corners, "vt 0 0", "vt 1 0", "vt 0 1"]
    for i, face in enumerate(faces * 2):
        marked = " ".join(f"{v}/{n}" for n, v in enumerate(face.split()[1:], start=1))
        body += [f"usemtl m{i % len(pictures)}", f"f {marked}"]
    (folder / "pictures.obj").write_text("\n".join(body) + "\n", encoding="utf-8")


def _gltfs(folder: Path, outside: Path, port: int) -> None:
    for number, way in enumerate(ways(outside, port, "secret.bin")):
        document = _document()
        document["buffers"] = [{"uri": way, "byteLength": 8}]
        (folder / f"buffer_{number:02d}.gltf").write_text(json.dumps(document), encoding="utf-8")
    document = _document()
    places = ways(outside, port, "secret.png")
    document["images"] = [{"uri": way} for way in places]
    document["textures"] = [{"source": i} for i in range(len(places))]
    document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": i}}} for i in range(len(places))]
    (folder / "images.gltf").write_text(json.dumps(document), encoding="utf-8")


def _document() -> dict[str, object]:
    """A glTF of a box with its data inside."""
    points, faces = _box(0.13)
    thing = Gltf([[float(v) for v in point] for point in points], [int(v) for face in faces for v in face])
    thing.primitive["material"] = 0
    thing.attributes["TEXCOORD_0"] = thing.add(np.zeros((len(points), 2), dtype="<f4"), "VEC2")
    uri = "data:application/octet-stream;base64," + base64.b64encode(thing.binary).decode()
    parts = {"buffers": [{"uri": uri, "byteLength": len(thing.binary)}], "bufferViews": thing.views}
    return {**thing.document, **parts, "accessors": thing.accessors, "materials": [{}]}


def _others(folder: Path, outside: Path, port: int) -> None:
    places = enumerate(ways(outside, port, "secret.png"))
    dae = _collada("".join(f'<image id="i{n}"><init_from>{way}</init_from></image>' for n, way in places))
    laughs = [f'<!ENTITY l{i + 1} "{f"&l{i};" * 10}">' for i in range(11)]
    text = f"{outside}/secret.txt"
    heads = {
        "entity_file": f'<!DOCTYPE c [<!ENTITY x SYSTEM "file://{text}">]>',
        "entity_parameter": f'<!DOCTYPE c [<!ENTITY % p SYSTEM "http://127.0.0.1:{port}/x.dtd"> %p;]>',
        "doctype_http": f'<!DOCTYPE c SYSTEM "http://127.0.0.1:{port}/x.dtd">',
        "doctype_file": f'<!DOCTYPE c SYSTEM "file://{text}">',
        "laughs": f'<!DOCTYPE c [<!ENTITY l0 "ha">{"".join(laughs)}<!ENTITY x "&l11;">]>',
        "stylesheet": f'<?xml-stylesheet href="http://127.0.0.1:{port}/x.xsl" type="text/xsl"?>',
    }
    for name, head in heads.items():
        body = dae.replace("TITLE", "&x;" if "DOCTYPE" in head else "a title")
        (folder / f"{name}.dae").write_text(f'<?xml version="1.0"?>\n{head}\n{body}', encoding="utf-8")
    include = f'<xi:include xmlns:xi="http://www.w3.org/2001/XInclude" href="file://{text}" parse="text"/>'
    (folder / "include.dae").write_text(dae.replace("TITLE", include), encoding="utf-8")
    points, faces = _box(0.14)
    head = ["ply", "format ascii 1.0", *(f"comment TextureFile {way}" for way in ways(outside, port, "secret.png"))]
    head += [f"element vertex {len(points)}", *(f"property float {axis}" for axis in "xyz")]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    lines = [*head, *map(" ".join, points), *(" ".join(("3", *face)) for face in faces)]
    (folder / "picture.ply").write_text("\n".join(lines) + "\n", encoding="utf-8")


def dae_of_box() -> bytes:
    """A COLLADA file of a box with a picture beside it."""
    text = _collada('<image id="i"><init_from>a.png</init_from></image>')
    return ('<?xml version="1.0"?>\n' + text.replace("TITLE", "box")).encode()


def _collada(pictures: str) -> str:
    points, faces = (" ".join(map(" ".join, rows)) for rows in _box(0.15))
    return f"""<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><title>TITLE</title><unit meter="0.5"/><up_axis>Y_UP</up_axis></asset><library_images>{pictures}</library_images>
<library_effects><effect id="e"><profile_COMMON><newparam sid="s"><surface type="2D"><init_from>i</init_from></surface>
</newparam><newparam sid="t"><sampler2D><source>s</source></sampler2D></newparam><technique sid="c"><lambert><diffuse>
<texture texture="t" texcoord="UV"/></diffuse></lambert></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="f" count="24">{points}</float_array>
<technique_common><accessor source="#f" count="8" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles material="m" count="12"><input semantic="VERTEX" source="#v" offset="0"/><p>{faces}</p></triangles>
</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="s"><node id="n">
<matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix><rotate>0 1 0 90</rotate><instance_geometry url="#g"><bind_material>
<technique_common><instance_material symbol="m" target="#m"/></technique_common></bind_material></instance_geometry>
</node></visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>
"""

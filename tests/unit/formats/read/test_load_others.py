"""PLY, STL and COLLADA, and pictures of all kinds."""

from __future__ import annotations

import io
import struct

import numpy as np
import pytest
from PIL import Image

from casa_assets.formats.read.materials import Images, ImageUse
from casa_assets.formats.read.text import Notes
from casa_assets.model import rejection_codes as codes
from casa_assets.model.source import Up
from tests.support.mesh.mesh_files import LIMITS, QUARTERS, load_bytes, png, refusal, texel

PLY_HEAD = "ply\nformat {} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n{}"
PLY_FACES = "element face {}\nproperty list uchar int vertex_indices\n{}end_header\n"
SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]

DAE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.0254" name="inch"/><up_axis>X_UP</up_axis></asset>
<library_images><image id="i"><init_from>p.png</init_from></image></library_images>
<library_effects><effect id="e"><profile_COMMON>
<newparam sid="s"><surface type="2D"><init_from>i</init_from></surface></newparam>
<newparam sid="t"><sampler2D><source>s</source></sampler2D></newparam>
<technique sid="c"><phong><diffuse>{diffuse}</diffuse></phong></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m" name="paint"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g" name="thing"><mesh>
<source id="gp"><float_array id="gpa" count="12">0 0 0 1 0 0 1 1 0 0 1 0</float_array>
<technique_common><accessor source="#gpa" count="4" stride="3"/></technique_common></source>
<source id="gu"><float_array id="gua" count="8">0 0 1 0 1 1 0 1</float_array>
<technique_common><accessor source="#gua" count="4" stride="2"/></technique_common></source>
<vertices id="gv"><input semantic="POSITION" source="#gp"/></vertices>
<polylist material="sym" count="1"><input semantic="VERTEX" source="#gv" offset="0"/>
<input semantic="TEXCOORD" source="#gu" offset="1" set="0"/><vcount>4</vcount><p>{p}</p></polylist>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="v"><node id="n" name="Node"><scale>{scale}</scale>
<instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="sym" target="#m">
<bind_vertex_input semantic="UV" input_semantic="TEXCOORD" input_set="0"/></instance_material>
</technique_common></bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#v"/></scene></COLLADA>"""
TEXTURED, PLAIN = '<texture texture="t" texcoord="UV"/>', "<color>0.5 0 1 1</color>"


def dae(diffuse: str = PLAIN, p: str = "0 0 1 1 2 2 3 3", scale: str = "1 1 1") -> str:
    return DAE.replace("{diffuse}", diffuse).replace("{p}", p).replace("{scale}", scale)


def stl_bytes(count: int, claimed: int | None = None, head: bytes = b"") -> bytes:
    row = struct.pack("<12fH", 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0)
    return head.ljust(80, b" ") + struct.pack("<I", count if claimed is None else claimed) + row * count


@pytest.mark.parametrize("order", ["<", ">", ""])
def test_ply_in_all_three_encodings(order: str) -> None:
    extra = "property float s\nproperty float t\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    form = {"<": "binary_little_endian", ">": "binary_big_endian", "": "ascii"}[order]
    head = (PLY_HEAD.format(form, extra) + PLY_FACES.format(2, "")).encode()
    rows = [(*p, p[0], p[1], 255, 0, 7) for p in SQUARE]
    faces = [(3, 0, 1, 2), (4, 0, 1, 2, 3)]  # lists of varying length
    if order:
        body = b"".join(struct.pack(order + "5f3B", *r) for r in rows)
        body += b"".join(struct.pack(f"{order}B{f[0]}i", *f) for f in faces)
    else:
        body = "\n".join(" ".join(map(str, r)) for r in (*rows, *faces)).encode()
    mesh = load_bytes("x.ply", head + body).parts[0].mesh
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 1, 2], [0, 2, 3]]
    assert mesh.uv is not None
    assert mesh.uv.tolist() == [[0, 0], [1, 0], [1, 1], [0, 1]]
    assert mesh.colors is not None
    assert mesh.colors[0].tolist() == [255, 0, 7, 255]


def test_ply_corner_coordinates_and_its_picture() -> None:
    head = PLY_HEAD.format("ascii", "").replace("element vertex", "comment TextureFile p q.png\nelement vertex")
    faces = PLY_FACES.format(1, "property list uchar float texcoord\n")
    text = head + faces + "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 6 0 0 1 0 1 1\n"
    model = load_bytes("x.ply", text, **{"p q.png": png(QUARTERS)})
    assert [texel(model, 0, i) for i in range(3)] == [(0, 0, 255), (255, 255, 0), (0, 255, 0)]


def test_bad_ply_is_refused() -> None:
    for text, code in [
        (PLY_HEAD.format("binary_little_endian", ""), codes.TRUNCATED),
        (PLY_HEAD.format("ebcdic", "") + PLY_FACES.format(0, ""), codes.BAD_HEADER),
        (
            PLY_HEAD.format("ascii", "").replace("4", "2000000000") + PLY_FACES.format(0, "") + "0 0 0",
            codes.LENGTH_MISMATCH,
        ),
        (PLY_HEAD.format("ascii", "") + PLY_FACES.format(0, "") + "0 0 0 " * 4, codes.NO_FACES),
        (PLY_HEAD.format("ascii", "") + PLY_FACES.format(1, "") + "0 0 0 " * 4 + "3 0 1 9", codes.OUT_OF_BOUNDS),
        (PLY_HEAD.format("ascii", "") + PLY_FACES.format(1, "") + "0 0 0 " * 3 + "0 0 x 3 0 1 2", codes.BAD_NUMBER),
        (PLY_HEAD.format("ascii", "") + PLY_FACES.format(1, "") + "0 0 0 " * 4 + "3 0 1", codes.TRUNCATED),
    ]:
        assert refusal("x.ply", text) == code


def test_stl_binary_even_where_it_says_solid_and_text_with_several() -> None:
    model = load_bytes("x.stl", stl_bytes(2, head=b"solid of revolution"))
    assert (len(model.parts[0].mesh.faces), model.up, model.metres_per_unit) == (2, None, None)

    facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    text = f"solid Lid\n{facet}endsolid Lid\nsolid empty\nendsolid\nSOLID pot\n{facet}{facet}endsolid\n"
    assert [(p.name, len(p.mesh.faces)) for p in load_bytes("x.stl", text).parts] == [("lid", 1), ("pot", 2)]


def test_bad_stl_is_refused() -> None:
    for data, code in [
        (stl_bytes(9)[:-60], codes.TRUNCATED),
        (stl_bytes(2, claimed=2**32 - 1), codes.LENGTH_MISMATCH),
        (b"solid x\nfacet\nvertex 0 0 0\nvertex 1 0 0\n", codes.TRUNCATED),
        (b"solid x\nfacet\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 a\nendsolid", codes.BAD_NUMBER),
        (b"solid x\nendsolid x\n", codes.EMPTY_FILE),
    ]:
        assert refusal("x.stl", data) == code


def test_dae_hands_on_unit_and_axis_and_reads_colour_as_display_value() -> None:
    model = load_bytes("x.dae", dae())
    assert (model.metres_per_unit, model.up, model.parts[0].name) == (0.0254, Up.X, "node")
    assert model.parts[0].material.base_color == pytest.approx((0.21404114, 0.0, 1.0, 1.0))
    assert model.parts[0].mesh.bounds.tolist() == [[0, 0, 0], [1, 1, 0]]
    assert len(load_bytes("x.dae", dae().replace('<?xml version="1.0"?>', "").encode("utf-16")).parts) == 1


def test_dae_picture_and_mirrored_node() -> None:
    model = load_bytes("x.dae", dae(TEXTURED, scale="-1 1 1"), **{"p.png": png(QUARTERS)})
    mesh = model.parts[0].mesh
    a, b, c = mesh.vertices[mesh.faces[0]]
    assert np.cross(b - a, c - a)[2] > 0
    at = {tuple(v): texel(model, 0, i) for i, v in enumerate(mesh.vertices.tolist())}
    assert at[(0.0, 0.0, 0.0)] == (0, 0, 255)
    assert at[(-1.0, 1.0, 0.0)] == (0, 255, 0)


def test_bad_dae_is_refused() -> None:
    for text, code in [
        (dae()[: len(dae()) // 2], codes.TRUNCATED),
        (dae().replace("</asset>", "</asse>"), codes.BAD_XML),
        (
            dae().replace("<COLLADA", '<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd">]>\n<COLLADA', 1),
            codes.XML_ENTITY,
        ),
        (dae().replace("<scene>", "<extra>" * 3000 + "</extra>" * 3000 + "<scene>"), codes.XML_DEPTH),
        (dae(p="0 0 1 1 2 2 9 3"), codes.OUT_OF_BOUNDS),
        (dae().replace("<node ", '<node id="q"><instance_node url="#q"/></node><node '), codes.BAD_SCENE_GRAPH),
        (dae().replace("1 1 0 0 1 0<", "nan 1 0 nan 1 0<"), codes.NON_FINITE),
        ("<COLLADA></COLLADA>", codes.NO_GEOMETRY),
        ("<svg></svg>", codes.WRONG_TYPE),
    ]:
        name = "x.xml" if "svg" in text else "x.dae"
        assert refusal(name, text) == code


def test_every_kind_of_picture_becomes_eight_bit_rgb() -> None:
    for mode in ["1", "L", "LA", "P", "RGB", "RGBA", "CMYK", "I;16"]:
        out = io.BytesIO()
        image = (
            Image.fromarray(QUARTERS).convert("L").convert("I;16")
            if mode == "I;16"
            else Image.fromarray(QUARTERS).convert(mode)
        )
        image.save(out, "JPEG" if mode == "CMYK" else "PNG")
        texture = Images(LIMITS, Notes()).texture("a", out.getvalue(), "Ärger/../x", ImageUse())
        assert texture is not None
        assert (texture.name, texture.width_px, texture.png[24], texture.png[25]) == ("arger_x", 2, 8, 2)
    out = io.BytesIO()  # grey of sixteen bits keeps its brightness
    Image.fromarray(np.array([[0, 65535], [32768, 257]], dtype=np.uint16)).save(out, "PNG")
    pixels = Images(LIMITS, Notes()).pixels("a", out.getvalue())
    assert pixels is not None
    assert pixels[:, :, 0].tolist() == [[0, 255], [128, 1]]


def test_large_pictures_are_refused_unseen_and_big_ones_scaled() -> None:
    notes = Notes()
    images = Images({"input_texture_px": 16384, "input_texture_pixels": 64e6}, notes)
    assert images.texture("bomb", png(np.zeros((20000, 20), dtype=np.uint8)), "x", ImageUse()) is None
    scaled = images.texture("wide", png(np.zeros((2, 8000), dtype=np.uint8)), "x", ImageUse())
    assert scaled is not None
    assert (scaled.width_px, scaled.height_px) == (4096, 1)
    assert [n.code for n in notes.issues] == [codes.IMAGE_REFUSED, codes.IMAGE_DOWNSCALED]

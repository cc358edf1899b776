"""OBJ with MTL, PLY, STL and COLLADA, and pictures of all kinds."""

from __future__ import annotations

import codecs
import io
import struct

import numpy as np
import pytest
from PIL import Image

from casa_assets.formats.read.materials import Images, ImageUse
from casa_assets.formats.read.obj import map_file
from casa_assets.formats.read.raw_parts import triangulate
from casa_assets.formats.read.text import Notes
from casa_assets.model import rejection_codes as codes
from casa_assets.model.source import Up
from tests.support.mesh.mesh_files import LIMITS, OBJ_TRIANGLE, QUARTERS, codes_of, load_bytes, png, refusal, texel


def test_spellings_of_the_same_triangle() -> None:
    for text in [
        codecs.BOM_UTF8 + OBJ_TRIANGLE.replace("\n", "\r\n").replace(" ", "\t").encode(),
        OBJ_TRIANGLE.replace("\n", "\r").encode(),
        OBJ_TRIANGLE.encode("utf-16"),
        OBJ_TRIANGLE.replace("f 1 2 3", "f 1 2 \\\n3").encode(),
        OBJ_TRIANGLE.replace("f 1 2 3", "f -3 -2 -1").encode(),
        OBJ_TRIANGLE.replace("f 1 2 3", "f 1 2// 3/").encode(),
        OBJ_TRIANGLE.replace("f 1 2 3\n", "f 1 2 3 # end").encode(),
        OBJ_TRIANGLE.replace("v 1 0 0", "v 1 0 0 # one").encode(),
    ]:
        mesh = load_bytes("x.obj", text).parts[0].mesh
        assert mesh.vertices[mesh.faces[0]].tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


def test_corners_with_other_uv_are_other_vertices_and_uv_count_from_the_lower_left() -> None:
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 2\nmtllib m.mtl\nusemtl m\n"
    text += "f 1/1/1 2/2/1 3/3/1\nf 2/2/1 4/2/1 3/2/1\n"
    model = load_bytes("x.obj", text, **{"m.mtl": b"newmtl m\nKd 0 0 0\nmap_Kd p.png\n", "p.png": png(QUARTERS)})
    mesh = model.parts[0].mesh
    assert len(mesh.vertices) == 5
    assert np.allclose(np.array(mesh.normals), [0, 0, 1])
    assert texel(model, 0, int(mesh.faces[0][0])) == (0, 0, 255)
    assert model.parts[0].material.base_color == (1.0, 1.0, 1.0, 1.0)


def test_kd_is_a_display_value_that_becomes_linear_and_colours_of_vertices_are_read() -> None:
    mtl = b"newmtl m\nKd 0.5 0 1\nd 0.5\nTr 0.25\nPr 0.3\nPm 0.9\n"
    text = "mtllib m.mtl\nusemtl m\n" + OBJ_TRIANGLE
    material = load_bytes("x.obj", text, **{"m.mtl": mtl}).parts[0].material
    assert material.base_color == pytest.approx((0.21404114, 0.0, 1.0, 0.5))
    assert (material.roughness, material.metallic) == (0.3, 0.9)
    text = OBJ_TRIANGLE.replace("0\nv", "0 1 0.5 0\nv").replace("v 0 1 0\n", "v 0 1 0 1 1 1\n")
    colors = np.array(load_bytes("x.obj", text).parts[0].mesh.colors)
    assert colors.tolist() == [[255, 128, 0, 255], [255, 128, 0, 255], [255, 255, 255, 255]]


def test_options_of_maps_are_stripped_and_height_maps_are_not_taken_for_normal_maps() -> None:
    for line, name in [
        ("-o 0 0 0 -bm 1 my tex.png", "my tex.png"),
        ("-s 1 1 1 -o 0.5 -clamp on a.png", "a.png"),
        ("-mm 0 1 dir\\b.png", "dir\\b.png"),
        ("plain name.jpg", "plain name.jpg"),
        ("-o 3.png", "3.png"),
    ]:
        assert map_file(line) == name
    grey, blue = np.full((4, 4, 3), 128, dtype=np.uint8), np.full((4, 4, 3), (128, 128, 255), dtype=np.uint8)
    text = "vt 0 0\nmtllib m.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/1 3/1\n"
    for pixels, kept in ((grey, False), (blue, True)):
        model = load_bytes("x.obj", text, **{"m.mtl": b"newmtl m\nmap_Bump -bm 1 b.png\n", "b.png": png(pixels)})
        assert (model.parts[0].material.normal_texture is not None) is kept


def test_bad_faces_are_dropped_with_a_note_and_unusable_files_are_refused() -> None:
    for line in ("f 0 1 2", "f 1 2 999999999999", "f 1 2", "f a b c", "f -9 1 2"):
        model = load_bytes("x.obj", OBJ_TRIANGLE + line + "\n")
        assert (len(model.parts[0].mesh.faces), codes_of(model)) == (1, {codes.FACE_DROPPED}), line
    for text, code in [
        ("", codes.EMPTY_FILE),
        ("# nothing\n", codes.EMPTY_FILE),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", codes.NO_FACES),
        ("v 0,5 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", codes.BAD_NUMBER),
        ("v 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", codes.BAD_NUMBER),
        ("v 0 0 0\nf 4 5 6\n", codes.OUT_OF_BOUNDS),
        ("v 0 0 0\n\0\0\0", codes.WRONG_TYPE),
    ]:
        assert refusal("x.obj", text) == code


def test_concave_polygons_keep_their_area() -> None:
    turn, radius = np.arange(10) * np.pi / 5, np.tile([0.3, 1.0], 5)
    star = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.zeros(10)], axis=1)
    points = np.array([star, star[::-1]])
    faces, polygon, fanned = triangulate(points)
    corners = points[polygon[:, None], faces]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] / 2
    whole = 10 * 0.5 * 0.3 * np.sin(np.pi / 5)
    assert fanned == 0
    assert (area[:8] >= 0).all()
    assert (area[8:] <= 0).all()
    assert area[:8].sum() == pytest.approx(whole)
    arrow = np.array([[[0, 0, 0], [2, 1, 0], [0, 2, 0], [0.5, 1, 0]]], dtype=float)  # a quad that is not folded
    faces, _, _ = triangulate(arrow)
    corners = arrow[0][faces]
    assert (np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] > 0).all()


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
    assert np.array(mesh.uv).tolist() == [[0, 0], [1, 0], [1, 1], [0, 1]]
    assert np.array(mesh.colors)[0].tolist() == [255, 0, 7, 255]


def test_ply_corner_coordinates_and_its_picture() -> None:
    head = PLY_HEAD.format("ascii", "").replace("element vertex", "comment TextureFile p q.png\nelement vertex")
    faces = PLY_FACES.format(1, "property list uchar float texcoord\n")
    text = head + faces + "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 6 0 0 1 0 1 1\n"
    model = load_bytes("x.ply", text, **{"p q.png": png(QUARTERS)})
    assert [texel(model, 0, i) for i in range(3)] == [(0, 0, 255), (255, 255, 0), (0, 255, 0)]


def test_bad_ply_is_refused() -> None:
    head, none, one = PLY_HEAD.format("ascii", ""), PLY_FACES.format(0, ""), PLY_FACES.format(1, "")
    for text, code in [
        (PLY_HEAD.format("binary_little_endian", ""), codes.TRUNCATED),
        (PLY_HEAD.format("ebcdic", "") + none, codes.BAD_HEADER),
        (head.replace("4", "2000000000") + none + "0 0 0", codes.LENGTH_MISMATCH),
        (head + none + "0 0 0 " * 4, codes.NO_FACES),
        (head + one + "0 0 0 " * 4 + "3 0 1 9", codes.OUT_OF_BOUNDS),
        (head + one + "0 0 0 " * 3 + "0 0 x 3 0 1 2", codes.BAD_NUMBER),
        (head + one + "0 0 0 " * 4 + "3 0 1", codes.TRUNCATED),
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


def test_dae_hands_on_unit_axis_and_picture_turns_mirrored_nodes_and_reads_colour_as_display_value() -> None:
    model = load_bytes("x.dae", dae())
    assert (model.metres_per_unit, model.up, model.parts[0].name) == (0.0254, Up.X, "node")
    assert model.parts[0].material.base_color == pytest.approx((0.21404114, 0.0, 1.0, 1.0))
    assert model.parts[0].mesh.bounds.tolist() == [[0, 0, 0], [1, 1, 0]]
    assert len(load_bytes("x.dae", dae().replace('<?xml version="1.0"?>', "").encode("utf-16")).parts) == 1
    model = load_bytes("x.dae", dae(TEXTURED, scale="-1 1 1"), **{"p.png": png(QUARTERS)})
    mesh = model.parts[0].mesh
    a, b, c = mesh.vertices[mesh.faces[0]]
    assert np.cross(b - a, c - a)[2] > 0
    at = {tuple(v): texel(model, 0, i) for i, v in enumerate(mesh.vertices.tolist())}
    assert at[(0.0, 0.0, 0.0)] == (0, 0, 255)
    assert at[(-1.0, 1.0, 0.0)] == (0, 255, 0)


def test_bad_dae_is_refused() -> None:
    entity = '<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd">]>\n<COLLADA'
    for text, code in [
        (dae()[: len(dae()) // 2], codes.TRUNCATED),
        (dae().replace("</asset>", "</asse>"), codes.BAD_XML),
        (dae().replace("<COLLADA", entity, 1), codes.XML_ENTITY),
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
        image = Image.fromarray(QUARTERS).convert("L" if mode == "I;16" else mode)
        image.convert(mode).save(out, "JPEG" if mode == "CMYK" else "PNG")
        texture = Images(LIMITS, Notes()).texture("a", out.getvalue(), "Ärger/../x", ImageUse())
        assert texture is not None
        assert (texture.name, texture.width_px, texture.png[24], texture.png[25]) == ("arger_x", 2, 8, 2)
    out = io.BytesIO()  # grey of sixteen bits keeps its brightness
    Image.fromarray(np.array([[0, 65535], [32768, 257]], dtype=np.uint16)).save(out, "PNG")
    pixels = np.array(Images(LIMITS, Notes()).pixels("a", out.getvalue()))
    assert pixels[:, :, 0].tolist() == [[0, 255], [128, 1]]


def test_large_pictures_are_refused_unseen_and_big_ones_scaled() -> None:
    notes = Notes()
    images = Images({"input_texture_px": 16384, "input_texture_pixels": 64e6}, notes)
    assert images.texture("bomb", png(np.zeros((20000, 20), dtype=np.uint8)), "x", ImageUse()) is None
    scaled = images.texture("wide", png(np.zeros((2, 8000), dtype=np.uint8)), "x", ImageUse())
    assert scaled is not None
    assert (scaled.width_px, scaled.height_px) == (4096, 1)
    assert [n.code for n in notes.issues] == [codes.IMAGE_REFUSED, codes.IMAGE_DOWNSCALED]

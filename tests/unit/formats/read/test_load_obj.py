"""Wavefront OBJ and MTL."""

from __future__ import annotations

import codecs

import numpy as np
import pytest

from casa_assets.formats.read.obj import map_file
from casa_assets.formats.read.raw_parts import triangulate
from casa_assets.model import rejection_codes as codes
from tests.support.mesh.mesh_files import OBJ_TRIANGLE, QUARTERS, codes_of, load_bytes, png, refusal, texel


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
    assert mesh.normals is not None
    assert np.allclose(mesh.normals, [0, 0, 1])
    corner = int(mesh.faces[0][0])
    assert texel(model, 0, corner) == (0, 0, 255)
    assert model.parts[0].material.base_color == (1.0, 1.0, 1.0, 1.0)


def test_kd_is_a_display_value_and_becomes_linear() -> None:
    mtl = b"newmtl m\nKd 0.5 0 1\nd 0.5\nTr 0.25\nPr 0.3\nPm 0.9\n"
    text = "mtllib m.mtl\nusemtl m\n" + OBJ_TRIANGLE
    material = load_bytes("x.obj", text, **{"m.mtl": mtl}).parts[0].material
    assert material.base_color == pytest.approx((0.21404114, 0.0, 1.0, 0.5))
    assert (material.roughness, material.metallic) == (0.3, 0.9)


def test_vertex_colours() -> None:
    text = OBJ_TRIANGLE.replace("0\nv", "0 1 0.5 0\nv").replace("v 0 1 0\n", "v 0 1 0 1 1 1\n")
    colors = load_bytes("x.obj", text).parts[0].mesh.colors
    assert colors is not None
    assert colors.tolist() == [[255, 128, 0, 255], [255, 128, 0, 255], [255, 255, 255, 255]]


def test_map_options_are_stripped() -> None:
    for line, name in [
        ("-o 0 0 0 -bm 1 my tex.png", "my tex.png"),
        ("-s 1 1 1 -o 0.5 -clamp on a.png", "a.png"),
        ("-mm 0 1 dir\\b.png", "dir\\b.png"),
        ("plain name.jpg", "plain name.jpg"),
        ("-o 3.png", "3.png"),
    ]:
        assert map_file(line) == name


def test_height_maps_are_not_taken_for_normal_maps() -> None:
    grey, blue = np.full((4, 4, 3), 128, dtype=np.uint8), np.full((4, 4, 3), (128, 128, 255), dtype=np.uint8)
    text = "vt 0 0\nmtllib m.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/1 3/1\n"
    for pixels, kept in ((grey, False), (blue, True)):
        model = load_bytes("x.obj", text, **{"m.mtl": b"newmtl m\nmap_Bump -bm 1 b.png\n", "b.png": png(pixels)})
        assert (model.parts[0].material.normal_texture is not None) is kept


def test_bad_faces_are_dropped_with_a_note() -> None:
    for line in ("f 0 1 2", "f 1 2 999999999999", "f 1 2", "f a b c", "f -9 1 2"):
        model = load_bytes("x.obj", OBJ_TRIANGLE + line + "\n")
        assert (len(model.parts[0].mesh.faces), codes_of(model)) == (1, {codes.FACE_DROPPED}), line


def test_unusable_files_are_refused() -> None:
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
    star = [
        ((1.0 if i % 2 else 0.3) * np.array([np.cos(i * np.pi / 5), np.sin(i * np.pi / 5), 0.0])) for i in range(10)
    ]
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

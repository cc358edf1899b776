"""A box in every format that takes a library or a reader of our own to write: small sound files, made in code."""

from __future__ import annotations

import base64
import io
import struct
import tarfile
import tempfile
import zipfile
from pathlib import Path

import DracoPy
import numpy as np
from pxr import Sdf

from tests.support.mesh.mesh_files import QUARTERS, UASTC, Gltf, png
from tests.support.mesh.meshes import box_mesh

BOX = box_mesh((0.08, 0.1, 0.06), (0.0, 0.05, 0.0), shared=True)


def draco_glb() -> bytes:
    """Compressed by Draco, with a KTX2 picture."""
    uv = BOX.vertices[:, :2] * 10.0
    data = DracoPy.encode(BOX.vertices, BOX.faces, tex_coord=uv, quantization_bits=16, preserve_order=True)
    kinds = {one["attribute_type"]: one["unique_id"] for one in DracoPy.decode(data).attributes}
    made = Gltf([(0.0, 0.0, 0.0)] * len(BOX.vertices), [0] * BOX.faces.size)
    made.attributes["TEXCOORD_0"] = made.add(uv.astype("<f4"), "VEC2")
    for accessor in made.accessors:
        del accessor["bufferView"]
    made.paint(UASTC)
    ids = {"POSITION": kinds[0], "TEXCOORD_0": kinds[3]}
    made.primitive["extensions"] = {"KHR_draco_mesh_compression": {"bufferView": made.view(data), "attributes": ids}}
    made.document["textures"] = [{"extensions": {"KHR_texture_basisu": {"source": 0}}}]
    made.document["extensionsRequired"] = ["KHR_draco_mesh_compression", "KHR_texture_basisu"]
    return made.glb()


def usda(points: str = "", head: str = "", inside: str = "") -> str:
    """A box of centimetres, z up, with a picture; `head` joins the metadata of its prim, `inside` its content."""
    written = points or ", ".join(f"({x * 100:g}, {y * 100:g}, {z * 100:g})" for x, y, z in BOX.vertices)
    corners = ", ".join(map(str, BOX.faces.ravel()))
    uv = ", ".join("(0, 0), (1, 0), (0, 1)" for _ in BOX.faces)
    return f"""#usda 1.0
(
    defaultPrim = "thing"
    metersPerUnit = 0.01
    upAxis = "Z"
)
def Xform "thing" ({head})
{{
    {inside}
    def Mesh "box" (prepend apiSchemas = ["MaterialBindingAPI"])
    {{
        int[] faceVertexCounts = [{", ".join("3" for _ in BOX.faces)}]
        int[] faceVertexIndices = [{corners}]
        point3f[] points = [{written}]
        texCoord2f[] primvars:st = [{uv}] (interpolation = "faceVarying")
        rel material:binding = </thing/paint>
    }}
    def Material "paint" {{
        token outputs:surface.connect = </thing/paint/look.outputs:surface>
        def Shader "look" {{
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor.connect = </thing/paint/picture.outputs:rgb>
            float inputs:roughness = 0.3
            token outputs:surface
        }}
        def Shader "picture" {{
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @a.png@
            float3 outputs:rgb
        }}
    }}
}}
"""


def usdz(layer: str = "", **members: bytes) -> bytes:
    """A package of a layer, its picture and more members."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_STORED) as packed:
        packed.writestr(zipfile.ZipInfo("a.usda"), layer or usda())
        packed.writestr(zipfile.ZipInfo("a.png"), png(QUARTERS))
        for name, data in members.items():
            packed.writestr(zipfile.ZipInfo(name), data)
    return out.getvalue()


def usdc() -> bytes:
    """The same box as a crate, without a picture."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(usda())
    with tempfile.TemporaryDirectory() as folder:
        layer.Export(f"{folder}/a.usdc")
        return Path(folder, "a.usdc").read_bytes()


def fbx(picture: bytes = b"", indices: str = "", points: str = "") -> bytes:
    """A text FBX in centimetres, y up; the picture lies in it where one is given, else beside it."""
    corners = indices or ",".join(f"{a},{b},{-c - 1}" for a, b, c in BOX.faces)
    written = points or ",".join(f"{v * 100:g}" for v in BOX.vertices.ravel())
    numbers = {"UpAxis": 1, "UpAxisSign": 1, "FrontAxis": 2, "FrontAxisSign": 1, "CoordAxis": 0, "CoordAxisSign": 1}
    axes = "\n        ".join(f'P: "{name}", "int", "Integer", "",{number}' for name, number in numbers.items())
    content = f'Content: , "{base64.b64encode(picture).decode()}"' if picture else ""
    return f"""; FBX 7.4.0 project file
FBXHeaderExtension:  {{ FBXHeaderVersion: 1003
    FBXVersion: 7400
}}
GlobalSettings:  {{
    Properties70:  {{
        {axes}
        P: "UnitScaleFactor", "double", "Number", "",1
    }}
}}
Objects:  {{
    Geometry: 10, "Geometry::box", "Mesh" {{
        Vertices: *{written.count(",") + 1} {{ a: {written} }}
        PolygonVertexIndex: *{corners.count(",") + 1} {{ a: {corners} }}
        LayerElementUV: 0 {{
            Name: "map"
            MappingInformationType: "ByPolygonVertex"
            ReferenceInformationType: "Direct"
            UV: *{BOX.faces.size * 2} {{ a: {",".join("0,0,1,0,0,1" for _ in BOX.faces)} }}
        }}
        Layer: 0 {{ LayerElement:  {{ Type: "LayerElementUV"
            TypedIndex: 0 }} }}
    }}
    Model: 11, "Model::thing", "Mesh" {{
        Properties70:  {{ P: "Lcl Translation", "Lcl Translation", "", "A",0,2,0 }}
    }}
    Material: 12, "Material::paint", "" {{
        ShadingModel: "phong"
        Properties70:  {{ P: "DiffuseColor", "Color", "", "A",0.5,0.2,0.1 }}
    }}
    Video: 14, "Video::picture", "Clip" {{
        Type: "Clip"
        Filename: "a.png"
        RelativeFilename: "a.png"
        {content}
    }}
    Texture: 13, "Texture::picture", "" {{
        Type: "TextureVideoClip"
        FileName: "a.png"
        RelativeFilename: "a.png"
    }}
}}
Connections:  {{
    C: "OO",11,0
    C: "OO",10,11
    C: "OO",12,11
    C: "OP",13,12, "DiffuseColor"
    C: "OO",14,13
}}
""".encode()


def x3d(geometry: str = "", head: str = "") -> str:
    """X3D of a box, moved up by 2 cm, with a picture."""
    points = " ".join(f"{v:g}" for v in BOX.vertices.ravel())
    index = " ".join(f"{a} {b} {c} -1" for a, b, c in BOX.faces)
    uv = " ".join(f"{v:g}" for v in (BOX.vertices[:, :2] * 10).ravel())
    made = geometry or (
        f"<IndexedFaceSet coordIndex='{index}'><Coordinate point='{points}'/>"
        f"<TextureCoordinate point='{uv}'/></IndexedFaceSet>"
    )
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<!DOCTYPE X3D PUBLIC "ISO//Web3D//DTD X3D 3.3//EN" "http://www.web3d.org/specifications/x3d-3.3.dtd">
<X3D profile="Interchange" version="3.3"><head>{head}</head><Scene>
<Transform DEF="place" translation="0 0.02 0"><Shape DEF="thing">
<Appearance><Material diffuseColor="0.5 0.2 0.1"/><ImageTexture url='"a.png"'/></Appearance>
{made}</Shape></Transform></Scene></X3D>
"""


def wrl(geometry: str = "") -> str:
    """VRML of a box, moved up by 2 cm."""
    points = ", ".join(f"{x:g} {y:g} {z:g}" for x, y, z in BOX.vertices)
    index = ", ".join(f"{a}, {b}, {c}, -1" for a, b, c in BOX.faces)
    made = geometry or f"IndexedFaceSet {{ coord Coordinate {{ point [ {points} ] }} coordIndex [ {index} ] }}"
    return f"""#VRML V2.0 utf8
# a box
DEF place Transform {{
  translation 0 0.02 0
  children [ DEF thing Shape {{
    appearance Appearance {{ material Material {{ diffuseColor 0.5 0.2 0.1 transparency 0 }}
                             texture ImageTexture {{ url "a.png" }} }}
    geometry {made}
  }} ]
}}
"""


def chunk(kind: int, data: bytes) -> bytes:
    return struct.pack("<HI", kind, 6 + len(data)) + data


def max3ds(count: int | None = None) -> bytes:
    """A 3DS of a box with a material and a picture; `count` is what it claims to have of points."""
    points = BOX.vertices[:, [0, 2, 1]].astype("<f4")
    faces = np.column_stack((BOX.faces, np.zeros(len(BOX.faces)))).astype("<u2")
    uv = (BOX.vertices[:, :2] * 10).astype("<f4")
    used = chunk(0x4130, b"paint\0" + struct.pack("<H", len(faces)) + np.arange(len(faces), dtype="<u2").tobytes())
    mesh = chunk(0x4110, struct.pack("<H", len(points) if count is None else count) + points.tobytes())
    mesh += chunk(0x4140, struct.pack("<H", len(uv)) + uv.tobytes())
    mesh += chunk(0x4120, struct.pack("<H", len(faces)) + faces.tobytes() + used)
    look = chunk(0xA000, b"paint\0") + chunk(0xA020, chunk(0x0011, bytes((128, 60, 30))))
    look += chunk(0xA200, chunk(0xA300, b"a.png\0"))
    return chunk(0x4D4D, chunk(0x3D3D, chunk(0xAFFF, look) + chunk(0x4000, b"thing\0" + chunk(0x4100, mesh))))


def zipped(**members: bytes) -> bytes:
    """A zip of members, packed."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, data in members.items():
            packed.writestr(zipfile.ZipInfo(name), data, compress_type=zipfile.ZIP_DEFLATED)
    return out.getvalue()


def tarred(**members: bytes) -> bytes:
    """A tar of members, packed by gzip."""
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w:gz") as packed:
        for name, data in members.items():
            info = tarfile.TarInfo(name)
            info.size = len(data)
            packed.addfile(info, io.BytesIO(data))
    return out.getvalue()

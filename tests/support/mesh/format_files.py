"""A box in every format that takes a library or a reader of our own to write: small sound files, made in code."""

from __future__ import annotations

import io
import tarfile
import tempfile
import zipfile
from pathlib import Path

from pxr import Sdf

from tests.support.mesh.meshes import box_mesh

BOX = box_mesh((0.08, 0.1, 0.06), (0.0, 0.05, 0.0), shared=True)


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
def Xform "thing" (
    {head}
)
{{
    {inside}
    def Mesh "box" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    )
    {{
        int[] faceVertexCounts = [{", ".join("3" for _ in BOX.faces)}]
        int[] faceVertexIndices = [{corners}]
        point3f[] points = [{written}]
        texCoord2f[] primvars:st = [{uv}] (
            interpolation = "faceVarying"
        )
        rel material:binding = </thing/paint>
    }}
    def Material "paint"
    {{
        token outputs:surface.connect = </thing/paint/look.outputs:surface>
        def Shader "look"
        {{
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor.connect = </thing/paint/picture.outputs:rgb>
            float inputs:roughness = 0.3
            token outputs:surface
        }}
        def Shader "picture"
        {{
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @a.png@
            float3 outputs:rgb
        }}
    }}
}}
"""


def usdc() -> bytes:
    """The same box as a crate, without a picture."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(usda())
    with tempfile.TemporaryDirectory() as folder:
        layer.Export(f"{folder}/a.usdc")
        return Path(folder, "a.usdc").read_bytes()


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

"""Asset -> `<id>.urdf`, what URDF cannot say as JSON beside it, and the meshes and images that it names."""

from __future__ import annotations

from lxml import etree

from casa_assets.export.urdf import body, label, visual
from casa_assets.model.asset.asset import Asset
from casa_assets.model.files import Files


def write(asset: Asset) -> Files:
    """The URDF package of an asset; the same asset is the same bytes.

    Returns:
        `<id>.urdf` (root link `object`, not tied to anything), `<id>.json`, and `meshes/` with OBJ, MTL and PNG
        files. Paths are plain and relative to the URDF, without `package://`.
    """
    meshes = visual.gather_meshes(asset)
    return Files.of({**texts(asset, meshes), **meshes.entries})


def texts(asset: Asset, meshes: visual.Meshes) -> dict[str, bytes]:
    """`<id>.urdf` and `<id>.json`, which lie beside the folders of the meshes."""
    root = robot(asset.id)
    body.add_all(root, body.BodyContext(asset, meshes))
    return {
        urdf_name(asset.id): document_text(root),
        json_name(asset.id): label.json_text(label.facts_beside(asset, urdf_name(asset.id))),
    }


def urdf_name(asset: str) -> str:
    """Name of the URDF of an asset."""
    return f"{asset}.urdf"


def json_name(asset: str) -> str:
    """Name of the JSON beside the URDF of an asset."""
    return f"{asset}.json"


def robot(name: str) -> etree._Element:
    """`<robot>`, with the settings under which MuJoCo reads all of it; other programs pass over them."""
    root = etree.Element("robot", {"name": name})
    settings = {"strippath": "false", "discardvisual": "false", "fusestatic": "false"}
    etree.SubElement(etree.SubElement(root, "mujoco"), "compiler", settings)
    return root


def document_text(root: etree._Element) -> bytes:
    """The file."""
    return etree.tostring(root, encoding="us-ascii", pretty_print=True, xml_declaration=True)

"""Asset -> `<id>.urdf`, `<id>.json` with data that URDF cannot represent, and the meshes and images of both."""

from __future__ import annotations

from lxml import etree

from casa_assets.export.urdf import body, label, visual
from casa_assets.model.asset.asset import Asset
from casa_assets.model.files import Files


def write(asset: Asset) -> Files:
    """Return the URDF package of an asset; the same asset gives the same bytes.

    Returns:
        `<id>.urdf` (root link `object`, not attached to anything), `<id>.json`, and `meshes/` with OBJ, MTL and PNG
        files. Paths are plain and relative to the URDF, without `package://`.
    """
    meshes = visual.gather_meshes(asset)
    return Files.of({**texts(asset, meshes), **meshes.entries})


def texts(asset: Asset, meshes: visual.Meshes) -> dict[str, bytes]:
    """`<id>.urdf` and `<id>.json`, which are in the same folder as the folders of the meshes."""
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
    """Name of the JSON file that accompanies the URDF of an asset."""
    return f"{asset}.json"


def robot(name: str) -> etree._Element:
    """`<robot>`, with the settings with which MuJoCo reads all of it; other programs ignore them."""
    root = etree.Element("robot", {"name": name})
    settings = {"strippath": "false", "discardvisual": "false", "fusestatic": "false"}
    etree.SubElement(etree.SubElement(root, "mujoco"), "compiler", settings)
    return root


def document_text(root: etree._Element) -> bytes:
    """Return the file."""
    return etree.tostring(root, encoding="us-ascii", pretty_print=True, xml_declaration=True)

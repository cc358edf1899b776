"""MJCF file -> fact table, by way of the model that MuJoCo compiles from it."""

from __future__ import annotations

import hashlib
from pathlib import Path

import mujoco

from casa_assets.checks.package.facts import AssetFacts, BodyFacts, ProgramTexts, StateFacts
from casa_assets.checks.readers import mujoco_load
from casa_assets.checks.readers.mujoco_facts import facts_of_model
from casa_assets.model.asset.asset import Base
from casa_assets.model.pose import Pose


def facts(path: Path) -> AssetFacts:
    """The table of a model.xml or scene.xml: joints at zero, root at the origin.

    The unnamed body around `object` is no body of the asset. Base and words are custom texts.

    Raises:
        ValueError: the file does not compile, or does not say what its base is.
    """
    loaded = mujoco_load.load_mjcf(path)
    if loaded.model is None:
        raise ValueError(f"{path.name} does not compile: {loaded.error}")
    model = loaded.model
    said = texts(model)
    geoms, joints = {model.geom(i).name for i in range(model.ngeom)}, {model.joint(i).name for i in range(model.njnt)}
    table = facts_of_model(model, base=Base(said.get("base", "")), words=words(said, geoms, joints))
    bodies = [body for body in table.bodies if body.name]
    roots = [Pose(position=b.position, quaternion=b.quaternion) for b in bodies if not b.parent]
    if len(roots) != 1:
        raise ValueError(f"{path.name} has {len(roots)} root bodies, not one")
    return table.replace(bodies=tuple(_seen_from(roots[0], body) for body in bodies))


def _seen_from(root: Pose, body: BodyFacts) -> BodyFacts:
    pose = root.inverse() @ Pose(position=body.position, quaternion=body.quaternion)
    return body.replace(position=pose.position, quaternion=pose.quaternion)


def words(texts: dict[str, str], geoms: set[str], joints: set[str]) -> ProgramTexts:
    """Words of the texts; of geoms and joints those that there are."""
    labels = [(name, label) for label, names in _after("label__", texts) for name in names.split() if name in geoms]
    grips = [(joint, name) for joint, name in _after("grip__", texts) if joint in joints and name in geoms]
    behind = [(joint, name) for joint, name in _after("behind__", texts) if joint in joints and name in joints]
    return ProgramTexts(
        classes=tuple(texts.get("class", "").split()),
        portion=texts.get("portion", ""),
        labels=tuple(sorted(labels)),
        grips=tuple(sorted(grips)),
        behind=tuple(sorted(behind)),
        states=tuple(_state(name, data) for name, data in sorted(_after("state__", texts))),
        contract=texts.get("contract", ""),
        behavior=hashlib.sha256(texts["behavior"].encode()).hexdigest() if "behavior" in texts else "",
    )


def _after(prefix: str, texts: dict[str, str]) -> list[tuple[str, str]]:
    """(rest of the name, text) of the texts whose names begin so."""
    return [(name.removeprefix(prefix), data) for name, data in texts.items() if name.startswith(prefix)]


def _state(name: str, data: str) -> StateFacts:
    joint, value, low, high = data.split()
    return StateFacts(name=name, joint=joint, value=value, interval=(float(low), float(high)))


def texts(model: mujoco.MjModel) -> dict[str, str]:
    """Custom texts by name."""
    data, names = bytes(model.text_data), bytes(model.names)
    starts = zip(model.name_textadr, model.text_adr, strict=True)
    return {_string(names, int(name)): _string(data, int(text)) for name, text in starts}


def _string(data: bytes, start: int) -> str:
    """The text that ends at the next zero byte."""
    return data[start : data.index(0, start)].decode()

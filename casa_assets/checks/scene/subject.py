"""A written scene as MuJoCo has it: compiled once, with what every check asks of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import mujoco
import numpy as np
from lxml import etree

from casa_assets.checks.motion.motion_model import open_before, open_end
from casa_assets.checks.readers.mujoco_load import Loaded, load_asset_file, native_warnings
from casa_assets.core.typing import Floats, Ints, Mask
from casa_assets.model.asset.asset import Asset, Base, Joint
from casa_assets.model.kitchen.scene import Placement, Scene

FILE = "scene.xml"
START = "start"


@dataclass(frozen=True)
class ScenePart:
    """A joint of a placement, as the model numbers it.

    Attributes:
        place, asset, joint: whose it is. name: `<placement>__<joint>`.
        number: in the model. address: in qpos. dof: in qvel.
        moved: (nbody,) what it carries along. geoms: numbers of the colliders of those bodies.
        before: joints of the same placement that have to stand open, by name in the model: rad or m.
    """

    place: Placement
    asset: Asset
    joint: Joint
    name: str
    number: int
    address: int
    dof: int
    moved: Mask
    geoms: Ints
    before: dict[str, float]

    @property
    def far(self) -> float:
        """The end of its range where it is open, rad or m."""
        return open_end(self.joint)


@dataclass(frozen=True, eq=False)
class SceneSubject:
    """A scene and the folder that holds its `scene.xml`.

    What is made of the file is made once, when the first check asks; a subject is equal to itself alone.

    Attributes:
        scene: what the writer was given. root: its folder.
    """

    scene: Scene
    root: Path

    @property
    def mjcf(self) -> Path:
        """The file."""
        return self.root / FILE

    @cached_property
    def loaded(self) -> Loaded:
        """The whole file, with pictures, and what MuJoCo says of it."""
        return load_asset_file(self.mjcf)

    @cached_property
    def model(self) -> mujoco.MjModel:
        """Collision model: no visuals, images and materials. Whoever changes it puts it back.

        It leaves out the pairs that the file does; who asks whether things are in each other enters `AllPairs`.
        Raises ValueError where the file does not compile.
        """
        return touched_model(self.mjcf)

    @cached_property
    def data(self) -> mujoco.MjData:
        """As the scene begins, with its contacts, of all pairs; shared, so nobody steps it."""
        data = mujoco.MjData(self.model)
        reset(self.model, data)
        with AllPairs(self.model):
            mujoco.mj_forward(self.model, data)
        return data

    @cached_property
    def assets(self) -> dict[str, Asset]:
        """Name of a placement -> its asset."""
        return self.scene.asset_of

    @cached_property
    def owner(self) -> list[str]:
        """Number of a geom -> name of its placement."""
        roots = [str(self.model.body(i).name) for i in range(self.model.nbody)]
        return [roots[self.model.body_rootid[body]] for body in self.model.geom_bodyid]

    @cached_property
    def geoms_of(self) -> dict[str, Ints]:
        """Name of a placement -> numbers of its geoms."""
        found: dict[str, list[int]] = {place.name: [] for place in self.scene.placements}
        for geom, name in enumerate(self.owner):
            found[name].append(geom)
        return {name: np.array(geoms, dtype=np.int64) for name, geoms in found.items()}

    @cached_property
    def is_fixed(self) -> Mask:
        """(ngeom,) whether a geom never moves."""
        mask: Mask = self.model.body_weldid[self.model.geom_bodyid] == 0
        return mask

    @cached_property
    def parts(self) -> tuple[ScenePart, ...]:
        """All joints of all placements, in the order of the scene."""
        return tuple(self._parts())

    def _parts(self) -> Iterator[ScenePart]:
        model = self.model
        for place in self.scene.placements:
            asset = self.assets[place.name]
            for joint in asset.joints:
                name = f"{place.name}__{joint.name}"
                number = int(model.joint(name).id)
                moved = carried(model, int(model.jnt_bodyid[number]))
                yield ScenePart(
                    place=place,
                    asset=asset,
                    joint=joint,
                    name=name,
                    number=number,
                    address=int(model.jnt_qposadr[number]),
                    dof=int(model.jnt_dofadr[number]),
                    moved=moved,
                    geoms=np.flatnonzero(moved[model.geom_bodyid]),
                    before={f"{place.name}__{k}": v for k, v in open_before(asset, joint).items()},
                )

    @cached_property
    def part_of(self) -> dict[str, ScenePart]:
        """Name of a joint in the model -> the part."""
        return {part.name: part for part in self.parts}

    @cached_property
    def free(self) -> tuple[Placement, ...]:
        """Placements that stand by their weight."""
        return tuple(p for p in self.scene.placements if self.assets[p.name].base is Base.FREE)

    @cached_property
    def fixed(self) -> tuple[Placement, ...]:
        """Placements that are held where they are."""
        return tuple(p for p in self.scene.placements if self.assets[p.name].base is Base.FIXED)

    def message(self, geom: int) -> str:
        """Name of a geom for people."""
        return str(self.model.geom(geom).name)

    def category(self, place: str) -> str:
        """Category of a placement: `counter`, `sink`, `base_cabinet` ..."""
        return self.assets[place].labels.classes[0]


def touched_model(path: Path) -> mujoco.MjModel:
    """A scene file compiled without what is only seen.

    The text is cut before MuJoCo reads it: deleting a thousand geoms from a specification takes ten times as long as
    all else. Raises ValueError where it does not compile.
    """
    root = etree.parse(str(path)).getroot()
    for geom in [g for g in root.iter("geom") if g.get("contype") == "0" and g.get("conaffinity") == "0"]:
        parent = geom.getparent()
        assert parent is not None, "a geom lies in a body"
        parent.remove(geom)
    for geom in root.iter("geom"):
        if "material" in geom.attrib:
            del geom.attrib["material"]
    used = {g.get("mesh") for g in root.iter("geom")}
    for asset in root.iter("asset"):
        for child in list(asset):
            if child.tag != "mesh" or child.get("name") not in used:
                asset.remove(child)
    compiler = root.find("compiler")
    if compiler is None:
        compiler = etree.SubElement(root, "compiler")
    compiler.set("meshdir", str(path.parent.resolve()))
    # What it warns of is told of the whole file.
    with native_warnings():
        return mujoco.MjModel.from_xml_string(etree.tostring(root, encoding="unicode"))


class AllPairs:
    """While it is entered, pairs that the file excludes can meet as well.

    A door is not tried against the frame that it hangs in, for the sake of speed: whether it is in it has to be seen.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self.model = model
        self.kept = model.exclude_signature.copy()

    def __enter__(self) -> None:
        # Ref: mjModel.exclude_signature is (body1 << 16) + body2, sorted; the world is never tried against itself.
        self.model.exclude_signature[:] = 0

    def __exit__(self, *_: object) -> None:
        self.model.exclude_signature[:] = self.kept


def reset(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Everything as the scene begins: its key `start`, or zero where it has none."""
    key = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, START)
    if key >= 0:
        mujoco.mj_resetDataKeyframe(model, data, key)
    else:
        mujoco.mj_resetData(model, data)


def carried(model: mujoco.MjModel, body: int) -> Mask:
    """(nbody,) a body and all that it carries."""
    moved = np.zeros(model.nbody, dtype=bool)
    moved[body] = True
    for other in range(body + 1, model.nbody):
        moved[other] |= moved[model.body_parentid[other]]
    return moved


def boxes(model: mujoco.MjModel, data: mujoco.MjData, geoms: Ints) -> Floats:
    """(N, 2, 3) corners of the boxes around geoms where they are now, world frame, metres."""
    turn = data.geom_xmat[geoms].reshape(-1, 3, 3)
    middle = data.geom_xpos[geoms] + np.einsum("nij,nj->ni", turn, model.geom_aabb[geoms, :3])
    half = np.einsum("nij,nj->ni", np.abs(turn), model.geom_aabb[geoms, 3:])
    return np.stack([middle - half, middle + half], axis=1)


def around(corners: Floats) -> Floats:
    """(2, 3) corners of the box around (N, 2, 3) boxes; of none it is empty."""
    return np.array([corners[:, 0].min(axis=0, initial=np.inf), corners[:, 1].max(axis=0, initial=-np.inf)])


def meet(one: Floats, other: Floats, gap: float = 0.0) -> Mask:
    """True where boxes (..., 2, 3) come within `gap` metres of each other."""
    apart = (one[..., 0, :] > other[..., 1, :] + gap) | (other[..., 0, :] > one[..., 1, :] + gap)
    mask: Mask = np.logical_not(np.any(apart, axis=-1))
    return mask


def corners(bounds: Floats) -> Floats:
    """(8 N, 3) corners of (N, 2, 3) boxes."""
    grid = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)])
    return np.concatenate([np.where(grid, box[1], box[0]) for box in bounds])

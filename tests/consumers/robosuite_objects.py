"""Loads objects of an export as RoboCasa v1.0 and v0.2 do, drops them on a floor and tells. Prints one JSON object.

    python robosuite_objects.py FOLDER

Runs in robosuite's own environment. RoboCasa itself is not on a package index; what its object class does to a model
before and after robosuite's own class has read it is repeated here: the copy beside the file, the free joint, scaling
of every geom, mesh, body and site, contact numbers forced on every geom, the region `bbox` for size and offsets (v1.0)
or the three sites beside the body (v0.2).
"""

from __future__ import annotations

import importlib.util
import json
import shutil
import sys
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import robosuite
from robosuite.models.arenas import EmptyArena
from robosuite.models.objects import MujocoXMLObject
from robosuite.models.tasks import Task

# What RoboCasa's categories force on every geom of an object.
FORCED = {"solref": "0.001 2", "solimp": "0.998 0.998 0.001", "density": "100", "friction": "0.95 0.3 0.1"}
LIFT_M, APART_M, STEPS = 0.01, 0.6, 500


def numbers(text: str) -> np.ndarray:
    return np.array([float(word) for word in text.split()])


class Loaded(MujocoXMLObject):
    """An object as RoboCasa's class makes it, scaled by three factors."""

    def __init__(self, name: str, path: Path, scale: float) -> None:
        copy = path.with_name(f"copied_{name}.xml")
        shutil.copyfile(path, copy)
        try:
            super().__init__(
                str(copy),
                name=name,
                joints=[{"type": "free", "damping": "0.0005"}],
                obj_type="all",
                duplicate_collision_geoms=False,
                scale=[scale] * 3,
            )
        finally:
            copy.unlink()
        regions = [g for g in self.worldbody.iter("geom") if g.get("name", "").split(f"{name}_")[1].startswith("reg_")]
        self.box = next(g for g in regions if g.get("name") == f"{name}_reg_bbox")
        for region in regions:
            assert region.get("pos")
            assert region.get("size")
            region.set("rgba", " ".join(map(str, [*numbers(region.get("rgba"))[:3], 0])))

    def set_scale(self, scale: Any, obj: Any = None) -> None:
        """Every number of a length, and the contact numbers; a size of one number is refused."""
        root = self._obj if obj is None else obj
        factor = np.array(scale, dtype=float)
        for geom in root.iter("geom"):
            for name, value in FORCED.items():
                geom.set(name, value)
            size = numbers(geom.get("size", ""))
            if len(size) == 1:
                raise ValueError(f"{geom.get('name')}: a size of one number")
            if len(size):
                geom.set("size", " ".join(map(str, size * factor[: len(size)])))
        for mesh in self.asset.findall("mesh"):
            mesh.set("scale", " ".join(map(str, numbers(mesh.get("scale", "1 1 1")) * factor)))
        placed = [*root.iter("geom"), *root.iter("body"), *root.iter("joint"), *self.worldbody.iter("site")]
        for element in placed:
            if element.get("pos") is not None:
                element.set("pos", " ".join(map(str, numbers(element.get("pos")) * factor)))

    @property
    def second_bottom(self) -> np.ndarray:
        """As v1.0 finds it."""
        center, half = numbers(self.box.get("pos")), numbers(self.box.get("size"))
        return center - [0, 0, half[2]]

    @property
    def second_size(self) -> np.ndarray:
        return 2 * numbers(self.box.get("size"))

    @property
    def first_size(self) -> np.ndarray:
        """As v0.2 finds it, from robosuite's own sites."""
        radius = self.worldbody.find(f"./body/site[@name='{self.naming_prefix}horizontal_radius_site']")
        x, y, _ = 2 * numbers(radius.get("pos"))
        return np.array([x, y, self.top_offset[2] - self.bottom_offset[2]])


def dropped(paths: list[Path], scale: float) -> list[dict[str, Any]]:
    loaded = [Loaded(f"obj{i}", path, scale) for i, path in enumerate(paths)]
    for i, one in enumerate(loaded):
        one.set_pos([APART_M * i, 0.0, LIFT_M - one.second_bottom[2]])
    model = Task(EmptyArena(), [], loaded).get_model(mode="mujoco")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    begun = data.qpos.copy()
    for _ in range(STEPS):
        mujoco.mj_step(model, data)
    rows = []
    for path, one in zip(paths, loaded, strict=True):
        body, joint = model.body(one.root_body), model.joint(one.joints[0])
        at = int(joint.qposadr[0])
        rows.append(
            {
                "path": str(path),
                "mass": float(model.body_subtreemass[body.id]),
                "size_v1_0": one.second_size.tolist(),
                "size_v0_2": one.first_size.tolist(),
                "moved_m": float(np.linalg.norm(data.qpos[at : at + 2] - begun[at : at + 2])),
                "fell_m": float(begun[at + 2] - data.qpos[at + 2]),
                "turned": float(
                    2 * np.arccos(min(1.0, abs(float(data.qpos[at + 3 : at + 7] @ begun[at + 3 : at + 7]))))
                ),
                "finite": bool(np.isfinite(data.qpos).all()),
            }
        )
    return rows


class Rows:
    """What RoboCasa v1.0 makes of a category: attributes, and models found one folder below those named."""

    def __init__(
        self,
        name: str,
        types: Any,
        model_folders: Any = None,
        exclude: Any = None,
        graspable: bool = False,
        washable: bool = False,
        microwavable: bool = False,
        cookable: bool = False,
        fridgable: bool = False,
        freezable: bool = False,
        dishwashable: bool = False,
        scale: Any = 1.0,
    ) -> None:
        assert isinstance(types, tuple)
        assert isinstance(scale, float)
        self.types, self.graspable, self.washable = types, graspable, washable
        found = [path for folder in model_folders for path in sorted(Path(folder).glob("*/model.xml"))]
        self.mjcf_paths = [str(path) for path in found if path.parent.name not in exclude]


def registered(folder: Path) -> dict[str, dict[str, list[str]]]:
    """Registry -> category -> models, as the script of the export puts them into tables."""
    spec = importlib.util.spec_from_file_location("casa_objects", folder / "casa_objects.py")
    assert spec is not None
    assert spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    categories: dict[str, dict[str, Rows]] = {}
    names = script.fill(Rows, categories, {"all": []}, folder)
    return {name: {kind: own[name].mjcf_paths for kind, own in categories.items() if name in own} for name in names}


def main() -> None:
    folder = Path(sys.argv[1])
    said: list[str] = []
    mujoco.set_mju_user_warning(said.append)
    lists = registered(folder)
    paths = sorted(Path(path) for own in lists["casa"].values() for path in own)
    stood = [path.with_name("model_upright.xml") for path in paths if path.with_name("model_upright.xml").is_file()]
    found = {
        "robosuite": robosuite.__version__,
        "registered": lists,
        "lying": dropped(paths, 1.0),
        "half": dropped(paths, 0.5),
        "stood": [{"path": str(p), "size": Loaded("up", p, 1.0).second_size.tolist()} for p in stood],
        "left": sorted(str(p) for p in folder.rglob("copied_*")),
        "warnings": said,
    }
    print(json.dumps(found))


if __name__ == "__main__":
    main()

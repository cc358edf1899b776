"""Assets one at a time: built from numbers, opened, written, checked, shown; poses in which they rest."""

from __future__ import annotations

import json
import os
import sys
import tempfile
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from casa_assets.api.behaviors import Behaviors
from casa_assets.api.kitchen import Detail, Kitchen
from casa_assets.core.numeric import Floats
from casa_assets.core.system import cache_dir
from casa_assets.errors import CasaError, OutputError, UnknownId
from casa_assets.families.asset_store import AssetStore
from casa_assets.families.build import FamilyRequest
from casa_assets.families.build import params_of as drawn
from casa_assets.formats import mjcf
from casa_assets.formats.values import VIEWER_GROUPS
from casa_assets.layouts.run.load_scene import model_of
from casa_assets.layouts.run.resolve import checked_params, params_of
from casa_assets.library.entry_files import CERTIFICATE, manifest_of, read_asset
from casa_assets.library.library import Library
from casa_assets.mesh.trimesh_exchange import resting_sides
from casa_assets.mesh.trimesh_exchange import to_trimesh as to_trimesh
from casa_assets.model.asset.asset import Asset
from casa_assets.model.issue import Report
from casa_assets.model.kitchen.files import SCENE_JSON
from casa_assets.model.kitchen.style import PresetChoice
from casa_assets.model.pose import Pose
from casa_assets.registry.families import family, family_names, object_family, object_names
from casa_assets.runs.asset_package import check_package, write_package
from casa_assets.runs.outcome import writing

if TYPE_CHECKING:
    from casa_assets.show.view.server import ViewServer
    from casa_assets.show.view.subject import Subject

# Sides whose normals differ by less than this are one pose: the facets of something round. A choice.
SAME_SIDE_RAD = np.radians(10.0)
OBJECTS = "objects/"  # before the name of a category that is the name of a family too


def build(name: str, preset: str = "", *, seed: int | None = None, index: int = 0, **params: Any) -> Asset:
    """Build a fixture of a family, or a loose object of a category.

    Args:
        name: a family, see `families()`, or a category of objects, which `casa-assets objects list` prints. If there
            are both, it is the family; `objects/jar` is the object.
        preset: name of a ready member of a family; if empty and there is no seed, the first.
        seed: seed that draws all numbers and choices; the same seed always gives the same asset. With a preset it is
            the parameter of that name, which families of irregular things have. Objects are always drawn.
        index: number of the draw, as in `casa-assets families build` and `casa-assets objects build`.
        params: numbers and choices that differ from the preset's or from those drawn, such as `width=0.6`.
    Raises:
        UnknownId: no such family, category, preset or finish. CasaError: the numbers are out of bounds or contradict
            each other.
    """
    category, is_object = name.removeprefix(OBJECTS), name not in family_names()
    if is_object and not name.startswith(OBJECTS) and name not in object_names():
        raise UnknownId("family or category of objects", name, [*family_names(), *object_names()])
    made = object_family(category) if is_object else family(name)
    if is_object and preset:
        raise CasaError(f"{name}: objects have no presets, got {preset!r}; a seed draws one")
    if is_object or (seed is not None and not preset):
        numbers = drawn(FamilyRequest(category, seed=seed or 0, index=index, is_object=is_object))
        numbers = checked_params(name, made.params, numbers.model_dump(), params) if params else numbers
    else:
        stated = params if seed is None else {**params, "seed": seed}
        numbers = params_of(PresetChoice(preset=f"{name}/{preset or next(iter(made.presets))}", params=stated))
    store = AssetStore(cache_dir())
    try:
        asset = store.built(made, numbers)
    except ValueError as error:
        raise CasaError(f"{name}: {error}") from error
    store.tidy()
    return asset


def load(path: str | Path, detail: Detail = "full") -> Asset | Kitchen:
    """Open an asset or a kitchen from its folder.

    Args:
        path: folder of an asset in a library, or one that `Asset.write` made; or folder of a kitchen, whose files are
            used as they are.
        detail: form of a kitchen, see `Kitchen`.
    Raises:
        OutputError: the folder contains neither, or a file is missing or damaged.
    """
    folder = Path(path)
    if (folder / SCENE_JSON).is_file():
        return Kitchen(folder, detail)
    if (folder / CERTIFICATE).is_file():
        return read_asset(folder)
    raise OutputError(str(folder), f"holds neither {SCENE_JSON} of a scene nor {CERTIFICATE} of an asset")


# The following are called by methods of Asset of the same names, which state what they do.


def to_mjspec(asset: Asset) -> mujoco.MjSpec:
    """See `Asset.to_mjspec`."""
    files = dict(mjcf.write(asset, VIEWER_GROUPS).entries)
    return mujoco.MjSpec.from_string(files.pop("model.xml").decode(), assets=files)


def to_mjmodel(asset: Asset) -> mujoco.MjModel:
    """See `Asset.to_mjmodel`."""
    return model_of(mjcf.write(asset))


def write(asset: Asset, folder: str | Path) -> Path:
    """See `Asset.write`."""
    library = Library(Path(folder))
    target = library.root / asset.id
    with library.locked(), writing(library.root):
        library.sweep()
        staged = library.stage(asset.id)
        write_package(asset, staged)
        text = json.dumps({"asset": manifest_of(asset)}, sort_keys=True, indent=1, ensure_ascii=False)
        (staged / CERTIFICATE).write_text(text + "\n", encoding="utf-8")
        library.put(staged, target)
    return target


def check(asset: Asset) -> Report:
    """See `Asset.check`."""
    with tempfile.TemporaryDirectory(prefix="casa-assets-") as place:
        folder = Path(place) / asset.id
        folder.mkdir()
        write_package(asset, folder)
        return check_package(asset, folder)


def check_folder(folder: Path) -> Report:
    """Run every check that applies on the files of an asset or a kitchen, which are only read. Raises OutputError."""
    found = load(folder)
    return found.check() if isinstance(found, Kitchen) else check_package(found, folder)


def show(asset: Asset, pose: str, web: bool) -> None:
    """See `Asset.show`."""
    from casa_assets.show.view.subject import Loaded

    show_subject(Loaded(asset), pose, web)


@dataclass(frozen=True)
class StablePose:
    """A way to rest on a plane.

    Attributes:
        pose: world_from_asset: the lowest point is at z = 0, the centre of mass above the origin.
        probability: probability of this pose if the asset is put down in a random orientation and only tips over edges.
    """

    pose: Pose
    probability: float


def stable_poses(asset: Asset, least: float = 0.02) -> list[StablePose]:
    """Return the poses in which an asset can rest on a plane, from its collision shapes, the most likely first.

    Joints are closed. Rolling is ignored, so that a round object rests in many poses, each of which is unlikely; those
    with a probability below `least` are left out.
    """
    center = asset.center_of_mass
    points, rotations, shares = resting_sides(asset, center)
    sides: list[Floats] = []
    sums: list[float] = []
    for rotation, share in zip(rotations, shares.tolist(), strict=True):
        near = [k for k, side in enumerate(sides) if float(side[2] @ rotation[2]) >= np.cos(SAME_SIDE_RAD)]
        if near:
            sums[near[0]] += share
        else:
            sides.append(rotation)
            sums.append(share)
    order = sorted(range(len(sides)), key=lambda k: -sums[k])
    found = []
    for k in (k for k in order if sums[k] >= least):
        matrix = np.eye(4)
        matrix[:3, :3] = sides[k]
        matrix[:2, 3] = -(sides[k] @ center)[:2]
        matrix[2, 3] = -float((points @ sides[k][2]).min())
        found.append(StablePose(Pose.from_matrix(matrix), sums[k]))
    return found


def has_screen() -> bool:
    """True if windows can be opened."""
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def show_subject(subject: Subject, pose: str, web: bool) -> None:
    """Show a subject in MuJoCo's viewer, or on a page without a screen or with `web`, until the user ends it."""
    from casa_assets.show.view.model import mujoco_model
    from casa_assets.show.view.server import open_in_browser
    from casa_assets.show.view.subject import cache_of

    if not web and has_screen():
        show_model(mujoco_model(subject, cache_of(subject), lambda *_: None), pose, subject.id)
        return
    with serving(subject, pose) as server, suppress(KeyboardInterrupt):
        sys.stderr.write(f"{subject.id} is shown at {server.address}; Ctrl-C ends it\n")
        if not os.environ.get("SSH_CONNECTION"):
            open_in_browser(server.address)
        server.serve_forever()


def show_model(model: Any, pose: str, name: str) -> None:
    """Show a compiled model in MuJoCo's viewer, with its state machines, until its window is closed."""
    from casa_assets.show.stills.live_viewer import Glow
    from casa_assets.show.stills.live_viewer import show as open_viewer

    behaviors, glow = Behaviors(model), Glow(model)

    def each_frame(_: Any, data: Any) -> None:
        if data.time == 0.0:
            behaviors.reset(data)
        else:
            behaviors.update(data)
        glow.show(behaviors.effects)

    open_viewer(model, pose, name, each_frame)


def serving(subject: Subject, pose: str, port: int = 0) -> ViewServer:
    """A server of the page of a subject; 0: any port that is free. Raises CasaError, OutputError for a bad port."""
    from casa_assets.show.view.model import asset_of, make
    from casa_assets.show.view.server import ViewServer, Workshop
    from casa_assets.show.view.subject import ModelFile, cache_of

    cache = cache_of(subject)
    if isinstance(subject, ModelFile):
        asset_of(subject, cache)
    try:
        return ViewServer(subject, Workshop(lambda wanted, progress: make(wanted, cache, progress)), pose, port)
    except (OSError, OverflowError) as error:
        raise OutputError(f"port {port}", f"cannot be used: {error}; leave --port out for one that is free") from error

"""Every name of `import casa_assets` once, with its type; type checkers read it, nobody runs it."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import trimesh

import casa_assets as casa
from casa_assets.ext import plugins

plan: casa.PlanInfo = casa.plans()["l_small"]
bounds: casa.Bounds = plan.bounds["width"]
style: casa.StyleInfo = casa.styles()["coastal"]
family: casa.FamilyInfo = casa.families()["microwave"]
walls: tuple[str, ...] = casa.surfaces()["wall"]
detail: casa.Detail = "light"
kitchen: casa.Kitchen = casa.kitchen("l_small", "coastal", seed=7, surfaces={"wall": walls[0]}, detail=detail)
equipped: casa.Kitchen = casa.kitchen("l_small", "coastal", models={"range": "range/pro_six"}, closed=True)
random: casa.Kitchen = casa.kitchen("l_small", "coastal", surfaces="random").with_detail("batch")
model: mujoco.MjModel = kitchen.to_mjmodel(sleep=True)
spec: mujoco.MjSpec = kitchen.to_mjspec()
folder: Path = kitchen.write("out/scenes", picture=False)
print(kitchen.id, kitchen.recipe.plan, kitchen.scene.placements, kitchen.facts["parking"])
textures: casa.SurfaceTextures = kitchen.textures_of(model)
textures.show({"wall": walls[1]})
textures.upload(mujoco.Renderer(model))
opened: casa.Asset | casa.Kitchen = casa.load(folder)
opened.show("open", web=True)
behaviors = casa.Behaviors(model)
starts: casa.StartStates = casa.kitchen("l_small__coastal").start_states(model)
starts.reset(mujoco.MjData(model), 0)
print(len(starts), starts.qpos, starts.addresses, starts.base[0], starts.notes[0].placed)
side_by_side = casa.batch(["l_small__coastal"], engine="mujoco", worlds=2)
worlds: casa.Batch[Any] = side_by_side
data: list[mujoco.MjData] = side_by_side.engine.data
one_of_them: casa.BatchKitchen = side_by_side.kitchens[0]
side_by_side.step(10)
side_by_side.reset([0], seed=1)
print(len(side_by_side), side_by_side.qpos, one_of_them.address("door"), one_of_them.rows.states, side_by_side.fields)
states: casa.FixtureStates = behaviors.update(mujoco.MjData(model))
state: str | None = states["microwave"]["power"]
asset: casa.Asset = casa.build("microwave", "steel", width=0.6)
apple: casa.Asset = casa.build("apple", seed=1, index=4)
report: casa.Report = asset.check()
lying: list[casa.StablePose] = casa.stable_poses(asset, least=0.05)
print(lying[0].pose.position, lying[0].probability)
issues: tuple[casa.Issue, ...] = report.issues
written: Path = asset.write("out/assets")
alone: mujoco.MjModel = asset.to_mjmodel()
scene: trimesh.Scene = asset.to_trimesh("collision")
done: casa.Ingested = casa.ingest("mug.obj", category="mug", library="out/lib")
box = trimesh.creation.box(extents=(0.3, 0.2, 0.02))
in_memory: casa.Ingested = casa.ingest(box, name="board", up="z")
rejection: casa.Rejection | None = done.rejection
oven: casa.Articulated = casa.articulate("oven.glb", up="+y", front="+z", category="wall_oven", size_m=0.7)
library = casa.Library("out/lib")
mesh = casa.MeshInput(box, name="board", category="cutting_board", up="z")
results: Iterator[casa.IngestResult] = library.ingest("meshes", Path("a.obj"), box, scene, [mesh, box, "b.obj"], jobs=2)
for result in results:
    print(result.source, result.status, result.asset_id, result.folder, result.count)
    reasons: tuple[casa.Rejection, ...] = result.reasons
    warnings: tuple[casa.Issue, ...] = result.warnings
accepted: list[casa.Entry] = list(library)
rejected: list[casa.Entry] = list(library.rejected())
hits: list[casa.SearchHit] = library.search("red mug", limit=3)
kept: casa.Asset = library.get(hits[0].id)
print(len(library), library.folder("mug_0"), "mug_0" in library)
cache: Path = casa.cache_dir()
project = casa.Project("my_kitchens", plugins=False)
ours: casa.Kitchen = project.kitchen("loft", "workshop", seed=3)
pack: casa.PackReport = casa.ingest_textures("pictures", surface="wall", tile_m=(1.2, 1.2), licence="CC0-1.0")
picture: str = pack.pack.pictures[0].id
runs: tuple[casa.MadeRun, ...] = project.make()
print(runs[0].passed, runs[0].command, runs[0].exit_code, runs[0].rows[0]["id"])
with project:
    print(casa.plans())
plugin: plugins.Plugin = casa.plugins().get("ours") or plugins.Plugin("ours", "1.0")
sources: tuple[plugins.Source, ...] = plugin.sources
exporters: tuple[plugins.Exporter, ...] = plugin.exporters
version: str = casa.__version__
try:
    casa.kitchen("galley", "rustik")
except casa.UnknownId as error:
    nearest: tuple[str, ...] = error.nearest
except (casa.OutputError, casa.RegistryError, casa.Rejected, casa.CasaError):
    pass

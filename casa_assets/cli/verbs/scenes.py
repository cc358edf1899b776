"""casa-assets scenes: list, build, check, sample, preview, pack, compare, robots, states; scene new: one's own."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.table import Table

from casa_assets.cli import scene_output
from casa_assets.cli.options import Force, OldForce, Photoreal
from casa_assets.cli.text import pluralize
from casa_assets.cli.verbs.pack import pack
from casa_assets.model.kitchen.surface import Surface

if TYPE_CHECKING:
    from casa_assets.pipeline.kitchens.resolve import SceneRecipe

app = typer.Typer(
    name="scenes",
    help="Whole kitchens, a floor plan in a style: list, build, check, sample, preview, pack, compare, robots, states.",
    no_args_is_help=True,
    rich_markup_mode="rich",
)
scene_app = typer.Typer(name="scene", help="A kitchen of one's own.", no_args_is_help=True, rich_markup_mode="rich")
OUT = Path("out/scenes")
NAMED = "Ids or globs, such as 'l_*__coastal', or 'l_*__coastal__o40' with 40 objects."
MAX_OBJECTS = 60


@app.command("list")
def list_scenes(
    json_: Annotated[bool, typer.Option("--json", help="One JSON object on standard output.")] = False,
) -> None:
    """Name every plan and every style; a scene is called <plan>__<style>.

    Example:  casa-assets scenes list
    """
    from casa_assets.registry.kitchens import load_plan, load_style, plan_names, style_names

    plans = {name: load_plan(name)[0] for name in plan_names()}
    styles = {name: load_style(name)[0] for name in style_names()}
    if json_:
        rows = {"plans": {k: v.title for k, v in plans.items()}, "styles": {k: v.title for k, v in styles.items()}}
        typer.echo(json.dumps(rows, indent=1))
        return
    console = Console()
    table = Table("plan", "what", "lengths that may vary, m")
    for name, plan in plans.items():
        lengths = ", ".join(f"{k} {p.low:g} to {p.high:g}" for k, p in plan.parameters.items())
        table.add_row(name, plan.title, lengths)
    console.print(table)
    table = Table("style", "what")
    for name, style in styles.items():
        table.add_row(name, style.description)
    console.print(table)
    console.print(f"{len(plans)} plans x {len(styles)} styles = {len(plans) * len(styles)} scenes")


@app.command()
def build(
    scenes: Annotated[list[str] | None, typer.Argument(help=NAMED)] = None,
    all_: Annotated[bool, typer.Option("--all", help="Every plan in every style.")] = False,
    out: Annotated[Path, typer.Option(help="Output folder, made where it is missing.")] = OUT,
    jobs: Annotated[int, typer.Option(min=0, help="Processes; 0: one per core.")] = 0,
    pictures: Annotated[bool, typer.Option(help="Draw an overview of each.")] = True,
    force: Force = False,
    json_: Annotated[bool, typer.Option("--json", help="One JSON object per scene on standard output.")] = False,
    anew: OldForce = False,
) -> None:
    """Build scenes as MJCF and USD; what an earlier run made and nothing has changed stays. Exit 1 when one fails.

    Example:  casa-assets scenes build 'galley__*' l_small__coastal
    """
    from casa_assets.pipeline.kitchens.scene_folders import all_recipes, recipes_named

    if not scenes and not all_:
        raise typer.BadParameter("name scenes, or give --all")
    _build(all_recipes() if all_ else recipes_named(scenes or [], out), out, jobs, pictures, force or anew, json_)


def _build(recipes: list[SceneRecipe], out: Path, jobs: int, pictures: bool, force: bool, json_: bool) -> None:
    from casa_assets.pipeline.kitchens.scene_folders import build_all

    console = Console(stderr=json_)
    done = build_all(recipes, out, jobs, pictures, force)
    results = scene_output.print_progress(done, len(recipes), "building", console, json_)
    scene_output.write_reports(results, out, console)
    scene_output.check_faults(results)
    if not all(r.passed for r in results):
        raise typer.Exit(1)


@app.command()
def check(
    scenes: Annotated[list[str] | None, typer.Argument(help=NAMED)] = None,
    all_: Annotated[bool, typer.Option("--all", help="Every plan in every style.")] = False,
    out: Annotated[Path, typer.Option(help="Folder of the scenes.")] = OUT,
    jobs: Annotated[int, typer.Option(min=0, help="Processes; 0: one per core.")] = 0,
    force: Force = False,
    pictures: Annotated[bool, typer.Option(help="Draw an overview of each.")] = True,
    in_3d: Annotated[
        bool, typer.Option("--3d/--no-3d", help="Write a model for the page of each, to turn and open (about 4 MB).")
    ] = True,
    json_: Annotated[bool, typer.Option("--json", help="One JSON object per scene on standard output.")] = False,
    anew: OldForce = False,
) -> None:
    """Run every check on scenes, built first where they are missing: physics, openings, design, ways, tasks, parity.

    Writes report.json and report.html beside each, summary.json and summary.html for all. Exit 1 when one does not
    pass.

    Example:  casa-assets scenes check l_small__coastal 'galley__*__o40'
    """
    from casa_assets.pipeline.kitchens.check import check_all
    from casa_assets.pipeline.kitchens.scene_folders import all_recipes, recipes_named

    if not scenes and not all_:
        raise typer.BadParameter("name scenes, or give --all")
    recipes = all_recipes() if all_ else recipes_named(scenes or [], out)
    console = Console(stderr=json_)
    done = check_all(recipes, out, jobs, force or anew, drawn=pictures, in_3d=in_3d)
    results = scene_output.print_progress(done, len(recipes), "checking", console, json_)
    if not json_:
        scene_output.print_numbers(results, out, console)
    scene_output.write_reports(results, out, console)
    scene_output.check_faults(results)
    if not all(r.passed for r in results):
        raise typer.Exit(1)


@app.command()
def sample(
    count: Annotated[int, typer.Argument(min=1, help="How many to draw.")],
    seed: Annotated[int, typer.Option(min=0, help="Of the draws.")] = 0,
    out: Annotated[Path, typer.Option(help="Output folder, made where it is missing.")] = OUT,
    jobs: Annotated[int, typer.Option(min=0, help="Processes; 0: one per core.")] = 0,
    pictures: Annotated[bool, typer.Option(help="Draw an overview of each that passes.")] = True,
    json_: Annotated[bool, typer.Option("--json", help="One JSON object per scene on standard output.")] = False,
) -> None:
    """Draw kitchens by chance: plan, its lengths, style and textures. Only those that pass every check are kept.

    The others are rejected: rejected.json says why. Exit 1 when none passes.

    Example:  casa-assets scenes sample 20 --seed 1
    """
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.kitchens.check import check_all
    from casa_assets.pipeline.kitchens.sample import draw_recipes, write_rejected

    recipes, console = draw_recipes(count, seed), Console(stderr=json_)
    done = check_all(recipes, out, jobs, strict=True, drawn=pictures)
    results = scene_output.print_progress(done, len(recipes), "drawing", console, json_)
    with writing(out):
        path = write_rejected(out, seed, recipes, results)
    if not json_:
        scene_output.print_numbers(results, out, console)
    scene_output.write_reports(results, out, console)
    passed = sum(r.passed for r in results)
    rate = f"{passed} of {pluralize(len(results), 'draw')} passed ({passed / len(results):.0%})"
    console.print(f"{rate}; why the others did not: {path}", highlight=False, soft_wrap=True)
    scene_output.check_faults(results)
    if not passed:
        raise typer.Exit(1)


@app.command()
def preview(
    scene: Annotated[str, typer.Argument(help="Id of a scene that was built.")],
    camera: Annotated[list[str] | None, typer.Option(help="Cameras; all where none is named.")] = None,
    pose: Annotated[str, typer.Option(help="Keyframe: start, closed or open.")] = "start",
    size: Annotated[int, typer.Option(min=64, max=4096, help="Width in pixels; the height is three quarters.")] = 960,
    passes: Annotated[int, typer.Option(min=1, max=400, help="Drawings that a picture is the mean of.")] = 6,
    photoreal: Photoreal = False,
    out: Annotated[Path, typer.Option(help="Folder of the scenes.")] = OUT,
) -> None:
    """Draw a scene through its cameras, beside its files.

    With --photoreal by a path tracer, in 16:9, through the cameras `eye` and `cutaway` where none is named.

    Example:  casa-assets scenes preview l_small__coastal --camera at_stove --pose open
    """
    from casa_assets.errors import OutputError, UnknownId
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.kitchens.scene_folders import all_recipes, draw_cameras
    from casa_assets.pipeline.reports.stills import draw_scene
    from casa_assets.preview.kitchen import PictureSettings
    from casa_assets.preview.photoreal.render import StillSettings

    folder = out / scene
    if not folder.is_dir():
        on_disk, scene_ids = [p.name for p in out.glob("*__*")], [r.scene_id for r in all_recipes()]
        if scene not in scene_ids:
            raise UnknownId("scene", scene, [*on_disk, *scene_ids])
        raise OutputError(str(folder), f"is not built; casa-assets scenes build {scene} --out {out}")
    with writing(out):
        if photoreal:
            for written in draw_scene(folder, StillSettings(size, size * 9 // 16), pose, camera or ()):
                typer.echo(str(written.path))
            return
        for path in draw_cameras(folder, camera or (), PictureSettings(size, size * 3 // 4, passes), pose):
            typer.echo(str(path))


@app.command()
def robots(
    scenes: Annotated[list[str] | None, typer.Argument(help=NAMED)] = None,
    all_: Annotated[bool, typer.Option("--all", help="Every plan in every style.")] = False,
    robot: Annotated[list[str] | None, typer.Option(help="Robots; all of registry/robots where none is named.")] = None,
    joint: Annotated[
        list[str] | None, typer.Option(help="Globs of joints to try, such as '*drawer*'; else all.")
    ] = None,
    models: Annotated[
        Path | None, typer.Option(help="robosuite/models/assets; that of the installed robosuite otherwise.")
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder of the scenes.")] = OUT,
    jobs: Annotated[int, typer.Option(min=0, help="Processes; 0: one per core.")] = 0,
    force: Force = False,
    json_: Annotated[bool, typer.Option("--json", help="One JSON object per scene on standard output.")] = False,
) -> None:
    """Find which handles, knobs, keys and levers robots reach from their parking places, and what they open.

    Inverse kinematics with mink; robots come from the installed robosuite. Writes robots.json beside each scene, built
    first where it is missing, and a line of its report. Exit 1 when PandaOmron reaches too little, or when it
    was not tried on all joints (--robot, --joint), so that nothing is said of the kitchen.

    Example:  casa-assets scenes robots l_small__coastal --robot PandaOmron
    """
    from casa_assets.pipeline.kitchens.robots import certify_all, find_robot_models
    from casa_assets.pipeline.kitchens.scene_folders import all_recipes, recipes_named
    from casa_assets.registry.robots import robot_names

    if not scenes and not all_:
        raise typer.BadParameter("name scenes, or give --all")
    recipes = all_recipes() if all_ else recipes_named(scenes or [], out)
    console = Console(stderr=json_)
    done = certify_all(recipes, out, robot or robot_names(), models or find_robot_models(), jobs, force, joint or ())
    results = scene_output.print_progress(done, len(recipes), "reaching", console, json_)
    if not json_:
        scene_output.print_robots(results, console)
    scene_output.check_faults(results)
    if not all(r.passed for r in results):
        raise typer.Exit(1)


@app.command()
def states(
    scenes: Annotated[list[str] | None, typer.Argument(help=NAMED)] = None,
    all_: Annotated[bool, typer.Option("--all", help="Every plan in every style.")] = False,
    count: Annotated[int, typer.Option(min=1, help="Start states of each scene.")] = 100,
    objects: Annotated[int, typer.Option(min=0, help="Loose things that are put somewhere else in each.")] = 10,
    doors: Annotated[int, typer.Option(min=0, help="Doors and drawers that stand open in each.")] = 0,
    seed: Annotated[int, typer.Option(min=0, help="Of the draws.")] = 0,
    out: Annotated[Path, typer.Option(help="Folder of the scenes.")] = OUT,
    jobs: Annotated[int, typer.Option(min=0, help="Processes; 0: one per core.")] = 0,
    force: Force = False,
    json_: Annotated[bool, typer.Option("--json", help="One JSON object per scene on standard output.")] = False,
) -> None:
    """Draw start states: loose things put somewhere else, the robot parked, all of it at rest; each is simulated.

    Writes start_states.npz beside each scene, built first where it is missing, and lines of its report. Exit 1 when
    one does not pass.

    Example:  casa-assets scenes states one_wall_small__coastal__o40
    """
    from casa_assets.checks.start_states.draw import StateRequest
    from casa_assets.pipeline.kitchens.scene_folders import all_recipes, recipes_named
    from casa_assets.pipeline.kitchens.start_states import draw_all

    if not scenes and not all_:
        raise typer.BadParameter("name scenes, or give --all")
    recipes = all_recipes() if all_ else recipes_named(scenes or [], out)
    console = Console(stderr=json_)
    done = draw_all(recipes, out, StateRequest(count, objects, doors, seed), jobs, force)
    results = scene_output.print_progress(done, len(recipes), "drawing", console, json_)
    if not json_:
        scene_output.print_states(results, console)
    scene_output.check_faults(results)
    if not all(r.passed for r in results):
        raise typer.Exit(1)


@app.command()
def diff(
    first: Annotated[Path, typer.Argument(help="Folder of a scene.")],
    second: Annotated[Path, typer.Argument(help="Folder of another, or of the same from elsewhere.")],
    json_: Annotated[bool, typer.Option("--json", help="One JSON object on standard output.")] = False,
) -> None:
    """Tell how two scenes differ: files, what stands where, finishes. Exit 1 where they do.

    Example:  casa-assets scenes diff out/scenes/l_small__coastal /mnt/other/l_small__coastal
    """
    from casa_assets.pipeline.kitchens.diff import compare, made_by_same_code

    found = compare(first, second)
    same = (
        "the same, byte for byte" if made_by_same_code(first, second) else "the same, made by other versions or tools"
    )
    if json_:
        typer.echo(json.dumps(found, indent=1))
    else:
        for line in found:
            typer.echo(line)
        typer.echo(pluralize(len(found), "difference") if found else same)
    if found:
        raise typer.Exit(1)


app.command()(pack)


@scene_app.command("new")
def new(
    plan: Annotated[str, typer.Argument(help="Name of a plan.")],
    style: Annotated[str, typer.Option(help="Name of a style.")],
    seed: Annotated[int | None, typer.Option(min=0, help="Draws the lengths of the plan.")] = None,
    textures: Annotated[
        str,
        typer.Option(help="'style', 'random' (drawn by the seed), or ids: 'wall=brick_red_running,floor=oak_ebony'."),
    ] = "style",
    closed: Annotated[bool, typer.Option("--closed", help="Draw the open walls too.")] = False,
    objects: Annotated[int, typer.Option(min=0, max=MAX_OBJECTS, help="Things put where people keep them.")] = 0,
    objects_seed: Annotated[int, typer.Option(min=0, help="Draws which things, and where.")] = 0,
    out: Annotated[Path, typer.Option(help="Output folder, made where it is missing.")] = OUT,
    json_: Annotated[bool, typer.Option("--json", help="One JSON object on standard output.")] = False,
) -> None:
    """Build one kitchen: a plan in a style, with lengths and textures of its own. Its id names all of it.

    Example:  casa-assets scene new galley --style rustic --seed 7 --textures random --objects 40
    """
    from casa_assets.pipeline.kitchens.resolve import SceneRecipe, draw_surfaces, ordered_surfaces
    from casa_assets.registry.kitchens import load_plan, load_style

    load_plan(plan), load_style(style)
    surfaces = draw_surfaces(seed or 0) if textures == "random" else ordered_surfaces(_pairs(textures))
    _build([SceneRecipe(plan, style, seed, surfaces, closed, objects, objects_seed)], out, 1, True, False, json_)


def _pairs(text: str) -> list[tuple[Surface, str]]:
    """`wall=ID,floor=ID` as pairs."""
    if text == "style":
        return []
    pairs = []
    for part in text.split(","):
        surface, _, name = part.partition("=")
        if surface not in list(Surface) or not name:
            raise typer.BadParameter(
                f"{part!r}: write wall=ID, floor=ID, counter=ID or cabinet=ID", param_hint="--textures"
            )
        pairs.append((Surface(surface), name))
    return pairs

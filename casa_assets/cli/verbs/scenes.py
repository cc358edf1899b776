"""casa-assets scenes: kitchens built, checked, drawn and packed; plans checked, mended and fitted to a room."""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from casa_assets.cli import batch_output
from casa_assets.cli.group import Verb, group_of
from casa_assets.cli.options import (
    COUNT_HELP,
    IN_3D_HELP,
    OBJECTS_HELP,
    OUT_HELP,
    SCENES_HELP,
    SEED_HELP,
    WIDTH_HELP,
    All,
    AsJson,
    Camera,
    Force,
    Jobs,
    Photoreal,
    Pictures,
    Pose,
    ScenesFolder,
    ScenesOut,
    Seed,
    Workers,
    complete_kitchens,
    complete_plans,
    complete_robots,
    complete_styles,
    more,
    shared,
)
from casa_assets.cli.output import Output, TextTable, from_column, measures_at, pluralize
from casa_assets.model.kitchen.choices import JointWord, Surface

if TYPE_CHECKING:
    from casa_assets.layouts.check_plan.check import PlanCheck
    from casa_assets.layouts.run.recipe import SceneRecipe
    from casa_assets.runs.pool import Workers

app = group_of("scenes", "Whole kitchens, a floor plan in a style: new, build, check, preview, pack and more.")
OUT, PACKS = Path("out/scenes"), Path("out/packs")
STYLE, TRIED_STYLE = "coastal", "modern_1"  # of a new kitchen, and of a plan that is tried, where none is named
STYLE_TEXTURES = "style"  # --textures: those of the style
STYLE_HELP = "Name of a style, see `scenes list`."
NAMED = f"{SCENES_HELP[:-1]}, or 'l_*__coastal__o40' with 40 objects."
MAX_OBJECTS = 60
PASSES = 6
Scenes = Annotated[list[str] | None, typer.Argument(help=NAMED, autocompletion=complete_kitchens)]
Objects = Annotated[
    int,
    typer.Option("--objects", min=0, max=MAX_OBJECTS, help=more(OBJECTS_HELP, "they are put where people keep them.")),
]
OneScene = Annotated[str, typer.Argument(help="Id of a scene that was built.", autocompletion=complete_kitchens)]
EyeLevel = Annotated[
    bool, typer.Option("--eye-level", help="Draw each that is built at eye level, too, with its doors open.")
]
TriedStyle = Annotated[
    str, typer.Option("--style", help=more(STYLE_HELP, "the plan is tried with it."), autocompletion=complete_styles)
]
OutFile = Annotated[
    Path | None, typer.Option("--out", help=more(OUT_HELP, "a YAML file that is not there yet."), dir_okay=False)
]


def _recipes(scenes: list[str] | None, all_: bool, out: Path) -> list[SceneRecipe]:
    """The scenes that a user names. Raises typer.BadParameter if no scenes are named, UnknownId."""
    from casa_assets.layouts.run.recipe import all_recipes, recipes_named

    if not scenes and not all_:
        raise typer.BadParameter("name scenes, or give --all")
    return all_recipes() if all_ else recipes_named(scenes or [], out)


@app.command("list", cls=Verb)
def list_scenes(json_: AsJson = False) -> None:
    """List every plan and every style; the id of a kitchen is <plan>__<style>.

    Exit 0.

    Example:  casa-assets scenes list
    """
    from casa_assets.registry.kitchens import load_plan, load_style, plan_names, style_names
    from casa_assets.registry.read import origin

    output, lengths = Output(json_), "lengths that may vary, m"
    plans = TextTable(("plan", "what", lengths, *from_column()), sentences=("what", lengths))
    for name in plan_names():
        plan, document = load_plan(name)
        source = origin(document.file)
        bounds = {k: [p.low, p.high] for k, p in plan.parameters.items()}
        output.row({"kind": "plan", "id": name, "title": plan.title, "lengths": bounds, "from": source})
        words = ", ".join(f"{k} {low:g} to {high:g}" for k, (low, high) in bounds.items())
        plans.add(name, plan.title, words, source)
    styles = TextTable(("style", "what", *from_column()), sentences=("what",))
    for name in style_names():
        style, document = load_style(name)
        source = origin(document.file)
        output.row({"kind": "style", "id": name, "title": style.title, "about": style.description, "from": source})
        styles.add(name, style.description, source)
    if json_:
        return
    plans.print(output.console)
    output.line("")
    styles.print(output.console)
    count = len(plans.rows) * len(styles.rows)
    output.line(f"{len(plans.rows)} plans x {len(styles.rows)} styles = {count} scenes")


@app.command(cls=Verb)
@shared
def build(
    output: Output,
    scenes: Scenes = None,
    all_: All = False,
    out: ScenesOut = OUT,
    workers: Workers = 0,
    pictures: Pictures = True,
    at_eye_level: EyeLevel = False,
    force: Force = False,
) -> None:
    """Build kitchens by their ids, as MJCF and USD; what an earlier run made and has not changed is kept.

    Exit 0 when all were built, 1 when one was not, 2 on misuse.

    Example:  casa-assets scenes build 'galley__*' l_small__coastal
    """
    _build(_recipes(scenes, all_, out), out, workers, output, pictures, at_eye_level, force)


def _build(
    recipes: list[SceneRecipe],
    out: Path,
    jobs: Workers,
    output: Output,
    drawn: bool = True,
    at_eye_level: bool = False,
    force: bool = False,
) -> None:
    from casa_assets.layouts.run.kept import kept_scene

    kept = [] if force else [result for one in recipes if (result := kept_scene(one, out, drawn)) is not None]
    done = iter(kept)
    if len(kept) < len(recipes):
        from casa_assets.layouts.run.scene_folders import BuildOptions, build_all

        done = build_all(recipes, out, jobs, BuildOptions(drawn, at_eye_level, force))
    results = batch_output.follow(done, recipes, "building", output)
    batch_output.write_reports(results, out, output)
    batch_output.end_builds(results, output)


@app.command(cls=Verb)
@shared
def check(
    output: Output,
    scenes: Scenes = None,
    all_: All = False,
    out: ScenesOut = OUT,
    workers: Workers = 0,
    force: Force = False,
    pictures: Pictures = True,
    at_eye_level: EyeLevel = False,
    in_3d: Annotated[bool, typer.Option("--3d/--no-3d", help=more(IN_3D_HELP, "about 4 MB each."))] = True,
) -> None:
    """Run every check on kitchens: physics, doors and drawers, design rules, robot access, tasks, MJCF equals USD.

    Kitchens that are missing are built first. Writes report.json and report.html beside each, index.html and
    summary.json for all. Exit 0 when all pass, 1 when one does not, 2 on misuse.

    Example:  casa-assets scenes check l_small__coastal 'galley__*__o40'
    """
    from casa_assets.layouts.run.check import check_all

    recipes = _recipes(scenes, all_, out)
    done = check_all(recipes, out, workers, force, drawn=pictures, in_3d=in_3d, at_eye_level=at_eye_level)
    results = batch_output.follow(done, recipes, "checking", output)
    if not output.as_json:
        batch_output.print_numbers(results, out, output)
    batch_output.write_reports(results, out, output)
    batch_output.end_builds(results, output)


@app.command(cls=Verb)
@shared
def sample(
    output: Output,
    count: Annotated[int, typer.Argument(min=1, help="How many to draw.")],
    seed: Seed = 0,
    objects: Objects = 0,
    out: ScenesOut = OUT,
    workers: Workers = 0,
    pictures: Pictures = True,
    in_3d: Annotated[bool, typer.Option("--3d/--no-3d", help=more(IN_3D_HELP, "about 4 MB each."))] = False,
) -> None:
    """Draw random kitchens: plan, lengths, style, finishes, models. Only those that pass every check are kept.

    The others are refused: rejected.json says why. diversity.json tells how diverse the kitchens are. A run that was
    stopped goes on where it was. Exit 0 when one passes or more, 1 when none does, 2 on misuse.

    Example:  casa-assets scenes sample 20 --seed 1 --objects 40
    """
    from casa_assets.layouts.run.sample import draw_recipes, sample_all

    recipes = draw_recipes(count, seed, objects)
    done = sample_all(recipes, out, workers, drawn=pictures, in_3d=in_3d)
    results = batch_output.follow(done, recipes, "drawing", output, lean=True)
    batch_output.print_sample(results, recipes, seed, out, output)
    batch_output.write_reports(results, out, output)
    batch_output.end_builds(results, output, one_is_enough=True)


@app.command(cls=Verb)
@shared
def preview(
    output: Output,
    scene: OneScene,
    camera: Camera = None,
    pose: Pose = "start",
    width_px: Annotated[int, typer.Option(min=64, max=4096, help=more(WIDTH_HELP, "4:3, with --photoreal 16:9."))] = (
        960
    ),
    passes: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=400,
            help="Renderings averaged per picture, for soft light; more is slower.",
            show_default=str(PASSES),
        ),
    ] = None,
    photoreal: Photoreal = False,
    out: ScenesOut = OUT,
) -> None:
    """Draw a kitchen through its cameras, beside its files.

    With --photoreal a path tracer draws them. Cameras: overview, above, at_stove, at_sink, at_fridge, robot_eye_1 and
    further ones, as scene.json lists them. Exit 0 when the pictures are drawn, 2 on misuse.

    Example:  casa-assets scenes preview l_small__coastal --camera at_stove --pose open
    """
    from casa_assets.errors import OutputError, UnknownId
    from casa_assets.layouts.run.recipe import LISTED_BY, all_recipes
    from casa_assets.layouts.run.scene_folders import draw_cameras
    from casa_assets.runs.outcome import writing
    from casa_assets.show.reports.pictures import draw_scene
    from casa_assets.show.stills.kitchen import PictureSettings
    from casa_assets.show.stills.photoreal import StillSettings

    if photoreal and passes is not None:
        raise typer.BadParameter("is for pictures without --photoreal", param_hint="--passes")
    folder = out / scene
    if not folder.is_dir():
        on_disk, scene_ids = [p.name for p in out.glob("*__*")], [r.scene_id for r in all_recipes()]
        if scene not in scene_ids:
            raise UnknownId("scene", scene, [*on_disk, *scene_ids], LISTED_BY)
        raise OutputError(str(folder), f"is not built; casa-assets scenes build {scene} --out {shlex.quote(str(out))}")
    with writing(out):
        if photoreal:
            stills = draw_scene(folder, StillSettings(width_px, width_px * 9 // 16), pose, camera or ())
            paths = (written.path for written in stills)
        else:
            settings = PictureSettings(width_px, width_px * 3 // 4, passes or PASSES)
            paths = (path for path in draw_cameras(folder, camera or (), settings, pose))
        for path in paths:
            output.made(scene, folder, measures_at(folder), picture=str(path))
            output.line(str(path))
    output.look(folder)


@app.command(cls=Verb)
@shared
def robots(
    output: Output,
    scenes: Scenes = None,
    all_: All = False,
    robot: Annotated[
        list[str] | None,
        typer.Option(help="Robots; all of registry/robots where none is named.", autocompletion=complete_robots),
    ] = None,
    joint: Annotated[
        list[str] | None, typer.Option(help="Globs of joints to try, such as '*drawer*'; else all.")
    ] = None,
    models: Annotated[
        Path | None, typer.Option(help="robosuite/models/assets; that of the installed robosuite otherwise.")
    ] = None,
    out: ScenesOut = OUT,
    jobs: Jobs = 0,
    force: Force = False,
) -> None:
    """Find which handles, knobs, buttons and levers robots reach from the parking places, and what they open.

    Inverse kinematics with mink; robots come from the installed robosuite. Writes robots.json beside each scene, built
    first where it is missing, and a line of its report. Exit 0 when ROB001 passes for every kitchen, 1 when PandaOmron
    reaches too little, or was not tried on all joints (--robot, --joint) so that ROB001 was not run, 2 on misuse.

    Example:  casa-assets scenes robots l_small__coastal --robot PandaOmron
    """
    from casa_assets.addons.robots.certify import certify_all, find_robot_models
    from casa_assets.registry.tables import robot_names

    recipes = _recipes(scenes, all_, out)
    done = certify_all(recipes, out, robot or robot_names(), models or find_robot_models(), jobs, force, joint or ())
    batch_output.follow_and_list(done, recipes, "reaching", batch_output.ROBOTS, output)


@app.command(cls=Verb)
@shared
def states(
    output: Output,
    scenes: Scenes = None,
    all_: All = False,
    count: Annotated[int, typer.Option(min=1, help=more(COUNT_HELP, "start states per kitchen."))] = 100,
    objects: Annotated[int, typer.Option(min=0, help=more(OBJECTS_HELP, "so many are moved in each state."))] = 10,
    doors: Annotated[int, typer.Option(min=0, help="Number of doors and drawers that are open in each state.")] = 0,
    seed: Seed = 0,
    out: ScenesOut = OUT,
    jobs: Jobs = 0,
    force: Force = False,
) -> None:
    """Draw settled start states: loose objects moved, a robot parked; each state is simulated.

    Writes start_states.npz beside each scene, built first where it is missing, and lines of its report. Exit 0 when all
    pass, 1 when one does not, 2 on misuse.

    Example:  casa-assets scenes states one_wall_small__coastal__o40
    """
    from casa_assets.checks.start_states.draw import StateRequest
    from casa_assets.layouts.run.check import draw_all

    recipes = _recipes(scenes, all_, out)
    done = draw_all(recipes, out, StateRequest(count, objects, doors, seed), jobs, force)
    batch_output.follow_and_list(done, recipes, "drawing", batch_output.STATES, output)


@app.command(cls=Verb)
@shared
def batch(
    output: Output,
    scenes: Scenes = None,
    all_: All = False,
    joints: Annotated[
        list[JointWord] | None,
        typer.Option("--joints", help="Kind of joints that stay; may be repeated. Default: all."),
    ] = None,
    primitives: Annotated[
        int, typer.Option("--primitives", min=0, help="Primitives at most; 0: as many as check BAT002 allows.")
    ] = 0,
    out: ScenesOut = OUT,
    workers: Workers = 0,
    force: Force = False,
) -> None:
    """Write kitchens for GPU engines that step thousands at once: few primitives, few pairs, all asleep at rest.

    Writes scene_batch.xml and batch.json beside each scene, built first where it is missing. Joints for which there is
    no room are locked, and batch.json names them. Exit 0 when all pass their checks, 1 when one does not, 2 on misuse.

    Example:  casa-assets scenes batch l_small__coastal --joints doors --joints drawers
    """
    from casa_assets.addons.batch.batch_form import BatchRequest, make_all

    recipes = _recipes(scenes, all_, out)
    request = BatchRequest(tuple(joints or JointWord), primitives or None)
    done = make_all(recipes, out, request, workers, force)
    batch_output.follow_and_list(done, recipes, "merging", batch_output.BATCHES, output)


@app.command(cls=Verb)
@shared
def pack(
    output: Output,
    scene: Annotated[
        str, typer.Argument(help="Id of a scene, such as l_small__coastal.", autocompletion=complete_kitchens)
    ],
    zip_: Annotated[bool, typer.Option("--zip", help="MJCF, USD, scene.json and all that they name.")] = False,
    usdz: Annotated[bool, typer.Option("--usdz", help="The USD and all that it names, as one USDZ.")] = False,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help=more(OUT_HELP, "by default out/packs/<id>.zip or .usdz."))
    ] = None,
    scenes_folder: ScenesFolder = OUT,
) -> None:
    """Write a kitchen as one file that loads by itself on another machine; built first where it is missing.

    Exit 0 when it is written, 2 on misuse.

    Example:  casa-assets scenes pack l_small__coastal --zip
    """
    from casa_assets.layouts.run.pack import PackKind, pack_scene

    if zip_ == usdz:
        raise typer.BadParameter("give one of --zip and --usdz")
    kind, target = PackKind.ZIP if zip_ else PackKind.USDZ, out or PACKS
    if target == PACKS or target.is_dir():
        target /= f"{scene}.{kind.value}"
    elif target.suffix.lower() != f".{kind.value}":  # by which other programs go
        target = target.with_name(f"{target.name}.{kind.value}")
    done = pack_scene(scene, scenes_folder, kind, target)
    facts: dict[str, Any] = {"kind": kind.value, "files": done.files, "bytes": done.size, "sha256": done.sha256}
    measured = measures_at(scenes_folder / done.scene_id)
    output.made(done.scene_id, done.file.parent, measured, file=str(done.file), built=done.built, **facts)
    output.line(f"{done.file}: {done.files} files, {done.size / 1e6:.1f} MB")
    elsewhere = () if scenes_folder == OUT else ("--scenes-folder", scenes_folder)
    output.look(done.scene_id, *elsewhere)


def plan_file(named: Path) -> Path:
    """The file of a plan that a user names: by its path, or as `scenes list` does. Raises UnknownId."""
    from casa_assets.errors import UnknownId
    from casa_assets.registry.kitchens import PLANS, plan_names
    from casa_assets.registry.read import stated_in

    if named.is_file():
        return named
    if str(named) not in plan_names():
        raise UnknownId("plan or file", str(named), plan_names(), "`casa-assets scenes list` names the plans")
    return stated_in(f"{PLANS}/{named}.yaml")[-1]


PlanFile = Annotated[
    Path,
    typer.Argument(
        help="A plan: a YAML file, or the name of one, see `scenes list`.",
        callback=plan_file,
        autocompletion=complete_plans,
    ),
]


@app.command("check-plan", cls=Verb)
@shared
def check_plan(
    output: Output,
    file: PlanFile,
    style: TriedStyle = TRIED_STYLE,
    fix: Annotated[bool, typer.Option("--fix", help="Write the corrected plan to --out.")] = False,
    out: OutFile = None,
) -> None:
    """Check a plan without building it: every fault with its line, and the nearest correction.

    Make corrections in the order in which they are printed. --json has them as edits: op, pointer, old and new
    value. Exit 0 when the plan fits, 1 when it has faults, 2 on misuse.

    Example:  casa-assets scenes check-plan studio.yaml --fix --out studio_2.yaml
    """
    from casa_assets.layouts.check_plan.check import check_plan as check
    from casa_assets.layouts.check_plan.edit import read_plan_text, write_new
    from casa_assets.registry.kitchens import load_style

    if fix != (out is not None):
        raise typer.BadParameter("--fix and --out go together: name a file for the corrected plan")
    found = check(read_plan_text(file), str(file), load_style(style)[0])
    row = {"id": file.stem, "verdict": "fits" if found.fits else "faulty", "file": str(file), "style": style}
    output.row({**row, "mended": found.mended, "faults": [fault.facts for fault in found.faults]})
    if not output.as_json:
        _print_faults(found, file, output)
    if out is not None and found.mended:
        write_new(out, found.text)
        output.line(f"{out}: {pluralize(len(found.faults), 'correction')} made")
    if not found.fits:
        raise typer.Exit(1)


def _print_faults(found: PlanCheck, file: Path, output: Output) -> None:
    for fault in found.faults:
        pointer = ".".join(map(str, fault.pointer)) or "(top)"
        output.wrong(f"{fault.file}:{fault.line}: {pointer}: expected {fault.expected}, got {fault.got}")
        output.wrong(f"    correction: {fault.mend.sentence if fault.mend else 'none was found'}")
    if found.fits:
        output.line(f"{file}: fits")
        return
    after = "with these corrections it fits" if found.mended else "what has no correction has to be rewritten"
    output.wrong(f"{pluralize(len(found.faults), 'fault')}; {after}")


@app.command(cls=Verb)
@shared
def fit(
    output: Output,
    file: PlanFile,
    width: Annotated[float, typer.Option(help="Of the room, along its back wall, metres.", min=1.5, max=20)],
    depth: Annotated[
        float, typer.Option(help="Of the room, from its back wall to its front, metres.", min=1.5, max=20)
    ],
    style: TriedStyle = TRIED_STYLE,
    out: OutFile = None,
) -> None:
    """Fit a plan to a room of another size: move walls and openings, then narrow or take out what does not fit.

    Shelves, fillers and doors go before drawers; sink, cooker and refrigerator stay. Prints each change, and the plan
    where no --out names a file. Exit 0 when the plan fits, 1 when the room is too small (the least room that is
    not is printed), 2 on misuse.

    Example:  casa-assets scenes fit studio.yaml --width 4.2 --depth 3.1 --out small.yaml
    """
    from casa_assets.layouts.check_plan.check import DoesNotFit, fit_plan
    from casa_assets.layouts.check_plan.edit import read_plan_text, write_new
    from casa_assets.registry.kitchens import load_style

    row = {"id": file.stem, "file": str(file), "style": style, "width": width, "depth": depth}
    try:
        fitted = fit_plan(read_plan_text(file), str(file), load_style(style)[0], width, depth)
    except DoesNotFit as error:
        output.row({**row, "verdict": "refused", "reason": error.reason, "least": error.least})
        output.wrong(str(error))
        raise typer.Exit(1) from None
    output.row({**row, "verdict": "fits", "changes": fitted.changes, "plan": fitted.text})
    for change in () if output.as_json else fitted.changes:
        output.line(f"# {change}")
    if out is not None:
        write_new(out, fitted.text)
        output.line(f"{out}: {pluralize(len(fitted.changes), 'change')}")
    elif not output.as_json:
        typer.echo(fitted.text, nl=False)


@app.command("new", cls=Verb)
@shared
def new(
    output: Output,
    plan: Annotated[str, typer.Argument(help="Name of a plan, see `scenes list`.", autocompletion=complete_plans)],
    style: Annotated[str, typer.Option(help=STYLE_HELP, autocompletion=complete_styles)] = STYLE,
    seed: Annotated[
        int | None,
        typer.Option(min=0, help=more(SEED_HELP, "of the lengths of the plan, else they have their defaults.")),
    ] = None,
    textures: Annotated[
        str,
        typer.Option(help="'style', 'random' (drawn by the seed), or ids: 'wall=brick_red_running,floor=oak_ebony'."),
    ] = STYLE_TEXTURES,
    model: Annotated[
        list[str] | None,
        typer.Option(
            help="A model in place of the style's, by its role: 'range=range/pro_six', 'fridge=library:ID'; repeatable."
        ),
    ] = None,
    mixed: Annotated[
        bool,
        typer.Option(
            "--mixed", help="Fronts, appliances, furniture and small things of all styles, drawn by the seed."
        ),
    ] = False,
    closed: Annotated[
        bool, typer.Option("--closed", help="Build all walls; by default some plans leave sides open.")
    ] = False,
    objects: Objects = 0,
    objects_seed: Annotated[int, typer.Option(min=0, help="Random seed of which objects, and where.")] = 0,
    out: ScenesOut = OUT,
) -> None:
    """Build one kitchen: a plan in a style, with options. Prints its id, by which other commands know it.

    Exit 0 when it was built, 1 when it was not, 2 on misuse.

    Examples:

      casa-assets scenes new l_small
      casa-assets scenes new galley --style rustic --objects 40
      casa-assets scenes new galley --seed 7 --textures random
    """
    from casa_assets.layouts.run.recipe import SceneRecipe
    from casa_assets.registry.kitchens import load_plan, load_style

    load_plan(plan), load_style(style)
    recipe = SceneRecipe(plan, style, seed, (), closed, objects, objects_seed, mixed)
    if textures != STYLE_TEXTURES or model:
        from casa_assets.layouts.run.resolve import draw_surfaces, ordered_models, ordered_surfaces

        surfaces = draw_surfaces(seed or 0) if textures == "random" else ordered_surfaces(_surfaces(textures))
        recipe = replace(recipe, surfaces=surfaces, models=ordered_models(_models(model or [])))
    _build([recipe], out, 1, output)


def _models(texts: list[str]) -> list[tuple[str, str]]:
    """`range=range/pro_six` as pairs."""
    pairs = []
    for text in texts:
        role, _, name = text.partition("=")
        if not role or not name:
            raise typer.BadParameter(f"{text!r}: write ROLE=FAMILY/PRESET or ROLE=library:ID", param_hint="--model")
        pairs.append((role, name))
    return pairs


def _surfaces(text: str) -> list[tuple[Surface, str]]:
    """`wall=ID,floor=ID` as pairs."""
    pairs = []
    for part in text.split(",") if text != STYLE_TEXTURES else ():
        surface, _, name = part.partition("=")
        if surface not in list(Surface) or not name:
            message = f"{part!r}: write wall=ID, floor=ID, counter=ID or cabinet=ID"
            raise typer.BadParameter(message, param_hint="--textures")
        pairs.append((Surface(surface), name))
    return pairs

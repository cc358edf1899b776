"""The grammar of the command line: options that verbs share, each with one meaning, and names that a shell completes.

A name has the same type and the same words of help in every verb; what follows a semicolon may say more of one verb.
`tests/architecture/test_commands.py` holds this. A shell asks for names at each press of a key. So they are taken from
the names of files and from the lines of registry/ that begin a row, and the records behind them are not read; tests
hold that they are the names that the registry gives.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Iterable, Iterator
from enum import StrEnum
from functools import partial, update_wrapper
from inspect import Parameter, Signature, signature
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from casa_assets.cli.group import CLUSTER, GENERAL, LIMITS
from casa_assets.cli.output import Output
from casa_assets.errors import OutputError
from casa_assets.projects import VARIABLE, data_root, find_project, layers

if TYPE_CHECKING:
    from casa_assets.library.library import Library as LibraryFolder
    from casa_assets.runs.pool import Workers as Workers
else:
    Workers = int  # the annotations of a verb are evaluated, and the pool is not imported for that

_ROW, _INNER_ROW = re.compile(r"([A-Za-z][\w-]*):"), re.compile(r"  ([A-Za-z][\w-]*):")
LIBRARY, ARTICULATED, SCENES = Path("out/library"), Path("out/articulated"), Path("out/scenes")
REJECTED = "rejected"
MOST_ASSETS = 200  # of more, the folders of their categories are offered first
OUT_HELP = "Where to write."
LIBRARY_HELP = "Folder of the library."
WIDTH_HELP = "Width of each picture in pixels."
SEED_HELP = "Random seed."
OBJECTS_HELP = "Number of loose objects."
COUNT_HELP = "Number of each."
ALL_HELP = "All of them."
CLIP_HELP = "Weights of CLIP: a file, a folder, or a name such as ViT-B-32/laion2b_s34b_b79k."
SCENES_HELP = "Ids of kitchens or globs, such as 'l_*__coastal'."
IN_3D_HELP = "Write models that the page shows in 3D."
FORCE_HELP = "Do it again even if nothing has changed."


class EngineName(StrEnum):
    """Where jobs run."""

    LOCAL = "local"
    RAY = "ray"


def source(text: str) -> str:
    """A source as a user names it: a path that is there, or the address of a store. Raises typer.BadParameter."""
    from casa_assets.ingest.sources.places import is_url

    is_address = is_url(text)
    if ":" in text and not is_address:  # plug-ins are not looked for otherwise
        from casa_assets.ingest.run.inputs import is_of_plugin

        is_address = is_of_plugin(text)
    if not is_address:
        if not os.path.exists(text):  # noqa: PTH110
            raise typer.BadParameter(f"Path {text!r} does not exist.")
        if not os.access(text, os.R_OK):
            raise typer.BadParameter(f"Path {text!r} is not readable.")
    return text


def more(help_: str, tail: str) -> str:
    """The words of help that all verbs share, and what one verb adds."""
    return f"{help_.removesuffix('.')}; {tail}"


def folder_of_library(folder: Path) -> Path:
    """The folder as it is. Raises typer.BadParameter where it is the address of a store, which a Path takes for one."""
    from casa_assets.ingest.sources.places import is_url

    first = folder.parts[0] if folder.parts else ""
    if first.endswith(":") and is_url(f"{first}//"):  # a Path keeps one of two slashes
        message = "is the address of a store; name a folder, and the store with `ingest --store` or `library push`"
        raise typer.BadParameter(f"{first}// {message}")
    return folder


def _starting(incomplete: str, names: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(name for name in names if name.startswith(incomplete)))


def _layers() -> tuple[Path, ...]:
    """Folders of registry files. No verb has been called yet, so that a project is looked for here."""
    if not os.environ.get(VARIABLE) and (found := find_project(Path())) is not None:
        return (data_root(), found)
    return layers()


def _paths_in(pattern: str) -> list[Path]:
    return sorted(path for layer in _layers() for path in layer.glob(pattern))


def _files(folder: str) -> list[str]:
    return sorted({path.stem for path in _paths_in(f"{folder}/*.yaml")})


def _rows(*patterns: str) -> list[str]:
    paths = [path for pattern in patterns for path in _paths_in(pattern)]
    lines = (line for path in paths for line in path.read_text(encoding="utf-8").splitlines())
    return sorted({found[1] for line in lines if (found := _ROW.match(line))})


def _pictures() -> Iterator[str]:
    for path in _paths_in("textures/*/pack.json"):
        try:
            yield from (picture["id"] for picture in json.loads(path.read_text(encoding="utf-8"))["pictures"])
        except (OSError, ValueError, TypeError, KeyError):
            continue  # a verb says what is wrong with it


def _completing(names: Callable[[], Iterable[str]]) -> Callable[[str], list[str]]:
    """Return what Typer calls with the beginning of a name."""

    def complete(incomplete: str) -> list[str]:
        return _starting(incomplete, names())

    return complete


complete_plans, complete_styles, complete_families, complete_robots = (
    _completing(partial(_files, folder)) for folder in ("plans", "styles", "families", "robots")
)
complete_categories = _completing(lambda: _rows("categories.yaml"))
complete_objects = _completing(lambda: _rows("objects/*.yaml"))
complete_textures = _completing(lambda: sorted({*_rows("textures/*.yaml", "skins/*.yaml"), *_pictures()}))


def complete_kitchens(ctx: typer.Context, incomplete: str) -> list[str]:
    """Ids of kitchens: every plan in every style, and those that are already in the folder of scenes."""
    place = ctx.params.get("scenes_folder") or ctx.params.get("out") or SCENES
    ids = {f"{plan}__{style}" for plan in _files("plans") for style in _files("styles")}
    built = {path.parent.name for path in Path(place).glob("*__*/scene.json")}
    return _starting(incomplete, sorted(ids | built))


def complete_presets(ctx: typer.Context, incomplete: str) -> list[str]:
    """Names of the presets of the families named earlier on the line; of all families if none are named."""
    known = _files("families")
    # While an option waits for its value, the words before it are not bound to arguments yet.
    named, presets = [word for word in ctx.params.get("names") or ctx.args if word in known], set()
    for path in (path for family in named or known for path in _paths_in(f"families/{family}.yaml")):
        inside = False
        for line in path.read_text(encoding="utf-8").splitlines():
            if found := _ROW.match(line):
                inside = found[1] == "presets"
            elif inside and (preset := _INNER_ROW.match(line)):
                presets.add(preset[1])
    return _starting(incomplete, sorted(presets))


def complete_assets(incomplete: str) -> list[str]:
    """Folders of the assets in the libraries that are in their usual places, as paths; and files below a path."""
    known = [name for place in (LIBRARY, ARTICULATED) for name in _assets_of(place, incomplete)]
    return _starting(incomplete, [*known, *_paths(incomplete)])


def _assets_of(place: Path, incomplete: str) -> list[str]:
    """Folders of assets of a library that begin with what is typed, or of categories where many do; no file is read."""
    found: list[str] = []
    shelves = [path.as_posix() for path in _folders(place) if path.name != REJECTED and path.name[0] != "."]
    shelves = [name for name in shelves if f"{name}/".startswith(incomplete) or incomplete.startswith(f"{name}/")]
    for shelf in shelves:
        found += [path.as_posix() for path in _folders(Path(shelf)) if path.as_posix().startswith(incomplete)]
        if len(found) > MOST_ASSETS and len(shelves) > 1:
            return [f"{name}/" for name in shelves]
    return found


def _folders(place: Path) -> list[Path]:
    try:
        with os.scandir(place) as found:
            return sorted(Path(one.path) for one in found if one.is_dir())
    except OSError:
        return []


def _paths(incomplete: str) -> list[str]:
    """Files and folders in the folder that a path begins with; folders end with a slash."""
    folder = Path(incomplete) if incomplete.endswith("/") else Path(incomplete).parent
    names = (path.as_posix() + "/" * path.is_dir() for path in (folder.iterdir() if folder.is_dir() else ()))
    return sorted(name for name in names if name.startswith(incomplete))


def complete_things(ctx: typer.Context, incomplete: str) -> list[str]:
    """Assets of libraries by path, and kitchens by id."""
    return [*complete_assets(incomplete), *complete_kitchens(ctx, incomplete)]


Out = Annotated[
    Path, typer.Option("--out", metavar="DIR", help=more(OUT_HELP, "folders are made where they are missing."))
]
# Of verbs on kitchens, which are in the folder that is written to.
ScenesOut = Annotated[Path, typer.Option("--out", metavar="DIR", help=more(OUT_HELP, "the folder of the kitchens."))]
# Of verbs that read a library; `LibraryOut` is that of verbs that write one.
Library = Annotated[Path, typer.Option("--library", help=LIBRARY_HELP, exists=True, file_okay=False)]
LibraryOut = Annotated[Path, typer.Option("--library", metavar="DIR", help=LIBRARY_HELP, callback=folder_of_library)]
ScenesFolder = Annotated[
    Path, typer.Option("--scenes-folder", metavar="DIR", help="Folder of kitchens; one that is missing is built.")
]

WidthPx = Annotated[int, typer.Option("--width-px", help=WIDTH_HELP, min=64, max=4096)]
SizeM = Annotated[float, typer.Option("--size-m", help="Longest side in metres; 0: by unit and category.", min=0)]
Jobs = Annotated[int, typer.Option("--jobs", help="Number of parallel workers; 0: one per core.", min=0)]
Engine = Annotated[
    EngineName,
    typer.Option("--engine", help="Where jobs run: on this machine, or on a Ray cluster.", rich_help_panel=CLUSTER),
]
Address = Annotated[
    str,
    typer.Option(
        "--address",
        metavar="HOST",
        help="Of a running Ray cluster, such as auto or host:6379; else one is started.",
        rich_help_panel=CLUSTER,
    ),
]
Seed = Annotated[int, typer.Option("--seed", help=SEED_HELP, min=0)]
Most = Annotated[int, typer.Option("--most", help="Largest number.", min=1)]
All = Annotated[bool, typer.Option("--all", help=ALL_HELP)]
Samples = Annotated[int, typer.Option("--samples", help="Number of random members of each.", min=0)]
In3d = Annotated[bool, typer.Option("--3d/--no-3d", help=more(IN_3D_HELP, "about 0.1 MB each."))]
Force = Annotated[bool, typer.Option("--force", help=FORCE_HELP)]
ForceWorse = Annotated[
    bool, typer.Option("--force", help=more(FORCE_HELP, "worse results replace accepted assets, too."))
]
DryRun = Annotated[bool, typer.Option("--dry-run", help="Print what would be done and why; write nothing.")]
Pictures = Annotated[bool, typer.Option("--pictures/--no-pictures", help="Draw a picture of each.")]
Camera = Annotated[
    list[str] | None,
    typer.Option(
        "--camera", metavar="NAME", help="Names of cameras; by default all, with --photoreal eye and cutaway."
    ),
]
Pose = Annotated[
    str, typer.Option("--pose", metavar="NAME", help="Named pose: start, closed, open or on, if the model has it.")
]
Category = Annotated[
    str,
    typer.Option(
        "--category",
        metavar="NAME",
        help="Category of every input, such as microwave; else it is guessed.",
        autocompletion=complete_categories,
    ),
]
Kitchens = Annotated[
    list[str] | None, typer.Option("--scenes", metavar="ID", help=SCENES_HELP, autocompletion=complete_kitchens)
]
WithReview = Annotated[bool, typer.Option("--with-review", help="Include assets that are in review.")]
Port = Annotated[int, typer.Option("--port", help="Port on this machine; 0: any that is free.", min=0, max=65535)]
Browser = Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")]
Photoreal = Annotated[
    bool, typer.Option("--photoreal", help="Path-traced stills from the USD, a minute or two each; needs Blender.")
]

AsJson = Annotated[
    bool,
    typer.Option(
        "--json",
        help="Print one JSON object per item on standard output, and nothing else there.",
        rich_help_panel=GENERAL,
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print only errors and failures.", rich_help_panel=GENERAL)]
Verbose = Annotated[
    bool, typer.Option("--verbose", "-v", help="Print also successes and times.", rich_help_panel=GENERAL)
]


_limit = partial(typer.Option, min=0, show_default=False, rich_help_panel=LIMITS)
# Options that bound an input; 0: the default, which their help names.
LIMIT_OPTIONS = {
    "timeout": (Annotated[float, _limit(metavar="SECONDS", help="Processor seconds per input; 300 by default.")], 0.0),
    "memory": (Annotated[float, _limit(metavar="GB", help="Gigabytes per input; 8 by default.")], 0.0),
    "max_size": (Annotated[float, _limit(metavar="MB", help="Megabytes of an input; 512 by default.")], 0.0),
    "max_faces": (Annotated[int, _limit(help="Faces of an input; 2500000 by default.")], 0),
    "max_texture": (Annotated[int, _limit(help="Pixels of a side; 16384 by default.")], 0),
    "max_pixels": (Annotated[float, _limit(help="Million pixels; 67.2 by default.")], 0.0),
}
InputLimits = dict[str, Any] | None  # options of a run of `ingest`, made of these


class shared:  # noqa: N801  a decorator
    """Decorator: the verb has options that many verbs have, and gets what they mean.

    `output` is the Output that --json, --quiet and --verbose ask for; if it takes `workers`, that is where jobs run, as
    --jobs, --engine and --address say; if it takes `limits`, they are those of `LIMIT_OPTIONS`.
    """

    def __init__(self, verb: Callable[..., None]) -> None:
        update_wrapper(self, verb)
        self.__annotations__ = {}  # Typer reads those of the signature
        self._verb = verb

    @property
    def __signature__(self) -> Signature:
        """The parameters of the command; made when it is called or its help is printed."""
        parameters: list[Parameter] = []
        for name, one in signature(self._verb, eval_str=True).parameters.items():
            if name == "workers":
                parameters += _options(jobs=(Jobs, 0), engine=(Engine, EngineName.LOCAL), address=(Address, ""))
            elif name == "limits":
                parameters += _options(**LIMIT_OPTIONS)
            elif name != "output":
                parameters.append(one.replace(kind=Parameter.KEYWORD_ONLY))
        return Signature(
            [*parameters, *_options(as_json=(AsJson, False), quiet=(Quiet, False), verbose=(Verbose, False))]
        )

    def __call__(self, *, as_json: bool, quiet: bool, verbose: bool, **values: Any) -> None:
        """Call the verb. Raises typer.BadParameter."""
        if "engine" in values:
            engine, address, jobs = values.pop("engine"), values.pop("address"), values.pop("jobs")
            if address and engine is not EngineName.RAY:
                raise typer.BadParameter("is of a Ray cluster; add --engine ray", param_hint="--address")
            values["workers"] = jobs
            if engine is EngineName.RAY:
                from casa_assets.runs.pool import RayCluster

                values["workers"] = RayCluster(address, jobs)
        if "timeout" in values:
            values["limits"] = _limits(**{name: values.pop(name) for name in LIMIT_OPTIONS})
        self._verb(Output(as_json, quiet, verbose), **values)


def _limits(
    timeout: float, memory: float, max_size: float, max_faces: int, max_texture: int, max_pixels: float
) -> dict[str, Any]:
    """Options of a run; what is 0 stays as the registry has it."""
    guards = {
        "input_bytes": max_size * 1e6,
        "input_faces": max_faces,
        "input_texture_px": max_texture,
        "input_texture_pixels": max_pixels * 1e6,
    }
    changed = {name: value for name, value in guards.items() if value}
    return {"seconds": timeout, "memory_bytes": int(memory * 1e9), "guards": changed}


def _options(**options: tuple[Any, Any]) -> list[Parameter]:
    """Parameters of a verb, from their types and defaults."""
    return [
        Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=annotation)
        for name, (annotation, default) in options.items()
    ]


def library_at(folder: Path) -> LibraryFolder:
    """The library in a folder. Raises OutputError where nothing was ever made there, so that nothing is written."""
    from casa_assets.library.library import Library

    place = Library(folder)
    if not place.private.is_dir() and next(chain(place.accepted(), place.refused()), None) is None:
        raise OutputError(str(folder), "is no library; give the folder that `casa-assets ingest` wrote")
    return place

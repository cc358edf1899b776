"""The grammar of the command line: options that verbs share, each with one meaning.

A name has the same type and the same words of help in every verb; what follows a semicolon may say more of one verb.
`tests/architecture/test_commands.py` holds this.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from enum import StrEnum
from functools import update_wrapper
from inspect import Parameter, Signature, signature
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from casa_assets.cli import completion
from casa_assets.cli.group import CLUSTER, GENERAL
from casa_assets.cli.output import Output
from casa_assets.errors import OutputError

if TYPE_CHECKING:
    from casa_assets.library.library import Library as LibraryFolder
    from casa_assets.runs.pool import Workers as Workers
else:
    Workers = int  # the annotations of a verb are evaluated, and the pool is not imported for that


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

Out = Annotated[
    Path, typer.Option("--out", metavar="DIR", help=more(OUT_HELP, "folders are made where they are missing."))
]
# Of verbs on kitchens, which are in the folder that is written to.
ScenesOut = Annotated[Path, typer.Option("--out", metavar="DIR", help=more(OUT_HELP, "the folder of the kitchens."))]
# Of verbs that read a library; `LibraryOut` is that of verbs that write one.
Library = Annotated[Path, typer.Option("--library", help=LIBRARY_HELP, exists=True, file_okay=False)]
LibraryOut = Annotated[Path, typer.Option("--library", metavar="DIR", help=LIBRARY_HELP, callback=folder_of_library)]
ScenesFolder = Annotated[
    Path,
    typer.Option("--scenes-folder", metavar="DIR", help="Folder of kitchens; one that is missing is built."),
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
        autocompletion=completion.categories,
    ),
]
Kitchens = Annotated[
    list[str] | None, typer.Option("--scenes", metavar="ID", help=SCENES_HELP, autocompletion=completion.kitchens)
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


class shared:  # noqa: N801  a decorator
    """Decorator: the verb has options that many verbs have, and gets what they stand for.

    `output` is the Output that --json, --quiet and --verbose ask for; if it takes `workers`, that is where jobs run, as
    --jobs, --engine and --address say.
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
        self._verb(Output(as_json, quiet, verbose), **values)


def _options(**options: tuple[Any, Any]) -> list[Parameter]:
    """Parameters of a verb, from their types and defaults."""
    return [
        Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=annotation)
        for name, (annotation, default) in options.items()
    ]


In3d = Annotated[bool, typer.Option("--3d/--no-3d", help=more(IN_3D_HELP, "about 0.1 MB each."))]


def library_at(folder: Path) -> LibraryFolder:
    """The library in a folder. Raises OutputError where nothing was ever made there, so that nothing is written."""
    from casa_assets.library.library import Library

    place = Library(folder)
    if not place.private.is_dir() and next(chain(place.accepted(), place.refused()), None) is None:
        raise OutputError(str(folder), "is no library; give the folder that `casa-assets ingest` wrote")
    return place

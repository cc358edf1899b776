"""casa-assets init, make: a user's project, and all that it makes."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from casa_assets.cli.options import DryRun, shared
from casa_assets.cli.output import Output
from casa_assets.errors import CasaError
from casa_assets.projects import SETTINGS, project_folder

if TYPE_CHECKING:
    from casa_assets.model.registry.document import Document, KeyPath
    from casa_assets.model.registry.rows import Project

VERDICTS = {0: "done", 4: "review"}  # of a run by its exit code; any other: failed
FAILED = (2, 3)  # exit codes after which the next command would fail too: misuse or a broken machine, a fault
# A small working project: a plan, a style, finishes, a member of a family, a category and its objects.
STARTER = Path(__file__).parents[1] / "starter"
NAME = "my_kitchens"  # in the starter's casa.yaml
# Options that hold for all runs, and are given to `make`.
OF_ALL = ("project", "plugins")
# Verbs that serve a page or write a project are no part of making a registry.
LEFT_OUT = ("make", "init", "view", "review")


@shared
def init(
    output: Output,
    folder: Annotated[Path, typer.Argument(help="Where the project is to be; the folder is made if it is missing.")],
) -> None:
    """Write a small working project: a plan, a style, textures, a category, objects, and what `make` makes of them.

    A project is a folder with a casa.yaml. Its files add to those of casa-assets, or replace them, for every command
    that is called in it. Exit 0 when it was written, 2 on misuse.

    Example:  casa-assets init my_kitchens
    """
    from casa_assets.runs.outcome import writing

    with writing(folder):
        paths = write_starter(folder)
    for path in paths:
        output.made(path.relative_to(folder).as_posix(), path.parent)
        output.line(str(path))
    if not output.as_json and not output.quiet:
        output.error(f"Make what it describes: cd {shlex.quote(str(folder))} && casa-assets make")


def write_starter(folder: Path) -> list[Path]:
    """Copy the starter into a folder, which names the project; returns the files. Raises CasaError if one is there."""
    targets = {path: folder / path.relative_to(STARTER) for path in sorted(STARTER.rglob("*.yaml"))}
    if taken := [str(path) for path in targets.values() if path.exists()]:
        raise CasaError(f"{', '.join(taken)}: is there already; name another folder, or take it away")
    for source, target in targets.items():
        text = source.read_text(encoding="utf-8")
        if source.name == SETTINGS:
            text = text.replace(f"name: {NAME}", f"name: {name_of(folder)}")
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")
    return list(targets.values())


def name_of(folder: Path) -> str:
    """The name of a folder as an id: `My kitchens 2` becomes `my_kitchens_2`."""
    name = "_".join(re.findall(r"[a-z0-9]+", folder.absolute().name.lower()))
    return name if re.match(r"[a-z]", name) else f"project_{name}".rstrip("_")


@shared
def make(output: Output, dry_run: DryRun = False) -> None:
    """Call the commands that the project lists under `runs` in its casa.yaml, one after the other, in its folder.

    What an earlier call made and has not changed is kept. With --json each command prints its rows, followed by
    one row for the command. Exit 0 when all ended with 0, 1 when something was rejected or failed, 4 when a
    person has to decide, 2 on misuse or a broken machine: the commands behind are not called then.

    Example:  casa-assets make --project my_kitchens
    """
    from casa_assets.cli.main import app
    from casa_assets.registry.read import load_project

    found = load_project()
    if found is None:
        raise CasaError(f"no {SETTINGS} here or above; write a project with `casa-assets init DIR`, or name one")
    steps = steps_of(*found, typer.main.get_command(app))
    if not steps:
        raise CasaError(f"{found[1].file}: lists no runs")
    codes = []
    for step, takes_json in steps:
        words = shlex.join(("casa-assets", *step))
        if dry_run:
            output.row({"id": words, "verdict": "planned"})
            output.line(words)
            continue
        output.console.rule(words, align="left")
        extra = ["--json"] * (output.as_json and takes_json) + ["--quiet"] * output.quiet
        end = step.index("--") if "--" in step else len(step)
        command = (sys.executable, "-m", "casa_assets.cli.main", *step[:end], *extra, *step[end:])
        codes.append(subprocess.run(command, cwd=project_folder(), check=False).returncode)
        output.row({"id": words, "verdict": VERDICTS.get(codes[-1], "failed"), "exit_code": codes[-1]})
        if codes[-1] in FAILED or codes[-1] < 0:
            break
    # A fault before misuse before rejections before decisions to be taken; of an unknown code that itself.
    order, known = (3, 2, 1, 4, 0), [3 if code < 0 else code for code in codes]
    raise typer.Exit(next((code for code in (*(c for c in known if c not in order), *order) if code in known), 0))


def steps_of(project: Project, document: Document, group: Any) -> list[tuple[tuple[str, ...], bool]]:
    """The commands of a project in their order: the words behind `casa-assets`, and whether it has an option --json.

    Raises:
        RegistryError: with file and line, if a command, an argument or an option does not exist, or has no such value.
    """
    from casa_assets.model.registry.document import expected_one_of

    known, found = dict(_commands(group)), []
    for number, run in enumerate(project.runs):
        ((name, values),) = run.items()
        at: KeyPath = ("runs", number, name)
        if name not in known:
            raise document.fault(at, expected_one_of(tuple(known), name), repr(name))
        takes_json = any("--json" in parameter.opts for parameter in known[name].params)
        found.append(((*name.split(), *_words(known[name], values or {}, document, at)), takes_json))
    return found


def _commands(group: Any, before: str = "") -> Iterator[tuple[str, Any]]:
    for name, command in group.commands.items():
        if command.hidden or (not before and name in LEFT_OUT):
            continue
        if hasattr(command, "commands"):
            yield from _commands(command, f"{before}{name} ")
        else:
            yield f"{before}{name}", command


def _words(command: Any, values: Mapping[str, Any], document: Document, at: KeyPath) -> Iterator[str]:
    """Options, then the arguments behind them."""
    from casa_assets.model.registry.document import expected_one_of

    own = [p for p in command.params if not p.hidden and p.name not in OF_ALL]
    parameters = {name: p for p in own for name in _names(p)}
    behind: list[str] = []
    for key, value in values.items():
        here = (*at, key)
        parameter = parameters.get(key.replace("_", "-"))
        if parameter is None:
            shown = tuple(dict.fromkeys(_names(p)[0] for p in parameters.values()))
            raise document.fault(here, expected_one_of(shown, key), repr(key))
        is_argument, is_many = parameter.param_type_name == "argument", parameter.multiple or parameter.nargs != 1
        if not is_argument and parameter.is_flag:
            if not isinstance(value, bool):
                raise document.fault(here, "true or false", repr(value))
            if value:
                yield _long(parameter.opts)
            elif parameter.secondary_opts:
                yield _long(parameter.secondary_opts)
            continue
        if isinstance(value, list) and not is_many:
            raise document.fault(here, "one value", repr(value))
        texts = [_text(one, document, here) for one in (value if isinstance(value, list) else [value])]
        if is_argument:
            behind += texts
        elif parameter.nargs > 1:
            if len(texts) != parameter.nargs:
                raise document.fault(here, f"{parameter.nargs} values", repr(value))
            yield from (_long(parameter.opts), *texts)
        else:
            yield from (f"{_long(parameter.opts)}={text}" for text in texts)
    if behind:
        yield from ("--", *behind)


def _names(parameter: Any) -> list[str]:
    """Names that a parameter has in a project: an argument by its name, an option by each of its long names."""
    if parameter.param_type_name == "argument":
        return [str(parameter.name).rstrip("_").replace("_", "-")]
    return [name.removeprefix("--") for name in parameter.opts if name.startswith("--")]


def _long(names: list[str]) -> str:
    return next(name for name in names if name.startswith("--"))


def _text(value: Any, document: Document, at: KeyPath) -> str:
    if isinstance(value, bool | list | dict) or value is None:
        raise document.fault(at, "a text or a number", repr(value))
    return str(value)

"""The class of every verb: it finds the project, and with --verbose says how long it took."""

from __future__ import annotations

import resource
import sys
import time
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from casa_assets.cli.help import GENERAL, help_text, usage_pieces
from casa_assets.projects import (
    NO_PROJECT,
    SETTINGS,
    VARIABLE,
    PluginUse,
    choose_plugins,
    find_project,
    plugin_use,
    project_folder,
    use_project,
)

PROJECT_HELP = f"Folder with a {SETTINGS}; by default this one or the nearest above it; '{NO_PROJECT}': none."
PLUGINS_HELP = "Run the code in plugins/ of the project; or none, not even of installed packages."


class Verb(TyperCommand):
    """A verb of the command line, with the options that all verbs share."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.params += _options_of_all()

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help."""
        formatter.write(help_text(self, ctx, formatter.width))

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """The words behind the name in the usage."""
        return usage_pieces(self, ctx)

    def invoke(self, ctx: Any) -> Any:
        """Run the verb; with --verbose, say on standard error what it took."""
        begin = time.monotonic()
        try:
            return super().invoke(ctx)
        finally:
            if ctx.params.get("verbose"):
                typer.echo(_spent(time.monotonic() - begin), err=True)


@lru_cache(maxsize=1)
def _options_of_all() -> tuple[Any, ...]:
    """The options of every verb, made by Typer of a command that has no others."""
    single = typer.Typer(add_completion=False)
    single.command()(_with_project)
    named = {name: p for p in typer.main.get_command(single).params for name in p.opts}
    return (named["--project"], named["--plugins"])


def _on_project(ctx: typer.Context, named: str) -> None:
    """Use the project that is named, or else the nearest at or above the working folder. Raises CasaError."""
    if ctx.resilient_parsing:
        return
    if named:
        use_project(None if named == NO_PROJECT else Path(named))
    elif (found := find_project(Path())) is not None:
        use_project(found)


def _on_plugins(ctx: typer.Context, wanted: bool | None) -> None:
    """Have the plug-ins run that are asked for; say which of the project do not."""
    if ctx.resilient_parsing:
        return
    if wanted is not None:
        choose_plugins(PluginUse.ALL if wanted else PluginUse.NONE)
    folder = project_folder()
    if folder is not None and plugin_use() is PluginUse.INSTALLED and any((folder / "plugins").glob("*.py")):
        from casa_assets.registry.plugins import ignored_files

        if ignored_files():
            message = f"the code in {folder / 'plugins'} does not run; add --plugins if you trust it"
            typer.echo(f"note: {message}, or --no-plugins", err=True)


def _with_project(
    project: Annotated[
        str,
        typer.Option(
            "--project",
            metavar="DIR",
            help=PROJECT_HELP,
            rich_help_panel=GENERAL,
            envvar=VARIABLE,
            show_envvar=False,
            expose_value=False,
            is_eager=True,
            callback=_on_project,
        ),
    ] = "",
    plugins: Annotated[
        bool | None,
        typer.Option(
            "--plugins/--no-plugins",
            help=PLUGINS_HELP,
            rich_help_panel=GENERAL,
            show_default=False,
            expose_value=False,
            callback=_on_plugins,
        ),
    ] = None,
) -> None: ...


def _spent(wall_s: float) -> str:
    """Seconds, processor seconds and memory of this process and of those that it waited for."""
    own, others = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    cpu_s = sum(usage.ru_utime + usage.ru_stime for usage in (own, others))
    peak = max(own.ru_maxrss, others.ru_maxrss) * (1 if sys.platform == "darwin" else 1024)  # Ref: getrusage(2)
    return f"took {wall_s:.1f} s, {cpu_s:.1f} s of processor time; the largest process had {peak / 1e6:.0f} MB"

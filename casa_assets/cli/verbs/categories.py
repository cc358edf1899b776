"""casa-assets categories: kinds of things, how large and heavy they usually are, and what builds them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from casa_assets.cli import completion
from casa_assets.cli.group import Group
from casa_assets.cli.options import AsJson
from casa_assets.cli.output import Output
from casa_assets.cli.tables import TextTable, from_column
from casa_assets.cli.text import pluralize
from casa_assets.cli.verb import Verb

if TYPE_CHECKING:
    from collections.abc import Mapping

    from casa_assets.model.registry.category import Category, SizeRange

app = typer.Typer(
    name="categories",
    cls=Group,
    help="Categories of things: usual size and mass, substance, other names, what builds them: list, show.",
    no_args_is_help=True,
)


@app.command("list", cls=Verb)
def list_categories(json_: AsJson = False) -> None:
    """List every category with its class, usual size and mass, and what builds it.

    First those that `ingest` assigns to meshes, then those of fixtures, which families build. Exit 0.

    Example:  casa-assets categories list
    """
    output, builders = Output(json_), _builders()
    heads = ("longest, m", "mass, kg")
    table = TextTable(("category", "class", *heads, "built by", *from_column()), right=heads, sentences=("built by",))
    for category in _all().values():
        row = _row(category, builders.get(category.id, ()))
        output.row(row)
        usual = (f"{category.longest_m.typical:g}", f"{category.mass_kg.typical:g}")
        table.add_from(category.id, category.parent, *usual, ", ".join(row["built_by"]), row["from"])
    if not json_:
        table.print(output.console)
        output.line(pluralize(len(table.rows), "category"))


@app.command(cls=Verb)
def show(
    names: Annotated[list[str], typer.Argument(help="Ids of categories.", autocompletion=completion.categories)],
    json_: AsJson = False,
) -> None:
    """Print what is known of categories: usual size and mass, substance, other names, what builds them.

    Exit 0 when there are such categories, 2 when there are not.

    Example:  casa-assets categories show mug microwave
    """
    from casa_assets.errors import UnknownId

    output, known, builders = Output(json_), _all(), _builders()
    for name in names:
        if name not in known:
            raise UnknownId("category", name, known)
    for name in names:
        row = _row(known[name], builders.get(name, ()))
        output.row(row)
        if not json_:
            _print(row, output)


def _all() -> Mapping[str, Category]:
    """Categories of objects, then those of fixtures, by id."""
    from casa_assets import registry

    known = registry.load()
    return {**known.categories, **known.fixtures}


def _builders() -> dict[str, tuple[str, ...]]:
    """Category -> commands that build one: of families, and of objects by their form."""
    from casa_assets.registry.families import families
    from casa_assets.registry.objects import object_names

    found: dict[str, tuple[str, ...]] = {}
    for made in families().values():
        found[made.category] = (*found.get(made.category, ()), f"families build {made.name}")
    for name in object_names():
        found[name] = (*found.get(name, ()), f"objects build {name}")
    return found


def _row(category: Category, builders: tuple[str, ...]) -> dict[str, Any]:
    """What `--json` tells of a category."""
    from casa_assets import registry
    from casa_assets.registry.look_alikes import look_alikes
    from casa_assets.registry.project import origin_of_row

    table = "categories.yaml" if category.id in registry.load().categories else "fixtures.yaml"
    kinds = look_alikes()
    kind = kinds.get(category.id)
    size = category.extents
    return {
        "id": category.id,
        "class": category.parent,
        "classes": [name for name in registry.load().classes_of(category) if name != category.id],
        "size": [side.typical for side in size],
        "size_low": [side.low for side in size],
        "size_high": [side.high for side in size],
        "longest": _range(category.longest_m),
        "mass": category.mass_kg.typical,
        "mass_range": _range(category.mass_kg),
        "substance": category.substance,
        "build": category.build.value,
        "rests": category.upright.value,
        "fixed": category.fixed,
        "affords": [use.value for use in category.affords],
        "aliases": list(category.aliases),
        "lvis": list(category.lvis),
        "looks_like": sorted(name for name, other in kinds.items() if kind and other == kind and name != category.id),
        "basis": {"size": category.basis.size.value, "mass": category.basis.mass.value},
        "built_by": list(builders),
        "from": origin_of_row(table, category.id),
    }


def _range(span: SizeRange) -> list[float]:
    return [span.low, span.typical, span.high]


def _print(row: dict[str, Any], output: Output) -> None:
    """Print a category line by line."""
    size = " x ".join(f"{value:.3g}" for value in row["size"])
    low, _, high = row["longest"]
    light, _, heavy = row["mass_range"]
    lines = {
        "class": " > ".join(row["classes"]),
        "size": f"{size} m, as it rests; longest side {low:g} to {high:g} m ({row['basis']['size']})",
        "mass": f"{row['mass']:g} kg; {light:g} to {heavy:g} kg ({row['basis']['mass']})",
        "substance": f"{row['substance']}, {row['build']}",
        "rests": row["rests"] + (", fixed to the building" if row["fixed"] else ""),
        "affords": ", ".join(row["affords"]),
        "other names": ", ".join(row["aliases"]),
        "looks like": ", ".join(row["looks_like"]),
        "built by": ", ".join(f"casa-assets {command}" for command in row["built_by"]),
        "from": row["from"] if from_column() else "",
    }
    output.line(row["id"])
    for name, words in lines.items():
        if words:
            output.line(f"  {name + ':':12} {words}")

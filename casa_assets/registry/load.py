"""Read registry/: YAML into frozen records; unknown keys, duplicate keys and unresolved names are errors."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

import yaml
from pydantic import ValidationError

from casa_assets.errors import RegistryError, UnknownId
from casa_assets.model.asset.material import Density, Substance
from casa_assets.model.record import Record
from casa_assets.model.registry.category import FALLBACK, Category, Certainty, QCode
from casa_assets.model.registry.contract import Contract
from casa_assets.model.registry.document import Document, KeyPath
from casa_assets.model.registry.fields import expected_one_of, fields_at
from casa_assets.model.registry.finish import Plain
from casa_assets.model.registry.rows import Limit, MisleadingWords, OtherThingsWords, Rejection, TaxonomyClass, Waiver
from casa_assets.model.registry.vocabulary import Vocabulary

FILES = (
    "categories",
    "classes",
    "densities",
    "fixtures",
    "limits",
    "materials",
    "other_things",
    "rejections",
    "substances",
    "waivers",
    "words",
)
LEARNED = "learned"  # folder of what scripts have learned, read by learned.py
YAML_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml, where PyYAML has it
R = TypeVar("R", bound=Record)


@dataclass(frozen=True, eq=False)
class Registry:
    """The decisions of this project, read from registry/.

    Attributes:
        categories, fixtures, materials, substances, classes, rejections: by id (rejections by code). Fixtures are the
            categories of what families build; free words never find them.
        densities: name -> kg/m^3, of the substances and of parts that are drawn solid and are not.
        contracts: what runtimes expect of fixtures, by id; one file each in contracts/.
        limits, limit_units: numbers and their units by key.
        waivers: in file order.
        digest: sha256 of the contents of all files.
        vocabulary: ids, aliases and LVIS names of the categories, for free words.
        other_things: words which tell that something is no single household object.
    """

    categories: Mapping[str, Category]
    fixtures: Mapping[str, Category]
    materials: Mapping[str, Plain]
    substances: Mapping[str, Substance]
    densities: Mapping[str, float]
    classes: Mapping[str, TaxonomyClass]
    limits: Mapping[str, float]
    limit_units: Mapping[str, str]
    waivers: tuple[Waiver, ...]
    rejections: Mapping[str, Rejection]
    contracts: Mapping[str, Contract]
    digest: str
    vocabulary: Vocabulary
    other_things: OtherThingsWords

    def category(self, name: str) -> Category:
        """The category of this id. Raises UnknownId with the nearest names."""
        if name not in self.categories:
            raise UnknownId("category", name, self.categories)
        return self.categories[name]

    def classes_of(self, category: Category | str) -> tuple[str, ...]:
        """Ids from the category itself up to the root, such as `("mug", "drinkware", "tableware", ...)`."""
        found = self.category(category) if isinstance(category, str) else category
        chain, at = [found.id], found.parent
        while at and at not in chain:  # the category `object` and the root class share their name
            chain.append(at)
            at = self.classes[at].parent or ""
        return tuple(chain)

    def waived(self, subject: str) -> dict[str, str]:
        """Code -> reason of the checks that are not run on the asset or scene of this id."""
        return {w.code: w.reason for w in self.waivers if w.subject == subject}

    def find_category(self, hints: Sequence[str]) -> tuple[Category, float, str] | None:
        """The category that free texts speak of, or None.

        Args:
            hints: file names, titles, tags; the best first. A weak word counts only where no hint has a better one.
        Returns:
            Category, confidence 0..1, and the evidence as `'mug' in 'Room Essentials Mug'`.
        """
        match = self.vocabulary.find(hints)
        return (self.categories[match.id], match.confidence, match.evidence) if match else None


def read_document(path: Path) -> Document:
    """Parse one file. Raises RegistryError where it is missing, no YAML, or has a key twice."""
    lines: dict[KeyPath, int] = {}
    loader = yaml.SafeLoader("")

    def parse(node: yaml.Node, at: KeyPath) -> Any:
        lines.setdefault(at, node.start_mark.line + 1)
        if isinstance(node, yaml.SequenceNode):
            return [parse(item, (*at, i)) for i, item in enumerate(node.value)]
        if not isinstance(node, yaml.MappingNode):
            return loader.construct_object(node)
        values: dict[str, Any] = {}
        for key, item in node.value:
            name, line = str(key.value), key.start_mark.line + 1
            if name in values:
                raise RegistryError(
                    path.name, line, ".".join(map(str, (*at, name))), "each key once", f"{name!r} again"
                )
            lines[(*at, name)] = line
            values[name] = parse(item, (*at, name))
        return values

    try:
        text = path.read_text(encoding="utf-8")
        try:
            root = yaml.compose(text, Loader=YAML_LOADER)
        except yaml.YAMLError:  # again in Python, whose messages are better than libyaml's
            root = yaml.compose(text, Loader=yaml.SafeLoader)
        value = parse(root, ()) if root else {}
    except OSError as error:
        raise RegistryError(path.name, 1, "", "a readable file", error.strerror or str(error)) from None
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        raise RegistryError(path.name, line, "", "YAML", f"what it cannot read: {error.problem}") from None
    except (yaml.YAMLError, ValueError) as error:
        raise RegistryError(path.name, 1, "", "YAML in UTF-8", str(error)) from None
    return Document(path.name, value, MappingProxyType(lines))


def read_record(kind: type[R], row: Any, document: Document, path: KeyPath, **given: Any) -> R:
    """One validated record from a row of a file; `given` are fields that the row does not state."""
    if not isinstance(row, dict):
        raise document.fault(path, "a mapping", repr(row))
    for name in row.keys() & given.keys():
        raise document.fault((*path, name), f"no {name}: the key of the row is its {name}", repr(row[name]))
    try:
        return kind.model_validate({**row, **given})
    except ValidationError as error:
        # A misspelt name is reported as unknown and as missing: the former is more helpful.
        first = next((e for e in error.errors() if e["type"] == "extra_forbidden"), error.errors()[0])
        at = (*path, *first["loc"])
        if first["type"] == "extra_forbidden":
            got = str(first["loc"][-1])
            raise document.fault(at, expected_one_of(fields_at(kind, first["loc"][:-1]), got), repr(got)) from None
        got = "nothing" if first["type"] == "missing" else repr(first["input"])[:80]
        raise document.fault(at, first["msg"].removeprefix("Input should be "), got) from None


def read_table(kind: type[R], document: Document, key: str = "id") -> dict[str, R]:
    """Records of a file that maps ids to rows."""
    if not isinstance(document.value, dict):
        raise document.fault((), "a mapping of ids to rows", type(document.value).__name__)
    return {name: read_record(kind, row, document, (name,), **{key: name}) for name, row in document.value.items()}


def read_classes(document: Document) -> dict[str, TaxonomyClass]:
    """The class tree; a class without its own Q-code takes that of the class above."""
    rows = document.value if isinstance(document.value, dict) else {}
    classes: dict[str, TaxonomyClass] = {}

    def read(name: str, below: tuple[str, ...]) -> TaxonomyClass:
        if name in below:
            raise document.fault((name, "parent"), "a tree", " -> ".join((*below, name)))
        if name not in classes:
            row = dict(rows[name]) if isinstance(rows[name], dict) else rows[name]
            parent = row.get("parent") if isinstance(row, dict) else None
            if parent is not None and str(parent) not in rows:
                raise document.fault((name, "parent"), "a class", repr(parent))
            if parent is not None and "qcode" not in row:
                row["qcode"] = inherited_q_code(read(parent, (*below, name)).qcode)
            elif parent is not None:
                read(parent, (*below, name))
            classes[name] = read_record(TaxonomyClass, row, document, (name,), id=name)
        return classes[name]

    return {name: read(name, ()) for name in rows}


def inherited_q_code(qcode: QCode) -> QCode:
    """The Q-code of a class as it is used for what lies below it."""
    return qcode.replace(certainty=Certainty.PARENT)


def read_span(value: Any, document: Document, path: KeyPath) -> Any:
    """The fields of a span from its short form, a list of three; anything else as it is."""
    if not isinstance(value, list):
        return value
    if len(value) != 3:
        raise document.fault(path, "[low, typical, high]", repr(value))
    return dict(zip(("low", "typical", "high"), value, strict=True))


def read_categories(
    document: Document, classes: Mapping[str, TaxonomyClass], substances: Mapping[str, Substance]
) -> dict[str, Category]:
    """The categories; short forms (a list of three for a span, no Q-code) filled in, names checked."""
    if not isinstance(document.value, dict):
        raise document.fault((), "a mapping of ids to rows", type(document.value).__name__)
    categories: dict[str, Category] = {}
    for name, stated in document.value.items():
        row = dict(stated) if isinstance(stated, dict) else stated
        for field in ("longest_m", "mass_kg") if isinstance(row, dict) else ():
            if isinstance(row.get(field), list):
                row[field] = read_span(row[field], document, (name, field))
        if isinstance(row, dict) and isinstance(row.get("size_m"), list):
            row["size_m"] = [read_span(span, document, (name, "size_m", i)) for i, span in enumerate(row["size_m"])]
        if isinstance(row, dict) and isinstance(row.get("portions"), dict):
            row["portions"] = _read_portions(row["portions"], document, (name, "portions"))
        if isinstance(row, dict) and str(row.get("parent")) in classes:
            row.setdefault("qcode", inherited_q_code(classes[row["parent"]].qcode))
        elif isinstance(row, dict) and "parent" in row:
            raise document.fault((name, "parent"), "a class of classes.yaml", repr(row["parent"]))
        categories[name] = found = read_record(Category, row, document, (name,), id=name)
        if found.substance not in substances:
            raise document.fault((name, "substance"), "a substance of substances.yaml", repr(found.substance))
        if min(found.shape) <= 0 or max(found.shape) != 1:
            raise document.fault((name, "shape"), "extents in 0..1, the largest 1", repr(found.shape))
    return categories


def _read_portions(stated: Mapping[str, Any], document: Document, path: KeyPath) -> dict[str, Any]:
    """The ranges of portions, each a list of three."""
    return {
        portion: {field: read_span(span, document, (*path, portion, field)) for field, span in ranges.items()}
        if isinstance(ranges, dict)
        else ranges
        for portion, ranges in stated.items()
    }


def read_materials(document: Document, substances: Mapping[str, Substance]) -> dict[str, Plain]:
    """The plain finishes; each names a substance."""
    materials = read_table(Plain, document)
    for name, row in materials.items():
        if row.substance not in substances:
            raise document.fault((name, "substance"), "a substance of substances.yaml", repr(row.substance))
    return materials


def read_densities(document: Document, substances: Mapping[str, Substance]) -> dict[str, float]:
    """kg/m^3 by name: of every substance, and of every row of the document."""
    found = {name: substance.density for name, substance in substances.items()}
    for name, row in read_table(Density, document).items():
        if name in substances:
            raise document.fault((name,), "a name that no substance has", repr(name))
        if row.substance is not None and row.substance not in substances:
            expected = expected_one_of(tuple(substances), row.substance)
            raise document.fault((name, "substance"), expected, repr(row.substance))
        found[name] = substances[row.substance].density * row.fill if row.substance else float(row.kg_m3 or 0.0)
    return found


def read_contracts(paths: Sequence[Path]) -> dict[str, Contract]:
    """The contracts, one file each, called after its id."""
    contracts: dict[str, Contract] = {}
    for path in paths:
        document = replace(read_document(path), file=f"{path.parent.name}/{path.name}")
        contracts[path.stem] = read_record(Contract, document.value, document, (), id=path.stem)
    return contracts


def read_vocabulary(document: Document, categories: Mapping[str, Category], words: MisleadingWords) -> Vocabulary:
    """Map each id and alias to its category. Raises RegistryError where two categories claim a name."""
    names = [(c.id, c.id) for c in categories.values() if c.id != FALLBACK]
    names += [(alias, c.id) for c in categories.values() for alias in (*c.aliases, *c.lvis)]
    try:
        return Vocabulary.of(names, words.weak, words.separators)
    except ValueError as error:
        name = str(error)
        claims: list[KeyPath] = [
            (c.id, field, row.index(name))
            for c in categories.values()
            for field, row in (("aliases", c.aliases), ("lvis", c.lvis))
            if name in row
        ]
        raise document.fault([(name,), *claims][-1], "a name that no other category has", repr(name)) from None


def data_root() -> Path:
    """Folder of the files: `registry_data` inside an installed package, `registry` beside it in a checkout."""
    package = Path(__file__).parents[1]
    inside = package / "registry_data"
    return inside if inside.is_dir() else package.parent / "registry"


@lru_cache(maxsize=8)
def load(root: Path | None = None) -> Registry:
    """Read and check every file of `root` (default: the one that comes with the package). Raises RegistryError."""
    folder = data_root() if root is None else root
    documents = {name: read_document(folder / f"{name}.yaml") for name in FILES}
    digest = hashlib.sha256()
    for name in FILES:
        digest.update(name.encode() + b"\0" + hashlib.sha256((folder / f"{name}.yaml").read_bytes()).digest())
    contracts = sorted((folder / "contracts").glob("*.yaml"))
    for path in (*contracts, *sorted((folder / LEARNED).glob("*.json"))):
        digest.update(path.name.encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    substances = read_table(Substance, documents["substances"])
    classes = read_classes(documents["classes"])
    categories = read_categories(documents["categories"], classes, substances)
    limits = read_table(Limit, documents["limits"])
    words = read_record(MisleadingWords, documents["words"].value, documents["words"], ())
    waivers = documents["waivers"]
    return Registry(
        categories=MappingProxyType(categories),
        fixtures=MappingProxyType(read_categories(documents["fixtures"], classes, substances)),
        materials=MappingProxyType(read_materials(documents["materials"], substances)),
        substances=MappingProxyType(substances),
        densities=MappingProxyType(read_densities(documents["densities"], substances)),
        classes=MappingProxyType(classes),
        limits=MappingProxyType({name: limit.value for name, limit in limits.items()}),
        limit_units=MappingProxyType({name: limit.unit for name, limit in limits.items()}),
        waivers=tuple(read_record(Waiver, row, waivers, (i,)) for i, row in enumerate(waivers.value or [])),
        rejections=MappingProxyType(read_table(Rejection, documents["rejections"], "code")),
        contracts=MappingProxyType(read_contracts(contracts)),
        digest=digest.hexdigest(),
        vocabulary=read_vocabulary(documents["categories"], categories, words),
        other_things=read_record(OtherThingsWords, documents["other_things"].value, documents["other_things"], ()),
    )

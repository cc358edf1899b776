"""Read registry/ as a whole, and what scripts have learned: YAML into records; unresolved names are errors."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from types import MappingProxyType

from casa_assets.core.numeric import Forest, forest_from_dict
from casa_assets.errors import RegistryError, UnknownId
from casa_assets.model.asset.material import Density, Substance
from casa_assets.model.registry.category import FALLBACK, Category, Certainty, Vocabulary
from casa_assets.model.registry.contract import Contract
from casa_assets.model.registry.document import Document, KeyPath, expected_one_of
from casa_assets.model.registry.rows import (
    ConfidenceModel,
    Limit,
    MisleadingWords,
    OtherThingsWords,
    Plain,
    Rejection,
    TaxonomyClass,
    Waiver,
)
from casa_assets.projects import data_root, read_once
from casa_assets.registry.read import (
    load_project,
    names_in,
    read_document,
    read_record,
    read_table,
    read_table_file,
    stated_in,
)

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
CONTRACTS = "contracts"
LEARNED = "learned"  # folder of what scripts have learned, read below


@dataclass(frozen=True, eq=False)
class Registry:
    """Contents of registry/, with those of the project in use laid over them.

    Attributes:
        categories, fixtures, materials, substances, classes, rejections: by id (rejections by code). Fixtures are the
            categories of what families build; free words never find them.
        densities: name -> kg/m^3, of the substances and of parts that are modelled as solid but are not.
        contracts: what runtimes expect of fixtures, by id; one file each in contracts/.
        limits, limit_units: numbers and their units by key. waivers: in file order.
        digest: sha256 of the contents of all files.
        vocabulary: ids, aliases and LVIS names of the categories, for free words.
        other_things: words which show that something is not a single household object.
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
                row["qcode"] = read(parent, (*below, name)).qcode.replace(certainty=Certainty.PARENT)
            elif parent is not None:
                read(parent, (*below, name))
            classes[name] = read_record(TaxonomyClass, row, document, (name,), id=name)
        return classes[name]

    return {name: read(name, ()) for name in rows}


def read_categories(
    document: Document, classes: Mapping[str, TaxonomyClass], substances: Mapping[str, Substance]
) -> dict[str, Category]:
    """The categories, with the Q-code of their class where they have none; names are checked."""
    if not isinstance(document.value, dict):
        raise document.fault((), "a mapping of ids to rows", type(document.value).__name__)
    categories: dict[str, Category] = {}
    for name, stated in document.value.items():
        row = dict(stated) if isinstance(stated, dict) else stated
        if isinstance(row, dict) and str(row.get("parent")) in classes:
            row.setdefault("qcode", classes[row["parent"]].qcode.replace(certainty=Certainty.PARENT))
        elif isinstance(row, dict) and "parent" in row:
            raise document.fault((name, "parent"), "a class of classes.yaml", repr(row["parent"]))
        categories[name] = found = read_record(Category, row, document, (name,), id=name)
        if found.substance not in substances:
            raise document.fault((name, "substance"), "a substance of substances.yaml", repr(found.substance))
        if min(found.shape) <= 0 or max(found.shape) != 1:
            raise document.fault((name, "shape"), "extents in 0..1, the largest 1", repr(found.shape))
    return categories


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
        claims = [(name,), *claims] if name in categories else claims
        # The later claim is at fault, and that of a project where it has one.
        at = next((claim for claim in claims if claim in document.files), claims[-1])
        others = ", ".join(dict.fromkeys(str(claim[0]) for claim in claims if claim != at))
        raise document.fault(at, "a name that no other category has", f"{name!r}, also of {others}") from None


@read_once
def load_limits(root: Path | None = None) -> Mapping[str, Limit]:
    """The limits of checks by key, for those who need nothing else of the registry. `root` as of `load`."""
    return read_table(Limit, read_table_file("limits.yaml", root))


@read_once
def load(root: Path | None = None) -> Registry:
    """Read and check every file. Raises RegistryError.

    `root`: the only folder to read; None reads the package's and, over it, that of the project in use.
    """
    if root is None:
        load_project()
    documents = {name: read_table_file(f"{name}.yaml", root) for name in FILES}
    contracts = {name: read_table_file(f"{CONTRACTS}/{name}.yaml", root) for name in names_in(CONTRACTS, root)}
    names = [*(f"{name}.yaml" for name in FILES), *(f"{CONTRACTS}/{name}.yaml" for name in contracts)]
    learned = sorted(((data_root() if root is None else root) / LEARNED).glob("*.json"))
    digest = hashlib.sha256()
    for path in (*(path for name in names for path in stated_in(name, root)), *learned):
        digest.update(path.stem.encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    substances = read_table(Substance, documents["substances"])
    classes = read_classes(documents["classes"])
    categories = read_categories(documents["categories"], classes, substances)
    limits = load_limits(root)
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
        contracts=MappingProxyType(
            {name: read_record(Contract, one.value, one, (), id=name) for name, one in contracts.items()}
        ),
        digest=digest.hexdigest(),
        vocabulary=read_vocabulary(documents["categories"], categories, words),
        other_things=read_record(OtherThingsWords, documents["other_things"].value, documents["other_things"], ()),
    )


@lru_cache(maxsize=8)
def learned_forest(name: str) -> Forest:
    """Return the forest of `registry/learned/<name>.json`. Raises RegistryError where it is missing or unsound."""
    path = data_root() / LEARNED / f"{name}.json"
    try:
        return forest_from_dict(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError) as error:
        raise RegistryError(f"{LEARNED}/{path.name}", 1, "", "a forest", str(error)) from None


@cache
def load_confidence() -> ConfidenceModel:
    """Return the curves, weights and bars. Raises RegistryError where the file is wrong."""
    document = read_document(data_root() / "confidence.yaml")
    return read_record(ConfidenceModel, document.value, document, ())

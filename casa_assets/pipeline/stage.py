"""The stages of ingest as a literal list, and the keys that their results are remembered by."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import version

from casa_assets.ingest.assemble import assemble
from casa_assets.ingest.backs import backs
from casa_assets.ingest.clean import clean
from casa_assets.ingest.collide import CollideParams, collide
from casa_assets.ingest.draft import Draft
from casa_assets.ingest.grasp import grasp
from casa_assets.ingest.load import load
from casa_assets.ingest.mass import mass
from casa_assets.ingest.orient import orient
from casa_assets.ingest.scale import scale
from casa_assets.ingest.simplify import simplify
from casa_assets.ingest.texture import texture
from casa_assets.model.asset import Asset
from casa_assets.model.category import Category
from casa_assets.model.issue import Issue
from casa_assets.model.material import Substance
from casa_assets.model.record import Record
from casa_assets.model.ruling import NO_RULING, Ruling
from casa_assets.model.source import Bundle, RawModel, Source, SourceKind


class Brief(Record):
    """All that decides how one bundle becomes an asset, besides its bytes and the stages themselves.

    Attributes:
        asset_id: name of the result. sha256: of the bundle.
        source: the source's own words. category, classes, substance: what the registry says of its kind.
        limits: numbers of registry/limits.yaml that the stages read.
        ruling: what a person decided about this input.
    """

    asset_id: str
    sha256: str
    source: Source
    category: Category
    classes: tuple[str, ...]
    substance: Substance
    limits: dict[str, float]
    ruling: Ruling = NO_RULING

    @property
    def generated(self) -> bool:
        """Whether a text-to-3D generator made it."""
        return self.source.kind is SourceKind.TEXT_TO_3D


@dataclass(frozen=True)
class Stage:
    """One step.

    Attributes:
        name: such as `collide`. version: goes up with every change of what comes out.
        function: pure. tools: packages whose version may change the result.
        keep: the result is put into the store.
    """

    name: str
    version: int
    function: Callable[[Draft, Brief], Draft]
    tools: tuple[str, ...] = ()
    keep: bool = False


def _collide(draft: Draft, brief: Brief) -> Draft:
    params = CollideParams(
        hull_count=int(brief.limits["hull_count"]),
        hull_vertices=int(brief.limits["hull_vertices"]),
        primitive_ratio=brief.limits["primitive_volume_ratio"],
        hull_ratio=brief.limits["hull_volume_ratio"],
        error_m=brief.limits["collider_error_m"],
    )
    return collide(draft, brief.category, params)


def _scale(draft: Draft, brief: Brief) -> Draft:
    texts = [t for t in (brief.source.title, brief.source.prompt) if t]
    slack = brief.limits["size_slack"]
    return scale(draft, brief.category, slack, texts, brief.generated, brief.ruling.size_m)


# Ratio up to which two estimates of a mass say the same.
MASSES_AGREE = 2.0
STAGES: tuple[Stage, ...] = (
    Stage("orient", 4, lambda d, b: orient(d, b.category, b.generated, b.ruling), ("numpy", "scipy")),
    Stage("scale", 2, _scale),
    Stage("simplify", 2, lambda d, b: simplify(d, int(b.limits["visual_faces"])), ("meshoptimizer",)),
    Stage("texture", 2, lambda d, b: texture(d, int(b.limits["texture_px"]), b.substance), ("pillow",)),
    Stage("collide", 10, _collide, ("coacd", "vhacdx", "manifold3d", "scipy"), keep=True),
    Stage("mass", 3, lambda d, b: mass(d, b.category, b.substance, MASSES_AGREE, b.ruling.mass_kg), ("manifold3d",)),
    Stage("grasp", 1, lambda d, b: grasp(d, b.category, b.limits["gripper_m"]), ("scipy",)),
    Stage("backs", 1, lambda d, b: backs(d, b.category, b.limits["missing_side"]), ("scipy",)),
)
# `load` and `clean` come before, `assemble` after: they change the type.
ENDS: Mapping[str, int] = {
    "load": 2,
    "clean": 4,
    "assemble": 4,
    "mjcf": 1,
    "usd": 1,
    "preview": 2,
    "checks": 3,
    "signature": 1,
}
# Limits that turn inputs away and change nothing about those that pass: raising one remakes nothing.
GATES = frozenset({"input_bytes", "input_faces", "input_seconds", "input_memory_bytes"})
END_TOOLS = ("pillow", "lxml", "usd-core", "mujoco", "simready-foundation-tier-core")


def versions() -> dict[str, str]:
    """Every stage and native tool with its version, for the certificate and the keys."""
    stages = {f"stage:{name}": str(number) for name, number in ENDS.items()}
    stages |= {f"stage:{s.name}": str(s.version) for s in STAGES}
    tools = sorted({t for s in STAGES for t in s.tools} | set(END_TOOLS))
    return dict(sorted((stages | {f"tool:{t}": version(t) for t in tools}).items()))


def recipe(limits: Mapping[str, float], registry_digest: str) -> str:
    """sha256 over stage and tool versions, limits and registry: what another recipe made is out of date."""
    text = json.dumps([versions(), _deciding(limits), registry_digest], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def ruled(mark: str, ruling: Ruling) -> str:
    """The recipe of an input about which a person decided something: another decision makes it anew."""
    return mark if ruling.is_empty else hashlib.sha256(f"{mark} {ruling.digest}".encode()).hexdigest()


def build(
    bundle: Bundle, brief: Brief, get: Callable[[str], bytes | None], put: Callable[[str, bytes], None]
) -> tuple[Asset, tuple[Issue, ...]]:
    """An asset from a bundle, and the warnings on the way; kept results are taken from the store.

    Args:
        get, put: the store.
    Raises:
        Rejected: a stage cannot accept its input.
    """
    keys = _keys(brief)
    start, draft = 0, None
    for i in reversed(range(len(STAGES))):
        data = get(keys[i]) if STAGES[i].keep else None
        if data is not None:
            start, draft = i + 1, Draft.from_json(data)
            break
    if draft is None:
        draft = clean(raw(bundle, brief.limits), brief.category)
    for i in range(start, len(STAGES)):
        draft = STAGES[i].function(draft, brief)
        if STAGES[i].keep:
            put(keys[i], draft.to_json().encode())
    asset = assemble(draft, brief.asset_id, brief.category, brief.classes, brief.substance, brief.source, brief.sha256)
    return asset, (*bundle.notes, *draft.notes)


def raw(bundle: Bundle, limits: Mapping[str, float]) -> RawModel:
    """The bundle as read. Raises Rejected."""
    return load(bundle, limits)


def _deciding(limits: Mapping[str, float]) -> dict[str, float]:
    """Limits that change what comes out, sorted."""
    return {name: value for name, value in sorted(limits.items()) if name not in GATES}


def _keys(brief: Brief) -> list[str]:
    """Key of each stage's result: everything that came before is in it."""
    source = Source(kind=brief.source.kind, path="", title=brief.source.title, prompt=brief.source.prompt)
    inputs = brief.replace(asset_id="", source=source, limits=_deciding(brief.limits))
    key = hashlib.sha256(json.dumps([inputs.digest, ENDS["load"], ENDS["clean"]]).encode()).hexdigest()
    keys = []
    for stage in STAGES:
        parts = [key, stage.name, stage.version, *(f"{t}={version(t)}" for t in stage.tools)]
        key = hashlib.sha256(json.dumps(parts).encode()).hexdigest()
        keys.append(key)
    return keys

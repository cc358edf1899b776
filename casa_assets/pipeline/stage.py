"""The stages of ingest as a literal list, and the keys that their results are remembered by."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import version

from casa_assets.ingest.assemble import assemble
from casa_assets.ingest.clean import clean
from casa_assets.ingest.collide import CollideParams, collide
from casa_assets.ingest.draft import Draft
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
from casa_assets.model.source import Bundle, RawModel, Source, SourceKind


class Brief(Record):
    """All that decides how one bundle becomes an asset, besides its bytes and the stages themselves.

    Attributes:
        asset_id: name of the result. sha256: of the bundle.
        source: the source's own words. category, classes, substance: what the registry says of its kind.
        limits: numbers of registry/limits.yaml that the stages read.
    """

    asset_id: str
    sha256: str
    source: Source
    category: Category
    classes: tuple[str, ...]
    substance: Substance
    limits: dict[str, float]


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


STAGES: tuple[Stage, ...] = (
    Stage("orient", 2, lambda d, b: orient(d, b.category, b.source.kind is SourceKind.TEXT_TO_3D), ("numpy", "scipy")),
    Stage("scale", 1, lambda d, b: scale(d, b.category, b.limits["size_slack"])),
    Stage("simplify", 2, lambda d, b: simplify(d, int(b.limits["visual_faces"])), ("meshoptimizer",)),
    Stage("texture", 2, lambda d, b: texture(d, int(b.limits["texture_px"]), b.substance), ("pillow",)),
    Stage("collide", 6, _collide, ("coacd", "vhacdx", "manifold3d", "scipy"), keep=True),
    Stage("mass", 2, lambda d, b: mass(d, b.category, b.substance, b.limits["mass_range_slack"]), ("manifold3d",)),
)
# `load` and `clean` come before, `assemble` after: they change the type.
ENDS: Mapping[str, int] = {"load": 1, "clean": 2, "assemble": 3, "mjcf": 1, "usd": 1, "preview": 2, "checks": 1}
END_TOOLS = ("pillow", "lxml", "usd-core", "mujoco", "simready-foundation-tier-core")


def versions() -> dict[str, str]:
    """Every stage and native tool with its version, for the certificate and the keys."""
    stages = {f"stage:{name}": str(number) for name, number in ENDS.items()}
    stages |= {f"stage:{s.name}": str(s.version) for s in STAGES}
    tools = sorted({t for s in STAGES for t in s.tools} | set(END_TOOLS))
    return dict(sorted((stages | {f"tool:{t}": version(t) for t in tools}).items()))


def recipe(limits: Mapping[str, float], registry_digest: str) -> str:
    """sha256 over stage and tool versions, limits and registry: what another recipe made is out of date."""
    text = json.dumps([versions(), dict(sorted(limits.items())), registry_digest], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


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
        draft = clean(raw(bundle, brief.limits))
    for i in range(start, len(STAGES)):
        draft = STAGES[i].function(draft, brief)
        if STAGES[i].keep:
            put(keys[i], draft.to_json().encode())
    asset = assemble(draft, brief.asset_id, brief.category, brief.classes, brief.substance, brief.source, brief.sha256)
    return asset, (*bundle.notes, *draft.notes)


def raw(bundle: Bundle, limits: Mapping[str, float]) -> RawModel:
    """The bundle as read. Raises Rejected."""
    return load(bundle, limits)


def _keys(brief: Brief) -> list[str]:
    """Key of each stage's result: everything that came before is in it."""
    inputs = brief.replace(asset_id="", source=Source(kind=brief.source.kind, path=""))
    key = hashlib.sha256(json.dumps([inputs.digest, ENDS["load"], ENDS["clean"]]).encode()).hexdigest()
    keys = []
    for stage in STAGES:
        parts = [key, stage.name, stage.version, *(f"{t}={version(t)}" for t in stage.tools)]
        key = hashlib.sha256(json.dumps(parts).encode()).hexdigest()
        keys.append(key)
    return keys

"""List the stages of ingest, and compute the cache keys of their results."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from casa_assets.ingest.add_back_faces import add_back_faces
from casa_assets.ingest.assemble import assemble
from casa_assets.ingest.clean import clean
from casa_assets.ingest.collision.collide import collide
from casa_assets.ingest.collision.strategies import CollideParams
from casa_assets.ingest.draft import Draft
from casa_assets.ingest.grasp import grasp
from casa_assets.ingest.load import load
from casa_assets.ingest.mass.combine import mass
from casa_assets.ingest.orient import orient
from casa_assets.ingest.simplify import simplify
from casa_assets.ingest.size.scale import scale
from casa_assets.ingest.texture import texture
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.material import Substance
from casa_assets.model.ingest.source import Bundle, RawModel, Source, SourceKind
from casa_assets.model.ingest.user_override import NO_OVERRIDE, UserOverride
from casa_assets.model.issue import Issue
from casa_assets.model.record import Record
from casa_assets.model.registry.category import Category
from casa_assets.pipeline.cache.cache_key import CodeRef, digest_of, key_of


class BuildContext(Record):
    """Inputs of the stages besides the bytes of the bundle: ids, category, substance, limits and overrides.

    Attributes:
        asset_id: name of the result. sha256: of the bundle.
        source: the source's own words. category, classes, substance: what the registry says of its kind.
        limits: numbers of registry/limits.yaml that the stages read.
        override: what a person decided about this input.
    """

    asset_id: str
    sha256: str
    source: Source
    category: Category
    classes: tuple[str, ...]
    substance: Substance
    limits: dict[str, float]
    override: UserOverride = NO_OVERRIDE

    @property
    def generated(self) -> bool:
        """True if a text-to-3D generator made it."""
        return self.source.kind is SourceKind.TEXT_TO_3D


@dataclass(frozen=True)
class Stage:
    """One step.

    Attributes:
        name: such as `collide`. function: pure; its result is kept under a key that is derived from its code.
        keep: the result is put into the store.
    """

    name: str
    function: Callable[[Draft, BuildContext], Draft]
    keep: bool = False


def _collide(draft: Draft, brief: BuildContext) -> Draft:
    params = CollideParams(
        hull_count=int(brief.limits["hull_count"]),
        hull_vertices=int(brief.limits["hull_vertices"]),
        primitive_ratio=brief.limits["primitive_volume_ratio"],
        hull_ratio=brief.limits["hull_volume_ratio"],
        error_m=brief.limits["collider_error_m"],
    )
    return collide(draft, brief.category, params)


def _scale(draft: Draft, brief: BuildContext) -> Draft:
    texts = [t for t in (brief.source.title, brief.source.prompt) if t]
    slack = brief.limits["size_slack"]
    return scale(draft, brief.category, slack, texts, brief.generated, brief.override.size_m)


# Ratio up to which two estimates of a mass say the same.
MASS_AGREEMENT_RATIO = 2.0


def _orient(draft: Draft, brief: BuildContext) -> Draft:
    return orient(draft, brief.category, brief.generated, brief.override)


def _simplify(draft: Draft, brief: BuildContext) -> Draft:
    return simplify(draft, int(brief.limits["visual_faces"]))


def _texture(draft: Draft, brief: BuildContext) -> Draft:
    return texture(draft, int(brief.limits["texture_px"]), brief.substance)


def _mass(draft: Draft, brief: BuildContext) -> Draft:
    return mass(draft, brief.category, brief.substance, MASS_AGREEMENT_RATIO, brief.override.mass_kg)


def _grasp(draft: Draft, brief: BuildContext) -> Draft:
    return grasp(draft, brief.category, brief.limits["gripper_m"])


def _backs(draft: Draft, brief: BuildContext) -> Draft:
    return add_back_faces(draft, brief.category, brief.limits["missing_side"])


# `load` and `clean` come before, `assemble` after: they change the type.
STAGES: tuple[Stage, ...] = (
    Stage("orient", _orient),
    Stage("scale", _scale),
    Stage("simplify", _simplify),
    Stage("texture", _texture),
    Stage("collide", _collide, keep=True),
    Stage("mass", _mass),
    Stage("grasp", _grasp),
    Stage("backs", _backs),
)
# Limits that turn inputs away and change nothing about those that pass: raising one remakes nothing.
ADMISSION_LIMITS = frozenset({"input_bytes", "input_faces", "input_seconds", "input_memory_bytes"})


def stage_key(stage: Stage) -> str:
    """Key of the code of a stage: what it, and nothing that only other stages do, can reach."""
    return key_of(stage.function)


def stage_functions() -> dict[str, CodeRef]:
    """Every stage and what does it, in the order in which they run."""
    return {"load": load, "clean": clean, **{s.name: s.function for s in STAGES}, "assemble": assemble}


def with_overrides(key: str, override: UserOverride) -> str:
    """The cache key of an input about which a person decided something: another decision makes it anew."""
    return key if override.is_empty else digest_of(key, override.digest)


def run_stages(
    bundle: Bundle, brief: BuildContext, get: Callable[[str], bytes | None], put: Callable[[str, bytes], None]
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
        draft = clean(read_raw_model(bundle, brief.limits), brief.category)
    for i in range(start, len(STAGES)):
        draft = STAGES[i].function(draft, brief)
        if STAGES[i].keep:
            put(keys[i], draft.to_json().encode())
    asset = assemble(draft, brief.asset_id, brief.category, brief.classes, brief.substance, brief.source, brief.sha256)
    return asset, (*bundle.notes, *draft.notes)


def read_raw_model(bundle: Bundle, limits: Mapping[str, float]) -> RawModel:
    """The bundle as read. Raises Rejected."""
    return load(bundle, limits)


def limits_in_key(limits: Mapping[str, float]) -> dict[str, float]:
    """Limits that change what comes out, sorted."""
    return {name: value for name, value in sorted(limits.items()) if name not in ADMISSION_LIMITS}


def _keys(brief: BuildContext) -> list[str]:
    """Key of each stage's result: everything that came before is in it."""
    source = Source(kind=brief.source.kind, path="", title=brief.source.title, prompt=brief.source.prompt)
    inputs = brief.replace(asset_id="", source=source, limits=limits_in_key(brief.limits))
    key = digest_of(inputs.digest, key_of(load, clean))
    keys = []
    for stage in STAGES:
        key = digest_of(key, stage.name, stage_key(stage))
        keys.append(key)
    return keys

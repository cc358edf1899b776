"""List the stages of ingest, and compute the cache keys of their results."""

from __future__ import annotations

import posixpath
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from casa_assets import registry
from casa_assets.cache.cache_key import CodeRef, digest_of, key_of
from casa_assets.cache.store import Store
from casa_assets.errors import Rejected
from casa_assets.ingest.assemble import assemble, grasp
from casa_assets.ingest.clean import clean
from casa_assets.ingest.collision.collide import collide
from casa_assets.ingest.collision.fit import CollideParams
from casa_assets.ingest.draft import Draft
from casa_assets.ingest.mass import mass
from casa_assets.ingest.orient import orient
from casa_assets.ingest.run.job import limits_in_key
from casa_assets.ingest.run.survey import Survey
from casa_assets.ingest.scale import scale
from casa_assets.ingest.simplify import simplify
from casa_assets.ingest.texture import add_back_faces, texture
from casa_assets.ingest.things import guess_of_things, load
from casa_assets.library.review import NAME, REJECTED_CODE, doubtful_guesses
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.material import Substance
from casa_assets.model.asset.provenance import Guess
from casa_assets.model.issue import ASKED_CODE, REVIEW_CODE, Issue
from casa_assets.model.record import Record
from casa_assets.model.registry.category import Category
from casa_assets.model.source import NO_OVERRIDE, Bundle, RawModel, Source, SourceKind, UserOverride, Word


class BuildContext(Record):
    """Inputs of the stages besides the bytes of the bundle.

    `asset_id`: name of the result. `sha256`: of the bundle. `limits`: numbers of registry/limits.yaml. `override`: a
    person's decisions. `failed_ups`: ways up in which it was built before and failed. `kind`: guess of the category.
    """

    asset_id: str
    sha256: str
    source: Source
    category: Category
    classes: tuple[str, ...]
    substance: Substance
    limits: dict[str, float]
    override: UserOverride = NO_OVERRIDE
    failed_ups: tuple[str, ...] = ()
    kind: Guess | None = None

    @property
    def generated(self) -> bool:
        """True if a text-to-3D generator made it."""
        return self.source.kind is SourceKind.TEXT_TO_3D


@dataclass(frozen=True)
class Stage:
    """One step of ingest: a pure function of the result of the stage before it and the context.

    `keep`: the result, a Draft, is put into the store, under a key that is derived from the code up to here.
    """

    name: str
    function: Callable[[Any, BuildContext], Any]
    keep: bool = False


# Ratio up to which two estimates of a mass say the same; a choice.
MASS_AGREEMENT_RATIO = 2.0


def _load(bundle: Bundle, context: BuildContext) -> RawModel:
    return load(bundle, context.limits)


def _clean(model: RawModel, context: BuildContext) -> Draft:
    known = registry.load()
    # What is cleaned away, such as a ground under several things, says whether it is one thing: that is asked first.
    guess = guess_of_things(model, context.source, context.category, known.vocabulary, known.other_things)
    draft = clean(model, context.category)
    told = tuple(one for one in (context.kind, guess) if one is not None)
    return draft.replace(guesses=(*told, *draft.guesses))


def _orient(draft: Draft, context: BuildContext) -> Draft:
    return orient(draft, context.category, context.generated, context.override, context.failed_ups)


def _scale(draft: Draft, context: BuildContext) -> Draft:
    said = context.source
    # The title and prompt of a file that was taken apart tell no size of one thing in it.
    texts = [t for t in (said.title, said.prompt) if t and not said.node]
    slack = context.limits["size_slack"]
    return scale(draft, context.category, slack, texts, context.generated, context.override.size_m)


def _simplify(draft: Draft, context: BuildContext) -> Draft:
    return simplify(draft, int(context.limits["visual_faces"]))


def _texture(draft: Draft, context: BuildContext) -> Draft:
    return texture(draft, int(context.limits["texture_px"]), context.substance)


def _collide(draft: Draft, context: BuildContext) -> Draft:
    params = CollideParams(
        hull_count=int(context.limits["hull_count"]),
        hull_vertices=int(context.limits["hull_vertices"]),
        primitive_ratio=context.limits["primitive_volume_ratio"],
        hull_ratio=context.limits["hull_volume_ratio"],
        error_m=context.limits["collider_error_m"],
        box_m=context.limits["collider_bounds_m"],
        box_ratio=context.limits["collider_bounds_ratio"],
        closed_share=context.limits["room_closed"],
    )
    return collide(draft, context.category, params)


def _mass(draft: Draft, context: BuildContext) -> Draft:
    return mass(draft, context.category, context.substance, MASS_AGREEMENT_RATIO, context.override.mass_kg)


def _grasp(draft: Draft, context: BuildContext) -> Draft:
    return grasp(draft, context.category, context.limits["gripper_m"])


def _backs(draft: Draft, context: BuildContext) -> Draft:
    return add_back_faces(draft, context.category, context.limits["missing_side"])


def _assemble(draft: Draft, context: BuildContext) -> tuple[Asset, tuple[Issue, ...]]:
    category, substance, sha256 = context.category, context.substance, context.sha256
    asset = assemble(draft, context.asset_id, category, context.classes, substance, context.source, sha256)
    return asset, draft.notes


# In the order in which they run: from a Bundle to an Asset and the notes on the way.
STAGES: tuple[Stage, ...] = (
    Stage("load", _load),
    Stage("clean", _clean),
    Stage("orient", _orient),
    Stage("scale", _scale),
    Stage("simplify", _simplify),
    Stage("texture", _texture),
    Stage("collide", _collide, keep=True),
    Stage("mass", _mass),
    Stage("grasp", _grasp),
    Stage("backs", _backs),
    Stage("assemble", _assemble),
)


def stage_key(stage: Stage) -> str:
    """Key of the code of a stage: what it, and nothing that only other stages do, can reach."""
    return key_of(stage.function)


def stage_functions() -> dict[str, CodeRef]:
    """Every stage and what does it, in the order in which they run."""
    return {stage.name: stage.function for stage in STAGES}


def run_stages(
    bundle: Bundle,
    context: BuildContext,
    get: Callable[[str], bytes | None],
    put: Callable[[str, bytes], None],
) -> tuple[Asset, tuple[Issue, ...]]:
    """An asset from a bundle, and the warnings on the way; `get` and `put` are of the store of results.

    Raises Rejected: a stage cannot accept its input.
    """
    keys = _keys(context)
    start = 0
    result: Any = bundle
    for i in reversed(range(len(STAGES))):
        data = get(keys[i]) if STAGES[i].keep else None
        if data is not None:
            start, result = i + 1, Draft.from_json(data)
            break
    for stage, key in zip(STAGES[start:], keys[start:], strict=True):
        result = stage.function(result, context)
        if stage.keep:
            put(key, result.to_json().encode())
    asset, notes = result
    return asset, (*bundle.notes, *notes)


def build_asset(
    bundle: Bundle,
    survey: Survey,
    source: Source,
    asset_id: str,
    limits: Mapping[str, float],
    override: UserOverride = NO_OVERRIDE,
    store: Store | None = None,
    failed_ups: tuple[str, ...] = (),
) -> tuple[Asset, tuple[Issue, ...]]:
    """Build an asset from a surveyed bundle; return it with warnings, including doubtful guesses.

    `store`: keeps results of stages. `failed_ups`: ways up, as in the asset's guesses of `up_axis`, that failed before.
    Raises Rejected: a stage cannot accept its input.
    """
    if override.decision is Word.REJECT:
        raise Rejected(REJECTED_CODE, f"a person rejected it, in {NAME} of the library")
    known = registry.load()
    category = known.category(survey.category)
    context = BuildContext(
        asset_id=asset_id,
        sha256=bundle.sha256,
        source=source,
        kind=Guess(subject="category", value=category.id, confidence=round(survey.confidence, 2), reason=survey.reason),
        category=category,
        classes=known.classes_of(category),
        substance=known.substances[category.substance],
        limits=dict(limits),
        override=override,
        failed_ups=failed_ups,
    )
    get, put = (store.get, store.put) if store is not None else (lambda key: None, lambda key, data: None)
    asset, notes = run_stages(bundle, context, get, put)
    if override.decision is Word.ACCEPT:
        return asset, tuple(note for note in notes if note.code not in (ASKED_CODE, REVIEW_CODE))
    return asset, (*notes, *doubtful_guesses(asset.provenance.guesses))


def _keys(context: BuildContext) -> list[str]:
    """Key of each stage's result: everything that came before is in it."""
    said = context.source
    # Of the path only the name says something of the thing: an input that was moved is not made anew.
    name = posixpath.basename(said.path)
    source = Source(kind=said.kind, path=name, title=said.title, prompt=said.prompt, node=said.node)
    key = context.replace(asset_id="", source=source, limits=limits_in_key(context.limits)).digest
    keys = []
    for stage in STAGES:
        key = digest_of(key, stage.name, stage_key(stage))
        keys.append(key)
    return keys

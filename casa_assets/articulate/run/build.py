"""Build the articulated asset of one static mesh, with every decision on the way."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

import numpy as np

from casa_assets import registry
from casa_assets.articulate.assemble import AssetSpec, assemble, drop_empty_links
from casa_assets.articulate.controls.classify import CONTROL_CLASSES, CONTROL_FEATURES
from casa_assets.articulate.decisions import (
    GIVEN_REASON,
    Decisions,
    apply_decisions,
    axis_word,
    decisions_text,
    parse_direction,
)
from casa_assets.articulate.frame import likely_frames, metres_per_unit
from casa_assets.articulate.fronts.front_hypotheses import CONTEXT, FEATURES
from casa_assets.articulate.interior.inner_parts import with_pieces_in_the_way
from casa_assets.articulate.kinds import kind_by_parts, kind_named
from casa_assets.articulate.plan import Articulation, Frame, JointPlan, Models, PlanModels, calibrate_parts
from casa_assets.articulate.run.interiors import add_interiors
from casa_assets.articulate.runtime.names import rename_for_runtime
from casa_assets.articulate.search.choose import choose_plan
from casa_assets.articulate.search.plan_features import PART_FEATURES, PLAN_FEATURES
from casa_assets.articulate.search.plans import Plan
from casa_assets.articulate.segment.fragments import WeldedMesh, weld_model
from casa_assets.articulate.segment.orthographic import TOP
from casa_assets.articulate.segment.segmentations import cut_shell_parts
from casa_assets.articulate.segment.shell_segments import Fragmentation
from casa_assets.articulate.unfound_parts import signs_of_parts
from casa_assets.core.numeric import Forest
from casa_assets.errors import CasaError, Rejected, UnknownId
from casa_assets.ingest.sources.discover import collect, discover
from casa_assets.ingest.sources.places import Found, Refused
from casa_assets.ingest.things import load
from casa_assets.library.clip import NO_WEIGHTS, classify_by_look, load_scorer
from casa_assets.library.entry_files import Identity, Producer
from casa_assets.library.review import REJECTED_CODE
from casa_assets.model.asset.asset import Asset, Guess
from casa_assets.model.record import Vec3
from casa_assets.model.registry.category import Category
from casa_assets.model.source import RawModel, Source, Up, UpAxis, UserOverride, Word

# A guess that is no surer than this names nothing: sizes and names stay those of any thing.
MIN_CONFIDENCE = 0.2
# Parts of a thing whose kind is no surer than this keep their own names.
NAMING_CONFIDENCE = 0.5
# Id of a kind or nothing, how sure, and why.
ImageClassifier = Callable[[], tuple[str, float, str]]
NOTHING_MOVES, MISFIT = "ART001", "ART002"
# Side of the frame guess that a stated up axis makes the top.
_TOPS = {Up.Z: TOP, Up.Y: 1, Up.X: 3}
# Sizes that differ by less are one size, rounded for reading.
SIZE_TOLERANCE = 5e-4
_UP_WORDS = {axis: ("-" if axis.startswith("minus_") else "+") + axis[-1] for axis in UpAxis}


@cache
def load_models() -> Models:
    """Return the forests of registry/learned/. Raises RegistryError, or ValueError where one fits other features."""
    needed = {"controls": CONTROL_FEATURES, "fronts_alone": FEATURES, "fronts": (*FEATURES, *CONTEXT)}
    forests = _forests(needed)
    if forests["controls"].classes != CONTROL_CLASSES:
        raise ValueError("a forest of other types: controls; run benchmarks/train")
    return Models(**forests)


@cache
def load_plan_models() -> PlanModels:
    """Return the forests that choose plans; raises as `load_models`."""
    forests = _forests({"plan_parts": PART_FEATURES, "plans": PLAN_FEATURES})
    return PlanModels(forests["plan_parts"], forests["plans"])


def _forests(needed: Mapping[str, Sequence[str]]) -> dict[str, Forest]:
    forests = {name: registry.learned_forest(name) for name in needed}
    other = [name for name, features in needed.items() if forests[name].features != features]
    if other:
        raise ValueError(f"forests of other features: {', '.join(other)}; run benchmarks/train")
    return forests


@dataclass(frozen=True)
class CategoryGuess:
    """A category with confidence and reason."""

    category: Category
    confidence: float
    reason: str

    @property
    def id(self) -> str:
        """Return the id of the category; empty where the guess is too uncertain."""
        return self.category.id if self.confidence > MIN_CONFIDENCE else ""


def guess_category(
    one: Found,
    extent: Vec3,
    articulation: Articulation,
    stated: str = "",
    classify_by_image: ImageClassifier | None = None,
) -> CategoryGuess:
    """Return the category of an input.

    A category given by the user that repeats a confident guess leaves it a guess: the same decisions make the same
    asset.

    Args:
        extent: width, depth, height, any unit. articulation: its moving parts.
        stated: category given by the user, or empty. classify_by_image: classifier by appearance, where there is one.
    """
    guessed = _guess_without_user(one, extent, articulation, classify_by_image)
    if not stated or (stated == guessed.category.id and guessed.confidence >= NAMING_CONFIDENCE):
        return guessed
    known = registry.load()
    return CategoryGuess(known.fixtures.get(stated) or known.category(stated), 1.0, GIVEN_REASON)


def stated_category(one: Found, stated: str = "") -> str:
    """Return the category that the user or the file name states; empty where neither does."""
    if stated:
        return stated
    named = kind_named([h for h in (one.source.category, *one.source.hints) if h])
    return named.id if named is not None and named.confidence >= NAMING_CONFIDENCE else ""


def _guess_without_user(
    one: Found, extent: Vec3, articulation: Articulation, classify_by_image: ImageClassifier | None
) -> CategoryGuess:
    known = registry.load()
    look = NO_WEIGHTS
    if classify_by_image is not None:
        kind, confidence, look = classify_by_image()
        if kind:
            return CategoryGuess(known.fixtures[kind], confidence, look)
    named = kind_named([h for h in (one.source.category, *one.source.hints) if h])
    if named is not None:
        return CategoryGuess(known.fixtures[named.id], named.confidence, f"by its name: {named.evidence}")
    kind, confidence = kind_by_parts(extent, articulation)
    if confidence > MIN_CONFIDENCE:
        return CategoryGuess(known.fixtures[kind], confidence, f"by its shape and parts; nothing names it, and {look}")
    message = f"nothing names it, {look}, and its shape and parts are like no one kind's"
    return CategoryGuess(known.category(registry.FALLBACK), 0.1, message)


@dataclass(frozen=True)
class ArticulateRequest:
    """A user's request to articulate one mesh.

    Attributes:
        mesh: file. out: folder, created if it is missing. category: id, or empty to guess from names.
        up, front: directions in axes of the file, None to guess. size_m: longest side, 0 to guess.
        decisions: content of a sidecar file; it overrides all guesses, and the options above override it.
        preview: write a strip of pictures. clip: weights of CLIP, which then names what the user does not.
        complete: build interiors if doors and drawers open onto nothing.
        force: work even if an earlier run made the same result, or has a better asset of the mesh.
        source_file: the input, if it was discovered before; None: it is looked up at `mesh`.
    """

    mesh: Path
    out: Path
    category: str = ""
    up: Vec3 | None = None
    front: Vec3 | None = None
    size_m: float = 0.0
    decisions: Decisions = field(default_factory=Decisions)
    preview: bool = False
    clip: Path | None = None
    complete: bool = True
    force: bool = False
    source_file: Found | None = None


@dataclass(frozen=True)
class ArticulateResult:
    """The articulated asset of a mesh, before anything is written, and how it was made.

    Attributes:
        articulation: the parts and joints as decided. placed: the mesh in the frame, a diagonal of 1. model: as read.
        planned: the parts over the faces of `read`, the model before shells are cut and interiors built.
        spec: what the asset needs besides its geometry. confidence: of the category, and why; `size`, of the scale.
        joints: part name -> joint name, once renamed. unmet_checks: what keeps it from meeting its category's contract.
        contacts: parts that run into each other on their way, in words.
    """

    asset: Asset
    articulation: Articulation
    planned: Articulation
    read: RawModel
    placed: WeldedMesh
    model: RawModel
    spec: AssetSpec
    category: Category
    confidence: tuple[float, str]
    size: tuple[float, str]
    longest_m: float
    source: Source
    joints: Mapping[str, str] = field(default_factory=dict)
    unmet_checks: tuple[str, ...] = ()
    contacts: tuple[str, ...] = ()

    def with_joints(self, joints: Mapping[str, JointPlan]) -> ArticulateResult:
        """Return the result with other joints for some parts."""
        if not joints:
            return self
        parts = tuple(p.replace(joint=joints[p.name]) if p.name in joints else p for p in self.articulation.parts)
        found = self.articulation.replace(parts=parts)
        return replace(self, articulation=found, asset=assemble(self.model, self.placed, found, self.spec))

    def with_refit_shapes(self, links: Set[str]) -> ArticulateResult:
        """Return the result with the collision shapes of some links fitted to each as a whole, and never cut."""
        spec = replace(self.spec, refit=self.spec.refit | links)
        return replace(self, spec=spec, asset=assemble(self.model, self.placed, self.articulation, spec))

    def with_runtime_names(self) -> ArticulateResult:
        """Return the result under the names that runtimes look for, where the category has any."""
        known = self.category.id if self.confidence[0] >= NAMING_CONFIDENCE else ""
        asset, joints = rename_for_runtime(self.asset, self.articulation, known)
        return replace(self, asset=asset, joints=joints)

    def decisions_text(self, given: Decisions) -> str:
        """Return the decisions.yaml of the mesh, which was built with some decisions."""
        return decisions_text(
            self.source.path or "the mesh",
            self.articulation,
            self.placed,
            (self.category.id, *self.confidence),
            (self.longest_m, *self.size),
            given,
            (NAMING_CONFIDENCE, registry.load_confidence().bars.frame),
        )


def build(request: ArticulateRequest) -> ArticulateResult:
    """Build the asset of a mesh, and record the decisions.

    Raises:
        Rejected: the file cannot be read, nothing of it moves (ART001), the decisions on it do not fit it (ART002), or
            a person rejects it (REV002).
        CasaError: what the user asks for does not exist, or does not go together.
    """
    if request.decisions.decision is Word.REJECT:
        raise Rejected(REJECTED_CODE, "a person rejected it")
    known = registry.load()
    source_file = find_input(request)
    bundle = collect(source_file, known.limits)
    model = load(bundle, known.limits)
    mesh = weld_model(model)
    if not mesh.areas.any():
        raise Rejected(NOTHING_MOVES, "none of its faces has an area")
    stated = stated_category(source_file, request.category or request.decisions.category or "")
    plan, found = _choose_plan(mesh, model, request, stated)
    placed, frame = mesh.in_frame(found.frame), found.frame
    kind = _choose_category(source_file, request, model, placed, found)
    longest = float(np.ptp(placed.points, axis=0).max()) / frame.scale
    scale = _scale(longest, model, request, kind.category if kind.id else None)
    metres_per_file_unit = scale[0]
    found = found.replace(frame=frame.replace(metres=metres_per_file_unit / frame.scale), category=kind.id)
    found = calibrate_parts(found, registry.load_confidence())
    try:
        found = apply_decisions(found, placed, request.decisions)
    except CasaError as error:
        raise Rejected(MISFIT, f"{error}; change the decisions on it") from error
    found = with_pieces_in_the_way(drop_empty_links(found, placed), placed)
    planned, read = found, model
    model, placed, found = _opened(model, plan.fragmentation, found, request, stated)
    planned = planned if found.parts else found
    spec = _spec(source_file, bundle.sha256, kind, scale, frame.scale)
    asset = assemble(model, placed, found, spec)
    return ArticulateResult(
        asset=asset,
        articulation=found,
        planned=planned,
        read=read,
        placed=placed,
        model=model,
        spec=spec,
        category=kind.category,
        confidence=(kind.confidence, kind.reason),
        size=scale[1:],
        longest_m=longest * metres_per_file_unit,
        source=source_file.source,
    )


def _opened(
    model: RawModel, fragmentation: Fragmentation, found: Articulation, request: ArticulateRequest, stated: str
) -> tuple[RawModel, WeldedMesh, Articulation]:
    """Cut the parts of a shell out of a model and build the interiors that it lacks; return it with its parts.

    Where no part is left, it is returned with the signs that there are some all the same.

    Args:
        stated: id of the kind that the user or a name states, or empty.
    Raises:
        Rejected: no part is left and there is no sign of any (ART001), or the decisions on it do not fit it (ART002).
    """
    model, placed, found = cut_shell_parts(model, fragmentation, found)
    # Cuts leave pieces of a shell by themselves that were no pieces before.
    found = with_pieces_in_the_way(drop_empty_links(found, placed), placed)
    if not found.parts:
        names = [name for part in model.parts for name in (*part.nodes, part.name)]
        signs = signs_of_parts(placed, stated, names, load_models())
        if not signs:
            raise Rejected(NOTHING_MOVES, "no moving part found")
        return model, placed, found.replace(signs=signs)
    try:
        return add_interiors(model, placed, found, found.category, request.decisions, request.complete)
    except UnknownId as error:
        raise Rejected(MISFIT, f"{error}; change the decisions on it") from error


def _spec(
    source_file: Found, sha256: str, kind: CategoryGuess, scale: tuple[float, float, str], per_unit: float
) -> AssetSpec:
    """Return what the asset needs besides its geometry.

    Args:
        scale: metres in a unit of the file, the confidence, and the reason. per_unit: diagonals in a unit of the file.
    """
    known = registry.load()
    metres, confidence, reason = scale
    category = kind.category
    guesses = (
        Guess(subject="category", value=category.id, confidence=round(kind.confidence, 2), reason=kind.reason),
        Guess(subject="scale", value=f"{metres:.6g} m per unit", confidence=confidence, reason=reason),
    )
    return AssetSpec(
        asset_id=Identity(Producer.ARTICULATE, sha256).asset_id(category.id),
        metres=metres / per_unit,
        category=category,
        classes=known.classes_of(category),
        substance=known.substances[category.substance],
        provenance=source_file.source.provenance(sha256, guesses),
    )


def _choose_category(
    source_file: Found, request: ArticulateRequest, model: RawModel, placed: WeldedMesh, articulation: Articulation
) -> CategoryGuess:
    """Return the category; where CLIP is used, it sees the closed object."""

    def seen() -> tuple[str, float, str]:
        assert request.clip is not None
        known = registry.load()
        any_thing = known.category(registry.FALLBACK)
        spec = AssetSpec(
            asset_id=f"{any_thing.id}_{'0' * 10}",
            metres=1.0,
            category=any_thing,
            classes=known.classes_of(any_thing),
            substance=known.substances[any_thing.substance],
            provenance=source_file.source.provenance("0" * 64, ()),
        )
        closed = Articulation(frame=articulation.frame.replace(metres=1.0))
        return classify_by_look(assemble(model, placed, closed, spec), load_scorer(request.clip))

    x, y, z = (float(v) for v in np.ptp(placed.points, axis=0))
    ordered = request.category or request.decisions.category or ""
    return guess_category(source_file, (x, y, z), articulation, ordered, None if request.clip is None else seen)


def _scale(
    longest: float, model: RawModel, request: ArticulateRequest, category: Category | None
) -> tuple[float, float, str]:
    """Return the metres in a unit for a longest side in units, the confidence, and the reason."""
    unit, confidence, reason = metres_per_unit(longest, model.metres_per_unit, category.longest_m if category else None)
    stated_size = request.size_m or request.decisions.size_m
    if stated_size and abs(stated_size / (longest * unit) - 1) > SIZE_TOLERANCE:
        return stated_size / longest, 1.0, GIVEN_REASON
    return unit, confidence, reason


def _choose_plan(mesh: WeldedMesh, model: RawModel, request: ArticulateRequest, kind: str) -> tuple[Plan, Articulation]:
    """Return the likeliest plan and its parts, in the frame that is given, if one is.

    Decisions that repeat a guess that is sure leave it a guess.
    """
    own = request.decisions
    up = request.up or (parse_direction(own.up) if own.up is not None else None)
    front = request.front or (parse_direction(own.front) if own.front is not None else None)
    stated = None if model.up is None else _TOPS[model.up]
    if up is None or front is None:
        return _guessed_plan(mesh, likely_frames(mesh, up, front, stated), kind)
    if abs(float(np.dot(up, front))) > 1e-3:
        message = f"the front {axis_word(front)} is not at a right angle to up {axis_word(up)}"
        if request.up is None or request.front is None:  # one of the two comes from the decisions on this mesh
            raise Rejected(MISFIT, f"{message}; change the decisions on it")
        raise CasaError(f"{request.mesh.name}: {message}; give another --front or --up")
    given = likely_frames(mesh, up, front, stated)[0].replace(confidence=1.0)
    guesses = likely_frames(mesh, stated=stated)
    if any(np.allclose(guess.rotation, given.rotation, atol=1e-4) for guess in guesses):
        plan, found = _guessed_plan(mesh, guesses, kind)
        is_same = np.allclose(found.frame.rotation, given.rotation, atol=1e-4)
        if is_same and found.frame.confidence >= registry.load_confidence().bars.frame:
            return plan, found
    plan, found = _guessed_plan(mesh, [given], kind)
    return plan, found.replace(frame=given)


def _guessed_plan(mesh: WeldedMesh, frames: Sequence[Frame], kind: str) -> tuple[Plan, Articulation]:
    """Return the likeliest plan over some frames, and its parts with how sure they are, uncalibrated."""
    choice = choose_plan(mesh, frames, kind, load_models(), load_plan_models())
    found = choice.plan.articulation
    parts = []
    for part, chance in zip(found.parts, choice.parts.tolist(), strict=True):
        sure = round(chance, 3)
        parts.append(part.replace(confidence=sure, joint=part.joint.replace(confidence=sure)))
    confidence = registry.load_confidence().frame.at(choice.frame_confidence)
    frame = choice.plan.frame.replace(confidence=confidence)
    return choice.plan, found.replace(frame=frame, parts=tuple(parts), value=round(choice.value, 3))


def find_input(request: ArticulateRequest) -> Found:
    """Return the input of a request. Raises Rejected where the file holds none, or cannot be read."""
    if request.source_file is not None:
        return request.source_file
    for source_file in discover([request.mesh]):
        if isinstance(source_file, Refused):
            raise Rejected(source_file.code, source_file.message)
        return source_file
    raise Rejected("SRC001", "no mesh")


def with_override(request: ArticulateRequest, override: UserOverride) -> ArticulateRequest:
    """Return the request with what review.csv says; what the request or its decisions say themselves goes before it."""
    own = request.decisions
    decisions = own.replace(
        category=own.category or override.category or None,
        up=own.up if own.up is not None else _UP_WORDS.get(override.up) if override.up is not None else None,
        size_m=own.size_m or override.size_m or None,
        decision=own.decision or override.decision,
    )
    return request if decisions == own else replace(request, decisions=decisions)

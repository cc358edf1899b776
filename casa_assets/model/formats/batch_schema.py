"""batch.json beside the batch form of a kitchen: what it holds and leaves out, and what an engine has to allocate."""

from __future__ import annotations

from casa_assets.model.issue import Report
from casa_assets.model.kitchen.batch_scene import EngineSizes
from casa_assets.model.record import Record, Sha256


class BatchFile(Record):
    """batch.json: of scene_batch.xml. Names of joints and placements are those of scene.xml.

    Attributes:
        id: of the scene.
        key: of the file; it changes where the scene, the options or the code that makes it change.
        joints: that move in it.
        locked: joints of the scene that are not in it; what they move stands as the scene begins.
        filled: placements that are solid in it: a thing that nothing can be put into, a door without open bins.
        colliders: primitives that can collide.
        pairs: pairs of colliders that an engine has to look at in every step.
        freedoms: degrees of freedom of all joints.
        engine: what an engine has to allocate for one world, and what it was found from.
        report: of the checks BAT001 to BAT010.
    """

    id: str
    key: Sha256
    joints: tuple[str, ...]
    locked: tuple[str, ...]
    filled: tuple[str, ...]
    colliders: int
    pairs: int
    freedoms: int
    engine: EngineSizes
    report: Report

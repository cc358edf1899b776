"""batch.json of the batch form of a kitchen: its joints and shapes, and the sizes that an engine has to allocate."""

from __future__ import annotations

from casa_assets.model.issue import Report
from casa_assets.model.kitchen.batch_scene import EngineSizes
from casa_assets.model.record import Record, Sha256


class BatchFile(Record):
    """batch.json, about scene_batch.xml. Names of joints and placements are those of scene.xml.

    Attributes:
        id: of the scene.
        key: of the file; it changes if the scene, the options or the code that makes it change.
        joints: joints that move in it.
        locked: joints of the scene that are not in it; the parts that they move stay as the scene begins.
        filled: placements that are solid in it: objects that nothing can be put into, and doors without open bins.
        colliders: primitives that can collide.
        pairs: pairs of colliders that an engine has to check in every step.
        freedoms: degrees of freedom of all joints.
        engine: sizes that an engine has to allocate for one world, and the measurements that they are based on.
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

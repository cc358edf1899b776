"""Joint of an asset -> the word by which one chooses it: a door, a drawer, a knob."""

from __future__ import annotations

from casa_assets.model.asset.asset import Asset, Joint, JointKind
from casa_assets.model.kitchen.joint_word import JointWord

# Label of the collider that a hand takes -> word.
WORD_OF_GRIP = {
    "knob": JointWord.KNOBS,
    "button": JointWord.BUTTONS,
    "key": JointWord.BUTTONS,
    "lever": JointWord.LEVERS,
    "spout": JointWord.LEVERS,
    "rack": JointWord.RACKS,
    "tray": JointWord.RACKS,
    "lid": JointWord.LIDS,
}
# Links of a tap that a hand takes by their own handle, which is no door.
TAP_LINKS = ("handle", "handle_temp")
# Links that are racks also where a hand takes them by a handle.
SLIDING_SHELVES = ("rack", "tray")


def joint_word(asset: Asset, joint: Joint) -> JointWord:
    """The word of a joint."""
    labels = {collider.name: collider.label for link in asset.links for collider in link.colliders}
    label = labels.get(joint.grip or "")
    if label in WORD_OF_GRIP:
        return WORD_OF_GRIP[label]
    if joint.child.rstrip("0123456789") in SLIDING_SHELVES:
        return JointWord.RACKS
    if joint.child in TAP_LINKS:
        return JointWord.LEVERS
    return JointWord.DOORS if joint.kind is JointKind.HINGE else JointWord.DRAWERS

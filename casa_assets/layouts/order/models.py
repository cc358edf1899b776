"""Look up the family member that a style uses for a role, with its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from casa_assets.errors import UnknownId
from casa_assets.model.kitchen.style import PresetChoice, Style

# family -> preset -> its numbers and choices, as JSON has them.
FamilyOffers = Mapping[str, Mapping[str, Mapping[str, Any]]]


@dataclass(frozen=True)
class StyleModel:
    """A chosen member.

    Attributes:
        choice: as the style has it.
        numbers: all numbers and choices of it, those that the style changes included.
    """

    choice: PresetChoice
    params: Mapping[str, Any]

    def length(self, name: str) -> float:
        """One of its lengths, metres."""
        return float(self.params[name])


@dataclass(frozen=True)
class StyleModels:
    """All roles of a style.

    Attributes:
        style: which. offers: what families there are.
    """

    style: Style
    presets: FamilyOffers

    def for_role(self, role: str) -> StyleModel:
        """The member for a role. Raises UnknownId where the style has none, or no family offers it."""
        if role not in self.style.models:
            raise UnknownId(f"model of style {self.style.id}", role, self.style.models)
        return self.resolve(self.style.models[role])

    def has(self, role: str) -> bool:
        """True if the style has a member for the role."""
        return role in self.style.models

    def resolve(self, choice: PresetChoice) -> StyleModel:
        """A member with its numbers. Raises UnknownId."""
        if choice.family not in self.presets:
            raise UnknownId("family", choice.family, self.presets)
        presets = self.presets[choice.family]
        if choice.name not in presets:
            raise UnknownId(f"preset of {choice.family}", choice.name, presets)
        return StyleModel(choice, {**presets[choice.name], **choice.params})

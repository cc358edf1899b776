"""Look up the family member that a style uses for a role, with its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from casa_assets.errors import UnknownId
from casa_assets.model.kitchen.style import PresetChoice, Style

# family -> preset -> its parameters, as JSON has them.
FamilyPresets = Mapping[str, Mapping[str, Mapping[str, Any]]]


@dataclass(frozen=True)
class StyleModel:
    """A chosen member.

    Attributes:
        choice: as the style has it.
        params: all parameters, with the changes of the style.
    """

    choice: PresetChoice
    params: Mapping[str, Any]

    def length(self, name: str) -> float:
        """A parameter that is a length, metres."""
        return float(self.params[name])


@dataclass(frozen=True)
class StyleModels:
    """All roles of a style.

    Attributes:
        style: the style. presets: parameters of all presets of all families.
    """

    style: Style
    presets: FamilyPresets

    def for_role(self, role: str) -> StyleModel:
        """The preset for a role. Raises UnknownId where the style has none, or there is no such preset."""
        if role not in self.style.models:
            raise UnknownId(f"model of style {self.style.id}", role, self.style.models)
        return self.resolve(self.style.models[role])

    def has(self, role: str) -> bool:
        """True if the style has a preset for the role."""
        return role in self.style.models

    def resolve(self, choice: PresetChoice) -> StyleModel:
        """A choice with all parameters of its preset. Raises UnknownId."""
        if choice.family not in self.presets:
            raise UnknownId("family", choice.family, self.presets)
        presets = self.presets[choice.family]
        if choice.name not in presets:
            raise UnknownId(f"preset of {choice.family}", choice.name, presets)
        return StyleModel(choice, {**presets[choice.name], **choice.params})

"""Look up the family member that a style uses for a role, with its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from casa_assets.errors import CasaError, UnknownId
from casa_assets.model.kitchen.style import PresetChoice, Style

# family -> preset -> its parameters, as JSON has them.
FamilyPresets = Mapping[str, Mapping[str, Mapping[str, Any]]]


# Roles whose members are built to the numbers of a worktop, a wall or a row; an asset of a library cannot be.
MADE_TO_MEASURE = frozenset({"sink", "hob", "window", "door", "curtain", "boards", "blender"})


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

    def with_params(self, **params: Any) -> PresetChoice:
        """The choice with some numbers of the family changed; an asset of a library stays as it is."""
        if self.choice.is_library:
            return self.choice
        return PresetChoice(preset=self.choice.preset, params={**self.choice.params, **params})


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
        choice = self.style.models[role]
        if choice.is_library and role in MADE_TO_MEASURE:
            expected = f"expected a preset of a family, since a {role} is made to the measure of what it is in"
            raise CasaError(f"style {self.style.id}: models.{role}: {expected}; got {choice.preset}")
        return self.resolve(choice)

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

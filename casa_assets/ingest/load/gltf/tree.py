"""Typed access to the JSON of a glTF: every wrong type or index is a Rejected that names its place."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.notes import printable

Json = Mapping[str, object]


def parse(text: bytes, name: str) -> Json:
    """The JSON object of a glTF.

    Raises:
        Rejected: BAD_JSON where it is cut, garbled, too deep, or not an object.
    """
    try:
        value = json.loads(text.removeprefix(b"\xef\xbb\xbf").rstrip(b"\0 \t\r\n"))
    except (ValueError, RecursionError) as error:
        message = f"{name}: the JSON cannot be read ({printable(str(error), 80)}); fetch or export the file again"
        raise Rejected(codes.BAD_JSON, message) from error
    if not isinstance(value, dict):
        raise Rejected(codes.BAD_JSON, f"{name}: the JSON is not an object; this is no glTF")
    return value


@dataclass(frozen=True)
class JsonObject:
    """A JSON object with its place, such as `meshes/0/primitives/2`.

    Attributes:
        value: the object.
        place: where it stands, for messages.
    """

    value: Json
    place: str

    def fail(self, key: str, wanted: str) -> Rejected:
        """The error to raise for a wrong value at `key`."""
        got = printable(repr(self.value.get(key)), 40)
        return Rejected(codes.BAD_SCHEMA, f"glTF {self.place}/{key}: expected {wanted}, got {got}; export it again")

    def has(self, key: str) -> bool:
        """True where the key is there and not null."""
        return self.value.get(key) is not None

    def child(self, key: str) -> JsonObject:
        """Object at `key`; an empty one where there is none."""
        value = self.value.get(key)
        if value is None:
            return JsonObject({}, f"{self.place}/{key}")
        if not isinstance(value, dict):
            raise self.fail(key, "an object")
        return JsonObject(value, f"{self.place}/{key}")

    def items(self, key: str) -> list[JsonObject]:
        """Objects of the array at `key`; none where it is missing."""
        out = []
        for i, value in enumerate(self.array(key)):
            if not isinstance(value, dict):
                raise self.fail(key, "an array of objects")
            out.append(JsonObject(value, f"{self.place}/{key}/{i}"))
        return out

    def array(self, key: str) -> list[object]:
        """The array at `key`; empty where it is missing."""
        value = self.value.get(key)
        if value is None:
            return []
        if not isinstance(value, list):
            raise self.fail(key, "an array")
        return value

    def text(self, key: str) -> str:
        """String at `key`; empty where it is missing."""
        value = self.value.get(key)
        if value is None:
            return ""
        if not isinstance(value, str):
            raise self.fail(key, "a string")
        return value.encode("utf-8", "replace").decode("utf-8")

    def flag(self, key: str) -> bool:
        """True where the value at `key` is true."""
        return self.value.get(key) is True

    def count(self, key: str, default: int | None = None) -> int:
        """Whole number >= 0 at `key`. Raises where it is missing and there is no default."""
        value = self.value.get(key)
        if value is None and default is not None:
            return default
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if not isinstance(value, int) or isinstance(value, bool) or value < 0:
            raise self.fail(key, "a whole number >= 0")
        return value

    def number(self, key: str, default: float) -> float:
        """Finite number at `key`."""
        return default if not self.has(key) else self._finite(key, self.value.get(key))

    def numbers(self, key: str, default: tuple[float, ...]) -> tuple[float, ...]:
        """As many finite numbers as `default` has. Raises NON_FINITE for NaN and infinities."""
        if not self.has(key):
            return default
        values = self.array(key)
        if len(values) != len(default):
            raise self.fail(key, f"{len(default)} numbers")
        return tuple(self._finite(key, v) for v in values)

    def _finite(self, key: str, value: object) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise self.fail(key, "a number")
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise Rejected(codes.NON_FINITE, f"glTF {self.place}/{key}: NaN or infinite; export the file again")
        return number

    def pick(self, index: int, key: str) -> JsonObject:
        """Object `index` of the array at `key`. Raises OUT_OF_BOUNDS where there is none."""
        values = self.array(key)
        if not 0 <= index < len(values):
            message = f"glTF {self.place}/{key}: index {index} of {len(values)}; export the file again"
            raise Rejected(codes.OUT_OF_BOUNDS, message)
        value = values[index]
        if not isinstance(value, dict):
            raise self.fail(key, "an array of objects")
        return JsonObject(value, f"{key}/{index}")

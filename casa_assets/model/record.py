"""Base class of all records: frozen, validated, JSON round trip, canonical digest."""

from __future__ import annotations

import base64
import hashlib
import json
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, ClassVar, Self

import numpy as np
import numpy.typing as npt
from pydantic import (
    BaseModel,
    ConfigDict,
    GetCoreSchemaHandler,
    SerializerFunctionWrapHandler,
    StringConstraints,
    field_validator,
    model_serializer,
)
from pydantic_core import CoreSchema, core_schema

Vec2 = tuple[float, float]
Vec3 = tuple[float, float, float]
Vec4 = tuple[float, float, float, float]
Vec5 = tuple[float, float, float, float, float]

# Legal at once as an MJCF name, a USD prim name and a file name; `__` is kept for joining id paths.
Id = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9]*(_[a-z0-9]+)*$", max_length=96)]
# An Id that may hold capitals, where a runtime spells a name with them.
MixedCaseId = Annotated[str, StringConstraints(pattern=r"^[a-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*$", max_length=96)]
Sha256 = Annotated[str, StringConstraints(pattern=r"^[0-9a-f]{64}$")]


@dataclass(frozen=True)
class ArrayOf:
    """Pydantic annotation of a read-only numpy array.

    Args:
        dtype: numpy dtype name that values are converted to. shape: expected shape; -1 accepts any length.
        finite: refuse NaN and infinities.
    """

    dtype: str
    shape: tuple[int, ...]
    finite: bool = True

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(
            self.read, serialization=core_schema.plain_serializer_function_ser_schema(self.write, when_used="json")
        )

    def read(self, value: Any) -> npt.NDArray[Any]:
        """Array from an array, nested lists, or the JSON form that `write` makes."""
        if isinstance(value, dict):
            raw = base64.b64decode(value["base64"], validate=True)
            value = np.frombuffer(raw, dtype=value["dtype"]).reshape(value["shape"])
        array = np.array(value, dtype=self.dtype, order="C", copy=True)
        if array.ndim == 1 and array.size == 0:
            array = array.reshape(tuple(0 if n < 0 else n for n in self.shape))
        if array.ndim != len(self.shape) or any(n not in (-1, m) for n, m in zip(self.shape, array.shape, strict=True)):
            raise ValueError(f"expected an array of shape {self.shape}, got {array.shape}")
        if array.dtype.kind == "f":
            if self.finite and not np.isfinite(array).all():
                raise ValueError("array holds NaN or infinity")
            array += 0.0  # turns -0.0 into 0.0, so that equal values have equal digests
        array.setflags(write=False)
        return array

    def write(self, array: npt.NDArray[Any]) -> dict[str, Any]:
        """JSON form: dtype (little endian), shape, base64 of the C-ordered bytes."""
        little = array.astype(array.dtype.newbyteorder("<"), copy=False)
        data = base64.b64encode(np.ascontiguousarray(little).tobytes()).decode("ascii")
        return {"dtype": little.dtype.str, "shape": list(array.shape), "base64": data}


Points = Annotated[npt.NDArray[np.float64], ArrayOf("float64", (-1, 3))]
Faces = Annotated[npt.NDArray[np.int32], ArrayOf("int32", (-1, 3))]
Uvs = Annotated[npt.NDArray[np.float64], ArrayOf("float64", (-1, 2))]
Colors = Annotated[npt.NDArray[np.uint8], ArrayOf("uint8", (-1, 4))]


class Record(BaseModel):
    """Immutable value. Two records are equal if their canonical JSON is equal.

    The validator of a class is built when its first record is made: a command uses only a few of the 350 classes, and
    building all validators took a fifth of the start-up time of the program.
    """

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        allow_inf_nan=False,
        ser_json_bytes="base64",
        val_json_bytes="base64",
        defer_build=True,
    )

    @field_validator("*")
    @classmethod
    def _no_minus_zero(cls, value: Any) -> Any:
        """Replace -0.0 by 0.0, alone or in a tuple: equal values have equal digests."""
        if type(value) is float:
            return value + 0.0
        if type(value) is tuple:
            return tuple(v + 0.0 if type(v) is float else v for v in value)
        return value

    def to_json(self) -> str:
        """Canonical JSON: sorted keys, no spaces, shortest floats that read back exactly."""
        data = self.model_dump(mode="json")
        return json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False, ensure_ascii=False)

    @classmethod
    def from_json(cls, text: str | bytes) -> Self:
        """Return the record that `to_json` wrote. Raises pydantic.ValidationError with the location of each fault."""
        return cls.model_validate_json(text)

    def replace(self, **changes: Any) -> Self:
        """A validated copy with some fields changed (model_copy would keep a stale digest)."""
        fields = {name: getattr(self, name) for name in type(self).model_fields}
        return type(self)(**{**fields, **changes})

    @cached_property
    def digest(self) -> str:
        """sha256 of the canonical JSON, 64 hex digits: identical on every machine."""
        return hashlib.sha256(self.to_json().encode("utf-8")).hexdigest()

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and isinstance(other, Record) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)


class BriefRecord(Record):
    """A record whose JSON leaves out the fields of `BLANKS` where they are empty."""

    BLANKS: ClassVar[tuple[str, ...]] = ()

    @model_serializer(mode="wrap")
    def _without_blanks(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return without_blanks(handler(self), self.BLANKS)


def without_blanks(data: dict[str, Any], names: tuple[str, ...]) -> dict[str, Any]:
    """JSON form of a record without the named fields if they are empty, so that older records keep their digests."""
    return {name: value for name, value in data.items() if name not in names or value}


def complete_records() -> None:
    """Build the validators of all record classes now: for a process that forks many others which need them."""
    waiting: list[type[Record]] = [Record]
    for record in waiting:  # in the order in which they were defined, since a class needs what its fields need
        record.model_rebuild()
        waiting += record.__subclasses__()

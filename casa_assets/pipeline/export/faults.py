"""Tell the faults of the program among the outcomes of an export."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

from casa_assets.errors import BatchFault


class Result(Protocol):
    """Outcome of the export of a kitchen; see its implementations."""

    @property
    def id(self) -> str:
        """Of the scene."""

    @property
    def message(self) -> str:
        """Why it failed, empty where it did not."""

    @property
    def is_fault(self) -> bool:
        """The program is to blame; `message` is a trace then."""


def raise_faults(results: Iterable[Result]) -> None:
    """Raise BatchFault with the results of which the program is to blame, if there are any."""
    faults = [result for result in results if result.is_fault]
    if faults:
        raise BatchFault([result.id for result in faults], "\n".join(result.message for result in faults))

"""Declaration of the keys that a dataclass has in a scene file; `scenes` makes their parsers from it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

FLAG_KIND, RESTITUTION_KIND = "flag", "restitution"
"""Kinds of keys that are no quantities with a unit: true or false, and a coefficient of restitution."""


@dataclasses.dataclass(frozen=True)
class SceneKey:
    """A key in a scene file.

    Attributes
    ----------
    kind
        Kind of quantity, a key of QUANTITY_KINDS, or FLAG_KIND or RESTITUTION_KIND.
    angle_kind
        Kind along a reading that is an angle; as `kind` if empty.
    sign
        Condition on the sign: "positive", "not negative", "not zero" or "any".
    reason
        Reason for the sign, as ", because friction opposes the motion".
    meaning
        What the key is, for the message about a missing one.
    examples
        Valid values along a length and an angle; those of the kind of quantity if empty.
    hint
        End of the message about a wrong sign or magnitude.
    bounded
        Whether the magnitude must be that of something that can be built.
    is_program
        Whether the value may also be a list of [time, value].
    is_required
        Whether the key must be given.
    """

    kind: str
    angle_kind: str = ""
    sign: str = "positive"
    reason: str = ""
    meaning: str = ""
    examples: tuple[str, ...] = ()
    hint: str = ""
    bounded: bool = True
    is_program: bool = False
    is_required: bool = False

    def kind_along(self, quantity: str) -> str:
        """Return the kind of quantity along a reading that is a "length" or an "angle"."""
        return self.angle_kind if quantity == "angle" and self.angle_kind else self.kind


@dataclasses.dataclass(frozen=True)
class Derivation:
    """A field that a function computes from other keys, along a length only.

    Attributes
    ----------
    field
        Name of the field.
    function
        Function of the keys; those with a default may be left out.
    kinds
        Kinds of quantity of the keys; all are positive.
    """

    field: str
    function: Callable[..., float]
    kinds: Mapping[str, str]


def scene_key(kind: str, angle_kind: str = "", *, default: Any = dataclasses.MISSING, **properties: Any) -> Any:
    """Declare a dataclass field that is a key of a scene file; the arguments are those of `SceneKey`."""
    key = SceneKey(kind, angle_kind, is_required=default is dataclasses.MISSING, **properties)
    return dataclasses.field(default=default, metadata={"scene_key": key})


def scene_keys_of(owner: Any) -> dict[str, SceneKey]:
    """Return the keys that the fields of a dataclass declare, by name.

    Parameters
    ----------
    owner
        Dataclass.

    Returns
    -------
    dict[str, SceneKey]
        The keys in the order of the fields.
    """
    return {field.name: field.metadata["scene_key"] for field in dataclasses.fields(owner) if "scene_key" in field.metadata}

"""The subject of checks: a part of a registry, with values for its fields."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from contactlab.parts.registry import Offer, Registry
from contactlab.testing.examples import example_spec, guesses


@dataclass(frozen=True, eq=False)
class Subject:
    """A part under check.

    fields   of the part, as a scene writes them; usual values stand in for those without a default
    results  of runs that several checks use, by what was run
    """

    registry: Registry
    kind: str
    name: str
    given: Mapping[str, Any] = field(default_factory=dict)
    results: dict[str, Any] = field(default_factory=dict, repr=False)

    @property
    def spec(self) -> dict[str, Any]:
        """The part as a scene names it. Raises NotApplicable naming a field without a value."""
        return example_spec(self.registry, self.kind, self.name, {**self.guessed, **self.given})

    @property
    def guessed(self) -> dict[str, Any]:
        """Values of fields that have neither a default nor a usual value, by their types."""
        return guesses(self.part_class, self.given)

    def with_fields(self, values: Mapping[str, Any]) -> Subject:
        """The same part with other values of some fields."""
        return Subject(self.registry, self.kind, self.name, {**self.given, **values})

    @property
    def offer(self) -> Offer:
        """The part and the plugin that it comes from."""
        return self.registry.offer(self.kind, self.name)

    @property
    def part_class(self) -> type[Any]:
        """Class of the part. Raises PartError if it cannot be imported or breaks the contract."""
        return self.registry.part_class(self.kind, self.name)

    def make(self) -> Any:
        """A new instance. Raises PartError or SceneError."""
        return self.registry.make(self.kind, self.spec)

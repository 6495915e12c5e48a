"""What the names of a text stand for, across the files that it imports."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..langs.frozen import dataclass
from ..langs.source import Source
from .mentions import Definition, Mention, Mentions, mentions_of


@dataclass(frozen=True, slots=True)
class Place:
    """A definition and the text it stands in."""

    source: Source
    definition: Definition

    @property
    def key(self) -> tuple[str, int]:
        """The same for all mentions of one thing."""
        return self.source.path, self.definition.mention.start


class Naming:
    """Finds what is meant by a mention. `sources` are a text and all that it imports, the text itself first."""

    def __init__(self, sources: Sequence[Source]) -> None:
        self.files: dict[str, Mentions] = {s.path: mentions_of(s) for s in sources}
        self._table: dict[tuple[str, str, str], Place] = {}
        self._own: dict[tuple[str, str, str, str], Place] = {}
        for file in self.files.values():
            for definition in file.definitions:
                mention, place = definition.mention, Place(file.source, definition)
                key = (mention.kind, mention.name, mention.home)
                self._table.setdefault(key, place)
                self._own.setdefault((file.source.path, *key), place)

    def meant(self, path: str, mention: Mention) -> Place | None:
        """The definition of what is mentioned in the text at `path`; None where nothing in sight declares it."""
        kind, name, home = mention.kind, mention.name, mention.home
        own = self._own.get((path, kind, name, home))
        if own is not None or home.startswith("@"):
            return own
        if kind == "object":
            return self._thing(name, home, set())
        if kind == "attribute":
            return self._part(home, name)
        found = self._table.get((kind, name, home))
        if found is None and kind == "variable":  # of an argument: `scene` and `task` share their parameters' form
            found = self._table.get((kind, name, home.replace("scene ", "task ", 1)))
        return found

    def _thing(self, name: str, scene: str, seen: set[str]) -> Place | None:
        """An object of a scene or task, or of the scenes that it uses."""
        found = self._table.get(("object", name, scene))
        if found is not None or scene in seen:
            return found
        seen.add(scene)
        used = [u for file in self.files.values() for u in file.uses.get(scene, ())]
        return next((f for f in (self._thing(name, u, seen) for u in used) if f is not None), None)

    def _part(self, home: str, name: str) -> Place | None:
        """The effector `name` of the robot that `home`, a scene and an object of it, tells."""
        scene, _, thing = home.partition(" ")
        robot = self._thing(thing, scene, set()) if thing else None
        return None if robot is None else self._table.get(("effector", name, robot.definition.type))

    def definitions(self, kinds: Sequence[str]) -> Iterator[Place]:
        """Everything of those kinds that the files declare for all to see, the main file's first."""
        for (kind, _, home), place in self._table.items():
            if kind in kinds and home == "":
                yield place

    def of_home(self, kind: str, home: str) -> list[Place]:
        """What belongs to a declaration, in the order of the text."""
        found = [p for (k, _, h), p in self._table.items() if k == kind and h == home]
        return sorted(found, key=lambda p: p.definition.mention.start)

    def things(self, scene: str) -> list[Place]:
        """The objects in sight in a scene or task."""
        found, waiting, seen = [*self.of_home("object", scene)], [scene], set[str]()
        while waiting:
            current = waiting.pop()
            if current in seen:
                continue
            seen.add(current)
            for file in self.files.values():
                for used in file.uses.get(current, ()):
                    found += self.of_home("object", used)
                    waiting.append(used)
        return found

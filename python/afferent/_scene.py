"""The scene: everything that Afferent is told, as a value."""

from __future__ import annotations

import os
import re
import warnings
from typing import Any, Mapping, Sequence, Union

from . import _afferent, _html, _scene_text, fields
from ._suggestions import suggests
from .errors import SceneError

PathLike = Union[str, "os.PathLike[str]"]


class Scene(_afferent.Scene):
    """A scene, checked. Each argument is a field of proto/scene.proto, and may be left out.

    A message is a dict with its fields; where it is one of several, its name stands for it with its defaults:

        Scene(patches=[dict(name="thumb", elements=3)], decoder="filter", duration_s=2)

    Paths are relative to `folder`. Raises SceneError, which names every field that is wrong.
    """

    @suggests
    def __init__(
        self,
        *,
        name: str | None = None,
        duration_s: float | None = None,
        seed: int | None = None,
        patches: Sequence[fields.Patch] | None = None,
        every_patch: fields.Patch | None = None,
        source: fields.Source | fields.SourceName | None = None,
        link: fields.Link | fields.LinkName | None = None,
        decoder: fields.Decoder | fields.DecoderName | None = None,
        gain: fields.Gain | None = None,
        hand: fields.Hand | None = None,
        record: fields.Record | None = None,
        runtime: fields.Runtime | None = None,
        output: Sequence[fields.Output] | None = None,
        trial: fields.Trial | None = None,
        uncertainty: fields.Uncertainty | None = None,
        folder: PathLike = ".",
    ) -> None:
        given = dict(
            name=name, duration_s=duration_s, seed=seed, patches=patches, every_patch=every_patch, source=source,
            link=link, decoder=decoder, gain=gain, hand=hand, record=record, runtime=runtime, output=output,
            trial=trial, uncertainty=uncertainty)  # fmt: skip
        try:
            super().__init__(_scene_text.text_of(given), "scene", folder)
        except SceneError as error:
            # Places in a text that nobody has written say nothing.
            raise SceneError([re.sub(r"^scene:\d+:\d+: ", "", message) for message in error.messages]) from None

    @classmethod
    def _of(cls, core: _afferent.Scene) -> Scene:
        scene = cls.__new__(cls)
        _afferent.Scene.__init__(scene, core)
        return scene

    @classmethod
    def from_text(cls, text: str, file: str = "scene", folder: PathLike = ".") -> Scene:
        """A scene as its text has it; `file` begins every message."""
        scene = cls.__new__(cls)
        _afferent.Scene.__init__(scene, text, file, folder)
        return scene

    @classmethod
    def from_file(cls, file: PathLike) -> Scene:
        """The scene in a file, to whose folder its paths are relative."""
        return cls._of(_afferent.Scene.read(file))

    @classmethod
    def for_table(cls, file: PathLike, **told: Any) -> Scene:
        """The scene of a table as it comes; `told` as for inspect(). What had to be assumed is a warning."""
        from ._tables import inspect

        found = inspect(file, **told)
        if found.scene is None:
            raise SceneError([f"{found.file}: {found.why_no_scene}"])
        for assumption in found.assumptions:
            warnings.warn(assumption, stacklevel=2)
        return found.scene

    def with_settings(self, settings: Mapping[str, Any]) -> Scene:
        """This scene with other values for some fields, each named by its path:

            scene.with_settings({"decoder": "filter", "neuron.delta_g": 0.1, "patch[thumb].elements": 5})

        What is no field of a scene is one of its patches, of all of them; None: as if the scene did not say.
        """
        texts = [(path, _scene_text.setting_text(path, value)) for path, value in settings.items()]
        return Scene._of(super().with_settings(texts))

    def to_dict(self) -> dict[str, Any]:
        """What differs from the defaults: Scene(**scene.to_dict()) is the same scene."""
        fields = _scene_text.fields_of(self.text())
        return {"patches" if name == "patch" else name: value for name, value in fields.items()}

    def __str__(self) -> str:
        return self.text(lines=True)

    def __repr__(self) -> str:
        return f"Scene.from_text({self.text()!r})"

    def _repr_html_(self) -> str:
        return _html.preformatted(f"Scene {self.name}".strip(), str(self))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _afferent.Scene) and self.text() == other.text()

    def __hash__(self) -> int:
        return hash(self.text())

    def __reduce__(self) -> tuple[Any, ...]:
        return Scene.from_text, (self.text(), self.file, str(self.folder))


class Plan(_afferent.Plan):
    """What a scene needs: what is built, what is left out and why, and how much to expect at most."""

    def __init__(self, scene: SceneLike) -> None:
        super().__init__(scene_of(scene))

    def _repr_html_(self) -> str:
        rows = [(part.name, "built" if part.built else "left out", part.reason) for part in self.items]
        about = (f"{self.elements:,} elements, {self.neurons:,} neurons, {self.threads} threads, at most "
                 f"{self.events_per_second_at_most:,.0f} events/s and {self.bytes_per_second_at_most:,.0f} B/s")
        return _html.table(about, ("part", "", "why"), rows)

    def __str__(self) -> str:
        lines = []
        for built, title in ((True, "Built"), (False, "Left out")):
            lines.append(title)
            lines += [f"  {part.name:<28}  {part.reason}" for part in self.items if part.built == built]
        return "\n".join(lines)


SceneLike = Union[_afferent.Scene, PathLike]


def scene_of(given: SceneLike) -> _afferent.Scene:
    """A scene, or that of a file."""
    if isinstance(given, _afferent.Scene):
        return given
    if not isinstance(given, (str, os.PathLike)):
        raise TypeError(f"a scene is an afferent.Scene, or the path of a file of one; this is {given!r}")
    try:
        return Scene.from_file(given)
    except SceneError as error:
        if len(error.messages) != 1 or ": a table, and no scene." not in error.messages[0]:
            raise
        raise SceneError([f"{os.fspath(given)}: a table, and no scene. To run it: "
                          f"afferent.run(afferent.Scene.for_table({os.fspath(given)!r}))"]) from None


def plan(scene: SceneLike) -> Plan:
    """The plan of a scene, or of the scene in a file; raises SceneError."""
    return Plan(scene)

"""What Afferent raises."""

from __future__ import annotations

from typing import Sequence


class SceneError(ValueError):
    """A scene is wrong: everything that is wrong with it at once, each with its place or its field."""

    def __init__(self, messages: Sequence[str]) -> None:
        super().__init__("\n".join(messages))
        self.messages = list(messages)

    def __reduce__(self) -> tuple[type[SceneError], tuple[list[str]]]:
        return SceneError, (self.messages,)


class DataError(ValueError):
    """What came from a file or a link is not what it has to be."""


class OutsideError(OSError):
    """A file or a peer cannot be reached."""


class SpikeStormError(RuntimeError):
    """A neuron fires more often than the scene allows."""

    def __init__(self, message: str, address: int, time_ns: int) -> None:
        super().__init__(message, address, time_ns)
        self.address = address
        self.time_ns = time_ns

    def __str__(self) -> str:
        return str(self.args[0])

"""Names that are nearly right."""

from __future__ import annotations

import difflib
import functools
import inspect
from typing import Any, Callable, Iterable, TypeVar, cast

Function = TypeVar("Function", bound=Callable[..., Any])


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """The end of a message about a name that is not known."""
    near = difflib.get_close_matches(name, list(known), 1)
    return f': did you mean "{near[0]}"?' if near else ""


def suggests(function: Function) -> Function:
    """Answers a keyword that the function does not take with the nearest one."""
    names = [
        name for name, parameter in inspect.signature(function).parameters.items()
        if parameter.kind in (parameter.KEYWORD_ONLY, parameter.POSITIONAL_OR_KEYWORD) and name != "self"
    ]  # fmt: skip

    @functools.wraps(function)
    def checked(*given: Any, **keywords: Any) -> Any:
        for name in keywords:
            if name not in names:
                raise TypeError(f"{function.__qualname__.replace('.__init__', '')} has no argument "
                                f'"{name}"{did_you_mean(name, names)}')
        return function(*given, **keywords)

    return cast(Function, checked)

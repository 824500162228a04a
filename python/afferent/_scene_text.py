"""Between Python's values and the text of a scene, by the fields that proto/scene.proto has."""

from __future__ import annotations

import ast
import functools
import json
import re
from typing import Any, Iterator, Mapping, NamedTuple

from . import _afferent
from ._suggestions import did_you_mean
from .errors import SceneError


class Field(NamedTuple):
    name: str
    type: str
    repeated: bool
    alternative: bool
    of: str
    names: list[str]


@functools.lru_cache(maxsize=None)
def schema() -> dict[str, dict[str, Field]]:
    """The fields of each message; the scene is the first."""
    return {message: {field[0]: Field(*field) for field in fields} for message, fields in _afferent.schema()}


def alternatives(message: str) -> list[str]:
    """The messages that stand for their oneof by their names alone, as in decoder="filter"."""
    return [field.name for field in schema()[message].values() if field.alternative and field.type == "message"]


def text_of(fields: Mapping[str, Any], message: str = "Scene", path: str = "") -> str:
    """What stands between the message's braces. A field that is None is left out."""
    parts = []
    for name, value in fields.items():
        if value is None:
            continue
        field = _find(message, name)
        here = path + name
        if not field.repeated:
            parts.append(_field_text(field, value, here))
            continue
        value = value.tolist() if hasattr(value, "tolist") else value
        items = value if isinstance(value, (list, tuple)) else [value]
        parts += [_field_text(field, item, f"{here}[{i}]" if len(items) > 1 else here) for i, item in enumerate(items)]
    return " ".join(parts)


def setting_text(path: str, value: Any) -> str:
    """A value for the field of that path, as "path=value" has it."""
    if value is None:
        return ""
    field = _field_at(path)
    if field is None:  # the library says what is wrong with the path
        return str(value)
    value = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(value, (list, tuple)):
        if not field.repeated:
            raise SceneError([f"{path} takes one value, is {value!r}"])
        return "[" + ", ".join(_list_item(field, item, path) for item in value) + "]"
    if field.type == "message":
        return value if isinstance(value, str) else "{" + text_of(value, field.of, path + ".") + "}"
    return str(value) if field.type == "text" else _scalar(field, value, path)


def fields_of(text: str) -> dict[str, Any]:
    """The inverse of text_of, for text as the library writes it."""
    tokens = iter(re.findall(r'"(?:\\.|[^"\\])*"|[{}:]|[^\s{}:"]+', text))
    return _read_fields(tokens, "Scene")


def _find(message: str, name: str) -> Field:
    known = schema()[message]
    # As in C++, where this one member is called by what it holds.
    found = known.get("patch" if (message, name) == ("Scene", "patches") else name)
    if found is None:
        raise SceneError([f'{message} has no field "{name}"{did_you_mean(name, known)}'])
    return found


def _field_at(path: str) -> Field | None:
    steps = [step.split("[")[0] for step in re.split(r"\.(?![^\[]*\])", path)]
    message = "Scene" if steps[0] in schema()["Scene"] else "Patch"
    field = None
    for step in steps:
        field = schema().get(message, {}).get(step)
        if field is None:
            return None
        message = field.of
    return field


def _field_text(field: Field, value: Any, path: str) -> str:
    if field.type != "message":
        return f"{field.name}: {_scalar(field, value, path)}"
    if isinstance(value, str):
        known = alternatives(field.of)
        if value not in known:
            wanted = "a dict" + (f", or one of {', '.join(known)}" if known else "")
            raise SceneError([f"{path} must be {wanted}, is {value!r}"])
        return f"{field.name} {{ {value} {{}} }}"
    if not isinstance(value, Mapping):
        raise SceneError([f"{path} must be a dict with the fields of {field.of}, is {value!r}"])
    return f"{field.name} {{ {text_of(value, field.of, path + '.')} }}"


def _list_item(field: Field, value: Any, path: str) -> str:
    return "{" + text_of(value, field.of, path + ".") + "}" if field.type == "message" else _scalar(field, value, path)


def _scalar(field: Field, value: Any, path: str) -> str:
    if hasattr(value, "item"):
        value = value.item()
    if field.type == "text" and hasattr(value, "__fspath__"):
        value = value.__fspath__()
    if field.type == "boolean" and isinstance(value, bool):
        return "true" if value else "false"
    if field.type == "number" and isinstance(value, (int, float)) and not isinstance(value, bool):
        return repr(float(value))
    if field.type == "whole number" and isinstance(value, int) and not isinstance(value, bool):
        return str(value)
    if field.type == "whole number" and isinstance(value, float) and value.is_integer():
        return str(int(value))
    if field.type == "text" and isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if field.type == "name" and isinstance(value, str) and value.upper() in field.names:
        return value.upper()
    wanted = f"one of {', '.join(field.names)}" if field.type == "name" else f"a {field.type}"
    raise SceneError([f"{path} must be {wanted}, is {value!r}"])


def _read_fields(tokens: Iterator[str], message: str) -> dict[str, Any]:
    fields: dict[str, Any] = {}
    for name in tokens:
        if name == "}":
            break
        field = schema()[message][name]
        value = _read_fields(tokens, field.of) if next(tokens) == "{" else _read_scalar(field, next(tokens))
        if field.repeated:
            fields.setdefault(name, []).append(value)
        else:
            fields[name] = value
    return fields


def _read_scalar(field: Field, token: str) -> Any:
    if field.type == "text":
        value = ast.literal_eval("b" + token)
        assert isinstance(value, bytes)
        return value.decode()
    if field.type == "boolean":
        return token == "true"
    if field.type == "name":
        return token
    return float(token) if field.type == "number" else int(token)

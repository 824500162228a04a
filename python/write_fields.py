#!/usr/bin/env python3
"""Writes afferent/fields.py, the types of a scene's messages, from the fields that the library has.

    PYTHONPATH=build/release/python python/write_fields.py python/afferent/fields.py
"""
import importlib.util
import pathlib
import sys

SCALARS = {"number": "float", "whole number": "int", "boolean": "bool", "text": "str"}


def module():
    """The compiled part alone: the package reads the file that is written here."""
    for folder in sys.path:
        for file in (pathlib.Path(folder) / "afferent").glob("_afferent.*.so"):
            spec = importlib.util.spec_from_file_location("afferent._afferent", file)
            found = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(found)
            return found
    sys.exit("afferent is not in PYTHONPATH")


def literal(names):
    return f"Literal[{', '.join(repr(name).replace(chr(39), chr(34)) for name in names)}]"


def text():
    messages = module().schema()
    names = {message: [f[0] for f in fields if f[3] and f[1] == "message"] for message, fields in messages}
    lines = ['"""The messages of a scene as dicts: proto/scene.proto says what each field means.', "",
             'Written by python/write_fields.py."""', "", "from __future__ import annotations", "",
             "from typing import Any, Literal, Sequence, TypedDict, Union", "", "from numpy.typing import NDArray", "",
             "Numbers = Union[Sequence[float], NDArray[Any]]"]
    aliases = []
    for message, fields in messages[1:]:
        lines += ["", "", f"class {message}(TypedDict, total=False):"]
        for name, type, repeated, _, of, values in fields:
            kind = of if type == "message" else literal(values) if type == "name" else SCALARS[type]
            if type == "message" and names[of]:
                kind = f"Union[{of}, {of}Name]"
            # Arrays of NumPy serve for numbers.
            many = "Numbers" if type in ("number", "whole number") else f"Sequence[{kind}]"
            lines.append(f"    {name}: " + (many if repeated else kind))
        if not fields:
            lines.append("    pass")
        if names[message]:
            aliases.append(f"{message}Name = {literal(names[message])}")
    return "\n".join(lines + ["", "", "# The names of the messages that stand for one of several.", *aliases]) + "\n"


if __name__ == "__main__":
    pathlib.Path(sys.argv[1]).write_text(text())

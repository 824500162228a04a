#!/usr/bin/env python3
"""Gives the tree in a folder the version of a release: scripts/cut_release.py VERSION DATE [FOLDER]

Sets the version of CMake and of the module for Python, and makes the changelog's *Unreleased* the notes of that version.
Changes nothing where the version is no later than that of the last release, or where there are no notes."""
import pathlib
import re
import sys


def replaced(text, pattern, by, name):
    changed, count = re.subn(pattern, by, text, count=1, flags=re.MULTILINE)
    if count != 1:
        sys.exit(f"{name}: has no line like {pattern}")
    return changed


def numbers(version):
    return tuple(int(each) for each in version.split("."))


def cut(version, date, folder):
    if not re.fullmatch(r"\d+\.\d+\.\d+", version):
        sys.exit(f"The version must be three numbers, such as 0.2.0, and is {version}")
    texts = {name: (folder / name).read_text() for name in ("CMakeLists.txt", "pyproject.toml", "CHANGELOG.md")}
    changelog = texts["CHANGELOG.md"]
    released = re.findall(r"^## \[(\d+\.\d+\.\d+)\]", changelog, flags=re.MULTILINE)
    if released and numbers(version) <= max(map(numbers, released)):
        sys.exit(f"CHANGELOG.md: {version} must be later than {max(released, key=numbers)}, which is released")
    notes = re.search(r"^## Unreleased\n(.*?)(?=^## |\Z)", changelog, flags=re.MULTILINE | re.DOTALL)
    if not notes or "\n- " not in notes.group(1):
        sys.exit("CHANGELOG.md: Unreleased has no notes")
    texts["CHANGELOG.md"] = changelog.replace("## Unreleased\n", f"## Unreleased\n\n## [{version}] - {date}\n", 1)
    texts["CMakeLists.txt"] = replaced(texts["CMakeLists.txt"], r"^  VERSION \S+$", f"  VERSION {version}",
                                       "CMakeLists.txt")
    texts["pyproject.toml"] = replaced(texts["pyproject.toml"], r'^version = ".*"$', f'version = "{version}"',
                                       "pyproject.toml")
    for name, text in texts.items():
        (folder / name).write_text(text)


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__.splitlines()[0])
    cut(sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3] if len(sys.argv) == 4 else "."))

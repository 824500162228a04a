"""The scene reference, from proto/scene.proto: every message and field with its comment, default, range and unit."""

import re
import subprocess
import tempfile
from pathlib import Path

from google.protobuf import descriptor_pb2

Field = descriptor_pb2.FieldDescriptorProto
TYPES = {
    Field.TYPE_DOUBLE: "number",
    Field.TYPE_UINT32: "whole number",
    Field.TYPE_UINT64: "whole number",
    Field.TYPE_INT32: "whole number",
    Field.TYPE_INT64: "whole number",
    Field.TYPE_BOOL: "yes or no",
    Field.TYPE_STRING: "text",
}
UNITS = {
    "s": "s", "ms": "ms", "us": "µs", "ns": "ns", "n": "N", "hz": "Hz", "mv": "mV", "mm": "mm", "mm2": "mm²", "cm2": "cm²",
    "deg": "°", "kpa": "kPa", "ohm": "Ω", "counts": "counts", "bits": "bits", "s2": "s²", "j": "J", "kg": "kg", "g": "g",
    "mj": "mJ", "ppm": "ppm", "percent": "%", "cm": "cm", "m": "m", "kbps": "kbit/s", "bps": "bit/s", "baud": "baud",
}  # fmt: skip


def unit_of(name):
    """The unit that the name ends in: gain_mv_s_per_n is in mV·s/N."""
    above, _, below = name.partition("_per_") if "_per_" in name else (name, "", "")
    if name.startswith("per_"):
        above, below = "", name[4:]
    words = above.split("_")[1:] if not below else above.split("_")
    units = []
    while words and words[-1] in UNITS:
        units.insert(0, UNITS[words.pop()])
    if below:
        if not all(word in UNITS for word in below.split("_")):
            return ""
        units = "·".join(units) or "1"
        return units + "/" + "·".join(UNITS[word] for word in below.split("_"))
    return "·".join(units)


def clean(comment):
    """As Markdown: indented lines are equations, and nothing else has a meaning."""
    lines = [re.sub(r"^ ", "", line.rstrip()) for line in comment.rstrip("\n").split("\n")]
    text = []
    for line in lines:
        if line.startswith("    "):
            if text and text[-1] and not text[-1].startswith("    "):
                text.append("")
            text.append(line)
        else:
            if text and text[-1].startswith("    ") and line:
                text.append("")
            text.append(re.sub(r"(?<!`)([<>$|*])(?!`)", r"\\\1", line))
    return "\n".join(text)


def in_cell(comment):
    return " ".join(clean(comment).split()).replace("\n", " ")


def is_range(text):
    return re.match(r"\s*(>|>=|-?[0-9.e-]+ to )", text) is not None


def type_name(field):
    """Of a message or an enumeration: Table.Unit, which is another than EmgTable.Unit."""
    return field.type_name.removeprefix(".afferent.proto.")


def link(name):
    return f"[{name}](#{name.lower().replace('.', '')})"


class Reference:
    def __init__(self, file):
        self.file = file
        self.comments = {tuple(place.path): place for place in file.source_code_info.location}
        self.lines = []
        self.users = {}
        # What a field says that has no comment of its own: the first sentence about its type.
        self.about = {}
        self.note_about(file, [], [4, 5])

    def place(self, path):
        return self.comments.get(tuple(path)) or descriptor_pb2.SourceCodeInfo.Location()

    def note_about(self, parent, path, kinds, within=""):
        """`kinds` are the field numbers of messages and enumerations in their parent's descriptor."""
        messages = parent.message_type if not path else parent.nested_type
        for kind, types in zip(kinds, (messages, parent.enum_type)):
            for i, each in enumerate(types):
                first = re.match(r"[^.]*[.]", in_cell(self.place([*path, kind, i]).leading_comments))
                self.about[within + each.name] = first[0] if first else ""
                if kind == kinds[0]:
                    self.note_about(each, [*path, kind, i], [3, 4], f"{within}{each.name}.")

    def note_users(self, message, name):
        for field in message.field:
            if field.type_name:
                used = self.users.setdefault(type_name(field), [])
                if name not in used:
                    used.append(name)
        for nested in message.nested_type:
            self.note_users(nested, f"{name}.{nested.name}")

    def type_of(self, field):
        if field.type in TYPES:
            kind = TYPES[field.type]
        else:
            kind = link(type_name(field))
        return kind + (", any number" if field.label == Field.LABEL_REPEATED else "")

    def row(self, message, field, path):
        place = self.place(path)
        meaning = in_cell(place.leading_comments) or self.about.get(type_name(field), "")
        limits = ""
        if is_range(place.trailing_comments):
            limits = in_cell(place.trailing_comments)
        elif place.trailing_comments.strip():
            meaning = " ".join([meaning, in_cell(place.trailing_comments)]).strip()
        if field.HasField("oneof_index"):
            choice = message.oneof_decl[field.oneof_index].name
            meaning = f"*One of `{choice}`.* {meaning}".strip()
        default = f"`{field.default_value}`" if field.HasField("default_value") else ""
        cells = [f"`{field.name}`", self.type_of(field), default, limits, unit_of(field.name), meaning]
        return "| " + " | ".join(cells) + " |"

    def heading(self, name, path):
        self.lines += [f"## {name}", ""]
        comment = self.place(path).leading_comments
        if comment:
            self.lines += [clean(comment), ""]
        used = ", ".join(link(user) for user in self.users.get(name, []) if user != name)
        if used:
            self.lines += [f"In {used}.", ""]

    def message(self, message, path, within=""):
        self.heading(within + message.name, path)
        if message.field:
            self.lines += ["| field | type | default | range | unit | meaning |", "|---|---|---|---|---|---|"]
            self.lines += [self.row(message, field, [*path, 2, i]) for i, field in enumerate(message.field)]
        else:
            self.lines += ["It has no fields: it is written `{}`."]
        self.lines += [""]
        for i, nested in enumerate(message.nested_type):
            self.message(nested, [*path, 3, i], f"{within}{message.name}.")
        for i, nested in enumerate(message.enum_type):
            self.enumeration(nested, [*path, 4, i], f"{within}{message.name}.")

    def enumeration(self, enumeration, path, within=""):
        self.heading(within + enumeration.name, path)
        self.lines += ["| value | meaning |", "|---|---|"]
        for i, value in enumerate(enumeration.value):
            place = self.place([*path, 2, i])
            meaning = in_cell(place.leading_comments + place.trailing_comments)
            self.lines += [f"| `{value.name}` | {meaning} |"]
        self.lines += [""]

    def page(self):
        for message in self.file.message_type:
            self.note_users(message, message.name)
        syntax = self.place([12])
        detached = "\n\n".join([*syntax.leading_detached_comments, syntax.leading_comments])
        self.lines = ["# Scene reference", "", clean(detached.strip("\n")), ""]
        self.lines += [
            "A scene is a text file of fields, `name: value` or `name { ... }` for what has fields itself; a comment begins with `#`.",
            "[Scene](#scene) is the file itself. A misspelt field is answered with the nearest one, and `afferent plan` says what a",
            "scene builds and what it leaves out.",
            "",
        ]
        kinds = [(message.name, self.message, message, [4, i]) for i, message in enumerate(self.file.message_type)]
        kinds += [(kind.name, self.enumeration, kind, [5, i]) for i, kind in enumerate(self.file.enum_type)]
        order = sorted(kinds, key=lambda kind: list(self.place(kind[3]).span))
        for _, write, kind, path in order:
            write(kind, path)
        return "\n".join(self.lines)


def scene_reference(root):
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "scene.bin"
        subprocess.run(
            ["protoc", f"-I{root}/proto", "--include_source_info", f"--descriptor_set_out={out}", f"{root}/proto/scene.proto"],
            check=True,
        )
        files = descriptor_pb2.FileDescriptorSet.FromString(out.read_bytes())
    return Reference(files.file[0]).page()

"""Lays out what Sphinx reads: prepare.py ROOT FOLDER [PROGRAM]

The pages are those of docs/, with parts of the README, the scene reference, and the help of the program where it is
given. A link to any other file of the repository becomes a link to a page that shows it.
"""

import base64
import re
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

from scene_reference import scene_reference

KATEX = Path("/usr/share/javascript/katex")
PICTURES = {".png", ".svg", ".gif", ".jpg"}
LANGUAGES = {
    ".cpp": "cpp", ".hpp": "cpp", ".c": "c", ".h": "c", ".py": "python", ".proto": "protobuf", ".sh": "sh", ".txtpb": "txtpb",
}  # fmt: skip

# In the order of the navigation. A page that does not exist yet is left out; one that is named nowhere comes last.
NAVIGATION = {
    "Begin": ["start", "install", "concepts"],
    "How to": ["embed", "python", "own_data", "tables", "view", "live_events", "own_decoder", "own_hand", "link_size", "ranks"],
    "In depth": ["afferents", "readouts", "safe_state", "threat_model", "trial"],
    "Reference": ["scene_reference", "commands", "wire", "interfaces", "numbers", "extend", "changelog"],
}
# Files of the repository that are pages, or parts of pages, of their own.
PAGES = {"README.md": "index", "CHANGELOG.md": "changelog", "bench/README.md": "numbers"}


def section(text, title):
    """What stands under a heading of the README, without the heading."""
    found = re.search(rf"^## {re.escape(title)}\n(.*?)(?=^## |\Z)", text, re.M | re.S)
    if not found:
        sys.exit(f"README.md has no section '{title}', of which docs/site/prepare.py makes a page")
    return found[1].strip() + "\n"


def as_table(match):
    """A state diagram in Mermaid, which takes a network, as a table of its transitions."""
    lines = ["| from | to | when |", "|---|---|---|"]
    for before, after, when in re.findall(r"^ *(\S+) --> (\S+): (.*)$", match[1], re.M):
        lines.append(f"| {before.replace('[*]', '')} | {after} | {when} |")
    return "\n".join(lines) + "\n"


class Site:
    def __init__(self, root, folder):
        self.root = root
        self.folder = folder
        self.shown = set()

    def write(self, name, text):
        file = self.folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def add(self, name, text, origin):
        """A page whose links are relative to `origin`, a folder of the repository."""

        def target(match):
            path, anchor = match[1], match[2] or ""
            there = (origin / path).resolve()
            if re.match(r"[a-z]+:", path) or not there.is_relative_to(self.root) or not there.exists():
                return match[0]
            return f"]({self.place_of(there)}{anchor})"

        text = re.sub(r"^```mermaid\n(.*?)^```\n", as_table, text, flags=re.M | re.S)
        self.write(name + ".md", re.sub(r"\]\(([^)#\s]+)(#[^)\s]*)?\)", target, text))

    def place_of(self, file):
        """Where the site shows a file of the repository."""
        path = str(file.relative_to(self.root))
        if path in PAGES:
            return f"{PAGES[path]}.md"
        if file.parent == self.root / "docs" and file.suffix == ".md":
            return file.name
        if path == "proto/scene.proto":
            return "scene_reference.md"
        if file.suffix in PICTURES:
            copy = self.folder / "files" / path
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(file, copy)
            return f"files/{path}"
        self.show(file, path)
        return f"files/{path}.md"

    def show(self, file, path):
        if path in self.shown:
            return
        self.shown.add(path)
        if file.is_dir():
            tracked = subprocess.run(
                ["git", "ls-files", path], cwd=self.root, capture_output=True, text=True, check=True
            ).stdout
            content = tracked or "\n".join(sorted(str(each.relative_to(self.root)) for each in file.iterdir())) + "\n"
        else:
            content = file.read_text()
        fence = "`" * 8
        language = LANGUAGES.get(file.suffix, "none")
        self.write(f"files/{path}.md", f"---\norphan: true\n---\n\n# {path}\n\n{fence}{language}\n{content}{fence}\n")


def commands_page(program):
    """The help of every command, as the program prints it."""

    def help_of(words):
        text = subprocess.run([program, *words, "--help"], capture_output=True, text=True, check=True).stdout
        return "\n".join(wrapped(line) for line in text.splitlines())

    def wrapped(line):
        below = " " * 30 if line.startswith("  -") or re.match(r"  \w+ .*  ", line) else ""
        return "\n".join(textwrap.wrap(line, 108, subsequent_indent=below) or [""])

    lines = ["# Commands", "", "What `afferent --help` and the help of each command print.", ""]
    waiting = [[]]
    while waiting:
        words = waiting.pop(0)
        if words == ["bench"]:
            continue
        text = help_of(words)
        lines += [f"## {' '.join(['afferent', *words])}", "", "```none", text.strip(), "```", ""]
        listed = re.search(r"^Subcommands:\n(.*?)(\n\n|\Z)", text, re.M | re.S)
        if listed:
            names = re.findall(r"^  ([a-z]+) ", listed[1], re.M)
            waiting = [[*words, name] for name in names] + waiting
    return "\n".join(lines)


def copy_katex(folder):
    """Its fonts go into its style sheet, because a browser may refuse to load fonts from another file."""

    def font(match):
        data = base64.b64encode((KATEX / match[1]).read_bytes()).decode()
        return f'src:url(data:font/woff2;base64,{data}) format("woff2")'

    folder.mkdir(parents=True)
    shutil.copy(KATEX / "katex.min.js", folder)
    style = (KATEX / "katex.min.css").read_text()
    style = re.sub(r"src:url\((fonts/[^)]*[.]woff2)\)[^;}]*", font, style)
    (folder / "katex.min.css").write_text(style)


def main(root, folder, program=None):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    here = root / "docs" / "site"
    shutil.copy(here / "conf.py", folder)
    copy_katex(folder / "_static" / "katex")
    for file in ("equations.js", "excerpts.js", "site.css"):
        shutil.copy(here / file, folder / "_static")

    site = Site(root, folder)
    readme = (root / "README.md").read_text()
    for page in sorted((root / "docs").glob("*.md")):
        if page.stem != "index":
            site.add(page.stem, page.read_text(), root / "docs")
    site.add("numbers", "# The numbers\n\n" + section(readme, "Where the numbers come from"), root)
    bench = (root / "bench" / "README.md").read_text()
    site.add("benchmarks", bench, root / "bench")
    site.add("extend", "# Extend it\n\n" + section(readme, "Extend it"), root)
    site.add("changelog", (root / "CHANGELOG.md").read_text(), root)
    site.write("scene_reference.md", scene_reference(root))
    site.write(
        "interfaces.md",
        "# Interfaces\n\nEvery header that is installed, from its own comments: "
        '<a href="interfaces/annotated.html">types</a>, <a href="interfaces/files.html">files</a>, '
        '<a href="interfaces/namespaceafferent.html">the namespace <code>afferent</code></a>.\n',
    )
    if program:
        site.write("commands.md", commands_page(program))

    index = (root / "docs" / "index.md").read_text()
    named = {page for pages in NAVIGATION.values() for page in pages}
    others = sorted(page.stem for page in folder.glob("*.md") if page.stem not in named | {"index"})
    for title, pages in {**NAVIGATION, "More": others}.items():
        there = [page for page in pages if (folder / f"{page}.md").exists()]
        if there:
            entries = "\n".join(there)
            index += f"\n```{{toctree}}\n:caption: {title}\n:hidden:\n:maxdepth: 1\n\n{entries}\n```\n"
    site.add("index", index, root / "docs")


main(*(Path(argument).resolve() for argument in sys.argv[1:]))

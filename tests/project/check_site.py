"""The site is whole: check_site.py ROOT SITE

Every link within it leads somewhere, nothing is loaded from elsewhere, every field of a scene is in the reference, and,
where Chromium is there, every equation is set.
"""

import re
import shutil
import subprocess
import sys
from html import unescape
from pathlib import Path
from urllib.parse import unquote, urlsplit

root, site = Path(sys.argv[1]), Path(sys.argv[2]).resolve()
faults = []
LOADED = {("script", "src"), ("img", "src"), ("link", "href"), ("iframe", "src"), ("source", "src"), ("object", "data")}


class Page:
    """The links and anchors of a page. A pattern finds them ten times as fast as a parser, and the generators write no
    tag that it does not know."""

    tag = re.compile(r"<(a|script|img|link|iframe|source|object)\s([^>]*)>")
    link = re.compile(r"""(?:^|\s)(href|src|data)=["']([^"']*)["']""")
    anchor = re.compile(r"""\s(?:id|name)=["']([^"']*)["']""")

    def __init__(self, file):
        text = file.read_text(errors="replace")
        self.anchors = set(self.anchor.findall(text))
        self.links = [
            (tag, unescape(value))
            for tag, attributes in self.tag.findall(text)
            for name, value in self.link.findall(attributes)
            if tag == "a" or (tag, name) in LOADED
        ]


pages = {file: Page(file) for file in site.rglob("*.html")}
if len(pages) < 50:
    faults.append(f"only {len(pages)} pages")
for file, page in pages.items():
    for tag, link in page.links:
        where = f"{file.relative_to(site)}: <{tag}> {link}"
        parts = urlsplit(link)
        if parts.scheme or parts.netloc:
            if tag != "a" and parts.scheme not in ("data", "javascript"):
                faults.append(where + " is loaded from elsewhere")
            continue
        target = (file.parent / unquote(parts.path)).resolve() if parts.path else file
        if not target.is_relative_to(site) or not target.exists():
            faults.append(where + " leads nowhere")
        # Doxygen makes some of its anchors in the browser.
        elif parts.fragment and "interfaces" not in file.relative_to(site).parts and target in pages:
            if unquote(parts.fragment) not in pages[target].anchors:
                faults.append(where + " has no such place")
for style in site.rglob("*.css"):
    for link in re.findall(r"(?:@import\s+|url\()\s*(?:url\()?[\"']?([^\"')\s]+)", style.read_text(errors="replace")):
        if re.match(r"(https?:)?//|/", link):
            faults.append(f"{style.relative_to(site)}: {link} is loaded from elsewhere")

reference = (site / "scene_reference.html").read_text()
sections = dict(re.findall(r'<section id="([^"]+)">(.*?)(?=<section id=|\Z)', reference, re.S))
message = []
fields = 0
for line in (root / "proto" / "scene.proto").read_text().splitlines():
    line = line.split("//")[0].strip()
    begins = re.match(r"(message|enum|oneof) (\w+) \{", line)
    field = re.match(r"(?:(?:optional|repeated|required) )?[\w.]+ (\w+) = \d+", line) or re.match(r"(\w+) = \d+", line)
    if begins:
        message.append(begins[2].lower() if begins[1] != "oneof" else message[-1])
        if "}" in line:
            message.pop()
    elif line == "}":
        message.pop()
    elif field and message:
        fields += 1
        if not re.search(rf">{field[1]}</span>", sections.get(message[-1], "")):
            faults.append(f"the scene reference lacks {message[-1]}.{field[1]}")
if fields < 200:
    faults.append(f"only {fields} fields are found in scene.proto")

browser = shutil.which("chromium")
for file in sorted(site.glob("*.html")) if browser else []:
    expected = len(re.findall(r'class="math[ "]', file.read_text()))
    if not expected:
        continue
    drawn = subprocess.run(
        [browser, "--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=5000", "--dump-dom", f"file://{file}"],
        capture_output=True, text=True, timeout=120,
    ).stdout  # fmt: skip
    wrong = len(re.findall(r'class="katex-error"', drawn))
    if len(re.findall(r'class="katex"', drawn)) != expected or wrong:
        faults.append(f"{file.name}: of {expected} equations {wrong} are wrong, or not all are set")

print("\n".join(faults) or f"{len(pages)} pages, {fields} fields: whole")
sys.exit(bool(faults))

"""The site is whole: check_site.py ROOT SITE

Every link within it leads somewhere, nothing is loaded from elsewhere, every field of a scene is in the reference with a
sentence, and, where Chromium is there, no script fails, every equation is set, and the search finds a page with an excerpt.
"""

import re
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
        elif parts.fragment and target in pages:
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
        within = message[-1] + "-" if message else ""
        message.append(within + begins[2].lower() if begins[1] != "oneof" else message[-1])
        if "}" in line:
            message.pop()
    elif line == "}":
        message.pop()
    elif field and message:
        fields += 1
        row = re.search(rf"<tr[^>]*>\s*<td>(?:(?!</td>).)*>{field[1]}</span>.*?</tr>", sections.get(message[-1], ""), re.S)
        meaning = re.sub("<[^>]*>", "", row[0].rsplit("<td>", 1)[-1]).strip() if row else ""
        if not row:
            faults.append(f"the scene reference lacks {message[-1]}.{field[1]}")
        elif not re.sub(r"^One of \w+[.]", "", meaning).endswith("."):
            faults.append(f"the scene reference has no sentence about {message[-1]}.{field[1]}")
if fields < 200:
    faults.append(f"only {fields} fields are found in scene.proto")


def look(browser):
    """At all pages that Sphinx makes, some of those that Doxygen makes, and a search, as files."""
    shown = [*sorted(site.glob("*.html")), *sorted((site / "files").rglob("*.html"))[:3]]
    shown += [site / "interfaces" / page for page in ("annotated.html", "functions_o.html", "classafferent_1_1Controller.html")]
    for file in shown:
        browser.get(file.as_uri())
        faults.extend(f"{file.name}: {each['message']}" for each in browser.get_log("browser"))
        expected = len(re.findall(r'class="math[ "]', file.read_text()))
        count = "return document.querySelectorAll(arguments[0]).length"
        wrong = browser.execute_script(count, ".katex-error")
        if browser.execute_script(count, ".katex") != expected or wrong:
            faults.append(f"{file.name}: of {expected} equations {wrong} are wrong, or not all are set")
    browser.get((site / "search.html").as_uri() + "?q=refractory")
    found = "return [...document.querySelectorAll('#search-results li')].map(each => each.innerText)"
    until(lambda: "search finished" in browser.find_element("css selector", "#search-results").text.lower(), "the search")
    until(lambda: all("refractory" in each.lower() for each in browser.execute_script(found)), "excerpts of the search")
    if not any(each.startswith("Scene reference") for each in browser.execute_script(found)):
        faults.append("the search for 'refractory' does not find the scene reference")
    faults.extend(f"search: {each['message']}" for each in browser.get_log("browser"))


sys.path.insert(0, str(root / "tests" / "view"))
try:
    from browser import chromium, until

    chrome = chromium()
except SystemExit:  # it has said what is missing
    chrome = None
if chrome:
    try:
        look(chrome)
    finally:
        chrome.quit()
print("\n".join(faults) or f"{len(pages)} pages, {fields} fields: whole")
sys.exit(bool(faults))

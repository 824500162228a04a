"""How a notebook shows things."""

from __future__ import annotations

from html import escape
from typing import Any, Sequence


def preformatted(title: str, text: str) -> str:
    return f"<div><b>{escape(title)}</b><pre>{escape(text)}</pre></div>"


def table(title: str, head: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    def row(cells: Sequence[Any], tag: str) -> str:
        inner = "".join(f'<{tag} style="text-align: left">{escape(str(cell))}</{tag}>' for cell in cells)
        return f"<tr>{inner}</tr>"

    body = "".join(row(cells, "td") for cells in rows)
    return f"<div><b>{escape(title)}</b><table><thead>{row(head, 'th')}</thead><tbody>{body}</tbody></table></div>"

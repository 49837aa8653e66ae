"""HTML of reports, as one file with its pictures inside."""

import base64
from collections.abc import Iterable
from html import escape
from pathlib import Path

from parisph.io.files import failing_as
from parisph.report.entries import Cell, CellTable

STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; color: #222; max-width: 66em; margin: 2em auto; padding: 0 1em; }
h1 { font-size: 1.5em; } h2 { font-size: 1.15em; margin-top: 1.8em; border-bottom: 1px solid #ccc; }
table { border-collapse: collapse; margin: .6em 0; } th, td { padding: .2em .7em; border-bottom: 1px solid #e3e3e3;
text-align: left; vertical-align: top; } th { font-weight: 600; background: #f5f5f5; }
td.number { font-variant-numeric: tabular-nums; } img { max-width: 100%; height: auto; }
figure { margin: .8em 0; } figcaption, .small { color: #555; font-size: .9em; } .warning { color: #a33; }
"""


def page(title: str, parts: Iterable[str]) -> str:
    """Return a whole page. parts : of its body, in HTML"""
    return (f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>{escape(title)}</title>\n'
            f"<style>{STYLE}</style>\n</head>\n<body>\n<h1>{escape(title)}</h1>\n" + "\n".join(parts)
            + "\n</body>\n</html>\n")


def heading(text: str) -> str:
    """Return a heading of a section."""
    return f"<h2>{escape(text)}</h2>"


def paragraph(text: str, kind: str = "") -> str:
    """Return a paragraph. kind : "", "small" or "warning" """
    return f'<p class="{kind}">{escape(text)}</p>' if kind else f"<p>{escape(text)}</p>"


def table(content: CellTable) -> str:
    """Return a table; a cell with a number has its source in data-from and as title."""
    head = "".join(f"<th>{escape(name)}</th>" for name in content.head)
    lines = [f"<tr>{head}</tr>"] if head else []
    lines += ["<tr>" + "".join(map(_cell, row)) + "</tr>" for row in content.rows]
    return "<table>\n" + "\n".join(lines) + "\n</table>"


def _cell(cell: Cell) -> str:
    if not cell.source:
        return f"<td>{escape(cell.text)}</td>"
    source = escape(cell.source)
    return f'<td class="number" data-from="{source}" title="{source}">{escape(cell.text)}</td>'


def picture(path: Path, caption: str) -> str:
    """Return a PNG file as part of a page. Raises StoreError."""
    with failing_as(f"read {path}"):
        data = base64.b64encode(path.read_bytes()).decode("ascii")
    return (f'<figure><img alt="{escape(caption)}" src="data:image/png;base64,{data}">'
            f"<figcaption>{escape(caption)}</figcaption></figure>")


def folded(title: str, part: str) -> str:
    """Return a part of the page (HTML) that opens by a click on its title."""
    return f"<details>\n<summary>{escape(title)}</summary>\n{part}\n</details>"

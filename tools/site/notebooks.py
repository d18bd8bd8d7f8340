"""Notebooks as pages and as tests: their cells run in one process, and what the last line of each gives is shown.

    python tools/site/notebooks.py docs/notebooks/first-look.ipynb

prints what the cells print and the first line of what they show.
"""

from __future__ import annotations

import ast
import base64
import contextlib
import io
import json
import sys
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import Any, NamedTuple


class Cell(NamedTuple):
    """A cell after it was run: its kind ("markdown" or "code"), its source, what it printed, and what it shows."""

    kind: str
    source: str
    printed: str = ""
    shown: Any = None


def cells_of(path: Path) -> list[Cell]:
    """The cells of a notebook, not run."""
    notebook = json.loads(path.read_text(encoding="utf-8"))
    return [Cell(cell["cell_type"], "".join(cell["source"])) for cell in notebook["cells"]]


def run_notebook(path: Path) -> Iterator[Cell]:
    """Run all cells in the present folder; what a cell raises is raised with its number."""
    names: dict[str, Any] = {"__name__": "__main__"}
    for number, cell in enumerate(cells_of(path)):
        if cell.kind != "code":
            yield cell
            continue
        printed = io.StringIO()
        try:
            with contextlib.redirect_stdout(printed):
                shown = _run(cell.source, names, f"{path.name}, cell {number}")
        except Exception as error:
            error.add_note(f"in cell {number} of {path.name}:\n{cell.source}")
            raise
        yield cell._replace(printed=printed.getvalue(), shown=shown)


def _run(source: str, names: dict[str, Any], where: str) -> Any:
    """The value of the last line, where that is an expression without a semicolon behind it."""
    tree = ast.parse(source, where)
    last = tree.body[-1] if tree.body else None
    if not isinstance(last, ast.Expr):
        exec(compile(tree, where, "exec"), names)
        return None
    exec(compile(ast.Module(tree.body[:-1], []), where, "exec"), names)
    value = eval(compile(ast.Expression(last.value), where, "eval"), names)
    return None if source.rstrip().endswith(";") else value


def as_html(value: Any) -> str:
    """What a notebook shows of a value; nothing for None."""
    if value is None:
        return ""
    html = value._repr_html_() if hasattr(value, "_repr_html_") else None
    if html:
        return str(html)
    if hasattr(value, "_repr_png_") or hasattr(value, "savefig"):
        data = base64.b64encode(_png(value)).decode()
        return f'<img style="max-width:100%" alt="figure" src="data:image/png;base64,{data}">'
    return f"<pre>{escape(repr(value))}</pre>"


def _png(figure: Any) -> bytes:
    """A figure of contactlab, or of Matplotlib alone."""
    if hasattr(figure, "_repr_png_"):
        return bytes(figure._repr_png_())
    file = io.BytesIO()
    figure.savefig(file, format="png", bbox_inches="tight")
    return file.getvalue()


def page_of(path: Path) -> str:
    """The notebook, run, as Markdown with HTML in it."""
    parts = []
    for cell in run_notebook(path):
        if cell.kind == "markdown":
            parts.append(cell.source)
            continue
        parts.append(f"```python\n{cell.source}\n```")
        if cell.printed:
            parts.append(f"```text\n{cell.printed.rstrip()}\n```")
        if html := as_html(cell.shown):
            parts.append(f'<div class="shown">{html}</div>')
    return "\n\n".join(parts) + "\n"


def main() -> None:
    """Run notebooks and say what they show."""
    for name in sys.argv[1:]:
        for cell in run_notebook(Path(name).resolve()):
            if cell.kind == "code":
                print(cell.printed + repr(cell.shown).partition("\n")[0])


if __name__ == "__main__":
    main()

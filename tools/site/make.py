"""The pages of the site: those of docs/, and those that are made from the program itself.

    python tools/site/make.py [--without-runs]

writes build/docs, from which mkdocs makes the site. Scenes of the gallery and notebooks are run, so that no picture is
older than what it shows.
"""

from __future__ import annotations

import os
import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks" / "studies"))
sys.path.insert(0, str(Path(__file__).parent))

import pages
from gallery import gallery
from notebooks import page_of

from contactlab.commands.part_page import page_of as part_page
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import bundled_scenes

ROOT = Path(__file__).parents[2]
PAGES = ROOT / "build" / "docs"
PYTHON = {
    "Scenes": ["contactlab.scene.scene.load_scene", "contactlab.scene.scene.Scene"],
    "Runs": ["contactlab.run.simulation.simulate", "contactlab.results.load.load_results",
             "contactlab.results.results.Results", "contactlab.results.results.ContactHistory",
             "contactlab.api.frame.ContactCurve", "contactlab.api.frame.Frame"],
    "Comparisons": ["contactlab.comparison.compare", "contactlab.studies.table.Table", "contactlab.studies.table.Row"],
    "Errors": ["contactlab.errors.ContactlabError", "contactlab.errors.RequestError",
               "contactlab.run.interruption.Interrupted"],
}  # fmt: skip
CONTRACT = ("part", "mesh", "element", "material", "contact", "friction", "enforcement", "integrator", "effect",
            "function", "profile", "recorder", "watch", "case", "measure", "reference", "surface", "record",
            "frame", "state", "warning")  # fmt: skip


def main(runs: bool = True) -> None:
    """Write all pages anew."""
    shutil.rmtree(PAGES, ignore_errors=True)
    shutil.copytree(ROOT / "docs", PAGES)
    pages.build(PAGES)
    for name in ("site.css", "iframe-worker.js"):
        shutil.copy(ROOT / "tools" / "site" / name, PAGES)
    (PAGES / "index.md").write_text(home((ROOT / "README.md").read_text(encoding="utf-8")), encoding="utf-8")
    (PAGES / "contributing.md").write_text(
        home((ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")), encoding="utf-8"
    )
    (PAGES / "reference").mkdir()
    (PAGES / "reference" / "python.md").write_text(python_page(), encoding="utf-8")
    (PAGES / "reference" / "contract.md").write_text(contract_page(), encoding="utf-8")
    (PAGES / "reference" / "parts.md").write_text(parts_page(), encoding="utf-8")
    shown = list(bundled_scenes()), default_registry().names("case")
    (PAGES / "gallery.md").write_text(gallery(PAGES / "pictures" / "gallery", runs, *shown), encoding="utf-8")
    _notebook_pages(runs)


def home(text: str) -> str:
    """A page of the top of the repository as one of the site: links lead to where their pages are there."""
    text = text.replace("](docs/notebooks)", "](tutorials/first-look.md)")
    text = re.sub(r"\]\(docs/", "](", text)
    return re.sub(r"\[([^\]]*)\]\((?:LICENSE|CODE_OF_CONDUCT\.md)\)", r"\1", text)


def python_page() -> str:
    """What `import contactlab` gives."""
    one = "::: {}\n    options:\n      show_root_full_path: false".format
    parts = [f"## {title}\n\n" + "\n\n".join(map(one, names)) for title, names in PYTHON.items()]
    return "# Python\n\n" + "\n\n".join(parts) + "\n"


def contract_page() -> str:
    """What authors of parts import."""
    return "# The contract of parts\n\n" + "\n\n".join(f"::: contactlab.api.{name}" for name in CONTRACT) + "\n"


def parts_page() -> str:
    """Every installed part that a scene can name, as `contactlab parts NAME` tells it."""
    registry = default_registry()
    kinds: dict[str, list[str]] = {}
    for offer in registry.parts():
        if offer.part.kind not in ("watch", "case", "measure", "reference"):
            kinds.setdefault(offer.part.kind, []).append(_part(part_page(offer, registry)))
    return "# Parts\n\n" + "\n\n".join(f"## {kind}\n\n" + "\n\n".join(parts) for kind, parts in kinds.items()) + "\n"


def _part(page: dict[str, Any]) -> str:
    lines = [f"### {page['name']}", f"{page['summary']}. *{page['distribution']}*", page["says"]]
    if page["fields"]:
        rows = ["| field | default | unit | meaning |", "|---|---|---|---|"]
        rows += [
            "| "
            + " | ".join(str(f[name]).replace("|", "\\|") for name in ("name", "default", "unit", "meaning"))
            + " |"
            for f in page["fields"]
        ]
        lines.append("\n".join(rows))
    if page["example"]:
        lines.append(f"```toml\n{page['example']}\n```")
    return "\n\n".join(line for line in lines if line)


def _notebook_pages(runs: bool) -> None:
    """The notebooks as tutorials, run here."""
    before = Path.cwd()
    for path in sorted((ROOT / "docs" / "notebooks").glob("*.ipynb")):
        place = ROOT / "build" / "notebooks" / path.stem
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir(parents=True)
        os.chdir(place)
        try:
            text = page_of(path) if runs else "\n\n".join(_sources(path))
        finally:
            os.chdir(before)
        title, _, rest = text.partition("\n")
        link = f"[This page as a notebook](../notebooks/{path.name})"
        (PAGES / "tutorials" / f"{path.stem}.md").write_text(f"{title}\n\n{link}\n{rest}", encoding="utf-8")


def _sources(path: Path) -> Iterator[str]:
    from notebooks import cells_of

    for cell in cells_of(path):
        yield cell.source if cell.kind == "markdown" else f"```python\n{cell.source}\n```"


if __name__ == "__main__":
    main("--without-runs" not in sys.argv)

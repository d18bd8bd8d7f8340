"""The page of a matrix in a real browser: filters leave what they name, heads sort, a cell shows its numbers."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from contactlab.cli import main

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
pytestmark = [pytest.mark.full, pytest.mark.skipif(BROWSER is None, reason="no Chromium here")]

ASK = """<script>
const lines = () => [...document.querySelectorAll("#map table > tr")].map(
  row => [...row.children].map(place => place.textContent));
const choose = (name, value) => {
  const choice = document.querySelector(`select[name=${name}]`);
  choice.value = value; choice.dispatchEvent(new Event("change"));
};
const heads = () => [...document.querySelectorAll("#map thead th")];
const sortBy = name => heads().find(head => head.textContent === name).click();
const seen = {heads: heads().map(head => head.textContent), all: lines()};
sortBy("node-on-segment"); seen.worst = lines();
sortBy("case"); seen.case = lines();
choose("case", "two-bars"); seen.filtered = lines();
choose("contact", "mortar-p1"); seen.alone = heads().map(head => head.textContent);
choose("case", ""); choose("contact", ""); choose("verdict", "silent");
seen.silent = lines(); seen.counts = document.getElementById("counts").textContent;
document.querySelector("button.cell").click();
seen.detail = document.getElementById("detail").innerText;
seen.links = [...document.querySelectorAll("#detail a")].map(link => link.getAttribute("href"));
document.body.replaceChildren(); document.body.append(JSON.stringify(seen));
</script>"""


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A matrix of two cases, one of which an algorithm answers wrongly."""
    folder = tmp_path_factory.mktemp("page") / "matrix"
    words = ["two-bars", "patch", "--contact", "mortar-p1", "--contact", "node-on-segment"]
    assert main(["matrix", *words, "--out", str(folder)]) == 0
    return folder


@pytest.fixture(scope="module")
def seen(made: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What the browser shows after each click."""
    page = (made / "matrix.html").read_text(encoding="utf-8").replace("</main>", f"</main>{ASK}")
    asked = tmp_path_factory.mktemp("browser") / "asked.html"
    asked.write_text(page, encoding="utf-8")
    command = [str(BROWSER), "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={asked.parent}/user"]
    out = subprocess.run([*command, "--dump-dom", asked.as_uri()], capture_output=True, text=True, check=True).stdout
    body = out.split("<body>")[1].split("</body>")[0]
    found: dict[str, Any] = json.loads(body.replace("&amp;", "&").replace("&lt;", "<").replace("&gt;", ">"))
    return found


def test_every_cell_is_on_the_page(seen: dict[str, Any]) -> None:
    assert seen["heads"] == ["case", "variant", "slave", "element", "integrator", "mortar-p1", "node-on-segment"]
    assert sorted(line[0] for line in seen["all"]) == ["patch", "two-bars"]


def test_a_head_sorts(seen: dict[str, Any]) -> None:
    assert [line[-1].split()[0] for line in seen["worst"]] == ["silent", "met"]  # the worst first
    assert [line[0] for line in seen["case"]] == ["patch", "two-bars"]


def test_filters_leave_what_they_name(seen: dict[str, Any]) -> None:
    assert [line[0] for line in seen["filtered"]] == ["two-bars"]
    assert seen["alone"][-1] == "mortar-p1"
    assert [(line[0], line[-1].split()[0]) for line in seen["silent"]] == [("patch", "silent")]
    assert "1 silent" in seen["counts"]
    assert seen["counts"].endswith("of 1 cells")


def test_a_cell_has_the_value_of_the_measure_behind_its_verdict(seen: dict[str, Any], made: Path) -> None:
    cells = json.loads((made / "matrix.json").read_text(encoding="utf-8"))["cells"]
    (wrong,) = (cell for cell in cells if cell["verdict"] == "silent")
    number = next(m["value"] for m in wrong["measures"] if m["verdict"] == "silent" and m["role"] == "error")
    assert float(seen["silent"][0][-1].split()[1]) == float(f"{number:.2g}")


def test_a_cell_leads_to_its_numbers_and_scenes(seen: dict[str, Any], made: Path) -> None:
    assert "stress" in seen["detail"]
    assert "patch, node-on-segment, declared" in seen["detail"]
    assert seen["links"]
    assert all((made / link).is_file() for link in seen["links"])

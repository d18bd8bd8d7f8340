"""`contactlab new-plugin` writes a package of each kind; test_strangers.py builds, installs and runs them."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from pathlib import Path

import pytest
from tiers import some

from contactlab.api import ContactAlgorithm, Potential
from contactlab.api.part import KINDS
from contactlab.cli import main
from contactlab.commands.new_plugin import WAYS, plugin_files
from contactlab.errors import RequestError
from contactlab.testing.examples import USUAL
from contactlab.testing.run import checks_for


@pytest.mark.parametrize("kind", KINDS)
def test_a_package_has_what_a_release_needs(kind: str) -> None:
    files = plugin_files(kind, f"own-{kind}", with_ci=True)
    module = f"own_{kind}"
    assert set(files) == {
        "pyproject.toml", "README.md", "LICENSE", "CITATION.cff", ".github/workflows/checks.yml",
        f"src/{module}/__init__.py", f"src/{module}/plugin.py", f"src/{module}/{kind}.py", f"src/{module}/py.typed",
        f"tests/test_{module}.py",
    }  # fmt: skip
    assert not [name for name, text in files.items() if re.search(r"\$\w", text)]
    project = tomllib.loads(files["pyproject.toml"])
    assert project["project"]["entry-points"]["contactlab"] == {f"own-{kind}": f"{module}.plugin"}
    assert "## Cite" in files["README.md"]
    assert f"contactlab check own-{kind} --kind {kind}" in files[".github/workflows/checks.yml"]
    assert not [name for name in plugin_files(kind, f"own-{kind}") if "workflows" in name]


@pytest.mark.parametrize("kind", KINDS)
def test_a_part_is_short_and_plain(kind: str) -> None:
    """NumPy, the standard library and the contract are all it imports; a class with a page's length of code."""
    source = plugin_files(kind, f"own-{kind}")[f"src/own_{kind}/{kind}.py"]
    tree = ast.parse(source)
    imports = {node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    imports |= {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    foreign = {name for name in imports if name.split(".")[0] not in {*sys.stdlib_module_names, "numpy"}}
    assert foreign <= {"contactlab.api", "contactlab.api.case", "contactlab.api.meshing"}
    assert 15 <= len([line for line in source.splitlines() if line.strip()]) <= 80


@pytest.mark.parametrize("kind", KINDS)
def test_a_part_can_be_checked_as_it_is_written(kind: str) -> None:
    """`contactlab check` knows a usual value for every field of it, or it would try one that may not suit."""
    tree = ast.parse(plugin_files(kind, f"own-{kind}")[f"src/own_{kind}/{kind}.py"])
    fields = [node for own in ast.walk(tree) if isinstance(own, ast.ClassDef) for node in own.body]
    required = {
        field.target.id
        for field in fields
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and field.value is None
    }
    assert required <= USUAL.keys()


@pytest.mark.parametrize(
    ("kind", "name", "word"),
    [
        ("contacts", "my-contact", 'did you mean "contact"'),
        ("contact", "MyContact", "lower-case words"),
        ("contact", "json", "keyword or module of Python"),
        ("contact", "class", "keyword or module of Python"),
        ("contact", "contact-algorithm", "as one of contactlab.api"),
    ],
)
def test_what_cannot_be_a_package_is_refused(kind: str, name: str, word: str) -> None:
    with pytest.raises(RequestError, match=word):
        plugin_files(kind, name)


@pytest.mark.parametrize(("name", "word"), [("mortar-p1", "of this name, from"), ("numpy", "would hide it")])
def test_names_that_are_taken_are_refused(
    name: str, word: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new-plugin", "contact", name]) == 2
    assert word in capsys.readouterr().err
    assert not [*tmp_path.iterdir()]


def test_an_existing_folder_is_left_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own-mesh").mkdir()
    assert main(["new-plugin", "mesh", "own-mesh"]) == 2
    assert "the folder exists already" in capsys.readouterr().err
    assert not [*(tmp_path / "own-mesh").iterdir()]


@pytest.mark.parametrize("start", some(WAYS["contact"], ["mortar", "rows", "potential"]))
def test_contacts_of_every_way_pass_their_checks(
    start: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Unit checks as `contactlab check` makes them; formulas as plain Python, each of whose lines runs."""
    source = plugin_files("contact", f"own-{start}", start=start)[f"src/own_{start.replace('-', '_')}/contact.py"]
    name, part = f"own_{start}_alone".replace("-", "_"), "Own" + "".join(map(str.capitalize, start.split("-")))
    hook = f'return [Part("contact", "own-{start}", "{name}:{part}", "as it is written")]'
    file = tmp_path / f"{name}.py"
    file.write_text(
        f"{source}\n\nfrom contactlab.api.plugin import Part, hookimpl\n\n\n"
        f"@hookimpl\ndef contactlab_parts():\n    {hook}\n"
    )
    kind = Potential if start in ("energy", "potential") else ContactAlgorithm
    units = [word for check in checks_for("contact", kind) for word in ("--only", check.__name__)]
    python = [] if start in ("rows", "potential") else ["--python"]
    assert main(["check", str(file), *units, *python]) == 0
    said = capsys.readouterr().out
    assert "0 failed" in said
    if python:
        assert f"{name}.py:" not in said
        assert len([line for line in source.splitlines() if line.strip()]) <= 40


def test_a_way_that_there_is_not_is_refused() -> None:
    for kind, start in (("contact", "mortars"), ("material", "mortar")):
        with pytest.raises(RequestError, match="no such way"):
            plugin_files(kind, "own", start=start)

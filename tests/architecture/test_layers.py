"""The house: data flows one way, the core names no plugin, plugins see the contract alone."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from collections.abc import Iterable, Iterator
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

from contactlab.parts.registry import default_registry

ROOT = Path(__file__).parents[2]
CORE = ROOT / "src" / "contactlab"

# lowest first; a module may import from its own layer and from those below it
LAYERS = (
    ("errors", "outside_files", "arguments"),
    ("api", "views"),
    ("formulas", "implicit", "kernels", "meshing"),
    ("contact", "parts", "scene"),
    ("model",),
    ("results",),
    ("missing_effects",),
    ("run",),
    ("jobs",),
    ("explanation", "studies"),
    ("cases",),
    ("accuracy", "verdicts"),
    ("reports",),
    ("comparison",),
    ("testing", "commands", "laboratory", "cli", "__main__"),
)


# modules that a run may not need, or not the start of the program, and that shared files name in annotations
OPTIONAL = {
    # a scene without contact
    "contact.explicit_system", "contact.implicit_system", "contact.pair", "contact.potential_pair",
    "contact.work_split", "results.contact_report", "results.contact_sampler",
    "model.implicit_model", "run.nested",  # explicit steps
    "results.checkpoint_slots", "results.iterate_sampler", "results.record_plan", "results.steps", "run.last_steps",
    "api.drawing.units", "jobs.driver", "reports.terminal", "run.simulation",
}  # fmt: skip


@cache
def modules() -> dict[str, Path]:
    """All modules of the core by dotted name; the package itself is only a lazy front."""
    found = {}
    for path in sorted(CORE.rglob("*.py")):
        parts = path.relative_to(CORE).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        if name:
            found[name] = path
    return found


def layer(module: str) -> int:
    """Number of the layer with the longest matching name."""
    matches = [
        (len(name), number)
        for number, names in enumerate(LAYERS)
        for name in names
        if module == name or module.startswith(f"{name}.")
    ]
    assert matches, f"{module} has no layer: give it one in this test and in the design"
    return max(matches)[1]


@cache
def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


@cache
def imports(path: Path, everywhere: bool = True) -> tuple[str, ...]:
    """Modules that a file imports, also for annotations alone; without `everywhere` none that functions import."""
    return tuple(_imports(tree_of(path), everywhere))


def _imports(tree: ast.AST, everywhere: bool) -> Iterator[str]:
    pending = [tree]
    while pending:
        node = pending.pop()
        if isinstance(node, ast.FunctionDef) and not everywhere:
            continue
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        pending += (child for child in ast.iter_child_nodes(node) if not isinstance(child, ast.expr))


def core_imports(path: Path, everywhere: bool = True) -> set[str]:
    """Imported modules of the core, without the leading package name."""
    return of_core(imports(path, everywhere))


def of_core(imported: Iterable[str]) -> set[str]:
    """Modules of the core among imported names, without the leading package name."""
    known = modules()
    found = set()
    for name in imported:
        parts = name.split(".")
        if parts[0] != "contactlab":
            continue
        names = [".".join(parts[1:end]) for end in range(len(parts), 1, -1)]
        found |= {next((name for name in names if name in known), "")} - {""}
    return found


def test_modules_import_from_their_own_layer_and_below() -> None:
    above = [
        f"{module} (layer {layer(module)}) imports {other}"
        for module, path in modules().items()
        for other in core_imports(path)
        if layer(other) > layer(module)
    ]
    assert not above


def test_there_is_no_import_cycle() -> None:
    """Not by annotations either: each module is understood without those that need it."""
    graph = {module: core_imports(path, everywhere=False) - {module} for module, path in modules().items()}
    assert len(list(TopologicalSorter(graph).static_order())) == len(graph)


def test_what_is_named_in_annotations_is_imported() -> None:
    """Except what is optional: then the guard says so. A trial run measures what all imports take."""
    guards = [
        node
        for module, path in modules().items()
        if module != "explanation.trial_run"
        for node in ast.walk(tree_of(path))
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)
    ]
    assert set().union(*(of_core(_imports(node, everywhere=True)) for node in guards)) == OPTIONAL


def plugin_files() -> list[Path]:
    return sorted((ROOT / "plugins").glob("*/src/**/*.py"))


def test_plugins_import_the_contract_alone() -> None:
    """And of the contract no tables that the core binds: kernels of plugins take arrays, or `Rows`."""
    bound = tuple(f"contactlab.api.compiled.{name}" for name in ("bound_arrays", "contact_tables", "unpack"))
    wrong = []
    for path in plugin_files():
        for name in imports(path):
            package = name.split(".")[0]
            inside = package == "contactlab" and (not name.startswith("contactlab.api.") or name.startswith(bound))
            if inside or (package.startswith("contactlab_") and package not in path.parts):
                wrong.append(f"{path.name} imports {name}")
    assert not wrong


def test_there_are_plugins() -> None:
    assert len({path.relative_to(ROOT / "plugins").parts[0] for path in plugin_files()}) >= 5


def test_the_core_names_no_plugin() -> None:
    """Neither a module of a plugin nor, outside docstrings, a part that a plugin brings."""
    offers = [o for o in default_registry().parts() if o.origin.distribution != "contactlab"]
    # a case may be called like a bundled scene, which is the core's own
    parts = {o.part.name for o in offers if o.part.kind != "case"}
    packages = {path.name.replace("-", "_") for path in (ROOT / "plugins").glob("contactlab-*")}
    wrong = []
    for module, path in modules().items():
        named = {text for text in texts(tree_of(path)) if text in parts or any(name in text for name in packages)}
        named |= {name for name in imports(path) if name.split(".")[0] in packages}
        wrong += [f"{module}: {name}" for name in named]
    assert not wrong


def texts(tree: ast.Module) -> set[str]:
    """Strings of a module, without its docstrings."""
    nodes = list(ast.walk(tree))
    docstrings = {
        id(node.value) for node in nodes if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    }
    return {
        node.value
        for node in nodes
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docstrings
    }


def loaded_by(code: str) -> set[str]:
    """Top-level modules outside the standard library that `code` brings into a fresh interpreter."""
    report = "import sys, json; print(json.dumps(sorted({name.split('.')[0] for name in sys.modules})))"
    found = []
    for program in (report, f"{code}\n{report}"):
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
        found.append(set(json.loads(done.stdout.splitlines()[-1])))
    return found[1] - found[0] - set(sys.stdlib_module_names)


def test_the_contract_imports_numpy_alone() -> None:
    assert loaded_by("import contactlab.api") == {"contactlab", "numpy"}


def test_an_entry_module_imports_pluggy_and_the_contract_alone() -> None:
    assert loaded_by("import contactlab.api.plugin") == {"contactlab", "numpy", "pluggy"}


def test_help_imports_nothing_heavy() -> None:
    program = "import contactlab.cli\ntry: contactlab.cli.main(['--help'])\nexcept SystemExit: pass"
    assert loaded_by(program) == {"contactlab"}


def test_listing_parts_imports_no_target() -> None:
    """Entry modules are light: what they offer is known without numba or any kernel."""
    loaded = loaded_by("from contactlab.parts.registry import Registry\nassert Registry().parts()")
    assert not loaded & {"numba", "scipy", "matplotlib", "rich"}


def test_a_scene_without_contact_imports_no_contact_part() -> None:
    code = (
        "from contactlab.scene.scene import load_scene\n"
        "load_scene('disc-on-block').with_({'contacts': []})\n"
        "import sys; assert 'contactlab_mortar.mortar' in sys.modules\n"
        "assert 'contactlab_segments.node_on_segment' not in sys.modules"
    )
    assert "contactlab_segments" in loaded_by(code), "its entry module is loaded, its target is not"

"""The registry: parts are found, checked when they are asked for, and broken plugins stop nothing else."""

from __future__ import annotations

import json
import pickle
import sys
from collections.abc import Callable
from pathlib import Path
from typing import ClassVar

import pytest

from contactlab.cli import main
from contactlab.commands.arguments import COMMANDS
from contactlab.commands.doctor import _plugins as plugin_facts
from contactlab.errors import PartError, RequestError, SceneError
from contactlab.parts.loading import Broken
from contactlab.parts.registry import Registry
from contactlab.parts.scenes_and_commands import CORE_COMMANDS

Install = Callable[..., None]
HEAD = "from contactlab.api.plugin import Part, hookimpl\n"

GOOD = f"""
{HEAD}
from dataclasses import dataclass
from contactlab.api import FrictionBound, FrictionLaw

@dataclass(frozen=True)
class Coulomb(FrictionLaw):
    mu: float
    cap: float = float("inf")
    name: str = "dry"

    def bound(self):
        return FrictionBound(self.mu, 0.0, self.cap)

@hookimpl
def contactlab_parts():
    return [Part("friction", "test-coulomb", "good_plugin:Coulomb", "for tests")]
"""


def offers(part: str) -> str:
    return f"{HEAD}\n@hookimpl\ndef contactlab_parts():\n    return [{part}]\n"


def only(registry: Registry, distribution: str) -> Broken:
    found = [item for item in registry.broken() if item.origin.distribution == distribution]
    assert len(found) == 1, found
    return found[0]


@pytest.fixture
def good(install: Install) -> None:
    install("good-plugin", GOOD)


def assert_rest_works(registry: Registry) -> None:
    assert registry.make("friction", {"use": "test-coulomb", "mu": 0.2}).bound().coefficient == 0.2
    assert {"mortar-p0", "mortar-p1", "node-on-segment"} <= set(registry.names("contact"))


BROKEN = {
    "import error": ("import no_such_module\n", "no_such_module"),
    "syntax error": ("def (:\n", "SyntaxError"),
    "exit on import": ("raise SystemExit(3)\n", "SystemExit"),
    "misspelt hook": (f"{HEAD}\n@hookimpl\ndef contactlab_part():\n    return []\n", '"contactlab_parts"'),
    "hook without marker": ("def contactlab_parts():\n    return []\n", "@hookimpl"),
    "no hook": ("x = 1\n", "no hook"),
    "wrong argument": (f"{HEAD}\n@hookimpl\ndef contactlab_parts(scene):\n    return []\n", "scene"),
    "exception in the hook": (f"{HEAD}\n@hookimpl\ndef contactlab_parts():\n    raise KeyError('odd')\n", "odd"),
    "no list": (f"{HEAD}\n@hookimpl\ndef contactlab_parts():\n    return 7\n", "int"),
    "no parts": (offers("'mortar'"), "str"),
    "other contract": (offers("Part('friction', 'x', 'a:B', 's', api=99)"), "version 99"),
    "unknown kind": (offers("Part('frictoin', 'x', 'a:B', 's')"), '"friction"'),
    "name with capitals": (offers("Part('friction', 'MyLaw', 'a:B', 's')"), "MyLaw"),
    "target without class": (offers("Part('friction', 'x', 'a.B', 's')"), "package.module:ClassName"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_plugin_is_named_with_its_reason_and_stops_nothing_else(
    name: str, good: None, install: Install
) -> None:
    source, reason = BROKEN[name]
    install("bad-plugin", source)
    registry = Registry()
    broken = only(registry, "bad-plugin")
    assert broken.origin.version == "1.0"
    assert reason in broken.reason
    assert "\n" not in broken.reason.replace("\n  ", "")
    assert_rest_works(registry)


def test_other_parts_of_a_plugin_with_one_bad_part_work(install: Install) -> None:
    install("good-plugin", GOOD.replace("return [", "return [Part('friction', 'old', 'a:B', 's', api=0), "))
    registry = Registry()
    assert only(registry, "good-plugin").item == "friction old"
    assert "test-coulomb" in registry.names("friction")


def test_two_parts_of_one_name_are_an_error_naming_both_distributions(good: None, install: Install) -> None:
    install("twin-plugin", offers("Part('friction', 'test-coulomb', 'twin_plugin:Coulomb', 's')"), version="2.3")
    registry = Registry()
    assert "test-coulomb" not in registry.names("friction")
    for distribution in ("good-plugin", "twin-plugin"):
        reason = only(registry, distribution).reason
        assert "good-plugin 1.0" in reason
        assert "twin-plugin 2.3" in reason
    with pytest.raises(PartError, match=r"good-plugin 1\.0.*twin-plugin 2\.3"):
        registry.make("friction", "test-coulomb")
    assert "mortar-p0" in registry.names("contact")


INCOMPLETE = {
    "no method": ("class Law(FrictionLaw):\n    mu: float = 0.1\n", "friction", "bound"),
    "no class attribute": (
        "class Law(Material):\n    density: float\n"
        "    def stress(self, *a): ...\n    def wave_speeds(self): ...\n",
        "material",
        "kinematics",
    ),
    "no field": (
        "class Law(Material):\n    kinematics = 'small'\n"
        "    def stress(self, *a): ...\n    def wave_speeds(self): ...\n",
        "material",
        "density",
    ),
    "other kind": ("class Law(FrictionLaw):\n    def bound(self): ...\n", "material", "contactlab.api.Material"),
}  # fmt: skip


@pytest.mark.parametrize("name", INCOMPLETE)
def test_an_incomplete_class_is_refused_by_what_is_missing(name: str, good: None, install: Install) -> None:
    body, kind, missing = INCOMPLETE[name]
    source = "from dataclasses import dataclass\nfrom contactlab.api import FrictionLaw, Material\n"
    source += f"@dataclass(frozen=True)\n{body}" + offers(f"Part('{kind}', 'half', 'half_plugin:Law', 's')")
    install("half-plugin", source)
    registry = Registry()
    assert any(missing in item.reason for item in registry.incomplete() if item.origin.plugin == "half-plugin")
    with pytest.raises(PartError, match=missing):
        registry.part_class(kind, "half", "materials.steel")
    assert_rest_works(registry)


@pytest.mark.parametrize(
    ("decorator", "reason"), [("", "not a dataclass"), ("@dataclass\n", "not frozen")], ids=["plain", "mutable"]
)
def test_a_part_must_be_a_frozen_dataclass(decorator: str, reason: str, install: Install) -> None:
    body = "from dataclasses import dataclass\nfrom contactlab.api import FrictionLaw\n"
    body += f"{decorator}class Law(FrictionLaw):\n    def bound(self): ...\n"
    install("half-plugin", body + offers("Part('friction', 'half', 'half_plugin:Law', 's')"))
    with pytest.raises(PartError, match=reason):
        Registry().part_class("friction", "half")


@pytest.mark.parametrize(
    ("target", "reason"),
    [("no_such_module:Law", "cannot be imported"), ("json:Law", "json has no Law"), ("json:dumps", "not a class")],
)
def test_a_target_that_is_not_there_is_told_when_it_is_asked_for(target: str, reason: str, install: Install) -> None:
    install("far-plugin", offers(f"Part('friction', 'far', '{target}', 's')"))
    registry = Registry()
    assert not [item for item in registry.broken() if item.origin.distribution == "far-plugin"]
    with pytest.raises(PartError, match=reason) as caught:
        registry.make("friction", "far", "contacts.0.friction")
    assert "contacts.0.friction" in str(caught.value)
    assert "far-plugin 1.0" in str(caught.value)


def test_parts_command_names_what_is_broken(
    good: None, install: Install, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("contactlab.commands.common.default_registry", Registry)
    install("bad-plugin", "import no_such_module\n")
    half = "from dataclasses import dataclass\nfrom contactlab.api import FrictionLaw\n"
    half += "@dataclass(frozen=True)\nclass Law(FrictionLaw):\n    pass\n"
    install("half-plugin", half + offers("Part('friction', 'half', 'half_plugin:Law', 's')"))
    assert main(["parts"]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "no_such_module" in shown
    assert "it has no bound" in shown
    assert main(["parts", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    named = {(part["kind"], part["name"]): part for part in listed["parts"]}
    assert named["friction", "test-coulomb"]["distribution"] == "good-plugin"
    assert named["friction", "test-coulomb"]["version"] == "1.0"
    assert ("friction", "half") not in named
    assert {item["distribution"] for item in listed["broken"]} == {"bad-plugin", "half-plugin"}


class TestRestriction:
    def test_only_named_plugins_and_the_core_are_loaded(self, good: None, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("CONTACTLAB_PLUGINS", "good_plugin, mortar")
        registry = Registry()
        assert {offer.origin.distribution for offer in registry.parts()} == {
            "contactlab",
            "contactlab-mortar",
            "good-plugin",
        }

    def test_an_unknown_name_is_refused_with_the_nearest(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("CONTACTLAB_PLUGINS", "mortr")
        with pytest.raises(RequestError, match="no such plugin") as caught:
            Registry()
        assert "CONTACTLAB_PLUGINS" in str(caught.value)
        assert 'did you mean "mortar"' in str(caught.value)


class TestFiles:
    SOURCE = GOOD.replace("good_plugin:", "my_part:")

    def test_a_file_offers_parts_that_live_in_it(self, tmp_path: Path) -> None:
        path = tmp_path / "my_part.py"
        path.write_text(self.SOURCE)
        registry = Registry(files=[path])
        try:
            made = registry.make("friction", {"use": "test-coulomb", "mu": 0.3})
            assert made.bound().coefficient == 0.3
            assert registry.offer("friction", "test-coulomb").origin.distribution == str(path)
            registry.add_file(path)
            assert registry.names("friction").count("test-coulomb") == 1
            again = pickle.loads(pickle.dumps(registry))
            assert "test-coulomb" in again.names("friction")
        finally:
            sys.modules.pop("my_part", None)

    @pytest.mark.parametrize(
        ("name", "source", "reason"),
        [
            ("absent.py", None, "no such file"),
            ("part.txt", "", "not a Python file"),
            ("json.py", SOURCE, r"another module has this name\n.*used by .*json/__init__\.py"),
            ("numpy.py", SOURCE, "another module has this name"),
            ("sys.py", SOURCE, "used by the interpreter"),
            ("my_part.py", "x = 1\ny = 1/0\n", r"ZeroDivisionError.*line 2"),
            ("my_part.py", "x = 1\n", "no hook"),
            ("my_part.py", f"{HEAD}\n@hookimpl\ndef contactlab_part(): return []\n", "contactlab_parts"),
        ],
    )
    def test_a_file_that_offers_nothing_is_refused(
        self, name: str, source: str | None, reason: str, tmp_path: Path
    ) -> None:
        path = tmp_path / name
        if source is not None:
            path.write_text(source)
        with pytest.raises(PartError, match=reason) as caught:
            Registry(files=[path])
        assert name in str(caught.value)
        assert "my_part" not in sys.modules or sys.modules.pop("my_part")

    MANY = f"""
{HEAD}
from dataclasses import dataclass
from contactlab.api import FrictionLaw

@dataclass(frozen=True)
class Half(FrictionLaw):
    mu: float

@hookimpl
def contactlab_parts():
    return [
        Part("friction", "Law", "my_part.Law", "two faults in one part"),
        Part("frictoin", "law", "my_part:Law", "no such kind"),
        Part("friction", "half", "my_part:Half", "no bound"),
        Part("contact", "mortar-p0", "my_part:Half", "a name that is taken"),
    ]

@hookimpl
def contactlab_scenes():
    return {{"gone": "/no/such/gone.toml", "disc-on-block": __file__}}

@hookimpl
def contactlab_commands():
    return {{"run": "my_part:run"}}
"""

    def test_every_fault_of_a_file_is_told_at_once(self, tmp_path: Path) -> None:
        path = tmp_path / "my_part.py"
        path.write_text(self.MANY)
        with pytest.raises(PartError) as caught:
            Registry(files=[path])
        sys.modules.pop("my_part")
        first, *rest = str(caught.value).splitlines()
        assert "my_part.py: 7 errors" in first
        expected = [
            ("friction Law", "lower-case", "package.module:ClassName"),
            ("frictoin law", 'did you mean "friction"'),
            ("contact mortar-p0", "more than once", "contactlab-mortar"),
            ("scene gone", "/no/such/gone.toml"),
            ("scene disc-on-block", "the core has a scene"),
            ("command run", "the core has a command"),
            ("friction half", "it has no bound"),
        ]
        assert len(rest) == len(expected)
        for line, words in zip(rest, expected, strict=True):
            assert all(word in line for word in words), line

    def test_every_incomplete_class_of_a_file_is_told_where_one_is_asked_for(self, tmp_path: Path) -> None:
        """The file is loaded all the same, so that its parts can be checked."""
        path = tmp_path / "my_part.py"
        text = f"{HEAD}\nfrom dataclasses import dataclass\nfrom contactlab.api import FrictionLaw\n"
        text += "".join(f"@dataclass(frozen=True)\nclass {name}(FrictionLaw):\n    mu: float\n" for name in "AB")
        parts = "Part('friction', 'a', 'my_part:A', 's'), Part('friction', 'b', 'my_part:B', 's')"
        path.write_text(f"{text}\n@hookimpl\ndef contactlab_parts():\n    return [{parts}]\n")
        registry = Registry(files=[path])
        with pytest.raises(PartError) as caught:
            registry.part_class("friction", "b")
        sys.modules.pop("my_part")
        assert "the friction b cannot be used" in str(caught.value)
        assert "also its friction a: my_part:A is incomplete: it has no bound" in str(caught.value)

    def test_every_wrong_hook_of_a_file_is_told_at_once(self, tmp_path: Path) -> None:
        path = tmp_path / "my_part.py"
        hooks = "@hookimpl\ndef contactlab_part():\n    return []\n\n"
        hooks += "@hookimpl\ndef contactlab_scenes(folder):\n    return {}\n\n"
        hooks += "@hookimpl\ndef contactlab_commands(words):\n    return {}\n\n"
        path.write_text(f"{HEAD}\n{hooks}def contactlab_run_finished(summary):\n    pass\n")
        with pytest.raises(PartError) as caught:
            Registry(files=[path])
        sys.modules.pop("my_part")
        for words in ("unknown hook contactlab_part;", "folder", "words", "contactlab_run_finished is not marked"):
            assert words in str(caught.value)

    def test_a_refused_file_leaves_no_trace(self, tmp_path: Path) -> None:
        path = tmp_path / "my_part.py"
        path.write_text(self.MANY)
        registry = Registry()
        before = registry.parts()
        with pytest.raises(PartError):
            registry.add_file(path)
        assert registry.parts() == before
        assert registry.broken() == []
        path.write_text(self.SOURCE)  # mended
        registry.add_file(path)
        sys.modules.pop("my_part")
        assert "test-coulomb" in registry.names("friction")


class TestMake:
    @pytest.fixture
    def registry(self, good: None) -> Registry:
        return Registry()

    def test_written_out_has_every_default(self, registry: Registry) -> None:
        written = registry.written_out("friction", {"use": "test-coulomb", "mu": 1})
        assert written == {"use": "test-coulomb", "mu": 1.0, "cap": float("inf"), "name": "dry"}
        assert isinstance(written["mu"], float)
        assert registry.written_out("friction", written) == written

    @pytest.mark.parametrize(
        ("spec", "words"),
        [
            ({"use": "test-coulomb"}, ['"mu" is missing']),
            ({"use": "test-coulomb", "my": 0.2}, ["contacts.0.friction.my", '"mu"']),
            ({"use": "test-coulomb", "mu": "0.2"}, ["contacts.0.friction.mu", '"0.2"', "a number", "without quotes"]),
            ({"use": "test-coulomb", "mu": True}, ["contacts.0.friction.mu", "true", "a number"]),
            ({"use": "test-coulomb", "mu": float("nan")}, ["contacts.0.friction.mu", "nan", "not finite"]),
            ({"use": "test-coulomb", "mu": float("inf")}, ["contacts.0.friction.mu", "inf", "not finite"]),
            ({"use": "test-coulomb", "mu": 10**400}, ["contacts.0.friction.mu", "not finite"]),
            ({"use": "test-coulomb", "mu": 0.2, "name": 3}, ["contacts.0.friction.name", "3", "a string"]),
            ({"mu": 0.2}, ['"use" is missing', "mu = 0.2"]),
            ({"use": 3}, ["contacts.0.friction.use", "3"]),
            (3, ["contacts.0.friction", "3", "use = NAME"]),
        ],
    )
    def test_wrong_fields_name_their_key(self, spec: object, words: list[str], registry: Registry) -> None:
        with pytest.raises(SceneError) as caught:
            registry.make("friction", spec, "contacts.0.friction")
        for word in words:
            assert word in str(caught.value)

    def test_an_unknown_part_has_the_nearest_name(self, registry: Registry) -> None:
        with pytest.raises(PartError) as caught:
            registry.make("friction", "test-columb", "contacts.0.friction")
        assert 'did you mean "test-coulomb"?' in str(caught.value)
        assert "contacts.0.friction" in str(caught.value)

    def test_a_part_that_raises_on_its_fields_is_blamed(self, install: Install) -> None:
        source = GOOD.replace("good_plugin", "odd_plugin").replace(
            "    def bound", "    def __post_init__(self):\n        1 / 0\n\n    def bound"
        )
        install("odd-plugin", source.replace("test-coulomb", "odd"))
        with pytest.raises(PartError, match=r"odd-plugin 1\.0.*ZeroDivisionError"):
            Registry().make("friction", {"use": "odd", "mu": 0.1})


class TestOtherHooks:
    def test_scenes_and_commands_of_plugins(self, install: Install, tmp_path: Path) -> None:
        scene = tmp_path / "my-scene.toml"
        scene.write_text("")
        install(
            "more-plugin",
            f"{HEAD}\nfrom pathlib import Path\n"
            f"@hookimpl\ndef contactlab_scenes():\n    return {{'my-scene': Path({str(scene)!r})}}\n"
            "@hookimpl\ndef contactlab_commands():\n    return {'greet': 'more_plugin:greet'}\n"
            "def greet(words):\n    print('hello', *words)\n    return 5\n",
        )
        registry = Registry()
        assert registry.scenes()["my-scene"] == scene
        assert registry.commands()["greet"][1].distribution == "more-plugin"

    @pytest.mark.parametrize("hook", ["contactlab_scenes", "contactlab_commands"])
    def test_a_hook_that_raises_or_gives_nonsense_is_broken(self, hook: str, install: Install) -> None:
        install("bad-plugin", f"{HEAD}\n@hookimpl\ndef {hook}():\n    raise ValueError('odd')\n")
        install("odd-plugin", f"{HEAD}\n@hookimpl\ndef {hook}():\n    return 3\n")
        registry = Registry()
        registry.scenes(), registry.commands()
        assert "odd" in only(registry, "bad-plugin").reason
        assert "not a table" in only(registry, "odd-plugin").reason
        registry.scenes(), registry.commands()
        assert only(registry, "bad-plugin")

    LEFT_OUT: ClassVar = {
        "missing file": ("scenes", "'gone': '/no/such/gone.toml'", "scene gone", "/no/such/gone.toml"),
        "relative path": ("scenes", "'near': 'near.toml'", "scene near", "Path(__file__).parent"),
        "no path": ("scenes", "'odd': 3", "scene odd", "int"),
        "scene of the core": ("scenes", "'disc-on-block': __file__", "scene disc-on-block", "the core has a scene"),
        "name of a scene": ("scenes", "'My Scene': __file__", "scene My Scene", "lower-case"),
        "command of the core": ("commands", "'run': 'bad_plugin:f'", "command run", "the core has a command"),
        "no function": ("commands", "'greet': 'bad_plugin.f'", "command greet", "package.module:function"),
        "name of a command": ("commands", "'--greet': 'bad_plugin:f'", "command --greet", "lower-case"),
    }

    @pytest.mark.parametrize("case", LEFT_OUT)
    def test_a_scene_or_command_that_cannot_be_used_is_listed_and_the_rest_works(
        self, case: str, install: Install
    ) -> None:
        hook, entry, item, reason = self.LEFT_OUT[case]
        right = "'right': __file__" if hook == "scenes" else "'right': 'bad_plugin:f'"
        install("bad-plugin", f"{HEAD}\n@hookimpl\ndef contactlab_{hook}():\n    return {{{entry}, {right}}}\n")
        registry = Registry()
        broken = only(registry, "bad-plugin")  # known before anyone asks for scenes or commands
        assert broken.item == item
        assert reason in broken.reason
        assert registry.reason_against(item) == f"fix bad-plugin 1.0: {broken.reason}"
        assert set(registry.scenes() if hook == "scenes" else registry.commands()) == {"right"}

    @pytest.mark.parametrize(("hook", "value"), [("scenes", "__file__"), ("commands", "'a:b'")])
    def test_a_name_that_two_plugins_offer_is_used_by_neither(self, hook: str, value: str, install: Install) -> None:
        for distribution in ("one-plugin", "two-plugin"):
            install(distribution, f"{HEAD}\n@hookimpl\ndef contactlab_{hook}():\n    return {{'same': {value}}}\n")
        registry = Registry()
        assert "same" not in {**registry.scenes(), **registry.commands()}
        for distribution in ("one-plugin", "two-plugin"):
            assert "one-plugin 1.0 and two-plugin 1.0" in only(registry, distribution).reason

    def test_what_is_left_out_is_told_by_doctor_and_parts_and_where_it_is_asked_for(
        self, install: Install, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        install(
            "bad-plugin",
            f"{HEAD}\n@hookimpl\ndef contactlab_scenes():\n    return {{'gone': '/no/such/gone.toml'}}\n"
            "@hookimpl\ndef contactlab_commands():\n    return {'scenes': 'bad_plugin:f', 'greet': 'f'}\n",
        )
        monkeypatch.setenv("COLUMNS", "200")  # whatever the terminal: no cell is wrapped
        registry = Registry()
        for place in ("commands.common", "commands.doctor", "parts.registry", "scene.scene"):
            monkeypatch.setattr(f"contactlab.{place}.default_registry", lambda: registry)
        facts = [fact.value for fact in plugin_facts(registry)]
        assert main(["parts"]) == 0
        shown = capsys.readouterr().out
        for word in ("scene gone", "command scenes", "command greet"):
            assert any(fact.startswith(f"bad-plugin 1.0 {word}: ") for fact in facts)
            assert word in shown
        assert main(["scenes"]) == 0
        assert "disc-on-block" in capsys.readouterr().out
        assert main(["greet"]) == 2
        assert "package.module:function" in capsys.readouterr().err
        assert main(["run", "gone"]) == 2
        assert 'there is no file "/no/such/gone.toml"' in capsys.readouterr().err

    def test_names_of_the_cores_commands_are_all_reserved(self) -> None:
        assert set(CORE_COMMANDS) == set(COMMANDS)

    def test_run_finished_reaches_all_plugins_and_gives_back_those_that_raise(self, install: Install) -> None:
        hook = f"{HEAD}\nseen = []\n@hookimpl\ndef contactlab_run_finished(summary):\n    "
        install("glad-plugin", hook + "seen.append(summary['status'])\n")
        install("sad-plugin", hook + "raise OSError('disk full')\n")
        registry = Registry()
        broken = registry.run_finished({"status": "finished"}, None)
        assert sys.modules["glad_plugin"].seen == ["finished"]
        assert [(item.origin.distribution, "disk full" in item.reason) for item in broken] == [("sad-plugin", True)]

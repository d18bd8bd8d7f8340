"""Every wrong request ends in one message: file, key, what was got, what is allowed, what to try."""

from __future__ import annotations

import pickle
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from contactlab.cli import main
from contactlab.commands.arguments import COMMANDS
from contactlab.errors import RequestError, SceneError
from contactlab.run.simulation import simulate
from contactlab.scene.scene import bundled_scenes, load_scene

SCENE = bundled_scenes()["disc-on-block"].read_text()


@dataclass(frozen=True)
class Wrong:
    """An edit of the bundled scene, words the message must have, and the text whose line it must name."""

    old: str
    new: str
    words: tuple[str, ...]
    at: str

    @property
    def text(self) -> str:
        return SCENE.replace(self.old, self.new, 1)

    @property
    def line(self) -> str:
        return f"line {self.text[: self.text.index(self.at)].count(chr(10)) + 1}" if self.at else ""


def edit(old: str, new: str, *words: str, at: str | None = None) -> Wrong:
    """By default the message names the line where the edit ends."""
    assert old in SCENE, old
    return Wrong(old, new, words, new.splitlines()[-1] if at is None else at)


WRONG = {
    "unknown key": edit("poisson = 0.3", "poison = 0.3", "key materials.steel.poison", '"poisson"'),
    "unknown table": edit("[record]", "[recrod]", "key recrod", '"record"', "allowed"),
    "unknown top key": edit('units = "mm N s t"', "unit = 3", "key unit", '"units"'),
    "wrong type": edit("young = 70000.0", 'young = "70000"', "key materials.steel.young", '"70000"', "a number", "without quotes"),
    "square beyond numbers": edit("young = 7000.0", "young = 1e308", "key materials.soft.young", "1e+308", "1e+150"),
    "bool for a number": edit("young = 70000.0", "young = true", "key materials.steel.young", "true", "a number"),
    "table for a number": edit("[record]", "[level]", "key level", "frames = 50", "whole number"),
    "number for a text": edit('slave = "disc.arc"', "slave = 3", "key contacts.0.slave", "3", "a string"),
    "nan": edit("young = 70000.0", "young = nan", "key materials.steel.young", "nan", "not finite"),
    "infinity": edit("to = -0.1581", "to = inf", "key supports.1.uy.to", "inf", "not finite"),
    "negative modulus": edit("young = 70000.0", "young = -1.0", "key materials.steel.young", "-1.0", "> 0"),
    "zero density": edit("density = 2.7e-9", "density = 0", "key materials.steel.density", "> 0"),
    "poisson one half": edit("poisson = 0.3", "poisson = 0.5", "key materials.steel.poisson", "0.5", "poisson < 0.5"),
    "unknown algorithm": edit('"mortar-p0"', '"mortar-p2"', "key contacts.0.algorithm", "mortar-p0, mortar-p1", "did you mean", at="algorithm ="),
    "unknown element": edit('element = "q1"', 'element = "q9"', "key bodies.disc.element", "q1, q1-fbar", at='element = "q9"'),
    "unknown integrator": edit('"central-difference"', '"central-diference"', "key integrator", '"central-difference"', at="[integrator]"),
    "part of another kind": edit('element = "q1"', 'element = "mortar-p0"', "key bodies.disc.element", "kind contact"),
    "part without use": edit('use = "arc-block", ', "", "key bodies.disc.mesh", '"use" is missing', at="mesh = {"),
    "field missing": edit("radius = 1.0, ", "", "key bodies.disc.mesh", '"radius" is missing', at="mesh = {"),
    "unknown edge set": edit('"disc.arc"', '"disc.bow"', "key contacts.0.slave", "disc.arc, disc.right"),
    "edge set missing": edit('"disc.arc"', '"disc"', "key contacts.0.slave", '"disc"', "body.edge_set"),
    "unknown body": edit('"block.top"', '"blok.top"', "key contacts.0.master", '"block"', "disc, block"),
    "slave is master": edit('"block.top"', '"disc.arc"', "key contacts.0.master", "same edge set", at="master = "),
    "unknown support": edit('"block.bottom"', '"block.botom"', "key supports.0.on", "block.bottom"),
    "support of nothing": edit("ux = 0.0\nuy = 0.0\n", "", "key supports.0", "ux = 0.0", at="[[supports]]"),
    "support given twice": edit('"disc.top"', '"block.bottom"', "key supports.1.ux", "supports.0 already", at="ux = 0.0\nuy = {"),
    "unknown ramp": edit('ramp = "parabola"', 'ramp = "parabel"', "key supports.1.uy.ramp", '"parabola"'),
    "unknown material": edit('material = "steel"', 'material = "steal"', "key bodies.disc.material", '"steel"'),
    "unused material": edit('material = "steel"', 'material = "soft"', "key materials.steel", "no body", at="[materials.steel]"),
    "zero cells": edit("cells = [24, 6]", "cells = [0, 6]", "key bodies.disc.mesh.cells", "[0, 6]", "at least 1"),
    "half a cell": edit("cells = [24, 6]", "cells = [2.5, 6]", "key bodies.disc.mesh.cells.0", "2.5", "whole number"),
    "three cell counts": edit("cells = [24, 6]", "cells = [24, 6, 1]", "key bodies.disc.mesh.cells", "[24, 6, 1]"),
    "inverted mesh": edit("y = [-0.3, 0.0]", "y = [0.0, -0.3]", "key bodies.block.mesh.y", "increasing"),
    "impossible arc": edit("half_width = 0.8", "half_width = 2.0", "key bodies.disc.mesh.half_width", "radius"),
    "overlapping bodies": edit("y = [-0.3, 0.0]", "y = [-0.3, 0.2]", "overlap", at=""),
    "missing support": edit('[[supports]]\non = "block.bottom"\nux = 0.0\nuy = 0.0\n', "", "block", "support", at=""),
    "level zero": edit("format = 1", "format = 1\nlevel = 0", "key level", "0", ">= 1"),
    "level one and a half": edit("format = 1", "format = 1\nlevel = 1.5", "key level", "1.5", "whole number"),
    "level as a text": edit("format = 1", 'format = 1\nlevel = "2"', "key level", '"2"', "write 2 without quotes"),
    "other format": edit("format = 1", "format = 2", "key format", "2", "allowed  1"),
    "negative duration": edit('end = "auto"', "end = -1.0", "key time.end", "-1.0", "> 0", "[s]"),
    "unknown duration": edit('end = "auto"', 'end = "never"', "key time.end", '"never"', '"auto"'),
    "step beyond the limit": edit('end = "auto"', 'end = "auto"\nfraction = 1.5', "key time.fraction", "<= 1"),
    "step beyond the end": edit('end = "auto"', "end = 1e-6\nstep = 1e-5", "key time.step", "1e-05"),
    "no frames": edit("frames = 50", "frames = 0", "key record.frames", ">= 1"),
    "no integrator": edit('[integrator]\nuse = "central-difference"\nforces = "frozen"', "", '"integrator" is missing', at=""),
    "velocity of three numbers": edit('element = "q1"', 'element = "q1"\nvelocity = [0, 0, 0]', "key bodies.disc.velocity"),
    "name with a dot": edit("[bodies.disc]", '[bodies."disc.1"]', "not a usable name", at=""),
    "name with a line break": edit("[[contacts]]", '[[contacts]]\nname = "a\\nb"', "key contacts.0.name", "not a usable name", at=""),
    "gap wider than the model": edit("[[contacts]]", '[[contacts]]\nstart = { overlap = "adjust", gap = 1e100 }', "key contacts.0.start.gap", "wider than the model", at=""),
    "broken table": edit("[time]", "[time", "invalid TOML"),
    "missing quote": edit('end = "auto"', "end = auto", "invalid TOML", "quotes"),
    "key written twice": edit("frames = 50", "frames = 50\nframes = 60", "invalid TOML", "frames = 60"),
    "table after its braces": edit("[[contacts]]", "[bodies.block.mesh.more]\nx = 1\n[[contacts]]", "declare bodies.block.mesh.more twice", "after =", at="[bodies.block.mesh.more]"),
    "table in a list of tables": edit('[[supports]]\non = "disc.top"', '[supports]\non = "disc.top"', "[[supports]] above each entry", at='[supports]\non = "disc.top"'),
    "unfinished file": edit("frames = 50\n", "frames = [50", "invalid TOML", at="frames = [50"),
}  # fmt: skip


def refused(words: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    assert main(words) == 2
    shown = capsys.readouterr()
    assert shown.err.startswith("contactlab: ")
    assert "Traceback" not in shown.err
    assert not shown.out
    return shown.err


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_scene(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    wrong = WRONG[name]
    Path("wrong.toml").write_text(wrong.text)
    message = refused(["run", "wrong.toml"], capsys)
    for word in ("wrong.toml", wrong.line, *wrong.words):
        assert word in message
    assert not list(Path("runs").glob("*")), "a refused run leaves no folder"


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (bytes(range(128, 256)), ["not UTF-8"]),
        (b"name = 1\n\x89PNG\r\n\x1a\n", ["not UTF-8"]),
        (b"\x00\x01\x02\x03", ["invalid TOML"]),
        (b"", ['"integrator" is missing']),
        (b"a = " + b"[" * 5000, ["nested too deeply"]),
        (b"name = 'x'\nlevel = " + b"9" * 4301, ["line 2", "too many digits"]),
        (SCENE.replace("format = 1", f"format = 1\nlevel = 0x{'f' * 4000}").encode(), ["4816 digits", "below 2^63"]),
        (SCENE.replace('units = "mm', 'units = "\\u0000mm').encode(), ["key units", "line 5", "NUL", "x00mm"]),
    ],
    ids=["binary", "picture", "control characters", "empty", "nested", "digits", "hexadecimal digits", "NUL"],
)
def test_a_file_that_is_no_scene(
    content: bytes, words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "junk.toml"
    path.write_bytes(content)
    message = refused(["run", str(path)], capsys)
    for word in ("junk.toml", *words):
        assert word in message


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "disc-on-blok"], ['"disc-on-block"', "no such scene"]),
        (["run", "missing.toml"], ["missing.toml", "no such scene", "disc-on-block"]),
        (["run", "."], ["this is a folder"]),
        (["rnu", "disc-on-block"], ["unknown command", '"run"', "compare"]),
        (["run", "disc-on-block", "--set", "level"], ["--set", "KEY=VALUE", '"level"']),
        (["run", "disc-on-block", "--set", "=3"], ["--set", "KEY=VALUE"]),
        (["run", "disc-on-block", "--set", "contacts.1.swap=[tru"], ["--set contacts.1.swap", "[tru"]),
        (["run", "disc-on-block", "--set", "levle=2"], ["key levle (set from outside the file)", '"level"']),
        (["run", "disc-on-block", "--set", "contacts.7.swap=true"], ["contacts.7", "0 to 0"]),
        (["run", "disc-on-block", "--set", "contacts.tool.swap=true"], ["contacts.tool", "no entry of this name"]),
        (["run", "disc-on-block", "--set", "bodies={}"], ["key bodies", "no body"]),
        (["run", "disc-on-block", "--set", "level.x=2"], ["level", "no keys inside"]),
        (["run", "disc-on-block", "--set", "bodies.disk.rotate=2"], ["bodies.disk", '"disc"']),
        (["run", "disc-on-block", "--set", "contacts..swap=true"], ["contacts..swap", "names joined by dots"]),
        (["run", "disc-on-block", "--set", "materials.steel.use=steel"], ["key materials.steel", "neo-hookean"]),
        (["run", "disc-on-block", "--set", "contacts.0.friction.mu=0.2"], ["contacts.0.friction", '"use" is missing']),
        (["run", "disc-on-block", "--with", "no_such_part.py"], ["no_such_part.py", "no such file"]),
        (["explain", "disc-on-block", "--set", "level=0"], ["key level", ">= 1"]),
        (["compare", "disc-on-blok"], ['"disc-on-block"']),
        (["compare", "acuracy"], ["no such scene", "a study of cases: accuracy, demo", 'did you mean "accuracy"?']),
        (["compare", "disc-on-block", "--vary", "level=2"], ["--vary level", "list"]),
        (["compare", "disc-on-block", "--vary", "level=[]"], ["--vary level", "empty"]),
        (["compare", "disc-on-block", "--vary", "contacts.0.algorithm=[mortar-p7]"], ["mortar-p7", "mortar-p1"]),
    ],
)  # fmt: skip
def test_a_wrong_command_line(
    arguments: list[str],
    words: list[str],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    message = refused(arguments, capsys)
    for word in words:
        assert word in message
    assert not list(Path("runs").glob("*"))


DIGITS = "9" * 4301
"""One more than Python reads as a decimal number."""


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("word", ["a\0b", "\udcff"], ids=["NUL", "not UTF-8"])
def test_a_word_that_no_file_can_keep(command: str, word: str, capsys: pytest.CaptureFixture[str]) -> None:
    """After every command, as the only word and as the value of an option."""
    for words in ([word], ["--set", f"source={word}"], ["--out", word]):
        assert ascii(word)[1:-1] in refused([command, *words], capsys)


@pytest.mark.parametrize(
    "words",
    [
        ["run", "two-bars", "--set", f"level={DIGITS}"],
        ["explain", "two-bars", "--set", f"bodies.left.mesh.x=[0, {DIGITS}]"],
        ["run", "two-bars", "--set", f"contacts.{DIGITS}.swap=true"],
        ["compare", "two-bars", "--vary", f"level=[{DIGITS}]"],
        ["compare", "two-bars", "--vary", f"contacts.{DIGITS}.*=[1]"],
        ["compare", "two-bars", "--repeat", DIGITS],
        ["matrix", "--jobs", DIGITS],
        ["choose", "two-bars", "--search", DIGITS],
        ["choose", "two-bars", "--error", DIGITS],
        ["view", "two-bars", "--step", DIGITS],
        ["check", "coulomb", "--set", f"mu={DIGITS}"],
    ],
    ids=lambda words: f"{words[0]} {words[-1][:12]}",
)
def test_an_integer_that_python_does_not_read(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert "999" in refused(words, capsys)


def test_numbers_and_texts_of_python_are_looked_at_as_well(tmp_path: Path) -> None:
    scene = load_scene("two-bars")
    for changes, key in (({"level": 10**5000}, "level"), ({"source": "\0"}, "source"), ({"name": "\udcff"}, "name")):
        with pytest.raises(SceneError, match=f"(?s){key}.*(file can store|below 2.63)"):
            scene.with_(changes)
    with pytest.raises(RequestError, match="no file can have this name"):
        simulate(scene, out=f"{tmp_path}/\0")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run"], ["run: SCENE is missing", "contactlab run [--set KEY=VALUE]", "contactlab run --help"]),
        (["run", "a", "b"], ["run: unexpected word", '"b"']),
        (["run", "a", "--resum"], ["unknown option", "--resum", 'did you mean "--resume"?']),
        (["run", "a", "--level", "2"], ["unknown option", "--level", "--set level=2"]),
        (["run", "a", "--set"], ["run, --set: a value is missing"]),
        (["compare", "a", "--jobs", "0"], ["compare, --jobs: this value is not allowed", "a whole number >= 1"]),
        (["completion", "fsh"], ["bash, zsh, fish, powershell", 'did you mean "fish"?']),
        (["--levl"], ["COMMAND is missing"]),
        (["view", ""], ["no folder is given", "a folder or a recording"]),
    ],
)  # fmt: skip
def test_words_that_fit_no_command(arguments: list[str], words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    message = refused(arguments, capsys)
    for word in words:
        assert word in message


def test_no_word_at_all_is_answered_with_the_commands(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 2
    said = capsys.readouterr().err
    assert "usage: contactlab" in said
    assert "choose" in said


def test_results_are_never_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "summary.json").write_text("{}")
    message = refused(["run", "disc-on-block", "--out", str(tmp_path)], capsys)
    assert f"results folder {tmp_path}" in message
    assert "summary.json" in message
    assert (tmp_path / "summary.json").read_text() == "{}"


def test_a_file_is_no_folder_for_results(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "taken").write_text("")
    assert "results folder" in refused(["run", "disc-on-block", "--out", str(tmp_path / "taken")], capsys)


def test_the_installed_program_returns_the_status(tmp_path: Path) -> None:
    """Once for real: a process, its exit status and its error stream."""
    command = [sys.executable, "-m", "contactlab.cli", "run", "disc-on-block", "--set", "level=0"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("contactlab: bundled scene disc-on-block, key level")
    assert "Traceback" not in done.stderr


def test_all_that_is_wrong_in_a_file_is_told_at_once(tmp_path: Path) -> None:
    """Keys, values and parts of tables in tables, each once, also from another process; a misspelt key is not missing."""
    text = SCENE
    wrong = {"poisson = 0.3": "poison = 0.3", 'element = "q1"': 'elment = "q1"', '"mortar-p0"': '"mortar-p2"',
             'units = "mm N s t"': "units = 3"}  # fmt: skip
    for old, new in wrong.items():
        text = text.replace(old, new, 1)
    (tmp_path / "scene.toml").write_text(text)
    with pytest.raises(RequestError) as caught:
        load_scene(tmp_path / "scene.toml")
    told = str(pickle.loads(pickle.dumps(caught.value)))
    assert told == str(caught.value)
    for key in ("materials.steel.poison", "bodies.disc.elment", "contacts.0.algorithm", "units"):
        assert told.count(f"key {key}: ") == 1, key
    assert len(caught.value.others) == len(wrong) - 1
    assert "is missing" not in told


def test_a_file_full_of_errors_is_told_in_part() -> None:
    with pytest.raises(RequestError, match="and 11 more errors") as caught:
        load_scene("disc-on-block").with_({f"wrong{number}": 1 for number in range(21)})
    assert str(caught.value).count("unknown key") == 10

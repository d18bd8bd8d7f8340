"""What docs/write-a-plugin.md shows is short and plain; test_strangers.py installs and runs it."""

from __future__ import annotations

import io
import re
import tokenize

from plugin_page import FILES


def test_the_page_has_its_files() -> None:
    assert {name.rpartition("/")[2] for name in FILES} == {
        "my_friction.py", "pyproject.toml", "plugin.py", "contact.py", "material.py", "element.py", "cylinder.py",
        "integrator.py", "test_parts.py",
    }  # fmt: skip


def test_the_algorithm_is_short_and_plain() -> None:
    """Under 60 lines without blank ones, comments and docstrings; NumPy and the contract are all it imports."""
    source = FILES["src/gauss_contact/contact.py"]
    skipped = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER)
    lines, fresh = set(), True
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        docstring = token.type == tokenize.STRING and fresh
        if token.type not in skipped and not docstring:
            lines |= set(range(token.start[0], token.end[0] + 1))
        fresh = token.type in skipped
    assert 30 < len(lines) < 60
    assert imports_of("contact.py") == {"dataclasses", "typing", "numpy", "contactlab.api"}


def test_case_and_integrator_are_short() -> None:
    """Under 40 lines, and forty in the integrator's step; a case needs nothing but the contract."""
    source = FILES["src/gauss_contact/cylinder.py"]
    assert len([line for line in source.splitlines() if line.strip()]) < 40
    assert imports_of("cylinder.py") == {"dataclasses", "numpy", "contactlab.api", "contactlab.api.case"}
    source = FILES["src/gauss_contact/integrator.py"]
    assert len([line for line in source[source.index("    def bind") :].splitlines() if line.strip()]) <= 40


def imports_of(file: str) -> set[str]:
    return set(re.findall(r"^(?:from|import) ([\w.]+)", FILES[f"src/gauss_contact/{file}"], re.MULTILINE))

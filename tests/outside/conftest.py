"""These tests need the packages beside them installed: `tests/contract/test_strangers.py` installs and runs them."""

from importlib.util import find_spec

collect_ignore = [] if find_spec("plain_leapfrog") is not None else ["test_outside.py"]

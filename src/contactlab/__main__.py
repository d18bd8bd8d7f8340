"""`python -m contactlab`."""

from __future__ import annotations

import sys

from contactlab.cli import main

sys.exit(main())

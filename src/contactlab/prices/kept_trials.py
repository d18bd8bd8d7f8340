"""Trials of scenes, as they are kept beside the prices of one machine and one version.

A trial belongs to the content of a scene (files that it names included) and to the versions of what its parts come
from: of a scene that was changed by a digit there is none.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from contactlab.errors import RequestError
from contactlab.jobs.keys import scene_key
from contactlab.parts.provenance import versions as versions_of
from contactlab.prices.counts import Length
from contactlab.prices.price_list import COMMAND, foreign, machine, price_file, versions, write_whole
from contactlab.scene.scene import Scene

FORMAT = 1


class BrokenTrialsError(RequestError):
    """There is a file of trials that cannot be used."""


@dataclass(frozen=True)
class SceneTrial:
    """A run of a scene, or its begin.

    scene       its name and the variant, for people
    made        date
    steps, iterations, frames  that were made
    cpu_s       CPU time of its steps [s]
    arrays_mib  memory of its arrays [MiB]
    ended       "" where it came to its end, "cut" where it was stopped before, else how and why it failed
    done        share of its loading that was done
    """

    scene: str
    made: str
    steps: float = 0.0
    iterations: float = 0.0
    frames: float = 0.0
    cpu_s: float = 0.0
    arrays_mib: float = 0.0
    ended: str = ""
    done: float = 1.0

    @property
    def failed(self) -> bool:
        """Whether it says nothing of costs."""
        return self.ended not in ("", "cut")

    @property
    def length(self) -> Length:
        """What was made."""
        return Length(self.steps, self.iterations, self.frames)


Trials = Mapping[str, SceneTrial]
"""Trials by the keys of their scenes."""
NO_TRIALS: Trials = {}


def trial_key(scene: Scene) -> str:
    """What a trial of a scene is kept by."""
    return scene_key(scene, versions_of(scene, scene.registry))


def trial_file() -> Path:
    """Where trials on this machine and with these versions are kept."""
    return price_file().parent / "trials" / price_file().name


def load_trials() -> Trials:
    """Trials on this machine; none where none were made. Raises BrokenTrialsError, which says what to do."""
    file = trial_file()
    hint = f"{COMMAND} SCENE makes it anew"
    try:
        return checked(json.loads(file.read_text(encoding="utf-8")))
    except FileNotFoundError:
        return {}
    except (OSError, UnicodeDecodeError) as error:
        raise BrokenTrialsError(f"the file of trials cannot be read: {error}", where=str(file), hint=hint) from error
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise BrokenTrialsError(f"the file of trials is broken: {error}", where=str(file), hint=hint) from error


def checked(data: Any) -> Trials:
    """Trials from plain tables. Raises what Python does, or ValueError, where they hold something else."""
    if not isinstance(data, Mapping) or data.get("format") != FORMAT:
        raise ValueError("it has another format")
    if other := foreign(data):
        raise ValueError(other)
    found = {str(key): SceneTrial(**trial) for key, trial in data["trials"].items()}
    for trial in found.values():
        numbers = (*trial.length, trial.cpu_s, trial.arrays_mib, trial.done)
        if not all(isinstance(value, int | float) and math.isfinite(value) and value >= 0.0 for value in numbers):
            raise ValueError(f"a number of the trial of {trial.scene} is none")
        if not trial.failed and not trial.cpu_s > 0.0:
            raise ValueError(f"the trial of {trial.scene} took no time")
    return found


def store_trials(trials: Trials) -> Path:
    """Keep trials, whole or not at all; the file. Raises RequestError where it cannot be written."""
    plain = {key: asdict(trial) for key, trial in trials.items()}
    data = {"format": FORMAT, "machine": machine(), "versions": versions(), "trials": plain}
    return write_whole(trial_file(), data, "the trials")

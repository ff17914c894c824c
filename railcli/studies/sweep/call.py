"""A parameter study as Python users ask for it."""

import shutil
import tempfile
from pathlib import Path

from railcli.errors import InputError
from railcli.files.scenario import load
from railcli.files.study import OF_A_STUDY, load_study
from railcli.model.scenario import Scenario

from .answer import Swept
from .study import sweep


def call(source, folder, vary, more, workers, scheduler, sure, overwrite, figures, voice):
    """Parameters as of `railcli.sweep`; source : a name, a file, the dict of a study or scenario, or a Scenario."""
    scenario = source if isinstance(source, Scenario) else None
    if isinstance(source, dict) and not OF_A_STUDY & set(source):
        scenario = load(source)
    more = {**more, **({"vary": [_entry(key, value) for key, value in vary.items()]} if vary else {})}
    study = {"name": scenario.name} if scenario is not None else source
    plan = load_study(study, {key: _plain(value) for key, value in more.items()}, scenario)
    rest = workers, scheduler, sure, overwrite, figures, voice
    if folder is not None:
        return sweep(*plan, folder, *rest)
    temporary = Path(tempfile.mkdtemp(prefix="railcli-"))
    try:
        answer = sweep(*plan, temporary / "study", *rest)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    return Swept({**answer.record, "folder": None}, answer.lines[:-2], None, answer.frame)


def _entry(key, value):
    """An entry of ``vary``."""
    if isinstance(value, dict):
        return {"key": key, **value}
    value = _plain(value)
    if not isinstance(value, list):
        raise InputError(f"vary: {key}", f"give a list of values or a dict such as {{'from': 1, 'to': 2, 'count': 5}}, "
                         f"got {value!r}")  # fmt: skip
    return {"key": key, "values": value}


def _plain(value):
    """Lists and numbers as a TOML file would hold them."""
    if isinstance(value, list | tuple | range):
        return [_plain(item) for item in value]
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    return value.tolist() if hasattr(value, "tolist") else value

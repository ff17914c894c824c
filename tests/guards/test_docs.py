"""The documents say what the commands are."""

import re
from pathlib import Path

import click
import pytest

from railcli.cli import main

ROOT = Path(__file__).parents[2]


def commands(group, path=("railcli",)):
    """All commands that are not groups: full name and click command."""
    for name, command in group.commands.items():
        if isinstance(command, click.Group):
            yield from commands(command, (*path, name))
        else:
            yield " ".join((*path, name)), command


def section(text, title):
    """Text under a heading `## title`."""
    return re.split(r"^## ", text.partition(f"## {title}\n")[2], maxsplit=1, flags=re.M)[0]


COMMANDS = dict(commands(main))


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_and_option_is_documented(name):
    command = COMMANDS[name]
    text = (ROOT / "docs/cli.md").read_text(encoding="utf-8")
    assert name in text
    assert command.help
    options = [item for item in command.params if isinstance(item, click.Option)]
    assert [item.name for item in options if not item.help] == []
    assert [item.name for item in options if not any(f"`{spelling}" in text for spelling in item.opts)] == []


@pytest.mark.parametrize("title, needed", [("Run", "railcli validate manchester"), ("Test", "pytest")])
def test_readme_gives_one_command(title, needed):
    text = section((ROOT / "README.md").read_text(encoding="utf-8"), title)
    blocks = re.findall(r"^```\w*\n(.*?)^```", text, flags=re.M | re.S)
    assert len(blocks) == 1
    assert needed in blocks[0] and len(blocks[0].splitlines()) == 1


def test_tables_of_ports_are_those_of_the_schema(run_python):
    done = run_python(
        "import sys; sys.path.insert(0, sys.argv[1]); import ports; "
        "assert ports.page() == ports.PAGE.read_text(encoding='utf-8'), 'run python docs/ports.py'; "
        "assert sum(1 for name in ports.OF for _ in ports.fields(name)) > 50",
        str(ROOT / "docs"),
    )
    assert done.returncode == 0, done.stderr

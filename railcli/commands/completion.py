"""Names that a shell completes: those of scenarios, vehicles and profiles that railcli brings along, beside files."""

import click
from click.shell_completion import CompletionItem


class Named(click.ParamType):
    """One that railcli brings along, by its name, or a file.

    Parameters
    ----------
    names : callable
        Gives the names; called when a shell asks.
    """

    name = "text"

    def __init__(self, names):
        self._names = names

    def shell_complete(self, ctx, param, incomplete):
        files = CompletionItem(incomplete, type="file")
        return [files, *(CompletionItem(name) for name in self._names() if name.startswith(incomplete))]


def _scenarios():
    from railcli.files.resources import scenario_files

    return scenario_files()


def _vehicles():
    from railcli.files.resources import VEHICLES

    return VEHICLES


def _profiles(kind):
    from railcli.files.resources import BUNDLED

    return [name for name, (of, _) in BUNDLED.items() if kind in (of, None)]


SCENARIOS, VEHICLES = Named(_scenarios), Named(_vehicles)
PROFILES, WHEELS, RAILS = (Named(lambda kind=kind: _profiles(kind)) for kind in (None, "wheel", "rail"))

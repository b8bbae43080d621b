"""The `cam` application. Nothing heavy is imported before a command is chosen."""

from __future__ import annotations

import os
import sys
from importlib import import_module

import typer

from camcli.cli.basins_help import BASINS_HELP, BASINS_OPTIONS
from camcli.cli.bench_help import BENCH_HELP, BENCH_OPTIONS
from camcli.cli.cam_profile_help import PROFILE_HELP, PROFILE_OPTIONS
from camcli.cli.classify_help import CLASSIFY_HELP, CLASSIFY_OPTIONS
from camcli.cli.detach_help import DETACH_HELP, DETACH_OPTIONS
from camcli.cli.figures_help import FIGURES_HELP, FIGURES_OPTIONS, WITHOUT
from camcli.cli.options import Request, command
from camcli.cli.orbits_help import ORBITS_HELP, ORBITS_OPTIONS
from camcli.cli.rerun_help import AGAIN, MERGE_HELP, MERGE_OPTIONS, RERUN_HELP, RERUN_OPTIONS
from camcli.cli.sweep_help import MANY, SIMULATE_HELP, SWEEP_HELP, SWEEP_OPTIONS

app = typer.Typer(
    name="cam",
    help="Bifurcations of a cam and a follower that can lift off, bounce, chatter and come back.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

# name: (help, options of its own, shared options that mean nothing to it); run() is in cli/NAME.py
COMMANDS = {
    "simulate": (SIMULATE_HELP + PROFILE_HELP, PROFILE_OPTIONS, ()),
    "sweep": (SWEEP_HELP, SWEEP_OPTIONS, ()),
    "detach": (DETACH_HELP, DETACH_OPTIONS, ()),
    "orbits": (ORBITS_HELP, ORBITS_OPTIONS, ()),
    "basins": (BASINS_HELP, BASINS_OPTIONS | MANY, ()),
    "classify": (CLASSIFY_HELP, CLASSIFY_OPTIONS, ()),
    "bench": (BENCH_HELP, BENCH_OPTIONS, ()),
    "figures": (FIGURES_HELP, FIGURES_OPTIONS, WITHOUT),
    "merge": (MERGE_HELP, MERGE_OPTIONS, AGAIN),
    "rerun": (RERUN_HELP, RERUN_OPTIONS, AGAIN),
}


def _lazily(name: str):
    """The command's run(), imported when it is called."""

    def run(request: Request) -> int:
        return import_module(f"camcli.cli.{name}").run(request)

    return run


for _name, (_help, _options, _without) in COMMANDS.items():
    command(app, _name, _lazily(_name), _help, _options, _without)


@app.command("schema", help="Print the scene's JSON Schema, for editors.")
def schema() -> None:
    """cam schema"""
    import json

    from camcli.scene import json_schema

    print(json.dumps(json_schema(), indent=2))


def main() -> None:
    """Run `cam`, turning every failure into words and an exit code."""
    import signal

    from camcli.cli.exit_codes import INTERRUPTED, guarded
    from camcli.cli.held_output import hold_output

    if "CAMCLI_PARENT" in os.environ:
        from camcli.cli.parent_watch import end_with_parent

        end_with_parent()
    real = sys.stdout
    hold_output()
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # ends like an interrupt
    code = guarded(lambda: app(standalone_mode=False))
    sys.stdout = real
    if code == INTERRUPTED:  # without waiting for a piece that is still at work in a thread
        sys.stderr.flush()
        os._exit(code)
    sys.exit(code)

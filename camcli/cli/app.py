"""The `cam` application. Nothing heavy is imported before a command is chosen."""

from __future__ import annotations

import os
import sys
from typing import Annotated

import typer

from camcli.cli.basins import basins
from camcli.cli.bench import bench
from camcli.cli.classify import classify
from camcli.cli.detach import detach
from camcli.cli.explore import explore
from camcli.cli.figures import figures
from camcli.cli.init import init
from camcli.cli.merge import merge
from camcli.cli.options import DRAWING, register
from camcli.cli.orbits import orbits
from camcli.cli.rerun import REPEATED, rerun
from camcli.cli.simulate import simulate
from camcli.cli.sweep import sweep

app = typer.Typer(
    name="cam",
    help="Bifurcations of a cam and a follower that can lift off, bounce, chatter and come back.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
for _command in (simulate, sweep, detach, orbits, basins, classify):
    register(app, _command)
register(app, bench, without=DRAWING)
register(app, explore, without=("no_plot", *DRAWING))
register(app, figures, without=("config", "rpm", "points", "no_plot", *DRAWING))
register(app, merge, without=(*REPEATED, *DRAWING))
app.command("init")(init)
register(app, rerun, without=(*REPEATED, "no_plot", *DRAWING))  # the record says whether it drew


@app.command("schema", help="Print the scene's JSON Schema, for editors.")
def schema() -> None:
    """cam schema"""
    import json

    from camcli.scene import json_schema

    print(json.dumps(json_schema(), indent=2))


def _version(asked: bool) -> None:
    if asked:
        import camcli

        print(f"cam {camcli.__version__}")
        raise typer.Exit


@app.callback()
def _of_all_commands(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    pass


def main() -> None:
    """Run `cam`, turning every failure into words and an exit code."""
    from camcli import interrupts
    from camcli.cli.exit_codes import INTERRUPTED, guarded, hold_output

    interrupts.install()
    os.environ.pop("MPLBACKEND", None)  # pictures are files; a name unknown here would stop them
    real = sys.stdout
    hold_output()
    code = guarded(lambda: app(standalone_mode=False), "--json" in sys.argv)
    sys.stdout = real
    if code == INTERRUPTED:  # without waiting for a piece that is still at work in a thread
        sys.stderr.flush()
        os._exit(code)
    sys.exit(code)

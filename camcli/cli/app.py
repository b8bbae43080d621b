"""The `cam` application. Nothing heavy is imported before a command is chosen."""

import gc
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Annotated, Any

import typer

from camcli.api import ANALYSES

COMMANDS = {  # each is a function of its name in a module of its name
    **ANALYSES,
    "bench": "How exact, robust and fast; published numbers beside ours.",
    "figures": "The figures of the cam-follower example, brought up to date.",
    "merge": "Join the parts of a run that was computed in shards.",
    "init": "Write a scene to begin with.",
    "guide": "Show the guide.",
    "schema": "Print the scene's JSON Schema, for editors.",
    "rerun": "Run again what a run.json records: do the bytes agree?",
}


def app(words: Sequence[str] | None = None, **options: Any) -> Any:
    """Run `cam WORDS`; of the commands only the one asked for is imported.

    A shell that completes a line gives it in the environment, with `cam` as its first word.
    """
    words = sys.argv[1:] if words is None else words
    line = words
    if "_CAM_COMPLETE" in os.environ:
        typed = os.environ.get("_TYPER_COMPLETE_ARGS") or os.environ.get("COMP_WORDS", "")
        line = typed.split()[1:]
    asked = (word for word in line if not word.startswith("-"))
    return application(next(asked, ""))(words, **options)


def application(*asked: str) -> typer.Typer:
    """The application with the commands asked for; of the others it has only a line of help."""
    made = typer.Typer(
        name="cam",
        help="Bifurcations of a cam and a follower that can lift off, bounce, chatter and come "
        "back.",
        no_args_is_help=True,
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    made.callback()(_of_all_commands)
    for name, line in COMMANDS.items():
        if name in asked:
            from camcli.cli.options import register

            module = import_module(f"camcli.cli.{name}")
            register(made, getattr(module, name), getattr(module, "WITHOUT", ()))
        else:
            made.command(name, help=line)(lambda: None)
    return made


def _version(asked: bool) -> None:
    """Print the version and end, where it is asked for."""
    if asked:
        import camcli

        print(f"cam {camcli.__version__}")
        raise typer.Exit


def _of_all_commands(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Take the options that stand before a command."""


def main() -> None:
    """Run `cam`, turning every failure into words and an exit code."""
    from camcli import interrupts
    from camcli.cli import drawing
    from camcli.cli.exit_codes import INTERRUPTED, guarded, hold_output

    def run() -> object:
        """Run the command line, interruptible."""
        interrupts.install()
        drawing.start(sys.argv[1:])
        return app(standalone_mode=False)

    if "_CAM_COMPLETE" in os.environ:  # a shell completes a line: nothing is run
        app()
    os.environ.pop("MPLBACKEND", None)  # pictures are files; a name unknown here would stop them
    real = sys.stdout
    hold_output()
    try:
        code = guarded(run, "--json" in sys.argv)
        interrupts.interrupt_arrived()  # all is done: a signal from here on changes nothing
    except KeyboardInterrupt:  # a second one, while the first was being told
        interrupts.interrupt_arrived()
        code = INTERRUPTED
    sys.stdout = real
    drawing.let_go()
    gc.freeze()  # what is still there goes with the process: nobody need look through it
    if code == INTERRUPTED:  # without waiting for a piece that is still at work in a thread
        sys.stderr.flush()
        interrupts.leave()
    sys.exit(code)

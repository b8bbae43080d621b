"""The options every command shares, declared once."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import typer

from camcli.errors import Fault, SceneError

MOST_THREADS = 4096
HOW = ("cluster", "shard")  # options that change no artefact


@dataclass(frozen=True)
class Request:
    """What the user asked for, unvalidated; field names are the option names."""

    config: Path | None
    sets: list[str]
    rpm: str | None
    points: int | None
    out: Path | None
    no_plot: bool
    json: bool
    quiet: bool
    threads: int | None
    dry_run: bool
    extra: dict[str, Any] = field(default_factory=dict)  # options of one command only
    scene: dict[str, Any] | None = None  # a whole scene, in place of config, sets, rpm and points
    home: Path = Path()  # the folder its files are in
    parts: tuple[Path, ...] = ()  # pieces that others have computed

    def folder(self, command: str) -> Path:
        """Where the artefacts go."""
        return self.out if self.out is not None else Path("out") / command

    def as_options(self) -> dict[str, Any]:
        """The options that change artefacts, for the run record."""
        given = {k: v for k, v in self.extra.items() if v is not None and k not in HOW}
        shared = {"rpm": self.rpm, "points": self.points, "set": self.sets}
        return {**shared, "plot": not self.no_plot, **given}


COMMON: dict[str, tuple[Any, Any]] = {
    "config": (
        Annotated[
            Path | None,
            typer.Option("-c", "--config", help="Scene file (YAML). Default: the chapter's scene."),
        ],
        None,
    ),
    "sets": (
        Annotated[
            list[str] | None,
            typer.Option(
                "--set", help="path.to.key=value, read as YAML. Repeatable.", metavar="KEY=VALUE"
            ),
        ],
        None,
    ),
    "rpm": (
        Annotated[str | None, typer.Option("--rpm", help="Speed X or range LO:HI, rpm.")],
        None,
    ),
    "points": (
        Annotated[
            int | None,
            typer.Option("--points", help="Speeds of a range; samples per turn in simulate."),
        ],
        None,
    ),
    "out": (
        Annotated[
            Path | None,
            typer.Option("-o", "--out", help="Folder for the artefacts. Default: out/COMMAND."),
        ],
        None,
    ),
    "no_plot": (Annotated[bool, typer.Option("--no-plot", help="Draw nothing.")], False),
    "json": (Annotated[bool, typer.Option("--json", help="One JSON object on stdout.")], False),
    "quiet": (
        Annotated[bool, typer.Option("--quiet", "-q", help="No progress and no notes.")],
        False,
    ),
    "threads": (
        Annotated[
            int | None,
            typer.Option("--threads", help="Threads; never changes a result. Default: all."),
        ],
        None,
    ),
    "dry_run": (
        Annotated[bool, typer.Option("--dry-run", help="Validate, print the plan and its cost.")],
        False,
    ),
}


def _refuse_threads(threads: int | None) -> None:
    """Raise SceneError for no threads, and for more than any machine has."""
    if threads is not None and not 1 <= threads <= MOST_THREADS:
        found, expected = f"found {threads}", f"expected 1 or more, at most {MOST_THREADS}"
        raise SceneError(Fault("--threads", "", found, expected, "leave it out for all"))


def command(
    app: typer.Typer,
    name: str,
    run: Callable[[Request], int],
    help_text: str,
    extra: Mapping[str, tuple[Any, Any]] | None = None,
    without: Collection[str] = (),
) -> None:
    """Register `cam NAME` with the shared options; `run` returns the exit code.

    `extra` declares options of this command alone, as in COMMON; they arrive in Request.extra.
    `without` names shared options that mean nothing to it.
    """
    own = dict(extra or {})
    shared = {key: value for key, value in COMMON.items() if key not in without}
    options = {**shared, **own}
    absent = {key: COMMON[key][1] for key in without}

    def call(**values: Any) -> None:
        values.update(absent)
        values["sets"] = values["sets"] or []
        values["extra"] = {key: values.pop(key) for key in own}
        _refuse_threads(values["threads"])
        raise typer.Exit(run(Request(**values)))

    call.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [
            inspect.Parameter(key, inspect.Parameter.KEYWORD_ONLY, annotation=kind, default=default)
            for key, (kind, default) in options.items()
        ]
    )
    call.__annotations__ = {key: kind for key, (kind, _) in options.items()}
    app.command(name, help=help_text)(call)

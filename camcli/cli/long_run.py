"""A command that works in pieces: the key of its run, and what it says of pieces on disk."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from camcli.cli.exit_codes import note
from camcli.cli.options import Request
from camcli.cli.setup import Setup
from camcli.errors import Fault, SceneError
from camcli.output.run_folder import PIECES, RunFolder, run_folder
from camcli.parallel import Shard
from camcli.scene import resolved

FORMAT = 2  # of what the pieces hold
MOST_SHARDS = 100_000


@contextmanager
def long_run(command: str, request: Request, setup: Setup) -> Iterator[RunFolder]:
    """The run folder of a command; the block ends early where only a shard was asked for.

    Where it is interrupted the finished pieces stay, and the same command goes on from them.
    """
    with run_folder(
        request.folder(command),
        key_of(command, request, setup),
        threads=request.threads,
        cluster=request.extra.get("cluster"),
        shard=shard_of(request),
        parts=request.parts,
    ) as run:
        checkpoint = run.work.checkpoint
        assert checkpoint is not None
        if not request.quiet:
            _tell(run, request)
        try:
            yield run
        except KeyboardInterrupt:
            if checkpoint.pieces and request.scene is None:
                note(f"{checkpoint.pieces} pieces are on disk, the same command goes on from them")
            raise
    if run.shard_done and not request.quiet:
        note(f"{checkpoint.path}: complete; once all are, cam merge {run.folder}")


def _tell(run: RunFolder, request: Request) -> None:
    """Note the pieces that are on disk: ours, a torn one, and those of other runs."""
    checkpoint = run.work.checkpoint
    assert checkpoint is not None
    others = [p for p in run.folder.glob(f".*{PIECES}") if p != checkpoint.path]
    if others:
        size = sum(p.stat().st_size for p in others) / 1e6
        names = ", ".join(p.name for p in others[:3]) + (", ..." if len(others) > 3 else "")
        note(f"{run.folder}/ keeps unfinished work of other scenes ({names}; {size:.3g} MB)")
    if run.resumed and not request.parts:
        note(f"going on: {run.resumed} pieces are on disk")
    if checkpoint.torn:
        note(f"a piece was torn: the last {checkpoint.torn} bytes are computed again")


def key_of(command: str, request: Request, setup: Setup) -> dict[str, Any]:
    """Everything beside the program that decides a result, and how to ask for it again."""
    options = {key: value for key, value in request.as_options().items() if key != "plot"}
    scene = resolved(setup.scene)
    return {
        "format": FORMAT,
        "command": command,
        "scene": {key: scene[key] for key in ("follower", "cam", "run", command)},
        "options": {**options, "rpm": None, "points": None, "set": []},  # they are in the scene
    }


def shard_of(request: Request) -> Shard | None:
    """The shard of --shard I/N; raises SceneError."""
    text = request.extra.get("shard")
    if text is None:
        return None
    number, _, count = text.partition("/")
    if number.isascii() and number.isdigit() and count.isascii() and count.isdigit():
        shard = Shard(int(number), int(count))
        if 1 <= shard.number <= shard.total <= MOST_SHARDS:
            return shard
    expected = f"expected I/N with 1 <= I <= N <= {MOST_SHARDS}"
    raise SceneError(Fault("--shard", "", f"found '{text}'", expected, "e.g. 3/16"))

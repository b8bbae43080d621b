"""The frame of a long run: its folder, its pieces on disk, and what an interrupt leaves."""

from __future__ import annotations

import errno
import json
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from camcli.cli.exit_codes import DONE, note
from camcli.cli.options import Request
from camcli.cli.setup import Setup
from camcli.errors import Fault, SceneError
from camcli.output.program import program_hash
from camcli.output.run_folder import Store, locked, unwritable
from camcli.parallel import Shard, Work
from camcli.parallel.journal import Journal, JournalError
from camcli.parallel.pieces import END
from camcli.scene import resolved

PIECES = ".pieces"
NO_ROOM = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS}
PASSING = "cam-rerun-"  # begins the names of folders that go at the end
FORMAT = 1  # of what the pieces hold


@dataclass(frozen=True)
class Desk:
    """Where a run works; `store` is None for a shard, which makes no artefacts."""

    work: Work
    store: Store | None
    journal: Journal


@contextmanager
def working(command: str, request: Request, setup: Setup) -> Iterator[Desk]:
    """Lock the folder and open the pieces of this very work; forget them once it is finished.

    Where the block ends early the pieces stay, and the same command goes on from them. Raises
    SceneError for a folder that cannot be used, and for a full disk in the middle of the work.
    """
    folder, shard = request.folder(command), shard_of(request)
    header = header_of(command, request, setup)
    with ExitStack() as stack:
        store = stack.enter_context(Store(folder)) if shard is None else None
        path = folder / _name(command, header, shard)
        journal = _opened(stack, path, header, request)
        work = Work(request.threads, journal, shard=shard)
        if request.extra.get("cluster") is not None:
            from camcli.parallel.dask_cluster import DaskCluster

            cluster = DaskCluster(request.extra["cluster"], work.threads, program_hash)
            work.cluster = stack.enter_context(cluster)
        try:
            yield Desk(work, store, journal)
        except KeyboardInterrupt:
            if journal.index and not folder.name.startswith(PASSING):
                note(f"{len(journal.index)} pieces are on disk, the same command goes on from them")
            raise
        except JournalError as error:
            raise _foreign(path, str(error)) from None
        except OSError as error:
            if error.errno in NO_ROOM:
                raise unwritable(folder, path.name, error) from None
            raise
        if shard is None:
            journal.discard()


def shard_done(desk: Desk, request: Request) -> int:
    """Mark the shard as complete, say what comes next; the exit code."""
    desk.journal.put(END, list(desk.work.shard))
    if not request.quiet:
        note(f"{desk.journal.path}: complete; once all are, cam merge {desk.journal.path.parent}")
    return DONE


def _name(command: str, header: str, shard: Shard | None) -> str:
    if shard is not None:
        return f"{command}-{shard.number}-of-{shard.count}{PIECES}"
    return f".{command}-{sha256(header.encode()).hexdigest()[:12]}{PIECES}"


def _opened(stack: ExitStack, path: Path, header: str, request: Request) -> Journal:
    """The journal, said aloud where there are pieces in it already."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.name.startswith("."):
            path.touch()
            stack.callback(_unlock, locked(path))
        journal = Journal(path, header, request.parts)
    except JournalError as error:
        raise _foreign(path, str(error)) from None
    except OSError as error:
        raise unwritable(path.parent, path.name, error) from None
    stack.callback(_leave, journal)
    journal.found = sum(name != END for name in journal.index)
    _tell_of_others(path, request)
    if journal.found and not request.parts and not request.quiet:
        note(f"going on: {journal.found} pieces are on disk")
    if journal.torn and not request.quiet:
        note(f"a piece was torn, what was behind it ({journal.torn} bytes) is computed again")
    return journal


def _foreign(path: Path, found: str) -> SceneError:
    """The refusal of a file of pieces that are not ours, or damaged."""
    cure = "delete the file, or choose another folder"
    return SceneError(Fault("-o", str(path), found, "expected pieces of this run", cure))


def _tell_of_others(path: Path, request: Request) -> None:
    """Note pieces of other scenes, options or versions that an interrupted run left here."""
    others = [p for p in path.parent.glob(f".*{PIECES}") if p != path]
    if others and not request.quiet:
        size = sum(p.stat().st_size for p in others) / 1e6
        names = ", ".join(p.name for p in others[:3]) + (", ..." if len(others) > 3 else "")
        note(f"{path.parent}/ keeps unfinished work of other scenes ({names}; {size:.3g} MB)")


def _leave(journal: Journal) -> None:
    """Close the journal; one without any piece goes."""
    if journal.index:
        journal.close()
    else:
        journal.discard()


def _unlock(handle: int | None) -> None:
    import os

    if handle is not None:
        os.close(handle)


def header_of(command: str, request: Request, setup: Setup) -> str:
    """What the pieces belong to: everything that decides a result, and how to ask for it again."""
    options = {key: value for key, value in request.as_options().items() if key != "plot"}
    scene = resolved(setup.scene)
    what = {
        "format": FORMAT,
        "command": command,
        "scene": {key: scene[key] for key in ("follower", "cam", "run", command)},
        "options": {**options, "rpm": None, "points": None, "set": []},  # they are in the scene
        "program": program_hash(),
    }
    return json.dumps(what, sort_keys=True, default=str)


def shard_of(request: Request) -> Shard | None:
    """The shard of --shard I/N; raises SceneError."""
    text = request.extra.get("shard")
    if text is None:
        return None
    number, _, count = text.partition("/")
    if number.isascii() and number.isdigit() and count.isascii() and count.isdigit():
        shard = Shard(int(number), int(count))
        if 1 <= shard.number <= shard.count <= MOST_SHARDS:
            return shard
    expected = f"expected I/N with 1 <= I <= N <= {MOST_SHARDS}"
    raise SceneError(Fault("--shard", "", f"found '{text}'", expected, "e.g. 3/16"))


MOST_SHARDS = 100_000

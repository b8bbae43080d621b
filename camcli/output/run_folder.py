"""The folder of one run: locked while it is at work, its artefacts changed at the end at once.

with run_folder(folder, key, threads=2) as run:
    result = sweep(..., work=run.work)         # finished pieces go on disk; a killed run resumes
    run.write_text("speeds.csv", lines)        # beside its place
    run.commit()                               # all of them in their places
"""

import json
import os
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from hashlib import file_digest, sha256
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

from camcli.errors import Fault, SceneError
from camcli.interrupts import finished, signals_held, unfinished
from camcli.output.program import program_hash
from camcli.parallel import Checkpoint, Shard, ShardDone, Work, in_threads
from camcli.parallel.checkpoint import END
from camcli.piece_faults import fault_records

PART, PIECES = ".cam-part", ".pieces"  # endings of files that are gone when a run has finished
RECORD = "run.json"
MOST_TRIES = 100  # to make a folder that others make and remove at the same time
NO_FOLDER = "found no way to create it (it is not there, or removed again and again)"


class UnwritableError(SceneError):
    """A file or folder cannot be written."""


class RunFolder:
    """What a run writes, and how its pieces are run (see `run_folder`)."""

    def __init__(self, folder: Path, work: Work):
        """Work in this folder, and run pieces as `work` says."""
        self.folder = folder
        self.work = work
        self.before: dict[str, str] = {}  # what the run before lists, where it is as it was
        self.mixed: list[str] = []  # files that a run left when it was killed in its commit
        self.removed: list[str] = []  # files of the run before that this one has not made
        self.committed = False
        self.shard_done = False
        self._replaceable: set[str] = set()  # files that earlier runs have left
        self._hashes: dict[str, str] = {}
        self._flushing: dict[str, Future[str]] = {}  # files that may not be on the disk yet
        self._threads = ThreadPoolExecutor(2)  # one may wait for the disk while the other reads

    @property
    def resumed(self) -> int:
        """Pieces that an earlier run had left on disk."""
        return self.work.checkpoint.resumed if self.work.checkpoint is not None else 0

    @property
    def names(self) -> list[str]:
        """The names of what was written."""
        return [*self._hashes, *self._flushing]

    @property
    def hashes(self) -> dict[str, str]:
        """SHA-256 by name of what was written, in this order; all of it is on the disk then."""
        self._wait_for_the_disk()
        return self._hashes

    def _wait_for_the_disk(self) -> None:
        """Return when all that was written is on the disk; raises UnwritableError."""
        for name, future in list(self._flushing.items()):
            del self._flushing[name]
            with self._removed_if_not_written(name):
                self._hashes[name] = future.result()

    def write(self, name: str, fill: Callable[[BinaryIO], Any]) -> None:
        """Let `fill` write the bytes of `name`; an earlier file stays until `commit`.

        Another thread waits for the disk and reads the file for its hash, so that the next one may
        be written meanwhile; what the disk refuses is told where the hashes are asked for.
        """
        with self.writing(name) as file:
            fill(file)

    @contextmanager
    def writing(self, name: str) -> Iterator[BinaryIO]:
        """A file that the block fills with the bytes of `name`, see `write`.

        Several may be open at the same time; they are listed in the order in which they are closed.
        """
        if name in self.names:
            del self.hashes[name]
        part = self._part(name)
        unfinished(part)
        with self._removed_if_not_written(name), open(part, "wb") as file:
            yield file
        self._flushing[name] = self._threads.submit(_flushed, part)

    @contextmanager
    def _removed_if_not_written(self, name: str) -> Iterator[None]:
        """Remove what there is of a file where the block fails; raises UnwritableError."""
        try:
            yield
        except BaseException as error:
            part = self._part(name)
            part.unlink(missing_ok=True)
            finished(part)
            if isinstance(error, OSError):
                raise _unwritable(self.folder, name, error) from None
            raise

    def write_whole(self, name: str, fill: Callable[[BinaryIO], Any]) -> None:
        """Write a file, of which nothing is written before `fill` has made all its bytes.

        An error of `fill` is then its own, and not one of the folder.
        """
        content = BytesIO()
        fill(content)
        self.write(name, lambda file: file.write(content.getbuffer()))

    def write_text(self, name: str, chunks: Iterable[str]) -> None:
        """Write `name` from pieces of text."""
        self.write(name, lambda file: file.writelines(chunk.encode() for chunk in chunks))

    def note_earlier_runs(self) -> None:
        """Take note of the files that earlier runs have left here: this run may replace them.

        They are listed in run.json. A run that was killed while it renamed its files leaves the
        run.json that was to come last under its unfinished name; what that one lists and is in its
        place already may be replaced, too.
        """
        listed = listed_in(self.folder / RECORD)
        self.before = unchanged(self.folder, listed or {})
        of_killed_run = unchanged(self.folder, listed_in(self._part(RECORD)) or {})
        self.mixed = [name for name in of_killed_run if name not in self.before]
        self._replaceable = {*self.before, *of_killed_run}
        if listed is not None:  # a run may leave its run.json alone
            self._replaceable.add(RECORD)

    def claim(self, names: Iterable[str]) -> None:
        """Raise SceneError where one of these files is there and no run has made it as it is."""
        faults = []
        for name in names:
            if name not in self._replaceable and os.path.lexists(self.folder / name):
                found = f"found {name}, which no run has left there as it is"
                cure = "move it away, or choose another folder"
                faults.append(Fault("-o", str(self.folder), found, "expected no such file", cure))
        if faults:
            raise SceneError(*faults)

    def keep_pictures(self, names: Collection[str], scene_sha256: str) -> dict[str, str]:
        """The pictures of the run before that show this one as well, SHA-256 by name.

        names: of all pictures. They are kept where that run had the same scene and left the same
        other files.
        """
        if not self.before:
            return {}
        other_files = {name: sha for name, sha in self.before.items() if name not in names}
        if other_files != self.hashes:
            return {}
        if scene_sha256.encode() not in (self.folder / RECORD).read_bytes():
            return {}
        return {name: self.before[name] for name in names if name in self.before}

    def commit(self, kept: Collection[str] = ()) -> None:
        """Put everything written in its place, run.json last: by renames, so each file is whole.

        With a new run.json the artefacts go that only the run before had, but for those `kept`; any
        other file in the folder is somebody's, or has been changed by somebody since. A signal
        waits until all is done.
        """
        names = [name for name in self.hashes if name != RECORD]
        if RECORD in self.hashes:
            names.append(RECORD)
            still_made = {*self.hashes, *kept}
            stale = {name: sha for name, sha in self.before.items() if name not in still_made}
            self.removed = list(unchanged(self.folder, stale))
        try:
            with signals_held():
                for name in names:
                    if name == RECORD:
                        for other in self.removed:
                            _remove(self.folder / other)
                    os.replace(self._part(name), self.folder / name)
                self.committed = True
                _sync(self.folder)  # the renames are on disk before the pieces are forgotten
        except OSError as error:
            raise _unwritable(self.folder, name, error) from None

    def replace_record(self, text: str) -> None:
        """Put another run.json in the place of the one that was committed; all else stays."""
        self.write_text(RECORD, [text])
        self._wait_for_the_disk()
        with signals_held():
            os.replace(self._part(RECORD), self.folder / RECORD)

    def close(self) -> None:
        """Remove what was written and not committed; the files of the run before stay."""
        self._threads.shutdown(cancel_futures=True)
        for name in self.names:
            part = self._part(name)
            part.unlink(missing_ok=True)
            finished(part)

    def _part(self, name: str) -> Path:
        """Where a file is while it is not in its place yet."""
        return self.folder / f".{name}{PART}"


@contextmanager
def run_folder(
    folder: Path,
    key: Mapping[str, Any] | None = None,
    *,
    threads: int | None = None,
    cluster: str | None = None,
    shard: Shard | None = None,
    parts: tuple[Path, ...] = (),
    names: Collection[str] = (),
    about: Mapping[str, Any] | None = None,
) -> Iterator[RunFolder]:
    """Lock the folder for a run, and open the pieces that an earlier run of this key has left.

    key: plain values that decide the results, beside the program (its `command` names the file of
    pieces); None: nothing is kept. The pieces stay where the block ends without a commit, so that a
    run with the same key goes on from them. cluster: `local` or HOST:PORT of a Dask scheduler.
    shard: only pieces of this part are made, no artefacts: the block ends early, without an
    exception, and `shard_done` is set. parts: files of shards, whose pieces are read. names: files
    that the run is going to write, see `RunFolder.claim`. about: what a complete shard says beside
    its number, for who merges it.

    Raises SceneError where the folder cannot be written, or another run is at work in it.
    """
    run = RunFolder(folder, Work(threads, shard=shard))
    with ExitStack() as stack:
        whole_key = path = None
        if key is not None:
            whole_key = json.dumps({**key, "program_sha256": program_hash()}, sort_keys=True)
            path = folder / _name_of_pieces(key.get("command", "run"), whole_key, shard)
        if shard is None:
            stack.enter_context(_folder_alone(folder))
            run.note_earlier_runs()
            run.claim([*names, RECORD] if names else ())
            stack.callback(run.close)
            for unfinished_file in folder.glob(f".*{PART}"):  # of a run that was killed
                _remove(unfinished_file)
        elif path is not None:
            stack.enter_context(_pieces_alone(folder, path))
        if path is not None and whole_key is not None:
            try:
                checkpoint = Checkpoint(path, whole_key, parts)
            except OSError as error:
                raise _unwritable(folder, path.name, error) from None
            run.work.checkpoint = checkpoint
            stack.callback(checkpoint.close)
        if cluster is not None:
            from camcli.parallel.dask_cluster import DaskCluster

            run.work.cluster = stack.enter_context(DaskCluster(cluster, threads, program_hash))
        try:
            yield run
        except ShardDone:  # raised by `Work` when the pieces of this shard are on disk
            assert shard is not None
            end = {**(about or {}), "shard": list(shard)}
            if run.work.faults:
                end["piece_faults"] = fault_records(run.work.faults)
            checkpoint.put(END, 0, end)
            run.shard_done = True
        finally:
            if run.committed and key is not None:
                checkpoint.discard()


def _name_of_pieces(command: str, key: str, shard: Shard | None) -> str:
    """The name of the file that keeps finished pieces.

    key: all that the pieces depend on, in a text. That of a shard is visible, since somebody moves
    it.
    """
    if shard is not None:
        return f"{command}-{shard.number}-of-{shard.total}{PIECES}"
    return f".{command}-{sha256(key.encode()).hexdigest()[:12]}{PIECES}"


@contextmanager
def _folder_alone(folder: Path) -> Iterator[None]:
    """Make the folder, and have it alone; an empty one that was made here goes at the end.

    Only who has the lock removes the folder. A run that begins while another one ends may have
    locked the folder that is just removed: it then makes and locks a new one.
    Raises SceneError where the folder cannot be written, or another run has it.
    """
    made: list[Path] = []
    for _ in range(MOST_TRIES):
        made += [path for path in _prepare(folder) if path not in made]
        with ExitStack() as stack:
            still_there = stack.enter_context(_locked(folder))
            if still_there:
                stack.callback(_remove_empty, made)
                yield
                return
    raise _refused(folder, NO_FOLDER)


@contextmanager
def _pieces_alone(folder: Path, path: Path) -> Iterator[None]:
    """Make the file of the pieces of a shard in the folder, and have that file alone.

    Other shards may be at work in the same folder. Raises SceneError as `_folder_alone`.
    """
    for _ in range(MOST_TRIES):
        made = _prepare(folder)
        with ExitStack() as stack:
            try:
                path.touch()
            except FileNotFoundError:  # another shard has removed the folder, which was empty
                continue
            except OSError as error:
                raise _unwritable(folder, path.name, error) from None
            stack.callback(_remove_empty, made)
            still_there = stack.enter_context(_locked(path))
            if still_there:
                yield
                return
    raise _refused(folder, NO_FOLDER)


def _prepare(folder: Path) -> list[Path]:
    """Create the folder, or raise SceneError where nothing could be written into it.

    Returns what was not there before, the folder itself first. Another run may remove it at once,
    where it has made it too.
    """
    made = [path for path in (folder, *folder.parents) if not os.path.lexists(path)]
    for _ in range(MOST_TRIES):
        try:
            folder.mkdir(parents=True, exist_ok=True)
            break
        except FileNotFoundError:  # another run has removed a folder above it
            continue
        except (FileExistsError, NotADirectoryError):
            if not os.path.lexists(folder):  # another run has removed it meanwhile
                continue
            raise _refused(folder, "found a file where the folder should be") from None
        except OSError as error:
            raise _refused(folder, f"found no way to create it ({error.strerror})") from None
    else:
        raise _refused(folder, NO_FOLDER)
    if not os.access(folder, os.W_OK | os.X_OK) and os.path.lexists(folder):
        raise _refused(folder, "found a folder that may not be written")
    return made


def _remove_empty(made: list[Path]) -> None:
    """Leave no empty folder behind where a run has ended before anything was written."""
    with suppress(OSError):
        for path in made:
            path.rmdir()


@contextmanager
def _locked(path: Path) -> Iterator[bool]:
    """Hold a lock on a folder or file, where the system has locks.

    Gives whether it is still there: False where another run has removed it meanwhile, so that what
    was locked has no name any more. The lock belongs to the open file, not to the process: of two
    runs in one process one is refused. Raises SceneError where another run has it.
    """
    with ExitStack() as stack:
        still_there = True
        try:
            import fcntl

            handle = os.open(path, os.O_RDONLY)
            stack.callback(os.close, handle)
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            still_there = os.path.samestat(os.fstat(handle), os.stat(path))
        except BlockingIOError:
            found, cure = "found another run at work here", "wait for it, or choose another"
            raise SceneError(Fault("-o", str(path), found, "expected it free", cure)) from None
        except FileNotFoundError:
            still_there = False
        except (ImportError, OSError):
            pass  # a system, or a file system, without locks
        yield still_there


def _remove(path: Path) -> None:
    """Remove a file, if it is there; raises UnwritableError where that cannot be done."""
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        found = f"{path.name} could not be removed ({error.strerror})"
        raise _refused(path.parent, found) from None


def listed_in(record: Path) -> dict[str, str] | None:
    """The artefacts of a run.json, SHA-256 by name; None where it is something else."""
    if not record.is_file():
        return None
    try:
        return dict(json.loads(record.read_bytes())["artefacts"])
    except (OSError, ValueError, TypeError, LookupError, RecursionError):
        return None


def unchanged(folder: Path, listed: Mapping[str, str]) -> dict[str, str]:
    """The listed files that are in the folder with just the bytes that were listed.

    listed: SHA-256 by name, as `listed_in` gives them. A name that leads elsewhere is left out.
    """
    names = []
    for name in listed:
        path = folder / name
        leads_elsewhere = name != path.name or path.is_symlink()
        if path.is_file() and not leads_elsewhere:
            names.append(name)
    hashes = in_threads(lambda name: _hash(folder / name), names)
    return {name: sha for name, sha in zip(names, hashes, strict=True) if sha == listed[name]}


def _sync(folder: Path) -> None:
    """Wait until the names of the files in a folder are on the disk, where the system can do it."""
    with suppress(OSError):  # not every system opens folders, or syncs them
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _flushed(path: Path) -> str:
    """The SHA-256 of a file, once it is on the disk."""
    with open(path, "r+b") as file:
        os.fsync(file.fileno())
        return file_digest(file, "sha256").hexdigest()


def _hash(path: Path) -> str:
    """The SHA-256 of a file."""
    with open(path, "rb") as file:
        return file_digest(file, "sha256").hexdigest()


def _unwritable(folder: Path, name: str, error: OSError) -> UnwritableError:
    """What to raise where the system would not write a file."""
    return _refused(folder, f"{name} could not be written ({error.strerror})")


def _refused(folder: Path, found: str) -> UnwritableError:
    """What to raise where a folder cannot be used, with what was found."""
    expected, cure = "expected a writable folder", "choose another"
    return UnwritableError(Fault("-o", str(folder), found, expected, cure))

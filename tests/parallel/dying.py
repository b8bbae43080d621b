"""`cam` that kills itself at a chosen moment: python dying.py WHERE NUMBER SIGNAL WORDS...

WHERE: half (half of a record is in the file of pieces), put (a record is), fsync (an artefact is
written beside its place), replace (it is about to go there), unlink (a file is about to go),
slow (never; NUMBER ms are added to every piece).
"""

import os
import signal
import sys
import time
from pathlib import Path

from camcli.parallel import pieces as work
from camcli.parallel.journal import Journal


def before(owner, name: str, number: int, end) -> None:
    """Call `end` before the call `number` of a function."""
    original, left = getattr(owner, name), number

    def dying(*args, **options):
        nonlocal left
        left -= 1
        if left == 0:
            end()
        return original(*args, **options)

    setattr(owner, name, dying)


class Half:
    """A file of which the next write is cut in the middle."""

    def __init__(self, file, end):
        self.file, self.end = file, end

    def __getattr__(self, name):
        return getattr(self.file, name)

    def write(self, data):
        """Half of it, then the end."""
        done = self.file.write(data[: len(data) // 2])
        self.end()
        return done


def in_record(number: int, end) -> None:
    """Die in the middle of the record `number` after the header."""
    append, left = Journal._append, number + 1

    def dying(journal, name, value):
        nonlocal left
        left -= 1
        if left == 0:
            journal._file = Half(journal._file, end)
        return append(journal, name, value)

    Journal._append = dying


def slowly(seconds: float) -> None:
    """Make every piece that is kept slow."""
    keep = work._Call.keep

    def slow(call, k, result):
        time.sleep(seconds)
        return keep(call, k, result)

    work._Call.keep = slow


def main() -> None:
    """Arm, then run `cam`."""
    where, number, how = sys.argv[1], int(sys.argv[2]), signal.Signals[sys.argv[3]]
    sys.argv = ["cam", *sys.argv[4:]]

    def end() -> None:
        os.kill(os.getpid(), how)

    if where == "half":
        in_record(number, end)
    elif where == "slow":
        slowly(number / 1000)
    else:
        owners = {"put": (Journal, "put"), "fsync": (os, "fsync"), "unlink": (Path, "unlink")}
        before(*owners.get(where, (os, "replace")), number, end)
    from camcli.cli.app import main as run

    run()


if __name__ == "__main__":
    main()

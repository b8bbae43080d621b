"""`cam` that kills itself at a chosen moment: python dying.py WHERE NUMBER SIGNAL WORDS...

WHERE: half (half of a piece is on disk), put (a piece is), fsync (an artefact is written beside its
place), replace (it is about to go there), unlink (a file is about to go), slow (never; NUMBER ms
are added to every piece).
"""

import os
import signal
import sys
import time
from pathlib import Path

from camcli.parallel.checkpoint import Checkpoint
from camcli.parallel.work import Kept


def before(owner, name: str, number: int, act) -> None:
    """Call act(first argument) before the call `number` of a function."""
    original, left = getattr(owner, name), number

    def dying(*args, **options):
        nonlocal left
        left -= 1
        if left == 0:
            act(args[0])
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


def main() -> None:
    """Arm, then run `cam`."""
    where, number, how = sys.argv[1], int(sys.argv[2]), signal.Signals[sys.argv[3]]
    sys.argv = ["cam", *sys.argv[4:]]

    def end(_=None) -> None:
        os.kill(os.getpid(), how)

    def cut(checkpoint) -> None:
        checkpoint._file = Half(checkpoint._file, end)

    if where == "half":
        before(Checkpoint, "put", number, cut)
    elif where == "slow":
        put = Kept.put
        Kept.put = lambda *args: time.sleep(number / 1000) or put(*args)
    else:
        owners = {"put": (Checkpoint, "put"), "unlink": (Path, "unlink"), "fsync": (os, "fsync")}
        before(*owners.get(where, (os, "replace")), number, end)
    from camcli.cli.app import main as run

    run()


if __name__ == "__main__":
    main()

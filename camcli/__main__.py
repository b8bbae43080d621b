"""`cam` and `python -m camcli`."""

import _signal  # `signal` without its enums, which take milliseconds to import
import gc
import os
import sys

OLDEST = (3, 11)  # Python's version, as in pyproject.toml


def _end(number: int, frame: object) -> None:
    """End the process at once: nothing has begun."""
    os.write(2, b"interrupted\n")
    os._exit(130)


def main() -> None:
    """Run the command line; an interrupt while it is still being loaded is one like any other.

    Before this function Python itself is starting, and tells an interrupt in its own way.
    """
    if sys.version_info < OLDEST:  # pip refuses it too, but a checkout runs without pip
        found, needed = (".".join(map(str, v[:2])) for v in (sys.version_info, OLDEST))
        sys.exit(f"cam: found Python {found}, expected {needed} or newer")
    for number in (_signal.SIGINT, _signal.SIGTERM):
        if _signal.getsignal(number) != _signal.SIG_IGN:
            _signal.signal(number, _end)
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its threads spin until there is work
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # looked for in every package
    gc.set_threshold(300_000)  # a start makes many objects and no garbage: a tenth of its time
    from camcli.cli.app import main as run

    run()


if __name__ == "__main__":
    main()

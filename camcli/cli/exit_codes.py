"""What a user sees at the end: the result once the artefacts are in place, a message per fault, the
exit code."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from contextlib import suppress
from io import BytesIO, TextIOWrapper
from typing import TextIO

from camcli.errors import Fault, SceneError, printable

DONE, INTERNAL, USAGE, NUMERICS, INTERRUPTED = 0, 1, 2, 3, 130


def guarded(call: Callable[[], object]) -> int:
    """Run `call`; the exit code it returns, or the one of its failure after saying what failed."""
    try:
        code = call()
        _release()
        if code == INTERRUPTED:  # the option parser has caught the interrupt
            note("interrupted")
        return code if isinstance(code, int) else DONE
    except SceneError as error:
        for fault in error.faults:
            note(str(fault))
        return USAGE
    except KeyboardInterrupt:
        note("interrupted")
        return INTERRUPTED
    except MemoryError:
        note("cam: out of memory: ask for fewer speeds or recorded turns (cam ... --dry-run)")
        return INTERNAL
    except Exception as error:
        return _other(error)
    finally:
        with suppress(SceneError):
            _release()


def _other(error: Exception) -> int:
    """Usage errors of the option parser, and faults of the program itself."""
    if hasattr(error, "exit_code") and hasattr(error, "format_message"):
        text = error.format_message()
        note(text if type(error).__name__ == "NoArgsIsHelpError" else f"cam: {printable(text)}")
        return USAGE
    if hasattr(error, "exit_code"):
        return int(error.exit_code)
    if type(error).__name__ == "Abort":
        note("interrupted")
        return INTERRUPTED
    note(f"cam: internal fault: {type(error).__name__}: {error}")
    note("This is a fault of camcli, please report it. CAMCLI_TRACEBACK=1 shows where it happened.")
    if os.environ.get("CAMCLI_TRACEBACK"):
        raise error
    return INTERNAL


def note(text: str) -> None:
    """A line on stderr; one that cannot be written is dropped."""
    try:
        print(text, file=sys.stderr, flush=True)
    except OSError:
        _to_nowhere(sys.stderr)


class Held(TextIOWrapper):
    """Text for a stdout that nobody watches; its encoding decides how tables are drawn."""

    def __init__(self, real: TextIO):
        self.bytes = BytesIO()
        super().__init__(self.bytes, encoding=real.encoding, errors=real.errors)
        self.real = real


def hold_output() -> None:
    """Hold stdout back until the artefacts are in place, unless a person watches.

    A stream that is closed takes everything and shows nothing.
    """
    if sys.stdout is None:
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115 - for the rest of the process
    elif not sys.stdout.isatty():
        sys.stdout = Held(sys.stdout)
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115


def _release() -> None:
    """Let stdout go; a reader that has left is no fault, a full disk is one of stdout alone."""
    sys.stdout.flush()
    if not isinstance(sys.stdout, Held):
        return
    held, real = sys.stdout.bytes.getvalue(), sys.stdout.real
    sys.stdout.bytes.seek(0)
    sys.stdout.bytes.truncate()
    try:
        real.buffer.write(held)
        real.flush()
    except OSError as error:
        _to_nowhere(real)
        if not isinstance(error, BrokenPipeError):
            found = f"could not be written ({error.strerror})"
            raise SceneError(Fault("stdout", "", found, "", "the artefacts are complete")) from None


def _to_nowhere(stream: TextIO) -> None:
    """Drop what the stream still holds, and all that comes."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)

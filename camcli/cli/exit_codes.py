"""Failures as a user sees them: one clear message per fault on stderr, and the exit code."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from contextlib import suppress

from camcli.errors import Fault, SceneError, printable

DONE, INTERNAL, USAGE, NUMERICS, INTERRUPTED = 0, 1, 2, 3, 130


def guarded(call: Callable[[], object]) -> int:
    """Run `call`; the exit code it returns, or the one of its failure after saying what failed."""
    try:
        code = call()
        _flush()
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
        with suppress(OSError, SceneError):
            _flush()


def _flush() -> None:
    """Let stdout go; a reader that has left is no fault, a full disk is one of stdout alone."""
    from camcli.cli.held_output import release_output

    try:
        release_output()
    except OSError as error:
        if not isinstance(error, BrokenPipeError):
            found = f"could not be written ({error.strerror})"
            raise SceneError(Fault("stdout", "", found, "", "the artefacts are complete")) from None


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
    """A line on stderr."""
    print(text, file=sys.stderr, flush=True)

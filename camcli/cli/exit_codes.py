"""What a user sees at the end: the result once the artefacts are in place, a message per fault, the
exit code."""

import codecs
import errno
import os
import re
import sys
from collections.abc import Callable
from contextlib import suppress
from io import BytesIO, TextIOWrapper
from typing import Any, TextIO

from camcli.errors import Fault, SceneError, shown
from camcli.interrupts import interrupt_arrived, signal_came

SCENES = (".yaml", ".yml", ".json")  # how the names of scene files end
BYTES_OR_ESCAPES = "camcli.bytes-or-escapes"  # a way for Python's streams to write odd letters
DONE, INTERNAL, USAGE, NUMERICS, INTERRUPTED = 0, 1, 2, 3, 130
MEANING = {
    DONE: "done",
    INTERNAL: "a fault of camcli: what it cost (a speed, a block of cells, a branch, a picture) "
    "has the status `fault` or is left out, all else is kept, and `piece_faults` of `run.json` "
    "has what a report needs",
    USAGE: "bad usage or a bad scene: `file:line:column: path: what was found, what is expected, "
    "what to do`, every fault at once",
    NUMERICS: "numerical trouble: all good rows are kept, the column `status` says which are not, "
    "and why; or what `cam orbits --all` or `--chaos` was to prove is not proved; or the scene "
    "still has numbers that `cam init` made up, as the first line says",
    INTERRUPTED: "interrupted: finished work is kept, the same command goes on",
}


def guarded(call: Callable[[], object], as_json: bool = False) -> int:
    """Run `call`; the exit code it returns, or the one of its failure after saying what failed.

    as_json: an object with the faults on stdout too.
    """
    faults: list[Fault] = []
    try:
        done = call()
        _release()
        code = done if isinstance(done, int) else DONE  # INTERRUPTED: the option parser caught it
    except SystemExit as end:  # what typer says of completion
        _release()
        code = end.code if isinstance(end.code, int) else DONE
    except SceneError as error:
        code = USAGE
        faults = list(error.faults)
    except KeyboardInterrupt:
        code = INTERRUPTED
    except Exception as error:
        code, faults = failure(error)
        code = INTERRUPTED if signal_came() else code  # a library made another error of it
    if code == INTERRUPTED:
        interrupt_arrived()
        faults = [Fault("", "", "interrupted", "", "")]
    for fault in faults:
        note(str(fault))
    with suppress(SceneError):
        if faults and as_json:
            import json
            from dataclasses import asdict

            records = [asdict(fault) for fault in faults]
            print(json.dumps({"exit_code": code, "faults": records}, indent=2))
        _release()
    return code


def failure(error: Exception) -> tuple[int, list[Fault]]:
    """Exit code and faults: usage errors of the option parser, limits of the system, our own."""
    from camcli.piece_faults import MOST_TEXT, SHORTAGES, PieceFault

    # the errors of the option parser, typer's or click's, are known by what they have
    if hasattr(error, "exit_code") and hasattr(error, "format_message"):
        if type(error).__name__ == "NoArgsIsHelpError":
            note(error.format_message())
            return USAGE, []
        return USAGE, [_refused_by_the_parser(error)]
    if hasattr(error, "exit_code"):
        return int(error.exit_code), []
    if type(error).__name__ == "Abort":
        return INTERRUPTED, []
    if isinstance(error, MemoryError) or any(words in str(error) for words in SHORTAGES):
        cure = "ask for fewer speeds, recorded turns or --threads (cam ... --dry-run)"
        return USAGE, [Fault("cam", "", "out of memory", "", cure)]
    if isinstance(error, OSError):
        return USAGE, [_refused_by_the_system(error)]
    if os.environ.get("CAMCLI_TRACEBACK"):
        raise error
    fault = PieceFault.of(error, "")
    found = f"internal fault: {shown(fault.error, MOST_TEXT)} ({fault.place})"
    cure = "this is a fault of camcli, please report it; CAMCLI_TRACEBACK=1 shows the traceback"
    return INTERNAL, [Fault("cam", "", found, "", cure)]


def _refused_by_the_parser(error: Any) -> Fault:
    """The fault for words that the option parser does not take, with what was probably meant."""
    text = error.format_message()
    extra_word = re.fullmatch(r"Got unexpected extra argument\S* \((\S+).*\)", text)
    cure = ""
    if extra_word:
        word = extra_word[1]
        if word.lower().endswith(SCENES) and _takes_a_scene(error):
            cure = f"did you mean -c {word}?"
        elif re.match(r"[\d.]", word):
            cure = f"give a speed or a range as --rpm {word}"
    return Fault("cam", "", text, "", cure)


def _takes_a_scene(error: Any) -> bool:
    """Whether the command that the option parser refused has the option -c."""
    command = getattr(getattr(error, "ctx", None), "command", None)
    return any("-c" in option.opts for option in getattr(command, "params", ()))


def _refused_by_the_system(error: OSError) -> Fault:
    """The fault for a file, folder or process that the system would not give."""
    try:
        os.getcwd()
    except OSError:
        return Fault("cam", "", "found no working folder: it was deleted", "", "cd to another")
    cures = {errno.EMFILE: "raise ulimit -n, or ask for fewer --threads"}
    cure = cures.get(error.errno or 0, "see what the system allows, then repeat the command")
    return Fault("cam", str(error.filename or ""), f"{error.strerror or error}", "", cure)


def note(text: str) -> None:
    """A line on stderr; one that cannot be written is dropped.

    On a terminal it is broken between words.
    """
    try:
        print(_broken(text) if sys.stderr.isatty() else text, file=sys.stderr, flush=True)
    except OSError:
        _to_nowhere(sys.stderr)


def _broken(text: str) -> str:
    """The text in lines of the terminal's width; long names stay whole."""
    from shutil import get_terminal_size
    from textwrap import fill

    form: Any = {"subsequent_indent": "  ", "break_long_words": False, "break_on_hyphens": False}
    width = get_terminal_size().columns
    return "\n".join(fill(line, width, **form) for line in text.splitlines())


class Held(TextIOWrapper):
    """Text for a stdout that nobody watches; its encoding decides how tables are drawn."""

    def __init__(self, real: TextIO):
        self.bytes = BytesIO()
        super().__init__(self.bytes, encoding=real.encoding, errors=_lenient(real.errors))
        self.real = real


def _lenient(errors: str | None) -> str:
    """How a stream writes what its encoding lacks, such as the bytes of a name that is no text.

    Where it would raise it writes the escapes of Python: no name costs a run its words. The locale
    C, whose streams hand bytes of names through, does so still.
    """
    if errors == "surrogateescape":
        codecs.register_error(BYTES_OR_ESCAPES, _bytes_or_escapes)
        return BYTES_OR_ESCAPES
    return "backslashreplace" if errors in (None, "strict") else errors


def _bytes_or_escapes(error: UnicodeError) -> tuple[bytes, int]:
    """The byte that a letter of a name stands for, else the letter's escape."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    letter = error.object[error.start]
    if "\udc80" <= letter <= "\udcff":  # how Python keeps a byte that is no letter
        return letter.encode("ascii", "surrogateescape"), error.start + 1
    return letter.encode("ascii", "backslashreplace"), error.start + 1


def hold_output() -> None:
    """Hold stdout back until the artefacts are in place, unless a person watches.

    A stream that is closed takes everything and shows nothing.
    """
    if sys.stdout is None:
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115 - for the rest of the process
    elif not sys.stdout.isatty():
        sys.stdout = Held(sys.stdout)
    elif isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors=_lenient(sys.stdout.errors))
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115


def _release() -> None:
    """Let stdout go; a reader that has left is no fault, a full disk is one of stdout alone."""
    sys.stdout.flush()
    if not isinstance(sys.stdout, Held):
        return
    held = sys.stdout.bytes.getvalue()
    real = sys.stdout.real
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

"""cam rerun: the run of a run.json again, and whether its bytes agree."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Argument, Option

from camcli.cli.exit_codes import DONE, NUMERICS, note
from camcli.cli.options import Request

if TYPE_CHECKING:
    from camcli.cli.record import Record

HomeFolder = Annotated[
    Path | None,
    Option("--folder", help="Where the files are that the scene names.", metavar="DIR"),
]
REPEATED = ("config", "sets", "rpm", "points", "dry_run")  # these stand in the record
SAME, OTHER, MISSING = "same bytes", "other bytes", "not made"


def rerun(
    request: Request,
    record: Annotated[Path, Argument(help="A run.json.", metavar="FILE")],
    folder: HomeFolder = None,
) -> int:
    """Run again what a run.json records, and say whether the bytes agree.

    \b
    Exit code 3 where a CSV differs. Artefacts go to a temporary folder, or to -o. For all commands
    but bench and figures. A lift table is looked for beside FILE, or in --folder.
    """
    from tempfile import TemporaryDirectory

    from camcli.cli.record import read_record, refusal

    found = read_record(record)
    if not found.artefacts:
        raise refusal(record, "found no artefacts in it")
    home = folder or record.parent
    if request.out is not None:
        return _compare(request, found, request.out, home)
    with TemporaryDirectory(prefix="cam-rerun-") as place:
        return _compare(request, found, Path(place), home)


def _compare(request: Request, record: Record, out: Path, home: Path) -> int:
    import json

    from camcli.cli.report import progress_bar, table
    from camcli.cli.run import IN_PIECES, IN_THREADS, analysis, compiling, key_of
    from camcli.output.program import program_hash
    from camcli.output.run_folder import run_folder

    scene, more = record.load(home), record.options.arguments()
    key = key_of(record.command, scene) if record.command in IN_PIECES else None
    with compiling(request), run_folder(out, key, threads=request.threads) as folder:
        if record.command in IN_THREADS:
            more["work"] = folder.work
        with progress_bar(request.quiet) as progress:
            result = analysis(record.command)(scene, progress, **more)
        now = result.write(folder, plot=record.options.plot)["artefacts"]
    verdicts = {
        name: MISSING if name not in now else SAME if now[name] == digest else OTHER
        for name, digest in record.artefacts.items()
    }
    differ = [name for name, verdict in verdicts.items() if verdict != SAME]
    if request.json:
        said = {"command": record.command, "same": not differ, "artefacts": verdicts}
        print(json.dumps(said, indent=2))
    else:
        title = f"cam {record.command} again: {'bytes differ' if differ else 'the same bytes'}"
        table(title, ["artefact", "verdict"], [list(row) for row in verdicts.items()])
    if differ and record.program_sha256 != program_hash():
        note("the record is of another version of this program")
    if any(not name.endswith(".png") for name in differ):
        return NUMERICS
    if differ:
        note("only pictures differ: their bytes are the same on the same installation alone")
    return DONE if result.complete else NUMERICS

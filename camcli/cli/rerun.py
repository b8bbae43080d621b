"""cam rerun: the run of a run.json again, and whether its bytes agree."""

from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

from typer import Argument, Option

from camcli.cli.exit_codes import DONE, NUMERICS, note
from camcli.cli.options import DRAWING, Request

HomeFolder = Annotated[
    Path | None, Option("--folder", help="Where the files are that the scene names.", metavar="DIR")
]
REPEATED = ("config", "sets", "rpm", "points", "dry_run")  # these stand in the record
WITHOUT = (*REPEATED, "no_plot", *DRAWING)  # the record says whether it drew
SAME, OTHER, MISSING = "same bytes", "other bytes", "not made"
CHANGED = "same bytes, but not those of the file beside the record"


def rerun(
    request: Request,
    record: Annotated[Path, Argument(help="A run.json, or its folder.", metavar="FILE")],
    folder: HomeFolder = None,
) -> int:
    """Run again what a run.json records, and say whether the bytes agree.

    \b
    Exit code 3 where a CSV differs. Artefacts go to a temporary folder, or to -o. For all commands
    but bench and figures. A lift table is looked for beside FILE, or in --folder.
    """
    import json

    from camcli.cli.record import read_record
    from camcli.cli.report import table
    from camcli.cli.run import ARTEFACTS, compute
    from camcli.output.program import program_hash
    from camcli.output.run_folder import run_folder, unchanged

    record = record / "run.json" if record.is_dir() else record
    found = read_record(record)
    scene = found.load(folder, record.parent)
    there = {name for name in found.artefacts if (record.parent / name).is_file()}
    changed = there - set(unchanged(record.parent, found.artefacts))
    with ExitStack() as stack:
        out = request.out
        if out is None:
            out = Path(stack.enter_context(TemporaryDirectory(prefix="cam-rerun-")))
        names = ARTEFACTS[found.command].split()
        place = stack.enter_context(run_folder(out, threads=request.threads, names=names))
        options = found.options.arguments()
        result, made = compute(found.command, scene, request, place, options, found.options.plot)
    now = made["artefacts"]
    verdicts = {
        name: MISSING if name not in now
        else OTHER if now[name] != digest
        else CHANGED if name in changed
        else SAME
        for name, digest in found.artefacts.items()
    }  # fmt: skip
    differ = [name for name, verdict in verdicts.items() if verdict != SAME]
    if request.json:
        said = {"command": found.command, "same": not differ, "artefacts": verdicts}
        print(json.dumps(said, indent=2))
    else:
        title = f"cam {found.command} again: {'bytes differ' if differ else 'the same bytes'}"
        table(title, ["artefact", "verdict"], [list(row) for row in verdicts.items()])
    if differ and found.program_sha256 != program_hash():
        note("the record is of another version of this program")
    if any(not name.endswith(".png") for name in differ):
        return NUMERICS
    if differ and not changed:
        note("only pictures differ: their bytes are the same on the same installation alone")
    return DONE if result.complete else NUMERICS

"""cam figures"""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from camcli.cli.options import DRAWING, Request

# shared options that mean nothing here
WITHOUT = ("config", "rpm", "points", "no_plot", *DRAWING)


def figures(
    request: Request,
    names: Annotated[
        list[str] | None,
        Argument(help="Figures, e.g. 3.5 or 3.6. Default: all.", metavar="[NAME]..."),
    ] = None,
    folder: Annotated[
        Path | None,
        Option("--folder", help="Folder of scenes. Default: configs/figures (here, else shipped)."),
    ] = None,
    check: Annotated[
        bool, Option("--check", help="Compute all, and compare with the reference.")
    ] = False,
    update_reference: Annotated[
        bool, Option("--update-reference", help="Make this run's numbers the reference.")
    ] = False,
) -> int:
    """The figures of the cam-follower example: what changed is computed again.

    \b
    NAME/           artefacts, run.json and figure.json of one figure
    index.html      all pictures with scene, command, numbers and cost; works offline

    \b
    Figures are the scenes in --folder that have a section `figure`: its `command` is run as
    `cam COMMAND -c NAME.yaml -o OUT/NAME`. NAME selects: 3.6 means 3.6a to 3.6f. Reasons to
    compute:
    new               no finished run in the folder
    scene changed     another value of a key that the command reads (titles and comments do not
                      count)
    data changed      another content of a file that the scene names
    program changed   another source of this program
    artefact changed  a file is missing or has another size
    check             --check computes everything
    else unchanged: nothing is computed. Figures run side by side, each on one thread (--threads N
    at a time); no byte of a table or a picture depends on that. An interrupted run keeps what is
    finished.

    \b
    --check compares with REFERENCE/NAME.json: labels, critical speeds, counts, quantiles. Solved
    numbers may differ by 1e-8 of their value; simulated ones must be the same to the last bit,
    since the kernel's arithmetic is the same everywhere. Where only chaotic motions or last bits
    differ it says `portability broke`, else how far each number has drifted. A drift is exit code
    3. --update-reference writes what was computed as the new reference.
    """
    extra = {"names": names, "folder": folder, "check": check, "update_reference": update_reference}
    from camcli.cli.figures_run import run

    return run(replace(request, extra=extra))

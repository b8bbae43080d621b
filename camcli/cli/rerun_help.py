"""What `cam merge --help` and `cam rerun --help` say, and the options of these commands alone."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

MERGE_HELP = """Join the parts of a run that was computed in shards.

\b
cam sweep --shard 1/4 -o DIR ... cam sweep --shard 4/4 -o DIR, on any machines and in any order,
then cam merge DIR: the same artefacts, byte for byte, as of one run.
"""

RERUN_HELP = """Run again what a run.json records, and say whether the bytes agree.

\b
Exit code 3 where a CSV differs. Artefacts go to a temporary folder, or to -o. For all commands but
bench and figures. A lift table is looked for beside FILE, or in --folder.
"""

FOLDER = Annotated[
    Path | None,
    typer.Option("--folder", help="Where the files are that the scene names.", metavar="DIR"),
]
PARTS = Annotated[
    list[Path] | None, typer.Argument(help="Parts, or folders of them.", metavar="[PART]...")
]
RECORD = Annotated[Path, typer.Argument(help="A run.json.", metavar="FILE")]
AGAIN = ("config", "sets", "rpm", "points", "dry_run")  # these stand in the record


MERGE_OPTIONS = {"parts": (PARTS, None), "folder": (FOLDER, None)}
RERUN_OPTIONS = {"record": (RECORD, ...), "folder": (FOLDER, None)}

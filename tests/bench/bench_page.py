"""The numbers of the guide's page `speed`, from one run on one machine that does nothing else.

    python tests/bench/bench_page.py

Some five minutes on two processors; with the extras `bench` and `cluster` no row is left out. What
is printed goes into camcli/guide/explanation/speed.md, with the name of the machine. The table of
precision there is that of `cam bench precision`, three minutes more.
"""

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

HERE = Path(__file__).parent
PARTS = ["pieces", "exponents", "shell", "rests", "tables"]
CLUSTER = ["scaling"] if find_spec("distributed") else []
COMMANDS = [
    [HERE / "bench_core.py"],
    ["-m", "camcli", "bench", "scale", "--no-plot", "-o", "out/bench-page"],
    [HERE / "bench_scale.py", "--only", *PARTS, *CLUSTER],
]


def main() -> None:
    """Run one command after the other, each alone."""
    for command in COMMANDS:
        words = list(map(str, command))
        print("\n$ python", *words, flush=True)
        subprocess.run([sys.executable, *words], check=True)


if __name__ == "__main__":
    main()

"""`cam` and `python -m camcli`."""

import gc
import os


def main() -> None:
    """Run the command line; an interrupt while it is still being loaded is one like any other."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its threads spin until there is work
    gc.set_threshold(300_000)  # a start makes many objects and no garbage: a tenth of its time
    try:
        from camcli.cli.app import main as run
    except KeyboardInterrupt:
        os.write(2, b"interrupted\n")
        os._exit(130)
    run()


if __name__ == "__main__":
    main()

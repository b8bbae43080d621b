"""`cam` and `python -m camcli`."""

import gc


def main() -> None:
    """Run the command line; an interrupt while it is still being loaded is one like any other."""
    gc.set_threshold(50_000)  # a start makes many objects and no garbage: a tenth of its time
    try:
        from camcli.cli.app import main as run
    except KeyboardInterrupt:
        import os

        os.write(2, b"interrupted\n")
        os._exit(130)
    run()


if __name__ == "__main__":
    main()

"""`cam` and `python -m camcli`."""


def main() -> None:
    """Run the command line; an interrupt while it is still being loaded is one like any other."""
    try:
        from camcli.cli.app import main as run
    except KeyboardInterrupt:
        import os

        os.write(2, b"interrupted\n")
        os._exit(130)
    run()


if __name__ == "__main__":
    main()

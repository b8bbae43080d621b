"""`cam` and `python -m camcli`."""


def main() -> None:
    """Run the command line."""
    from camcli.cli.app import main as run

    run()


if __name__ == "__main__":
    main()

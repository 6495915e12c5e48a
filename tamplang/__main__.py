"""`python -m tamplang` is the command `tamplang`."""


def main() -> None:
    """Entry point of the console script. Ctrl-C while the command line loads ends it as quietly as later on."""
    try:
        from .cli import main as run
    except KeyboardInterrupt:
        import sys

        print("interrupted", file=sys.stderr)
        sys.exit(130)
    run()


if __name__ == "__main__":
    main()

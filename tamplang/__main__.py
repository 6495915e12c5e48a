"""`python -m tamplang` is the command `tamplang`."""

import sys


def main() -> None:
    """Entry point of the console script. Ctrl-C while the command line loads ends it as quietly as later on."""
    try:
        from .cli import main as run

        status = run()
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        status = 130
    # Python remembers an interrupt that passed through code compiled from a string (named tuples and data classes are),
    # even where it was caught, and `python -m` then ends by SIGINT whatever the status. The next such code forgets it.
    exec("")
    sys.exit(status)


if __name__ == "__main__":
    main()

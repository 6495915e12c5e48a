"""`python -m tamplang` is the command `tamplang`."""

from .cli import main

if __name__ == "__main__":
    main()

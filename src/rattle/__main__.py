"""`python -m rattle` is the command `rattle`."""

from rattle.cli import main

if __name__ == "__main__":
    main()

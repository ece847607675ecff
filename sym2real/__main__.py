"""``python -m sym2real`` is the command line."""

from sym2real.cli import main

if __name__ == "__main__":
    main()

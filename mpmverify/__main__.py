"""Entry point of the command line."""

from mpmverify.cli import main

if __name__ == "__main__":
    main()

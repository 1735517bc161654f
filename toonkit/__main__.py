"""`python -m toonkit`: the command line."""

import sys

from toonkit.cli import main

if __name__ == "__main__":
    sys.exit(main())

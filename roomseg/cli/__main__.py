"""``python -m roomseg.cli`` is the command ``roomseg``."""

import sys

from roomseg.cli.main import main

if __name__ == "__main__":
    sys.exit(main())

"""The command `wgdenoise`, also as `python -m wgdenoise`."""

import signal
import sys

from . import _wgdenoise


def main() -> None:
    """Run the command line and exit with its code."""
    # Let Ctrl-C end the program at once; Python's handler would wait for the command to return.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_wgdenoise.run_command(["wgdenoise", *sys.argv[1:]]))


if __name__ == "__main__":
    main()

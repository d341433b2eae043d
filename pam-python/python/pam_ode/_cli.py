"""The program ``pam``."""

from __future__ import annotations

import signal
import sys


def main() -> int:
    """Runs the command line of the process; its exit code."""
    from . import _pam

    # Commands set handlers of their own where they can stop and go on later.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _pam.run_program(["pam", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())

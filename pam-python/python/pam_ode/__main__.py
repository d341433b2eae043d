"""``python -m pam_ode`` is the program ``pam``."""

import sys

from ._cli import main

sys.exit(main())

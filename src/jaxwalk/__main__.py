"""``python -m jaxwalk`` is the command ``jaxwalk``."""

import sys

from jaxwalk.cli import main

sys.exit(main())

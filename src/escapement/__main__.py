"""`python -m escapement`: the command line without its script."""

import sys

from escapement.cli import main

sys.exit(main())

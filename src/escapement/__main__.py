"""`python -m escapement`: the command line without its script."""

from escapement.cli import program

program()

"""`python -m lienumba` is the command line."""

from lienumba.cli import main

main()

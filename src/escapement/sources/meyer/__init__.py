"""Meyer (1973): Appendix E, the program that computed it, and what is true of its mechanisms."""

from escapement.sources.meyer.program import program_1973, read_printout
from escapement.sources.meyer.published_cell import PublishedCell
from escapement.sources.meyer.rows import INERTIAS, agreement, appendix_e, printed_rows

__all__ = [
    "INERTIAS",
    "PublishedCell",
    "agreement",
    "appendix_e",
    "printed_rows",
    "program_1973",
    "read_printout",
]

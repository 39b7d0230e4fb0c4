"""Declarations of what is computed, as those of `base/quantity.py` are of what is given.

    FIGURES = {"period": Result("time", "period of one engagement of the terminal cycle"), ...}

Values in the user's units, the lines of tables and reports, the JSON, the units in files and the
reason for a number that does not exist follow from the declaration, see `base/records.py`.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from escapement.base.units import unit_name


class Result(NamedTuple):
    """Something that is computed.

    kind : of its unit, as in `escapement.base.units.factor`.
    long_name : its description in words.
    dtype : its type in a file.
    label : its name in tables, if that is not its key in words.
    digits : significant figures in tables.
    missing : why it does not exist, if there can be only one reason.
    exists : whether a design, an `Escapement`, has it; by default each has. Where it has not, the
        number is left out, or there is a reason for that in `missing`.
    unlike : name of a result to which it is equal where tables need not show it.
    tabled : whether tables show it; JSON always does.
    """

    kind: str = "ratio"
    long_name: str = ""
    dtype: str = "<f8"
    label: str = ""
    digits: int = 6
    missing: str = ""
    exists: Callable[[Any], bool] | None = None
    unlike: str = ""
    tabled: bool = True

    @property
    def units(self) -> str:
        """UDUNITS spelling of its unit in SI."""
        return unit_name(self.kind, "SI")

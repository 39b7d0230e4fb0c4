"""Outcomes of a case: the codes that kernels return and files store, and their messages."""

from enum import IntEnum


class Status(IntEnum):
    """Outcome of one case; the names are the `flag_meanings` of a result file."""

    OK = 0
    NO_TERMINAL = 1
    STALL = 2
    PAINLEVE = 3
    NOT_CONVERGED = 4
    INVALID = 5
    SPENT = 6

    @property
    def label(self) -> str:
        """Lower-case name, as written to files and JSON."""
        return self.name.lower()

    @property
    def failed(self) -> bool:
        """Whether there is no result; "no terminal speed" and "spring spent" are results."""
        return self not in (Status.OK, Status.NO_TERMINAL, Status.SPENT)


MESSAGES = {
    Status.OK: "done",
    Status.NO_TERMINAL: (
        "no terminal velocity exists: no loss grows with the speed, which grows without bound; "
        "give a friction greater than 0, or, if the mechanism has no slots, an efficiency below 1 "
        "and a ratio that varies"
    ),
    Status.STALL: "the drive cannot carry the load and the mechanism stops",
    Status.PAINLEVE: "friction is at or above the Painleve limit: no unique rigid motion exists",
    Status.NOT_CONVERGED: (
        "the iteration did not converge within its limit; try the other engine, or a larger rtol"
    ),
    Status.SPENT: "the spring is spent and nothing moves any more",
    Status.INVALID: "the parameters of this case break a rule",
}

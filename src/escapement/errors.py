"""What can go wrong for a user, each with the exit code the shell sees."""


class EscapementError(Exception):
    """Base of every error this package raises on purpose.

    The message is one line naming the argument, the rule, the value received
    and the remedy. `exit_code` is what the command line returns.
    """

    exit_code = 2


class InvalidValue(EscapementError, ValueError):
    """An argument breaks its rule."""


class UnknownArgument(EscapementError, TypeError):
    """A call has a keyword that there is none of."""


class InputFileError(EscapementError):
    """An input file exists but cannot be understood."""

    exit_code = 65


class MissingInput(EscapementError, FileNotFoundError):
    """An input file does not exist."""

    exit_code = 66

    def __str__(self) -> str:
        return str(self.args[0])


class CannotCreate(EscapementError, OSError):
    """An output cannot be created where it was asked for."""

    exit_code = 73

    def __str__(self) -> str:
        return str(self.args[0])


class StorageError(EscapementError, OSError):
    """Reading or writing failed half-way: disk full, device lost."""

    exit_code = 74

    def __str__(self) -> str:
        return str(self.args[0])

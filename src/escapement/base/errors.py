"""The errors that a user can cause, each with its exit code in the shell."""


class EscapementError(Exception):
    """Base of every error that this package raises on purpose.

    The message is one line that names the argument, the rule, the value received
    and the remedy. The command line returns `exit_code`.
    """

    exit_code = 2

    def __str__(self) -> str:
        # OSError, a base of some of them, would compose its text from several arguments
        return str(self.args[0]) if self.args else ""


class InvalidValue(EscapementError, ValueError):
    """An argument breaks its rule."""


class UnknownArgument(EscapementError, TypeError):
    """A call has an unknown keyword."""


class MissingPackage(EscapementError, ImportError):
    """A package that an optional function needs is not installed."""


class InputFileError(EscapementError):
    """An input file exists but cannot be understood."""

    exit_code = 65


class MissingInput(EscapementError, FileNotFoundError):
    """An input file does not exist."""

    exit_code = 66


class CannotCreate(EscapementError, OSError):
    """An output file cannot be created, or exists already."""

    exit_code = 73


class StorageError(EscapementError, OSError):
    """Reading or writing failed after it had begun: the disk is full, or a device was lost."""

    exit_code = 74

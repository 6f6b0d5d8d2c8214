"""What goes wrong, with the message that the command line prints."""


class Error(Exception):
    """Any of these. exit_code: of the command line."""
    exit_code = 1


class BadInput(Error, ValueError):
    """A scene, or what was given to a call, is wrong."""
    exit_code = 3


class LawRefused(Error, ValueError):
    """A law could not be loaded, or refused its properties."""
    exit_code = 4


class NumericalFailure(Error, ArithmeticError):
    """Not a number, or no equilibrium. What was computed until then can be read."""
    exit_code = 5


class Gone(Error, ReferenceError):
    """The simulation that this belonged to is closed or deleted."""


def from_exit_code(code, message):
    return next((kind for kind in (BadInput, LawRefused, NumericalFailure) if kind.exit_code == code), Error)(message)

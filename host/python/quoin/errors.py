"""Errors, with the messages of the command line."""


class Error(Exception):
    """Base class of errors. exit_code: that of the command line."""
    exit_code = 1


class BadInput(Error, ValueError):
    """A fault in a scene, or in the arguments of a call."""
    exit_code = 3


class LawRefused(Error, ValueError):
    """A law that does not load, or refuses its properties."""
    exit_code = 4


class NumericalFailure(Error, ArithmeticError):
    """A value that is not a number, or no equilibrium. Results up to then can be read."""
    exit_code = 5


class Gone(Error, ReferenceError):
    """Access to a simulation that is closed or deleted."""


def from_exit_code(code, message):
    return next((kind for kind in (BadInput, LawRefused, NumericalFailure) if kind.exit_code == code), Error)(message)

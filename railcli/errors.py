"""What railcli raises for its users; each class carries the exit code of the command that ends with it."""

LONGEST = 800  # characters of a message


class RailcliError(Exception):
    """Anything railcli reports in one line instead of a traceback."""

    exit_code = 1

    def __reduce__(self):
        return _again, (type(self), str(self))


def _again(kind, text):
    """An error that another process raised."""
    error = kind.__new__(kind)
    error.args = (text,)
    return error


class RailcliWarning(UserWarning):
    """What raises a doubt about an input or a result; the command shows it in one line."""


class InputError(RailcliError):
    """Something the user gave (file, option, output place) cannot be used.

    Parameters
    ----------
    where : str
        File and key, or option, that is wrong.
    message : str
        What was found, what is allowed and, if possible, what to do.
    """

    exit_code = 2

    def __init__(self, where, message):
        super().__init__(_one_line(f"{where}: {message}"))

    def and_so(self, more):
        """The same error with more words at its end."""
        other = InputError("", "")
        other.args = (_one_line(f"{self}{more}"),)
        return other


def _one_line(text):
    """The text with line ends and control characters, which names in users' files may hold, written as escapes.

    Of a text that is far too long the middle is left out: what is wrong stands at its ends.
    """
    if len(text) > LONGEST:
        half = LONGEST // 2
        text = f"{text[:half]} [...] {text[-half:]}"
    return harmless(text, "")


def harmless(text, kept="\n"):
    """The text as a terminal may have it: what is no letter, such as the codes that move its cursor, as escapes.

    Joiners of letters, which some scripts need, are letters.
    """
    kept += "\u200c\u200d"
    return "".join(letter if letter.isprintable() or letter in kept else ascii(letter)[1:-1] for letter in text)


class SimulationError(RailcliError):
    """A run ended before its time; what was computed until then is kept.

    Attributes
    ----------
    results : railcli.Results or None
        Of a run in Python: where it is kept.
    """

    exit_code = 3
    results: object = None


class CheckError(RailcliError):
    """A comparison or a ``--check`` found a difference beyond its tolerance.

    Attributes
    ----------
    answer : railcli.Answer or None
        Of a comparison in Python: all of it.
    """

    exit_code = 4
    answer: object = None

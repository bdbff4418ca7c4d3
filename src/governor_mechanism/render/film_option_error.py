"""A mistake in an option of a film, in words for Python and, on the command line, with the names of its options."""

from collections.abc import Mapping

from governor_mechanism.errors import MechanismError

PYTHON_WORDS: Mapping[str, str] = {
    **{
        name: name
        for name in (
            *("size", "frames_per_second", "part", "start", "stop", "slow_down", "layout", "readings", "theme", "footer"),
            *("labels", "forces", "traces", "view", "exaggerate"),
        )
    },
    "use_gif": "write a .gif",
}
"""Words of messages by the names that templates have for them: the arguments of `gm.film`, and how to choose a GIF."""


class FilmOptionError(MechanismError):
    """A mistake in an option of a film.

    Parameters
    ----------
    template
        The message, with the names of options in braces, as in "{size} must be ...", and of other values, which follow by name.
    """

    def __init__(self, template: str, **values: object) -> None:
        self._template, self._values = template, values
        super().__init__(template.format_map({**PYTHON_WORDS, **values}))

    def in_words(self, words: Mapping[str, str]) -> MechanismError:
        """Return the mistake in other words.

        Parameters
        ----------
        words
            Words by their names in `PYTHON_WORDS`; others stay.

        Returns
        -------
        MechanismError
            The mistake.
        """
        return MechanismError(self._template.format_map({**PYTHON_WORDS, **words, **self._values}))


def list_options(names: list[str]) -> str:
    """Return a template that lists options: "{labels} and {forces}".

    Parameters
    ----------
    names
        Names of options.

    Returns
    -------
    str
        The template.
    """
    return " and ".join(f"{{{name}}}" for name in names)

"""How an integration ended. The numbers are what compiled integrators return."""

from enum import IntEnum


class IntegrationStatus(IntEnum):
    """Return code of an integrator."""

    DONE = 0
    """The end of the interval is reached."""
    STALLED = 1
    """The step size fell to rounding."""
    STEP_LIMIT = 2
    """The allowed number of steps is used up."""
    BELOW_TABLE = 3
    """The coordinate is below the tabulated range."""
    ABOVE_TABLE = 4
    """The coordinate is above the tabulated range."""
    STIFF = 5
    """The equation is too stiff for an explicit method."""
    OUT_OF_RANGE = 6
    """The mechanism leaves the range in which its description holds."""
    EVENT = 7
    """An event function crosses zero within the last step."""
    TABLE_ENDED = 8
    """The table cannot be extended to where the motion leads."""
    ENDLESS_EVENTS = 9
    """Events follow each other at one time without end."""
    TURNED_BACK = 10
    """A shaft that must not turn back does."""
    SINGULAR_COORDINATES = 11
    """The independent coordinates become unsuitable: others are needed."""
    LEFT_LIMITS = 12
    """A reading leaves its limits within the last step, or comes so near that a finer look must tell."""

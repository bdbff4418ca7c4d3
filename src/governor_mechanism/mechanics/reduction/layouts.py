"""Layouts of the contact mode and of the event functions of the reduced model."""

from typing import NamedTuple


class ModeLayout(NamedTuple):
    """First index of each part of a contact mode, in their order.

    Attributes
    ----------
    held
        Whether the mechanism is held at rest.
    contacts
        State of each contact: 1, -1, 0 or HELD, see `mechanics.contact.rules`.
    springs
        Whether each one-sided spring is taut.
    tables
        Segment of each table of a reading.
    kinks
        Whether each kink is monitored.
    """

    held: int
    contacts: int
    springs: int
    tables: int
    kinks: int


class EventLayout(NamedTuple):
    """First index of each kind of event function, in their order.

    Attributes
    ----------
    sticks
        Rate of each contact, against its sliding.
    high_stops
        Value of each contact beyond its high stop.
    low_stops
        Value of each contact beyond its low stop.
    springs
        Elongation of each one-sided spring, or its negative value while it is taut.
    release_up
        Static force upwards beyond what holds the mechanism.
    release_down
        Static force downwards beyond that.
    table_ends
        Value of each table beyond the upper and the lower end of its segment, in turn.
    kinks
        Those of gas.
    """

    sticks: int
    high_stops: int
    low_stops: int
    springs: int
    release_up: int
    release_down: int
    table_ends: int
    kinks: int


def lay_out_mode(n_contacts: int, n_springs: int, n_tables: int) -> ModeLayout:
    """Return the layout of a contact mode."""
    contacts = 1
    springs = contacts + n_contacts
    tables = springs + n_springs
    return ModeLayout(held=0, contacts=contacts, springs=springs, tables=tables, kinks=tables + n_tables)


def lay_out_events(n_contacts: int, n_springs: int, n_tables: int) -> EventLayout:
    """Return the layout of the event functions."""
    high_stops = n_contacts
    low_stops = high_stops + n_contacts
    springs = low_stops + n_contacts
    release_up = springs + n_springs
    table_ends = release_up + 2
    return EventLayout(
        sticks=0,
        high_stops=high_stops,
        low_stops=low_stops,
        springs=springs,
        release_up=release_up,
        release_down=release_up + 1,
        table_ends=table_ends,
        kinks=table_ends + 2 * n_tables,
    )

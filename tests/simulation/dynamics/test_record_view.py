"""Record views: rows of structured arrays as attributes, of the same memory."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.simulation.characters.person_record import PERSON
from pipeline.simulation.dynamics.record_array import zero_records
from pipeline.simulation.dynamics.record_view import record_view


@pytest.mark.parametrize("name", PERSON.names)
def test_a_field_is_written_to_its_row_alone(name: str) -> None:
    records = zero_records(3, PERSON)
    view = record_view(records, 1)
    setattr(view, name, np.int64(1))
    assert (records[1][name] == 1).all()
    assert sum(np.count_nonzero(np.asarray(records[field])) for field in PERSON.names) == np.size(
        records[1][name]
    )


@pytest.mark.parametrize("name", PERSON.names)
def test_a_field_is_read_from_its_row(name: str) -> None:
    records = zero_records(3, PERSON)
    view = record_view(records, 2)
    records[name][2] = 1
    assert np.all(getattr(view, name) == 1)
    assert np.all(view[name] == 1)
    assert np.all(getattr(record_view(records, 0), name) == 0)


def test_numbers_are_those_of_python_and_arrays_are_changed_in_place() -> None:
    records = zero_records(1, PERSON)
    view = record_view(records, 0)
    assert [type(value) for value in (view.pace, view.deck, view.frozen)] == [float, int, bool]
    view.goal[0] = 3.0
    view.goal[1] += 2.0
    np.testing.assert_array_equal(records["goal"][0], [3.0, 2.0])

"""The author's words for the track: what is accepted, what is refused and how."""

import pytest
from pydantic import ValidationError

from audio.config.sound import Master, Room, Sound


@pytest.mark.parametrize("name", ["open", "dry", "room", "hall"])
def test_a_room_may_be_a_name_or_said_in_full(name):
    assert Sound.model_validate({"room": name}).room == Room(preset=name)
    full = Sound.model_validate({"room": {"preset": name, "seconds": 2}}).room
    assert full == Room(preset=name, seconds=2)


def test_a_master_may_be_off_or_adjusted():
    assert Sound().master == Master(lufs=-16, true_peak_db=-1)
    for off in ("off", False):
        assert Sound.model_validate({"master": off}).master is None
    assert Sound.model_validate({"master": {"lufs": -23}}).master == Master(lufs=-23)


@pytest.mark.parametrize(
    ("words", "place"),
    [
        ({"room": "cave"}, ("room", "preset")),
        ({"room": {"preset": "hall", "seconds": 0}}, ("room", "seconds")),
        ({"room": {"size": [1, 0, 2]}}, ("room", "size", 1)),
        ({"room": {"reverb": 1}}, ("room", "reverb")),
        ({"room": 3}, ("room",)),
        ({"master": {"lufs": 0}}, ("master", "lufs")),
        ({"master": {"true_peak_db": 1}}, ("master", "true_peak_db")),
        ({"master": "on"}, ("master",)),
        ({"soundfont": ""}, ("soundfont",)),
    ],
)
def test_what_makes_no_sense_is_refused_with_its_place(words, place):
    with pytest.raises(ValidationError) as refused:
        Sound.model_validate(words)
    assert [error["loc"] for error in refused.value.errors()] == [place]

"""Render speed, and options of size and samples."""

from __future__ import annotations

import json

import pytest

from pipeline.production.reports.render_speed import Speed, table


def test_the_table_has_every_preset_and_the_time_of_the_film() -> None:
    fast = Speed("draft", 320, 180, 2, 1, 1.0, 0.25, 0.7, 0.2, 0.05, 36.75)
    slow = Speed("master", 1920, 1080, 64, 16, 90.0, 80.0, 0.9, 0.05, 0.05, 11530.0)
    head, one, other = table([fast, slow]).splitlines()
    assert head.split() == ["preset", "size", "samples", "first", "frame", "traced", "denoised",
                            "film"]  # fmt: skip
    assert one.split()[:3] == ["draft", "320x180", "2"]
    assert "64 in 16" in other
    assert other.endswith("  3 h 12 min")


@pytest.mark.nightly
def test_bench_measures_and_overwrites_nothing(studio, pronk) -> None:
    before = studio.state()
    arguments = ("bench", "tiny", "--preset", "draft", "--frames", "1", "--json")
    arguments += ("--size", "64x36")
    code, out, _ = pronk(*arguments, cwd=studio.folder)
    assert code == 0
    (speed,) = json.loads(out.splitlines()[-1])["presets"]
    assert speed["preset"] == "draft"
    assert (speed["width"], speed["height"]) == (64, 36)
    assert 0.0 < speed["frame"] < speed["film"]
    assert speed["film"] == pytest.approx(speed["first"] + 7 * speed["frame"])
    assert 0.0 < speed["tracing"] + speed["denoising"] + speed["moving"] <= 1.0
    assert studio.changes(before) <= {"manifest.json"}


@pytest.mark.nightly
def test_size_and_samples_are_settings_of_the_film(unmade, pronk, tmp_path) -> None:
    studio = unmade.copied(tmp_path / "studio")
    arguments = ("frame", "tiny", "1", "--size", "32x18", "--samples", "2", "--json")
    code, _, _ = pronk(*arguments, cwd=studio.folder)
    assert code == 0
    from render.image_files import read_png

    assert read_png(studio.frame(1)).shape == (18, 32, 3)


@pytest.mark.parametrize(
    ("size", "code", "expected"),
    [
        ("12", 2, "--size '12' is no size; write width and height, as in 1280x720"),
        ("641x360", 3, "film.size"),
    ],
)
def test_an_invalid_size_is_refused_with_a_valid_one(unmade, pronk, size, code, expected) -> None:
    got, _, message = pronk("frame", "tiny", "1", "--size", size, cwd=unmade.folder)
    assert got == code
    assert expected in message
    assert "Traceback" not in message

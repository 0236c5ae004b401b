"""Where the sun is placed: its direction from hour, day and latitude.

Source: J. Meeus, Astronomical Algorithms, 1998, eq. 13.5 and 13.6; the declination is
    Cooper's fit, accurate to half a degree.
"""

from __future__ import annotations

import math

from render.config import Light, Sun


def sun_direction(sun: Sun) -> tuple[float, float, float]:
    """Return the unit vector towards the sun in the world frame (Y up)."""
    declination = math.radians(23.45) * math.sin(2 * math.pi * (284 + sun.day) / 365)
    hour_angle = math.radians(15 * (sun.hour - 12))
    latitude = math.radians(sun.latitude_deg)
    up = math.sin(latitude) * math.sin(declination)
    up += math.cos(latitude) * math.cos(declination) * math.cos(hour_angle)
    north = math.cos(latitude) * math.sin(declination)
    north -= math.sin(latitude) * math.cos(declination) * math.cos(hour_angle)
    east = -math.cos(declination) * math.sin(hour_angle)
    # A heading h looks along (cos h, 0, -sin h); east lies a quarter turn to its right.
    heading = math.radians(sun.north_deg)
    x = north * math.cos(heading) + east * math.sin(heading)
    z = -north * math.sin(heading) + east * math.cos(heading)
    return x, up, z


def light_elevation_deg(light: Light) -> float | None:
    """Return the angle of the sun above the horizon in a light [degrees].

    -90 at night, where no sun is given; None in a studio and in a panorama.
    """
    if light.sun is not None:
        return sun_elevation_deg(light.sun)
    return -90.0 if light.studio is None and light.hdr is None else None


def sun_elevation_deg(sun: Sun) -> float:
    """Return the angle of the sun above the horizon [degrees]."""
    return math.degrees(math.asin(max(-1.0, min(1.0, sun_direction(sun)[1]))))

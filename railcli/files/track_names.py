"""What columns of recorded tracks are called, in English, German and French, and what they are to railcli."""

import re
from typing import NamedTuple

SIDES = {
    "left": "left", "l": "left", "lh": "left", "links": "left", "linke": "left", "li": "left", "gauche": "left",
    "right": "right", "r": "right", "rh": "right", "rechts": "right", "rechte": "right", "re": "right",
    "droite": "right",
}  # fmt: skip
IGNORED = {"rail", "schiene", "of", "the", "measured", "irregularity", "file", "mean", "track"}  # say nothing new
BANDS = {"d0": "waves up to 5 m", "d1": "waves of 3 to 25 m", "d2": "waves of 25 to 70 m", "d3": "waves of 70 to 150 m"}
CHORD = re.compile(r"(\d+)m", re.ASCII)
STEMS = {  # without sides and bands
    "vertical": {"vertical", "level", "longitudinal_level", "profile", "top", "surface", "height", "langshohe", "hohe",
                 "hohenlage", "nivellement", "nl"},
    "alignment": {"alignment", "align", "line", "lining", "lateral", "richtung", "seitenlage", "dressage", "dr"},
    "cross_level": {"cross_level", "crosslevel", "xlevel", "cant", "superelevation", "super_elevation", "uberhohung",
                    "ueberhoehung", "devers", "gegenseitige_hohenlage"},
    "gauge": {"gauge", "gage", "spurweite", "spur", "ecartement"},
    "versine": {"versine", "versines", "versin", "mid_chord_offset", "mco", "pfeilhohe", "pfeilhoehe", "fleche"},
    "curvature": {"curvature", "kappa", "krummung", "kruemmung", "courbure"},
    "radius": {"radius", "r", "halbmesser", "rayon", "curve_radius"},
    "gradient": {"gradient", "grade", "slope", "neigung", "langsneigung", "declivite"},
}  # fmt: skip
OTHERS = {
    "twist", "verwindung", "gauche", "speed", "geschwindigkeit", "vitesse", "time", "zeit", "date", "datum", "number",
    "nr", "no", "index", "sample", "event", "remark", "remarks", "comment", "bemerkung", "kommentar", "latitude",
    "longitude", "lat", "lon", "temperature", "valid", "quality",
}  # fmt: skip
_KNOWN = {name: quantity for quantity, names in STEMS.items() for name in names}


class Meaning(NamedTuple):
    """What a name says.

    Attributes
    ----------
    quantity : str or None
        A key of STEMS.
    side : "left", "right" or None
    vertical : bool
        Of a versine: of heights.
    band : str or None
        A key of BANDS: the column is filtered.
    chord : float or None
        That the name tells [m].
    known : bool
        False: nobody knows such a name.
    """

    quantity: str | None
    side: str | None = None
    vertical: bool = False
    band: str | None = None
    chord: float | None = None
    known: bool = True


def meaning_of(name):
    """The Meaning of a text_table.Name."""
    words = list(name.words)
    if name.stem in _KNOWN:
        return Meaning(_KNOWN[name.stem])
    side = next((SIDES[word] for word in words if word in SIDES), None)
    band = next((word for word in words if word in BANDS), None)
    chord = next((float(match[1]) for word in words if (match := CHORD.fullmatch(word))), None)
    rest = [word for word in words if word not in SIDES and word not in BANDS and not CHORD.fullmatch(word)]
    quantity = _quantity(rest) or _quantity([word for word in rest if word not in IGNORED])
    if quantity is None and (versine := [word for word in rest if word in STEMS["versine"]]):
        of = _quantity([word for word in rest if word not in versine and word not in IGNORED])
        if of in ("vertical", "alignment", None):
            return Meaning("versine", side, of == "vertical", band, chord)
    if quantity is None:
        return Meaning(None, known=bool(set(words) & OTHERS))
    return Meaning(quantity, side, False, band, chord)


def _quantity(words):
    return _KNOWN.get("_".join(words))

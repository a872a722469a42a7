"""From which errors on a fitted number, or a combination of several, is called unknown."""

#: Errors of the restitution, of ln l and of ln U from which on these are not known.
UNKNOWN_FROM = {"restitution": 0.1, "path": 0.3, "speed_unit": 0.2}
#: Share of a direction from which on a number is named as a part of it.
NAMED_FROM = 0.3
#: How the numbers are named in a sentence.
NAMES = {"restitution": "e", "path": "the mean free path", "speed_unit": "U"}

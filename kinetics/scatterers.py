"""The words for arrangements of scatterers, as all of the package and `particles` have them.

Dilute scatterers are those of the paper's equation; in `particles` the class BoltzmannGrad. Hard
disks do not overlap (HardDisks), overlapping disks are placed independently (Poisson). This file
needs no NumPy.
"""

#: The arrangements of scatterers, as `Scene(scatterers=...)` names them.
SCATTERERS = ("dilute", "overlapping disks", "hard disks")
#: Other words that are understood, and what they stand for.
OTHER_WORDS = {"overlapping": "overlapping disks"}


def usual_word(word: str) -> str:
    """Return the usual word for another one; hyphens and underscores stand for spaces."""
    spaced = word.replace("_", " ").replace("-", " ")
    return OTHER_WORDS.get(spaced, spaced)

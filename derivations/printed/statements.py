"""The paper's claims in words: nothing to transcribe but what they say."""

from __future__ import annotations

from .equation import Section

SECTION = Section("Statements of the paper")

for _label, _title in (
    ("h-linear", "the cooling rate is proportional to 1 - e"),
    ("h-not-haff", "the cooling rate is not proportional to 1 - e^2"),
    ("a2-missing", "a_2 does not exist below e = 0.5816"),
    ("sonine-a2", "the stable Sonine root approximates a_2"),
    ("gaussian-f", "the scaled VDF is nearly Gaussian, and Gaussian for small dissipation"),
    ("exponential-f", "the scaled VDF has an exponential tail"),
    ("log-msd", "the mean square displacement grows as the logarithm of time"),
    ("universal-g", "the scaled position distribution is universal in e and time"),
    ("exponential-g", "the position distribution has an exponential tail, a Gaussian peak"),
):
    SECTION.add(f"statement:{_label}", _title)

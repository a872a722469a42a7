"""The figures: nothing to transcribe but what their captions state."""

from __future__ import annotations

from .equation import Section

SECTION = Section("Figures")

for _label, _title in (
    ("collision", "a collision and its unit vector"),
    ("v0re", "thermal velocity over time"),
    ("hetomu2", "M_2/2 and the fitted cooling rate"),
    ("msdtheory", "mean square displacement and the random walk"),
    ("inelasticposi", "scaled position distribution"),
    ("scalev", "scaled velocity distribution"),
    ("impact", "impact parameter"),
    ("sign", "H(e) at both roots"),
    ("soninediffuse", "mean square displacement and the Sonine expansion"),
):
    SECTION.add(_label, _title)

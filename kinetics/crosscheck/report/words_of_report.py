"""Words and formulas of the page of a report, from `templates/report.json`."""

import json
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

#: Words of one system: what was compared, a line, and findings, with "{words}" to be filled.
Texts = dict[str, list[str]]


@dataclass(frozen=True)
class ObservableWords:
    """Title of an observable with its unit, and its short name."""

    title: str
    short: str


@dataclass(frozen=True)
class ReportWords:
    """What `report.json` holds.

    Parameters
    ----------
    head : of each kind of system, title, symbols, units and what the equation has beside
    claims : of the paper: claim, place, its own words, judgement, what came out
    story : sentences of findings
    cooling : of a gas that is left alone, its sentences
    findings : of systems that cool: "paper", "others", "elastic"
    driven : of driven systems, by name
    figures : title and caption of each
    observables : in the order of the tables
    algebra : labels of the formulas beyond the paper, by system
    below : names of the equations that are folded on the page, by system
    notes : of rows, by observable
    equations : words, then labels
    """

    head: Texts
    claims: list[list[str]]
    story: dict[str, str]
    cooling: dict[str, str]
    findings: Texts
    driven: Texts
    figures: Texts
    observables: dict[str, ObservableWords]
    algebra: Texts
    below: Texts
    notes: dict[str, str]
    equations: Texts


@cache
def report_words() -> ReportWords:
    """Return the words of the page."""
    file = files("kinetics.crosscheck") / "templates" / "report.json"
    document = json.loads(file.read_text(encoding="utf-8"))
    observables = {
        name: ObservableWords(title, short)
        for name, (title, short) in document.pop("observables").items()
    }
    return ReportWords(observables=observables, **document)

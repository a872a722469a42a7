"""The equations that the pages state, as the derivations print them.

`../templates/equations.json` keeps their MathML, so that a page waits for no sympy; this writes it:

    python -m kinetics.crosscheck.report.equations

The sentences that introduce them stand in `../templates/equations.txt.j2`.
"""

import json
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple

from markupsafe import Markup

from kinetics.crosscheck.report.templates import paragraphs

FORMULAS = {
    "collision": ["vchange"],
    "lorentz": ["inelaslorentz2"],
    "averages": ["beyond:log-loss", "beyond:loss-1"],
    "cooling": ["vdiff", "beyond:cooling-rate"],
    "diffusion": ["beyond:slope", "beyond:cosine"],
}
"""The labels of `derivations` that stand under each sentence, in the order of the report."""
OF_ANY_LAW = {
    "rule": ["beyond:rule"],
    "one_collision": ["beyond:one-collision"],
    "measure_plane": ["beyond:measure-plane"],
    "measure_space": ["beyond:measure-space"],
    "averages_space": ["beyond:space-power", "beyond:space-log", "beyond:space-cosine"],
    "moments": ["beyond:any-moments"],
    "slope": ["beyond:any-slope"],
}
"""The same for other laws than the paper's."""
_ONLY_IN = {"measure_plane": 2, "measure_space": 3, "averages_space": 3}
_FILE = files("kinetics.crosscheck") / "templates" / "equations.json"


class Equation(NamedTuple):
    """One equation, or several beside each other, and the sentence that introduces it."""

    text: str
    mathml: Markup


def report_equations(dimension: int | None = None) -> list[Equation]:
    """The equations of the report, in its order: the paper's, or of other laws in a dimension."""
    if dimension is None:
        return [_equation(name) for name in FORMULAS]
    return [_equation(n) for n in OF_ANY_LAW if _ONLY_IN.get(n, dimension) == dimension]


def comparison_equations() -> list[Equation]:
    """The equations of a comparison of data with the solver, in its order."""
    return [_equation(name) for name in ("collision", "lorentz", "chi_square")]


def _equation(name: str) -> Equation:
    text, *formula = paragraphs("equations.txt.j2", name)
    mathml = formula or json.loads(_FILE.read_text(encoding="utf-8"))[name]
    # All from files of this package: nothing of a user's goes in unescaped.
    return Equation(text, Markup("".join(mathml)))


def printed() -> dict[str, list[str]]:
    """MathML of the equations under each sentence, from `derivations`; takes a second."""
    from derivations import printed_equation
    from derivations.printers import mathml

    def block(label: str) -> str:
        # Ascending powers read better: 1 - e^2.
        element = mathml(printed_equation(label).formula, order="rev-lex")
        return element.replace("<math>", '<math display="block">')

    every = FORMULAS | OF_ANY_LAW
    return {name: [block(label) for label in labels] for name, labels in every.items()}


if __name__ == "__main__":
    text = json.dumps(printed(), ensure_ascii=False, indent=1)
    Path(str(_FILE)).write_text(text + "\n", encoding="utf-8")

"""The report as one HTML page with nothing beside it and as text, and the formulas that it shows.

    python -m kinetics.crosscheck.report.page LABEL ...

prints the rows of these labels of `derivations` (none: those of the paper's report) as JSON, for
`algebra`; `--write` writes the equations of the page as `derivations` prints them, so that a page
waits for no sympy.
"""

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from kinetics.crosscheck.words import Verdict, number, numeral

EQUATIONS = {
    "collision": ("The rule of a bounce, v* before it and v after it (eq. (1)).", ["vchange"]),
    "rule": ("The rule of a bounce; e_t is left of the velocity across the line of centres.",
             ["beyond:rule"]),
    "lorentz": ("The inelastic Lorentz equation (eq. (9)), which the solver discretises and the "
                "Boltzmann-Grad particles sample.", ["inelaslorentz2"]),
    "averages": ("A bounce with impact parameter y d, y uniform, multiplies the speed by s, "
                 "s² = e² + (1 − e²)y². Cooling needs λ(p) = 1 − ⟨sᵖ⟩ and κ = ⟨−ln s⟩.",
                 ["beyond:log-loss", "beyond:loss-1"]),
    "cooling": ("The thermal speed falls at a rate h(e), which the scaling state has exactly.",
                ["vdiff", "beyond:cooling-rate"]),
    "diffusion": ("The late slope d⟨r²⟩/d ln t in units of l²; χ is the angle of deflection.",
                  ["beyond:slope", "beyond:cosine"]),
    "one_collision": ("With the impact parameter y d a bounce multiplies the speed by s and turns "
                      "it by χ.", ["beyond:one-collision"]),
    "measure_plane": ("Among disks y is uniform.", ["beyond:measure-plane"]),
    "measure_space": ("Among spheres y² is uniform.", ["beyond:measure-space"]),
    "averages_space": ("Averages over y: ⟨sᵖ⟩ = 1 − λ(p), κ = ⟨−ln s⟩ and ⟨cos χ⟩.",
                       ["beyond:space-power", "beyond:space-log", "beyond:space-cosine"]),
    "moments": ("The scaling state has v₀ = 2l/(ht).", ["beyond:any-moments"]),
    "slope": ("⟨r²⟩ after N collisions, and d⟨r²⟩/d ln t at long times.", ["beyond:any-slope"]),
}  # fmt: skip
"""What the page says of an equation, and its labels in `derivations`."""
_OF_PAPER = ("averages", "cooling", "diffusion")
_OF_LAW = {
    2: ("one_collision", "measure_plane", "moments", "slope"),
    3: ("one_collision", "measure_space", "averages_space", "moments", "slope"),
}
_ANY_LAW = ("rule", "one-collision", "any-moments", "any-slope")
_IN_DIMENSION = {
    2: ("measure-plane", "plane-equal"),
    3: ("measure-space", "space-power", "space-log", "space-cosine", "space-e-zero"),
}
_FILE = files("kinetics.crosscheck") / "templates" / "report.json"
_WORDS = ("if", "L", "N", "ab", "eta", "tn", "mup", "msd", "impact", "rewrite", "collision")
"""Labels of the paper that are words or symbols too: they are labels only after "eq."."""


# -- the algebra, and the paper's equations by their numbers ---------------------------------------


@contextmanager
def algebra(system: Any) -> Iterator[Callable[[], list[dict[str, Any]]]]:
    """Derive the formulas of the report in a process of its own; gives a function that waits.

    The process ends with the context. RuntimeError with its last line if it fails; a report in a
    field has no formulas.
    """
    if system.in_field:
        yield list
        return
    more = () if system.is_papers_law else _ANY_LAW + _IN_DIMENSION[system.dimension]
    # The child must find the packages where this process did, installed or not.
    paths = os.pathsep.join(p for p in sys.path if p)
    with subprocess.Popen(
        [sys.executable, "-P", "-m", __name__, *(f"beyond:{name}" for name in more)],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=dict(os.environ, PYTHONPATH=paths),
        start_new_session=True,  # Ctrl-C reaches the parent alone, which then ends the child
    ) as process:  # fmt: skip

        def wait() -> list[dict[str, Any]]:
            out, err = process.communicate()
            if process.returncode:
                last = (err.strip().splitlines() or ["no message"])[-1]
                raise RuntimeError(f"the derivations failed: {last}")
            found: list[dict[str, Any]] = json.loads(out)
            return found

        try:
            yield wait
        finally:
            process.kill()


def algebra_rows(labels: Iterable[str]) -> list[dict[str, Any]]:
    """One row per label: title, status, note, and both formulas as sympy's text and as MathML."""
    from derivations import verify

    names = ("label", "title", "proof", "note", "printed_mathml", "derived_mathml")
    return [
        {name: getattr(check, name) for name in names}
        | {
            "status": str(check.status),
            "printed": "" if check.printed is None else str(check.printed),
            "derived": "" if check.derived is None else str(check.derived),
            "numbers": {each.name: float(each.value) for each in check.numbers},
        }
        for check in verify(labels)
    ]


def printed_equations() -> dict[str, list[str]]:
    """MathML of the equations of the page, from `derivations`; takes a second."""
    from derivations import printed_equation
    from derivations.typesetting import mathml

    def block(label: str) -> str:
        # Ascending powers read better: 1 - e^2.
        element = mathml(printed_equation(label).formula, order="rev-lex")
        return element.replace("<math>", '<math display="block">')

    return {name: [block(label) for label in labels] for name, (_, labels) in EQUATIONS.items()}


@cache
def _kept() -> dict[str, Any]:
    """The "numbers" of the paper's labels, and the "mathml" of the equations."""
    found: dict[str, Any] = json.loads(_FILE.read_text(encoding="utf-8"))
    return found


def with_numbers(text: Any) -> Any:
    """A text, or several, with the numbers of the paper's equations in place of their labels."""
    if not isinstance(text, str):
        return [with_numbers(each) for each in text]
    numbers = _kept()["numbers"]
    every = sorted(numbers, key=len, reverse=True)
    end = r"(?![\w#]|\.\d)"
    for start, known in (
        (r"\b(?:eq\. |label )", every),
        (r"(?<![\w:])", [label for label in every if label not in _WORDS]),
    ):
        pattern = rf"{start}({'|'.join(map(re.escape, known))}){end}"
        text = re.sub(pattern, lambda match: f"eq. ({numbers[match[1]]})", text)
    return text


# -- words of the page -----------------------------------------------------------------------------


def title(system: Any) -> str:
    """The heading of the page."""
    if system.in_field:
        return "The inelastic Lorentz gas in a uniform field"
    return "The inelastic Lorentz gas: three methods compared"


def units(system: Any) -> str:
    """In which units every number stands."""
    if system.in_field:
        return (
            "l, the mean free path; g, the acceleration of the field, along z; speeds in √(gl), "
            "times in √(l/g), dispersion in √(gl³)."
        )
    root = "√3" if system.dimension == 3 else "√2"
    return (
        "d, the diameter of a scatterer; U, the standard deviation of a velocity component at the "
        f"start (v₀(0) = {root} U); times in d/U."
    )


def symbols(system: Any) -> str:
    """What the letters of the page mean."""
    if system.in_field:
        return "u = ⟨v_z⟩ drift; D∥, D⊥ half the growth of the variance along and across the field."
    path = "1/(πd²ρ₀)" if system.dimension == 3 else "1/(2dρ₀)"
    return (
        f"v₀² = ⟨v²⟩; dv₀/dt = −h v₀²/(2l); l = {path} free path; F(c) density of c = v/v₀; G(R) "
        "of R = r/√⟨r²⟩; a₂ = "
        + ("3⟨c⁴⟩/5 − 1." if system.dimension == 3 else "⟨c⁴⟩/2 − 1.")
    )


def deviation(row: Mapping[str, Any]) -> str:
    """A row's relative deviation, with its standard error where it has one."""
    from kinetics.crosscheck.report.rows import scale_of

    value = row["deviation"]
    if value is None:
        return "–"
    if row["kind"] == "numerical":
        return numeral(value, ".0e")
    if row["error"] is None:
        if value >= 1:
            return f"factor {numeral(1 + value, '.2g')}"
        return numeral(100 * value, "+.1f") + " %"
    error = float(100 * row["error"] / scale_of(row["observable"], row["theory"]))
    return number(100 * value, error, "+") + " %"


def _where(row: Mapping[str, Any]) -> str:
    at = [
        f"{name} = {numeral(row[key], '.3g')}"
        for key, name in (("distance", "R"), ("time", "t"), ("c", "c"))
        if row[key] is not None
    ][:1]
    return ", ".join([*at, *([f"worst of {row['looks']}"] if row["looks"] > 1 else [])])


# -- the page --------------------------------------------------------------------------------------


def render(document: Mapping[str, Any], figures: Sequence[Any], chance: str) -> str:
    """The page. Every text of the document is escaped."""
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup

    # Formulas are of this package's own printer, figures are matplotlib's with escaped texts:
    # nothing of a user's goes in unescaped.
    made = Environment(
        loader=PackageLoader("kinetics.crosscheck"), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True,
    )  # fmt: skip
    made.filters |= {"numeral": numeral, "number": number, "cited": with_numbers}
    settings, mathml = document["settings"], _kept()["mathml"]
    in_field, dimension = "dimensions" in settings, settings.get("dimension", 2)
    papers_law = not in_field and dimension == 2 and settings["tangential_restitution"] == 1
    below = () if in_field else _OF_PAPER if papers_law else _OF_LAW[dimension]

    def equation(name: str) -> tuple[str, Markup]:
        return EQUATIONS[name][0], Markup("".join(mathml[name]))

    return made.get_template("report.html.j2").render(
        doc=document,
        figures=[(drawn, Markup(drawn.svg())) for drawn in figures],
        strip=[equation("collision" if papers_law or in_field else "rule"), equation("lorentz")],
        equations=[equation(name) for name in below],
        deviation=deviation,
        summary=_summary(document),
        tables=_tables(document),
        chance=chance,
        formula=Markup,
        in_field=in_field,
    )


def _summary(document: Mapping[str, Any]) -> tuple[list[str], list[list[str]]]:
    """Restitutions, and for each quantity its name and a cell for each of them."""
    rows = document["tables"]["summary"]
    restitutions = sorted({row["restitution"] for row in rows})
    lines: dict[str, dict[float, str]] = {}
    for row in rows:
        shown = number(row["value"], row["error"], row["sign"], 4 if row["unit"] == "" else 2)
        lines.setdefault(row["quantity"], {})[row["restitution"]] = shown
    head = [f"e = {e:g}" for e in restitutions]
    return head, [[q, *(c.get(e, "–") for e in restitutions)] for q, c in lines.items()]


def _tables(document: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The folded tables: id, title, note, head and lines; a line of one cell is a heading."""
    from kinetics.crosscheck.report.rows import OBSERVABLES, matrix

    rows, every = document["rows"], sorted({row["restitution"] for row in document["rows"]})
    verdicts: list[list[Any]] = []
    detail: list[list[Any]] = []
    last = None
    for (observable, system, who), cells in matrix(rows).items():
        if (observable, system) != last:
            last = (observable, system)
            verdicts.append([f"{OBSERVABLES[observable].title}, {system}"])
        verdicts.append([who, *(cells.get(e, "–") for e in every)])
    for row in rows:
        if (row["observable"], row["system"]) != last:
            last = (row["observable"], row["system"])
            detail.append([f"{OBSERVABLES[row['observable']].title}, {row['system']}"])
        sigmas = (row["sigmas"], row["corrected_sigmas"])
        detail.append([
            numeral(row["restitution"], "g"), f"{row['source']} / {row['against']}", _where(row),
            number(row["value"], row["error"]), number(row["theory"]),
            *("" if s is None else numeral(s, ".1f") for s in sigmas), row,
        ])  # fmt: skip
    found = [
        ("verdicts", "Verdicts", "Who against whom, with the relative difference ± one standard "
         "error.", ["who / against whom", *(f"e = {e:g}" for e in every)], verdicts),
        ("rows", "Every comparison", document["units"], ["e", "who / against whom", "at",
         "value ± s.e.", "theory", "σ", "σ corrected", "verdict"], detail),
    ]  # fmt: skip
    tables = document["tables"]
    if "finite_density" in tables:
        found.append(_levels(tables["finite_density"]))
    if "dimensions" in tables:
        lines = [
            [f"{OBSERVABLES[r['observable']].short}, e = {r['restitution']:g}, {r['scatterers']}",
             *(number(r[name]) for name in ("exact", "solver", "equation")),
             number(r["value"], r["error"])]
            for r in sorted(tables["dimensions"],
                            key=lambda r: (list(OBSERVABLES).index(r["observable"]), r["restitution"]))
        ]  # fmt: skip
        note = (
            "The same law at the same l; ⟨r²⟩ and its slope in l². Closed form and solver: limits "
            "of late times; equation and particles: at the last time (rates: last decade)."
        )
        head = ["quantity", "closed form", "solver", "equation", "dilute particles"]
        found.append(("dimensions", "Disks and spheres side by side", note, head, lines))
    if "hard_disks" in tables:
        lines = [
            [f"e = {r['restitution']:g}", f"{r['density']:g}",
             number(r["drift_over_density"], r["error"]),
             f"{100 * r['trapped']:.1f} % by t = {r['until']:.0f}", f"{r['captures']:.2g}"]
            for r in tables["hard_disks"]
        ]  # fmt: skip
        note = "The mean velocity while they move, over the equation’s; captures per free path."
        head = ["restitution", "density ρ₀d²", "drift", "trapped", "captures"]
        found.append(("hard-disks", "Tracers among hard disks", note, head, lines))
    names = ("id", "title", "note", "head", "lines")
    return [dict(zip(names, table, strict=True)) for table in found]


def _levels(rows: Sequence[Mapping[str, Any]]) -> tuple[str, str, str, list[str], list[list[str]]]:
    """Hard disks beside the theory of a finite density."""
    from kinetics.crosscheck.report.rows import OBSERVABLES
    from kinetics.crosscheck.report.runs import LEVELS

    lines: list[list[str]] = []
    for row in rows:
        heading = f"e = {row['restitution']:g}, until t = {row['time']:g} d/U"
        if [heading] not in lines:
            lines.append([heading])
        cells = []
        for level in LEVELS:
            off = 100 * (row["value"] / row[level] - 1), 100 * row["error"] / row[level]
            cells.append(f"{number(row[level])} ({number(*off, '+')} %)")
        disks = number(row["value"], row["error"])
        lines.append([OBSERVABLES[row["observable"]].short, *cells, disks])
    note = (
        "The theory level by level, each with what the one before it has: the free path of the "
        "medium; the leading order ρ₀d² ln(ρ₀d²) of returns, nothing fitted; the first order; a "
        "second order fitted to other simulations. In brackets: hard disks over it."
    )
    head = ["quantity", *LEVELS, "hard disks"]
    return "finite-density", "Hard disks predicted: the finite density", note, head, lines


# -- the terminal ----------------------------------------------------------------------------------

_MARK = {Verdict.DIFFERS: "!", Verdict.UNCLEAR: "?", Verdict.NOT_TESTED: "-"}
_SHORT = {
    "kinetic equation, measured l": "equation, own l", "kinetic equation": "equation",
    "Boltzmann-Grad": "dilute limit", "hard disks": "disks", "hard spheres": "spheres",
    "paper's integral": "integral", "hard disks, extrapolated": "disks",
}  # fmt: skip
_COLUMNS = 4  # restitutions beside each other


def text(document: Mapping[str, Any]) -> str:
    """Every comparison with its deviations, four restitutions beside each other."""
    from kinetics.crosscheck.report.rows import OBSERVABLES, matrix

    every = sorted({row["restitution"] for row in document["rows"]})
    legend = "Differences. No mark: none seen; - not tested; ? unclear; ! differs; ~ a formula."
    out = [legend]
    for first in range(0, len(every), _COLUMNS):
        shown, last = every[first : first + _COLUMNS], None
        out.append("\n" + " " * 26 + "".join(f"{f'e = {e:g}':18}" for e in shown).rstrip())
        for (observable, system, who), cells in matrix(document["rows"]).items():
            found = [cells.get(e) for e in shown]
            if not any(found):
                continue
            if (observable, system) != last:
                out.append(f"{OBSERVABLES[observable].short}, {system}")
                last = (observable, system)
            names = " / ".join(_SHORT.get(name, name) for name in who.split(" / "))
            line = f"  {names:24}"
            for row in found:
                mark = " " if row is None else _MARK.get(row["verdict"], " ")
                mark = "~" if row is not None and row["kind"] == "approximation" else mark
                line += f"{mark} {'–' if row is None else deviation(row).removesuffix(' %'):16}"
            out.append(line.rstrip())
    return "\n".join(out)


if __name__ == "__main__":
    if sys.argv[1:] == ["--write"]:
        kept = {"numbers": _kept()["numbers"], "mathml": printed_equations()}
        Path(str(_FILE)).write_text(json.dumps(kept, ensure_ascii=False) + "\n", encoding="utf-8")
    else:
        from derivations import report_subset

        json.dump(algebra_rows(sys.argv[1:] or report_subset), sys.stdout)

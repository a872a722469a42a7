"""The page of `lorentz explore`: its tables against the solver, in Python and in Chromium."""

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pages import Page

from kinetics import ScalingSolution, Scene, solve, solve_field, solve_steady
from kinetics.crosscheck import explore

OUTPUTS = ("thermal_speed", "msd")
RNG = np.random.default_rng(35)
PLACES = [(RNG.uniform(), math.exp(RNG.uniform(-4, 12))) for _ in range(50)]
PLACES += [(e, t) for e in (0.0, 0.01, 0.99, 0.999, 1.0) for t in (0.1, 30.0, 1e5)]


def averages(e: float, t: Any, n: float = 0.04, scatterers: str = "dilute") -> Any:
    """v0 and <r^2> of the solver, in U and d^2."""
    scene = Scene(e, n, times=np.ravel(t), scatterers=scatterers, outputs=OUTPUTS)
    return np.array([getattr(solve(scene, rtol=1e-7), name) for name in OUTPUTS])


DRIVES = {"bath": {"bath_speed": 1.0}, "noise": {"heating": 1.0}}


def figures(e: float, **told: Any) -> list[float]:
    """v0, D, 1 + a2 and Einstein's ratio of a driven tracer, l = 1."""
    state = solve_steady(e, **told)
    ratio = state.diffusion_coefficient / (state.mobility * state.mean_square_along)
    return [state.thermal_speed, state.diffusion_coefficient, 1 + state.a2, ratio]


@pytest.fixture(scope="module")
def made() -> explore.Tables:
    return explore.all_tables()


@pytest.fixture(scope="module")
def file(made: explore.Tables, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("explore") / "explorer.html"
    path.write_text(explore.render(made), encoding="utf-8")
    return path


def read_steady(made: explore.Tables, drive: str, e: float) -> Any:
    """The figures of a steady state from the tables, as the page has them."""
    powers = explore.POWERS[drive]
    return [made[f"{drive} {name}"].at(e)[()] * (1 - e) ** p for name, p in powers.items()]


def read_averages(made: explore.Tables, e: float, n: float | None, t: Any) -> Any:
    """v0 in U and <r^2> in l^2 from the tables, as the page has them, shape (2, n_times)."""
    log_t, rates = np.log(t), explore.rates(e, None)
    if n is None:
        return np.array([made[k].at(e, log_t) for k in ("v0", "msd")]) * explore.factors(*rates, t)
    root = math.sqrt(n)
    h, a = (float(made[k].at(e, root)[0]) for k in ("hard H", "hard A"))
    both = np.array([made[k].at(e, root, log_t)[0] for k in ("hard v0", "hard msd")])
    return both * explore.factors(h * (1 - e), a, t)


def test_what_is_read_is_what_the_solver_finds(made: explore.Tables) -> None:
    """To what the page says of itself."""
    for e, t in PLACES:
        read = read_averages(made, e, None, np.array([t * 0.08])) * [[1.0], [12.5**2]]
        assert read == pytest.approx(averages(e, t), rel=2e-4), (e, t)
    times = np.geomspace(0.1, 1e5, 8)
    for e, n in RNG.uniform((0.0, explore.LOWEST_DENSITY), (1.0, explore.HIGHEST_DENSITY), (8, 2)):
        read = read_averages(made, e, n, 2 * n * times) * [[1.0], [(2 * n) ** -2]]
        assert read == pytest.approx(averages(e, times, n, "hard disks"), rel=3e-4), (e, n)
    for e in (0.01, 0.37, 0.8, 0.98):
        width = math.sqrt((1 - e * e) / 5)
        c = np.exp(width * np.linspace(-4, 5, 7))
        read = np.exp(made["ln F"].at(e, np.log(c) / width)) / (2 * np.pi * width * c * c)
        assert read == pytest.approx(ScalingSolution(e).vdf(c), rel=3e-4)
        xi = np.linspace(*explore.WIDTHS["hard disks"], 41)
        exact = explore.scaled_density(e, 0.04, xi)
        read = np.exp(made["hard ln F"].at(e, 0.2, xi)).ravel()
        assert read == pytest.approx(exact, abs=5e-3 * exact.max())
        state = solve_field(e)
        field = [state.drift, state.diffusion_parallel, state.diffusion_perpendicular]
        assert read_steady(made, "field", e) == pytest.approx(field, rel=1e-4)
        for drive, told in DRIVES.items():
            assert read_steady(made, drive, e) == pytest.approx(figures(e, **told), rel=2e-5)


def test_the_page_needs_nothing_beside_it(file: Path) -> None:
    found = Page(text := file.read_text(encoding="utf-8"))
    assert len(text.encode()) < 400_000
    assert found.references == []
    assert not re.search(r"https?:|@import|url\(\"|fetch\(|<img|<link", text)
    assert {"e", "n", "g", "pace"} <= {a.get("for") for tag, a in found.elements if tag == "label"}


COUNTED = "document.querySelectorAll('figure %s').length"


def ask(browser: Any, file: Path, width: int = 1400, dark: bool = False, **more: str) -> Any:
    """What the page answers; nothing is complained of, and nothing else is loaded."""
    seen = browser.visit(file, width, more, dark)
    assert seen.complaints == []
    requests = [address for address in seen.requests if not address.startswith("data:")]
    assert requests == [file.resolve().as_uri()]
    return seen.answers


def test_the_numbers_of_the_page_are_those_of_the_solver(browser: Any, file: Path) -> None:
    read = "explorer.curvesOf(e, .04, 'dilute').averages(t)"
    found = ask(
        browser, file, at=f"{json.dumps(PLACES)}.map(([e, t]) => {read})",
        laws="[0, .01, .5, .9, .99].map(e => [e, explorer.lawOf(e).h, explorer.lawOf(e).a2])",
        hard="explorer.curvesOf(.63, .07, 'hard disks').averages(500)",
        shape="explorer.curvesOf(.63, .07, 'dilute').F(.8)",
        drift="explorer.steadyOf('field', .4).drift",
        driven=f"{[*DRIVES]}.map(d => Object.values(explorer.steadyOf(d, .83)))",
        elastic="explorer.steadyOf('bath', 1)",
    )  # fmt: skip
    for (e, t), pair in zip(PLACES, found["at"], strict=True):
        assert pair == pytest.approx(averages(e, t).ravel(), rel=2e-4), (e, t)
    for e, h, a2 in found["laws"]:
        exact = ScalingSolution(e)
        assert (h, a2) == pytest.approx((exact.cooling_rate, exact.a2), rel=1e-9)
    assert found["hard"] == pytest.approx(averages(0.63, 500, 0.07, "hard disks").ravel(), rel=3e-4)
    assert found["shape"] == pytest.approx(ScalingSolution(0.63).vdf(0.8), rel=2e-4)
    assert found["drift"] == pytest.approx(solve_field(0.4).drift, rel=1e-4)
    for told, read in zip(DRIVES.values(), found["driven"], strict=True):
        assert read == pytest.approx(figures(0.83, **told), rel=2e-5)
    assert found["elastic"] is None


def test_the_particles_of_the_page(browser: Any, file: Path) -> None:
    """Elastic ones keep their speeds; others have the averages of the equation."""
    start = "(() => {const g = new explorer.Gas({%s, seed: 5, count: 201}), b = [...g.vx.keys()]"
    kept = f"{start % 'e: 1, n: .04'}.map(i => g.speed(i)); g.advance(300); "
    kept += "return [Math.max(...b.map((v, i) => Math.abs(g.speed(i) / v - 1))), g.hits[3]]})()"
    last = "g.advance(2000); return g.records.slice(-8).map(r => [r.t, r.v0, r.msd, r.vx])})()"
    cool, fall = f"{start % 'e: .7, n: .02'}; {last}", f"{start % 'e: .5, n: .01, g: .05'}; {last}"
    found = ask(browser, file, kept=kept, cool=cool, fall=fall)
    assert found["kept"][0] < 1e-11 < 5 < found["kept"][1]  # change, collisions
    t, *own = found["cool"][-1][:3]
    value, error = np.array(own).T
    assert np.all(abs(value - averages(0.7, t, 0.02, "hard disks").ravel()) < 4.5 * error)
    drift = solve_field(0.5).in_units(0.05, 1.0, 0.01).drift
    assert np.mean([row[3][0] for row in found["fall"]]) == pytest.approx(drift, rel=0.15)


@pytest.mark.parametrize(("drive", "solved"), [("bath", "bath_speed"), ("noise", "heating")])
def test_driven_particles_of_the_page_have_the_steady_speed(
    browser: Any, file: Path, drive: str, solved: str
) -> None:
    """v0 at late times, within 4.5 standard errors of a mean over 8 times apart (and 3 % of n)."""
    density = 0.005
    strength = {"bath": 1.0, "noise": 2.0 * density}[drive]  # w = U, or D_v = U^3/l
    run = f"(() => {{const g = new explorer.Gas({{e: .5, n: {density}, {drive}: {strength}, "
    run += "seed: 7, count: 801}); const found = []; g.advance(1000); for (let k = 0; k < 8; k++) "
    run += "{g.advance(250); let s = 0; for (let i = 0; i < g.count; i++) s += g.speed(i) ** 2; "
    run += "found.push(s / g.count)} return found})()"
    mean_squares = np.array(ask(browser, file, found=run)["found"])
    mean_square = solve_steady(0.5, **{solved: 1.0}).thermal_speed ** 2
    error = mean_squares.std(ddof=1) / math.sqrt(8)
    assert abs(mean_squares.mean() - mean_square) < 4.5 * error + 0.03 * mean_square


def test_a_figure_is_saved_as_a_picture(browser: Any, file: Path) -> None:
    found = ask(browser, file, picture="explorer.plots.fifth.picture()")
    assert found["picture"].startswith("data:image/png;base64,")
    assert len(found["picture"]) > 5000


def test_presets_are_the_systems_of_the_paper(browser: Any, file: Path) -> None:
    press = "(document.querySelector('#paper button[value=\"0.4\"]').click(), "
    press += "[explorer.state.e, explorer.state.n, explorer.state.medium])"
    assert ask(browser, file, state=press)["state"] == [0.4, 0.04, "hard disks"]


def test_data_address_and_python(browser: Any, file: Path) -> None:
    t = np.geomspace(1, 1e3, 9)
    rows = np.array([t, *averages(0.437, t, 0.03)]).T
    lines = ["time [d/U],thermal_speed [U],msd [d^2]", *(",".join(map(str, row)) for row in rows)]
    text = json.dumps("\n".join(lines))
    tracks = json.dumps("t,tracer,x,y\n0,a,1,1\n0,b,5,5\n2,a,1,3\n2,b,9,5\n")
    found = ask(
        browser, file, fit=f"explorer.fitted(explorer.averagesOf({text}), .03, 'dilute').e",
        msd=f"explorer.averagesOf({tracks})[1].msd",
        refused="(() => {try {explorer.averagesOf('a,b\\n1,2')} catch (e) {return e.message}})()",
        told="location.hash = '#e=0.25&n=0.02&medium=hard-disks'", wait="explorer.play(false)",
        state="[explorer.state.e, explorer.state.n, explorer.state.medium]",
        changed="(explorer.change({e: .5, g: .02}), location.hash)",
    )  # fmt: skip
    assert found["fit"] == pytest.approx(0.437, abs=1e-3)
    assert found["msd"] == pytest.approx((4 + 16) / 2)
    assert "needed are t" in found["refused"]
    assert found["state"] == [0.25, 0.02, "hard disks"]
    assert found["changed"] == "#e=0.5&n=0.02&g=0.02&medium=dilute"


def test_what_drives_the_tracer_is_chosen(browser: Any, file: Path) -> None:
    """Panel, sentence, address and Python follow; field and drive exclude each other."""
    text = "document.getElementById('%s').textContent"
    seen = f"[location.hash, {text % 'numbers'}, {text % 'code'}]"
    found = ask(
        browser, file, bath=f"(explorer.change({{drive: 'bath', e: .5}}), {seen})",
        markers=COUNTED % "circle.marker",
        field="(explorer.change({g: .03}), explorer.state.drive)",
        again="(explorer.change({drive: 'noise'}), explorer.state.g)",
    )  # fmt: skip
    assert (found["markers"], found["field"], found["again"]) == (4, "field", 0)
    address, numbers, python = found["bath"]
    assert address.endswith("&drive=bath")
    assert "2.449" in numbers
    names: dict[str, Any] = {}
    exec(python, names)
    assert names["steady"].thermal_speed == solve_steady(0.5, **DRIVES["bath"]).thermal_speed


@pytest.mark.parametrize(("width", "dark"), [(390, True), (1400, False)])
def test_the_page_fits_its_width(browser: Any, file: Path, width: int, dark: bool) -> None:
    box, curves = "getBoundingClientRect()", "document.querySelectorAll('figure path.curve').length"
    outside = f"(t, a = t.{box}, b = t.ownerSVGElement.{box}) => a.x < b.x || a.right > b.right"
    texts = f"[...document.querySelectorAll('figure svg text')].filter(t => ({outside})(t)).length"
    wide = "document.documentElement.scrollWidth"
    pairs = f"[...f.querySelectorAll('svg text')].map(t => t.{box}).some((a, i, all) => "
    pairs += "all.some((b, k) => k > i && a.x < b.right && b.x < a.right && a.y + 3 < b.bottom "
    pairs += "&& b.y + 3 < a.bottom))"  # 3: boxes are higher than digits
    overlaps = f"[...document.querySelectorAll('figure')].filter(f => {pairs}).length"
    cut = "[...document.querySelectorAll('.equation')].filter(q => q.scrollWidth > q.clientWidth)"
    found = ask(
        browser, file, width, dark, wide=wide, curves=curves, cut=f"{cut}.length",
        at=f"['nothing', 'field', 'bath', 'noise'].map(drive => (explorer.change({{drive}}), "
        f"[{wide} > innerWidth, {texts}, {overlaps}]))",
    )  # fmt: skip
    assert found["wide"] <= width
    assert (found["curves"], found["cut"]) == (12, 0)
    assert found["at"] == [[False, 0, 0]] * 4

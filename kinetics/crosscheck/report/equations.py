"""The equations that a report states, as MathML: no script and no font has to be loaded."""

from typing import NamedTuple

from markupsafe import Markup


class Equation(NamedTuple):
    """One equation, and the sentence that introduces it."""

    text: str
    mathml: Markup


def _row(*parts: str) -> str:
    return f"<mrow>{''.join(parts)}</mrow>"


def _i(name: str) -> str:
    return f"<mi>{name}</mi>"


def _vector(name: str) -> str:
    # MathML Core has no bold but the letters themselves.
    return _i(
        {"v": "\N{MATHEMATICAL BOLD SMALL V}", "σ": "\N{MATHEMATICAL BOLD SMALL SIGMA}"}[name]
    )


def _n(number: str) -> str:
    return f"<mn>{number}</mn>"


def _o(sign: str) -> str:
    return f"<mo>{sign}</mo>"


def _over(top: str, bottom: str) -> str:
    return f"<mfrac>{_row(top)}{_row(bottom)}</mfrac>"


def _power(base: str, exponent: str) -> str:
    return f"<msup>{_row(base)}{_row(exponent)}</msup>"


def _sub(base: str, index: str) -> str:
    return f"<msub>{_row(base)}{_row(index)}</msub>"


def _root(*inside: str) -> str:
    return f"<msqrt>{''.join(inside)}</msqrt>"


def _paren(*inside: str) -> str:
    return _row(_o("("), *inside, _o(")"))


def _math(*parts: str) -> Markup:
    # Every part is a literal of this module: nothing of a user's goes in unescaped.
    return Markup(f'<math display="block">{_row(*parts)}</math>')


_E, _F, _H, _T, _L, _Y = (_i(name) for name in "efhtly")
_V, _SIGMA = _vector("v"), f"<mover>{_vector('σ')}{_o('^')}</mover>"
_STAR = _power(_V, _o("*"))
_COMMA = _o(",") + '<mspace width="1.2em"/>'
_THIN = '<mspace width="0.17em"/>'
_MINUS, _PLUS, _EQUALS, _DOT = _o("−"), _o("+"), _o("="), _o("·")
_E2 = _power(_E, _n("2"))
_LAMBDA1 = _row(_i("λ"), _paren(_n("1")))


def _mean(*inside: str) -> str:
    return _row(_o("⟨"), *inside, _o("⟩"))


def _collision() -> Markup:
    return _math(
        _power(_V, _o("′")), _EQUALS, _V, _MINUS,
        _paren(_n("1"), _PLUS, _E), _paren(_V, _DOT, _SIGMA), _SIGMA,
    )  # fmt: skip


def _lorentz() -> Markup:
    domain = _row(_V, _DOT, _SIGMA, _o("&gt;"), _n("0"))
    gain = _over(_row(_F, _paren(_STAR, _o(","), _T)), _E2)
    return _math(
        _over(_row(_o("∂"), _F, _paren(_V, _o(","), _T)), _row(_o("∂"), _T)), _EQUALS,
        _i("d"), _sub(_i("ρ"), _n("0")),
        f"<munder>{_o('∫')}{domain}</munder>", _paren(_V, _DOT, _SIGMA),
        _row(_o("["), gain, _MINUS, _F, _paren(_V, _o(","), _T), _o("]")),
        _row(_o("d"), _SIGMA),
    )  # fmt: skip


def _average() -> Markup:
    s = _i("s")
    y2 = _power(_Y, _n("2"))
    return _math(
        _power(s, _n("2")), _EQUALS, _E2, _PLUS, _paren(_n("1"), _MINUS, _E2), y2, _COMMA,
        _i("λ"), _paren(_i("p")), _EQUALS, _n("1"), _MINUS, _mean(_power(s, _i("p"))), _COMMA,
        _i("κ"), _EQUALS, _mean(_MINUS, _i("ln"), _THIN, s),
    )  # fmt: skip


def _cooling() -> Markup:
    return _math(
        _over(_row(_i("d"), _sub(_i("v"), _n("0"))), _row(_i("d"), _T)), _EQUALS, _MINUS,
        _i("d"), _sub(_i("ρ"), _n("0")), _H, _paren(_E),
        f"<msubsup>{_i('v')}{_n('0')}{_n('2')}</msubsup>", _COMMA,
        _H, _paren(_E), _EQUALS, _n("2"), _root(_i("κ"), _LAMBDA1),
    )  # fmt: skip


def _diffusion() -> Markup:
    slope = _over(
        _row(_i("d"), _mean(_power(_i("r"), _n("2")))),
        _row(_i("d"), _THIN, _i("ln"), _THIN, _T),
    )
    left = _paren(_n("1"), _MINUS, _mean(_i("cos"), _THIN, _i("χ")))
    return _math(slope, _o("→"), _over(_row(_n("2"), _power(_L, _n("2"))), _row(_i("κ"), left)))


def report_equations() -> list[Equation]:
    """The equations of the report, in its order."""
    return [
        Equation(
            "A bounce reverses the velocity component along the line of centres and multiplies it "
            "by the restitution e (label vchange).",
            _collision(),
        ),
        Equation(
            "Between scatterers of density ρ₀ placed at random, the velocity distribution obeys "
            "the inelastic Lorentz equation (label inelaslorentz2), which the solver discretises "
            "and the Boltzmann-Grad particles sample.",
            _lorentz(),
        ),
        Equation(
            "A bounce with impact parameter y d, y uniform on [-1, 1], multiplies the speed by s. "
            "All that cooling needs are averages over y.",
            _average(),
        ),
        Equation("The cooling rate of the scaling state, exactly.", _cooling()),
        Equation(
            "The mean square displacement at long times; χ is the angle of deflection and "
            "l = 1/(2dρ₀) the mean free path.",
            _diffusion(),
        ),
    ]


def _chi_square() -> Markup:
    d, p, g = (_i(name) for name in "dpG")
    inverse = _power(_i("C"), _o("−") + _n("1"))
    square = _power(_i("χ"), _n("2"))
    ratio = _over(_row(_paren(g, _MINUS, p), square), _row(p, _paren(g, _MINUS, _n("1"))))
    law = _sub(_F, _row(p, _o(","), g, _MINUS, p))
    return _math(
        square, _EQUALS, _power(d, _o("⊤")), inverse, d, _COMMA, ratio, _o("∼"), law,
    )  # fmt: skip


def comparison_equations() -> list[Equation]:
    """The equations of a comparison of data with the solver, in its order."""
    *first, _ = report_equations()[:3]
    return [
        *first,
        Equation(
            "Differences d at p times have the covariance C, estimated from G independent groups "
            "by the jackknife; the chi-square's p-value is that of Hotelling's law, G being less "
            "where a few tracers make most of a variance.",
            _chi_square(),
        ),
    ]

"""Reads the LaTeX of the paper's equations into sympy, apart from the transcriptions.

A recursive descent over the small part of LaTeX that the paper uses. It exists so that a test can
hold every transcription of :mod:`derivations.printed` against its LaTeX; no derivation uses it.
"""

from __future__ import annotations

import re
from collections.abc import Callable

import sympy as sp

from derivations import symbols as s
from derivations.formal import Avg, Dt, Int, Lam, Measure, Partial, Second, dot

# -- the LaTeX as tokens, with one command for each name that the paper writes in many ----------

_REWRITES: tuple[tuple[str, str], ...] = (
    (r"\\begin\{[a-z]+\}|\\end\{[a-z]+\}|\\nonumber|\\quad|\\left|\\right|&", " "),
    (r"\\mathrm\{if\}.*|\(\s*<\s*1\)", " "),
    (r"\\frac\{dT\(\s*t\)\}\{dt\}", r"\\frac{\\diff T(t)}{\\diff t}"),
    (r"\\mathrm\{d\}", r"\\diff "),
    (r"\\mathrm\{e\}", r"\\eul "),
    (r"\{\s*\\bf\s*\\hat\{\\sigma\}\s*\}", r"\\hsig "),
    (r"\{\s*\\bf\s*\\hat\{v\}\s*\}", r"\\bvhat "),
    (r"\{\s*\\bf\s*([vc])\s*\}\^\{\*\}", r"\\b\1s "),
    (r"\{\s*\\bf\s*v\s*\}\^\{\\prime\}", r"\\bvp "),
    (r"\{\s*\\bf\s*([vcrlBJ])\s*\}", r"\\b\1 "),
    (r"\|\\bv \|", r"\\speed "),
    (r"\|\\bvs \|", r"\\speeds "),
    (r"\|\\bvhat \|", r"\\speedh "),
    (r"\\Bigl\|(.*)\\Bigr\|", r"\\abs{\1}"),
    (r"\\langle\s*\\br \^\{2\}\(t\)\\rangle_\{e\}", r"\\msd(t)"),
    (r"\\langle\s*\\br \^\{2\}\(t\)\\rangle", r"\\msdel(t)"),
    (r"\\simeq|\\equiv|\\sim", "="),
    (r"\\partial_\{t\}\^\{\(([j0-9])\)\}", r"\\Dt{\1}"),
    (r"\\nabla\^\{\(0\)\}", r"\\nabz "),
    (r"\\nabla\^\{\(1\)\}", r"\\nabo "),
    (
        r"\\tau_\{1\}\+\\tau_\{2\}\+\\cdot\s*\\cdot\s*\\cdot\s*\+\\tau_\{N\}",
        r"\\sum_{k=1}^{N}\\tau_{k}",
    ),
    (r"\+\\cdots", ""),
    (r"\\delta a_\{2\}", r"\\da "),
    (r"\\bar\{a\}_\{2\}", r"\\abar "),
    (r"\\bar\{\s*V\s*\}", r"\\Vbar "),
    (r"\\delta_\{pp\^\{\\prime\}\}", r"\\kron "),
    (r"\\delta\s*\(", r"\\dirac("),
    (r"\\delta\s*(\\mathit\{t\}|t)", r"\\dt "),
    (
        r"\\frac\{\\partial\^\{2\} p\(V,R\)\}\{\\partial V\^\{2\}\s*\}(\\big)?\|_\{V=V\^\{\*\}\}",
        r"\\curv ",
    ),
    (r"\\tilde\{g\}_\{e\}", r"\\gtilde "),
    (r"\\tilde\{G\}", r"\\Gtilde "),
    (r"V\^\{\*\}\(R\)|V\^\{\*\}", r"\\Vs "),
    (r"(?<![a-z])t\s*\^\{\\prime\}", r"\\tp "),
    (r"c\^\{\\prime p\}", r"\\cp^{p}"),
    (r"p\^\{\\prime\}", r"\\pprime "),
    # ap19 lacks a closing parenthesis after the operator
    (r"\(\\Lambda\\bB \(v\\bvhat ,T\(t\)\)\\cdot", r"(\\Lambda\\bB (v\\bvhat ,T(t)))\\cdot"),
)


def tokenize(source: str) -> list[str]:
    """The source without fonts and spacing, in tokens: commands, numbers, single characters."""
    text = source
    for pattern, replacement in _REWRITES[:4]:
        text = re.sub(pattern, replacement, text)
    text = _strip_fonts(text)
    for pattern, replacement in _REWRITES[4:]:
        text = re.sub(pattern, replacement, text)
    return re.findall(r"\\[A-Za-z]+|\\[{}]|\d+(?:\.\d+)?|[^\s]", text)


def _strip_fonts(text: str) -> str:
    """Remove \\mathrm{...} and \\mathit{...} around anything but Euler's e."""
    text = text.replace(r"\mathrm{e}", r"\eul ")
    while match := re.search(r"\\math(?:rm|it)\{", text):
        depth, end = 1, match.end()
        while depth:
            depth += {"{": 1, "}": -1}.get(text[end], 0)
            end += 1
        text = text[: match.start()] + " " + text[match.end() : end - 1] + " " + text[end:]
    return text


# -- the tokens as sympy ---------------------------------------------------------------------

_PLAIN: dict[str, sp.Expr] = {
    "e": s.e, "d": s.d, "l": s.l, "m": s.m, "n": s.n, "t": s.t, "b": s.b, "v": s.v,
    "c": s.c, "p": s.p, "j": s.j, "k": s.k, "x": s.x, "r": s.r, "N": s.N, "V": s.V,
    "R": s.R, "T": s.T(s.t), "F": s.F(s.bc), r"\bB": s.Bv(s.bv, s.T(s.t)),
    r"\pi": sp.pi, r"\infty": sp.oo, r"\alpha": s.alpha, r"\beta": s.beta, r"\eta": s.eta,
    r"\gamma": s.gamma, r"\kappa": s.kappa_d, r"\tau": s.tau1, r"\psi": s.psi,
    r"\epsilon": s.eps, r"\rho_0": s.rho0, r"\nu_D": s.nuD, r"\hsig": s.sigma,
    r"\bv": s.bv, r"\bvs": s.bvs, r"\bvp": s.bvp, r"\bvhat": s.bvh, r"\bc": s.bc,
    r"\bcs": s.bcs, r"\br": s.br, r"\bl": s.bl, r"\nabla": s.nabla, r"\nabz": s.nabla0,
    r"\nabo": s.nabla1, r"\speed": s.v, r"\speeds": s.vs, r"\speedh": s.vh,
    r"\abar": s.a2bar, r"\Vbar": s.Vbar, r"\Vs": s.Vs, r"\tp": s.t1, r"\dt": s.dt,
    r"\cp": s.cp, r"\pprime": s.pprime, r"\kron": sp.KroneckerDelta(s.p, s.pprime),
    r"\curv": Second(s.pd(s.V, s.R), s.V, s.Vs), "a_1": s.a1, "a_2": s.a2,
    "M_2": s.M2, "M_4": s.M4, "M_p": s.Mp, "a_p": s.a(s.p), "t_N": s.tc(s.N),
    r"\Gamma_-": s.Gamma_minus, r"\Gamma_+": s.Gamma_plus, r"\Gamma_flow": s.Gamma_flow,
}  # fmt: skip

_FUNCTIONS = {
    "v_0": s.v0, "T": s.T, "f": s.f, "F": s.F, "p": s.pd, "n": s.nd, "m": s.mn, "g": s.g,
    "g_e": s.ge, "G": s.G, "X": s.X, "Y": s.Y, "B": s.Brate, "D_e": s.De, "I": s.I_,
    "a_2": s.a2t, "f_a_2": s.fa2, r"\xi": s.xi, r"\phi": s.phi, r"\bB": s.Bv, r"\bJ": s.J,
    r"\msd": s.msd, r"\msdel": s.msd1, r"\da": s.da2, r"\dirac": s.delta,
    r"\gtilde": s.gt, r"\Gtilde": s.Gt, "p0": s.p0, "p1": s.p1, "p2": s.p2, "pj": s.pj,
    r"\bJ0": s.J0, r"\bJ1": s.J1, r"\bJj": s.Jj,
}  # fmt: skip

_MAGNITUDE = {s.bv: s.v, s.bc: s.c}
_VECTORS = {s.bv, s.bvs, s.bvp, s.bvh, s.bc, s.sigma, s.nabla, s.nabla0, s.nabla1}
_VECTOR_FUNCTIONS = {s.Bv, s.J, s.J0, s.J1, s.Jj, Lam}
_LAMBDA = sp.Symbol("<Lambda>")
_OF_BRACES: dict[str, Callable[..., sp.Expr]] = {r"\sqrt": sp.sqrt, r"\abs": sp.Abs}
_OF_ATOM: dict[str, Callable[..., sp.Expr]] = {
    r"\exp": sp.exp, r"\ln": sp.log, r"\cos": sp.cos, r"\diff": Measure,
}  # fmt: skip
_CLOSING = {"(": ")", "[": "]", r"\{": r"\}", "{": "}"}
_STOP = {"+", "-", r"\pm", ")", "]", "}", r"\}", "=", ",", r"\rangle", r"\leq", ""}


def _is_vector(expression: sp.Expr) -> bool:
    return expression in _VECTORS or expression.func in _VECTOR_FUNCTIONS


class LatexError(ValueError):
    """The source holds something that the reader does not know."""


def read(source: str) -> list[list[sp.Expr]]:
    """The statements of an equation, each as the list of its sides: ``a = b = c`` has three.

    Raises LatexError for LaTeX that it does not know.
    """
    reader = _Reader(tokenize(source))
    statements = [[reader.expression()]]
    while reader.peek():
        token = reader.take()
        if token in {"=", r"\leq"}:
            statements[-1].append(reader.expression())
        elif token == ",":
            statements.append([reader.expression()])
        else:
            raise LatexError(f"unexpected {token!r}")
    return statements


class _Reader:
    """Reads tokens from left to right; ``read_int`` reads what follows the command ``\\int``."""

    def __init__(self, tokens: list[str]) -> None:
        self.tokens = tokens
        self.at = 0

    def peek(self, ahead: int = 0) -> str:
        return self.tokens[self.at + ahead] if self.at + ahead < len(self.tokens) else ""

    def take(self, expected: str | None = None) -> str:
        token = self.peek()
        if expected is not None and token != expected:
            raise LatexError(f"expected {expected!r}, found {token!r} at {self.at}")
        self.at += 1
        return token

    def group(self) -> list[str]:
        """The tokens of the next brace group, or the next single token."""
        if self.peek() != "{":
            return [self.take()]
        self.take()
        start, depth = self.at, 1
        while depth:
            depth += {"{": 1, "}": -1}.get(self.take(), 0)
        return self.tokens[start : self.at - 1]

    def braced(self) -> sp.Expr:
        return _parse(self.group())

    def expression(self) -> sp.Expr:
        signs = {"+": sp.Integer(1), "-": sp.Integer(-1), r"\pm": s.pm}
        total: sp.Expr = sp.Integer(0) if self.peek() == "-" else self.term()
        while self.peek() in signs:
            total += signs[self.take()] * self.term()
        return total

    def term(self) -> sp.Expr:
        factors: list[sp.Expr] = []
        while (token := self.peek()) not in _STOP and token != "|":
            if token == r"\cdot":
                self.take()
                factors.append(self.dotted(factors.pop()))
            elif token == "/":
                self.take()
                factors.append(1 / self.factor())
            elif token == r"\times":
                self.take()
            else:
                factors.append(self.factor())
        return _apply_operators(factors)

    def dotted(self, left: sp.Expr) -> sp.Expr:
        scalars: sp.Expr = sp.Integer(1)
        right = self.factor()
        while not _is_vector(right) and not isinstance(right, _Operator):
            scalars *= right
            right = self.factor()
        return scalars * (_Along(left, right) if isinstance(right, _Operator) else dot(left, right))

    def read_int(self) -> sp.Expr:
        lower = upper = domain = None
        while self.peek() in {"_", "^"}:
            if self.take() == "^":
                upper = self.braced()
                continue
            tokens = self.group()
            if ">" in tokens:
                domain = s.hemi_c if r"\bc" in tokens else s.hemi
            else:
                lower = _parse(tokens)
        product = self.term()
        measures = [x for x in sp.Mul.make_args(product) if isinstance(x, Measure)]
        over = [x for x in measures if x.args[0] == s.b] or measures
        if len(over) != 1:
            raise LatexError(f"{len(over)} integration variables")
        variable = over[0].args[0]
        integrand = product / over[0]
        if lower is not None:
            return sp.Integral(integrand, (variable, lower, upper))
        return Int(integrand, variable, *([domain] if domain else []))

    def read_sum(self) -> sp.Expr:
        self.take("_")
        below = self.group()
        split = below.index("=")
        self.take("^")
        limits = (_parse(below[:split]), _parse(below[split + 1 :]), self.braced())
        return sp.Sum(self.term(), limits)

    def factor(self) -> sp.Expr:
        base = self.atom()
        if self.peek() == "^":
            self.take()
            base = _MAGNITUDE.get(base, base) ** self.braced()
        return base

    def atom(self) -> sp.Expr:
        token = self.take()
        if token.replace(".", "").isdigit():
            return sp.Rational(token)
        if token in _CLOSING:
            inside = self.expression()
            self.take(_CLOSING[token])
            return inside
        if token in _OF_BRACES:
            return _OF_BRACES[token](self.braced())
        if token in _OF_ATOM:
            return _OF_ATOM[token](self.atom())
        special = getattr(self, "read_" + token[1:], None) if token[0] == "\\" else None
        return special() if special else self.name(token)

    def read_frac(self) -> sp.Expr:
        above, below = self.group(), self.group()
        marks = {r"\partial", r"\diff"}
        if above[0] in marks and below[0] == above[0]:
            variable = _parse(below[1:])
            if len(above) == 1:
                return _Operator(variable)
            return _derivative(_parse(above[1:]), variable)
        return _parse(above) / _parse(below)

    def read_eul(self) -> sp.Expr:
        self.take("^")
        return sp.exp(self.braced())

    def read_langle(self) -> sp.Expr:
        inside = self.expression()
        self.take(r"\rangle")
        return Avg(inside)

    def read_Lambda(self) -> sp.Expr:
        return _LAMBDA

    def read_Dt(self) -> sp.Expr:
        order = self.braced()
        return Dt(order, self.factor())

    def name(self, token: str) -> sp.Expr:
        key, subscript = token, ""
        if self.peek() == "_":
            self.take()
            subscript = "".join(x for x in self.group() if x not in "{}")
            key = f"{token}_{subscript}"
        power: sp.Expr = sp.Integer(1)
        if self.peek() == "^" and self.peek(1) == "{" and self.peek(2) == "(":
            self.take()
            key += "".join(self.group()).strip("()")
        elif self.peek() == "^" and self.is_power_before_arguments():
            self.take()
            power = self.braced()
        return self.resolve(key, token, subscript) ** power

    def is_power_before_arguments(self) -> bool:
        """v_0^2(t): the power stands between the name and its arguments."""
        following = "".join(self.tokens[self.at + 1 : self.at + 7])
        return re.fullmatch(r"\{\d\}\(t\)", following) is not None

    def resolve(self, key: str, token: str, subscript: str) -> sp.Expr:
        if token in {"h", "H"}:
            self.arguments()
            return {"h": s.h, "H": s.H}[token]
        if token == "S":
            return s.S(_parse([subscript]), *self.arguments())
        if key in _FUNCTIONS and self.peek() == "(" and (key != "a_2" or self.peek(1) == "t"):
            return _FUNCTIONS[key](*self.arguments())
        if token in {r"\tau", "t"} and subscript:
            index = sp.sympify(subscript, locals={"N": s.N, "k": s.k})
            return s.tau(index) if token == r"\tau" else s.tc(index)
        if key in _PLAIN:
            return _PLAIN[key]
        raise LatexError(f"unknown name {key!r}")

    def arguments(self) -> list[sp.Expr]:
        self.take("(")
        found = [self.expression()]
        while self.peek() == ",":
            self.take()
            found.append(self.expression())
        self.take(")")
        return found


class _Operator(sp.Function):
    """A derivative that waits for what stands to its right."""

    nargs = 1


class _Along(sp.Function):
    """A vector times a derivative that waits."""

    nargs = 2


def _parse(tokens: list[str]) -> sp.Expr:
    reader = _Reader(tokens)
    result = reader.expression()
    if reader.peek():
        raise LatexError(f"{reader.peek()!r} is left over")
    return result


def _derivative(what: sp.Expr, variable: sp.Expr) -> sp.Expr:
    if isinstance(variable, sp.Symbol) and what.has(variable):
        return sp.Derivative(what, variable)
    return Partial(what, variable)


def _apply_operators(factors: list[sp.Expr]) -> sp.Expr:
    """The product, in which an operator acts on all that stands to its right but measures."""
    for index, factor in enumerate(factors):
        if not factor.has(_LAMBDA, _Operator) or index == len(factors) - 1:
            continue
        measures = [x for x in factors[index + 1 :] if isinstance(x, Measure)]
        operand = _apply_operators([x for x in factors[index + 1 :] if not isinstance(x, Measure)])
        applied = sum(_act(part, operand) for part in sp.Add.make_args(sp.expand(factor)))
        return sp.Mul(*factors[:index], *measures) * applied
    return sp.Mul(*factors)


def _act(operator: sp.Expr, operand: sp.Expr) -> sp.Expr:
    result: sp.Expr = operand
    for factor in sp.Mul.make_args(operator):
        if factor == _LAMBDA:
            result = Lam(operand)
        elif isinstance(factor, _Operator):
            result = _derivative(operand, factor.args[0])
        elif isinstance(factor, _Along):
            result = dot(factor.args[0], Partial(operand, factor.args[1].args[0]))
    waiting = [x for x in sp.Mul.make_args(operator) if not x.has(_LAMBDA, _Operator)]
    return sp.Mul(*waiting) * result

"""The LaTeX of an equation as tokens, with one command for each name that the paper writes in many.

A vector is ``{\\bf v}`` in the paper and ``\\bv`` here; fonts and spacing are dropped.
"""

from __future__ import annotations

import re

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

"""Characters that pdfLaTeX does not know, in its own terms."""

import re

_GREEK = {
    letter: f"\\ensuremath{{\\{name}}}"
    for letter, name in zip(
        "αβγδεθκλμνξπρστφωΓΔΘΛΣΦΨΩ",
        "alpha beta gamma delta varepsilon theta kappa lambda mu nu xi pi rho sigma tau varphi omega Gamma Delta "
        "Theta Lambda Sigma Phi Psi Omega".split(),
        strict=True,
    )
}
_RAISED = dict(zip("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789", strict=True))
_LOWERED = dict(zip("₀₁₂₃₄₅₆₇₈₉₊₋", "0123456789+-", strict=True)) | {"ₙ": "n"}
_SIGNS = {
    "×": "\\ensuremath{\\times}",
    "±": "\\ensuremath{\\pm}",
    "−": "\\ensuremath{-}",
    "≤": "\\ensuremath{\\le}",
    "≥": "\\ensuremath{\\ge}",
    "≈": "\\ensuremath{\\approx}",
    "≫": "\\ensuremath{\\gg}",
    "∞": "\\ensuremath{\\infty}",
    "½": "\\ensuremath{\\frac12}",
    "√": "\\ensuremath{\\surd}",
    "∂": "\\ensuremath{\\partial}",
    "·": "\\ensuremath{\\cdot}",
    "†": "\\dag{}",
    "…": "\\ldots{}",
    "‑": "-",
    "\u00a0": "~",
    "\u2009": "\\,",
    "u\u0307": "\\ensuremath{\\dot u}",
    "u\u0308": "\\ensuremath{\\ddot u}",
}
#: What LaTeX prints by itself with its usual encodings.
_KNOWN = set("–—‘’“”äöüßéèáàóñçÄÖÜÉø")


def in_latex(text: str) -> str:
    """A text whose characters pdfLaTeX prints.

    Raises
    ------
    ValueError
        If it has a character that is not known here.
    """
    text = re.sub(
        f"[{''.join(_RAISED)}]+", lambda run: f"\\textsuperscript{{{''.join(_RAISED[c] for c in run[0])}}}", text
    )
    text = re.sub(
        f"[{''.join(_LOWERED)}]+", lambda run: f"\\textsubscript{{{''.join(_LOWERED[c] for c in run[0])}}}", text
    )
    for character, latex in (_SIGNS | _GREEK).items():
        text = text.replace(character, latex)
    unknown = sorted({character for character in text if ord(character) > 127} - _KNOWN)
    if unknown:
        listed = ", ".join(f"'{character}' (U+{ord(character):04X})" for character in unknown)
        raise ValueError(f"LaTeX does not print {listed}; add it to paper/latex/symbols.py.")
    return text

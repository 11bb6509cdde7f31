"""A table as LaTeX with the rules of booktabs, which pdfLaTeX sets without further declarations."""

import re

import pandas as pd

from paper.products import Product

#: Characters that pdfLaTeX does not set by itself, and how it sets them.
_SIGNS = dict(zip("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", (f"^{sign}" for sign in "0123456789-"), strict=True))
_SIGNS |= dict(zip("₀₁₂₃₄₅₆₇₈₉₊₋ₙ", (f"_{sign}" for sign in "0123456789+-n"), strict=True))
_SIGNS |= {
    "−": "-",
    "≈": r"\approx",
    "∞": r"\infty",
    "≤": r"\le",
    "≥": r"\ge",
    "≫": r"\gg",
    "∂": r"\partial",
    "√": r"\surd",
}
_SIGNS |= {"α": r"\alpha", "β": r"\beta", "γ": r"\gamma", "δ": r"\delta", "ε": r"\varepsilon", "θ": r"\theta"}
_SIGNS |= {"κ": r"\kappa", "λ": r"\lambda", "μ": r"\mu", "ν": r"\nu", "ξ": r"\xi", "π": r"\pi", "ρ": r"\rho"}
_SIGNS |= {"σ": r"\sigma", "τ": r"\tau", "φ": r"\varphi", "ω": r"\omega", "Γ": r"\Gamma", "Δ": r"\Delta"}
_SIGNS |= {"Θ": r"\Theta", "Λ": r"\Lambda", "Σ": r"\Sigma", "Φ": r"\Phi", "Ψ": r"\Psi", "Ω": r"\Omega"}
_SET = str.maketrans(
    {sign: rf"\ensuremath{{{set}}}" for sign, set in _SIGNS.items()} | {"\u2009": r"\,", "\u00a0": "~"}
)
#: Derivatives in time, a letter and a combining character.
_DOTS = {"\u0307": "dot", "\u0308": "ddot"}


def tex(product: Product, frame: pd.DataFrame) -> str:
    """The source of a table with its caption and label, after a comment that names the table and what it needs."""
    comment = f"% Table '{product.name}' of the study: {product.title}. In the preamble: \\usepackage{{booktabs}}\n"
    table = frame.to_latex(index=False, escape=True, caption="CAPTION", label=f"tab:{product.name}")
    caption = re.sub(r"([&%$#_{}])", r"\\\1", product.title)
    dotted = re.sub(
        r"(\w)([\u0307\u0308])",
        lambda x: rf"\ensuremath{{\{_DOTS[x[2]]}{{{x[1]}}}}}",
        table.replace("CAPTION", caption),
    )
    return comment + dotted.translate(_SET)

"""A table as LaTeX with the rules of booktabs, which pdfLaTeX sets without further declarations."""

import re

import numpy as np
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
    "⅓": r"\frac13",
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


#: Letters of a line of 17 cm in footnotesize, and of the space between two columns; a table that is wider wraps the
#: columns with more than ``NARROW`` letters.
LINE, SPACE, NARROW = 118, 2, 10
#: Largest number of rows of a table on one page.
ROWS = 30


def _columns(frame: pd.DataFrame) -> tuple[str, str]:
    """Format of the columns, and size of the letters, which are smaller if the longest words do not fit.

    Wrapped columns share the line by the roots of their lengths, but hold their words.
    """
    cells = [[str(name), *map(str, frame[name])] for name in frame]
    lengths = np.array([max(map(len, column)) for column in cells])
    wrapped = (lengths > NARROW) & (lengths.sum() + SPACE * len(lengths) > LINE)
    words = np.array([max(len(word) for cell in column for word in re.split("[ -]", cell)) for column in cells])
    shortest, roots = np.where(wrapped, words, lengths), np.where(wrapped, np.sqrt(lengths - words), 0.0)
    needed = shortest.sum() + SPACE * len(cells)
    widths = (shortest + max(LINE - needed, 0) * roots / max(roots.sum(), 1.0)) / max(LINE, needed)
    columns = [
        rf">{{\raggedright\arraybackslash}}p{{{width:.3f}\linewidth}}" if wrap else "l"
        for width, wrap in zip(widths, wrapped, strict=True)
    ]
    return "".join(columns), "scriptsize" if needed > LINE else "footnotesize"


def tex(product: Product, frame: pd.DataFrame) -> str:
    """The source of a table with its caption and label, after a comment that names the table and what it needs."""
    (columns, letters), is_long = _columns(frame), len(frame) > ROWS
    packages = ["booktabs", *["array"] * ("p{" in columns), *["longtable"] * is_long]
    comment = f"% Table '{product.name}' of the study: {product.title}. In the preamble: "
    comment += f"\\usepackage{{{','.join(packages)}}}\n"
    table = frame.to_latex(
        index=False,
        escape=True,
        caption="CAPTION",
        label=f"tab:{product.name}",
        column_format=columns,
        longtable=is_long,
    )
    size = f"\\{letters}\\setlength{{\\tabcolsep}}{{3pt}}\n"
    table = f"{{{size}{table}}}\n" if is_long else table.replace("{table}\n", f"{{table}}\n{size}", 1)
    caption = re.sub(r"([&%$#_{}])", r"\\\1", product.title)
    dotted = re.sub(
        r"(\w)([\u0307\u0308])",
        lambda x: rf"\ensuremath{{\{_DOTS[x[2]]}{{{x[1]}}}}}",
        table.replace("CAPTION", caption),
    )
    return comment + dotted.translate(_SET)

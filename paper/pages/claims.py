"""The ledger of claims as a page."""

import pandas as pd

from paper.pages import STYLE
from paper.products import page
from study.words import document, text_of


def _article(claim: dict[str, str]) -> str:
    """One claim as an article: its statement, and its other entries in the ledger."""
    heading = f"{claim.pop('No.')}. {claim.pop('Claim')}"
    facts = "".join(f"<dt>{text_of(name.lower())}</dt><dd>{text_of(text)}</dd>" for name, text in claim.items() if text)
    return f"<article><h2>{text_of(heading)}</h2><dl>{facts}</dl></article>\n"


@page("Ledger of claims: what was printed, what is computed, and the verdict.", ledger="tables/claims.csv")
def claims(ledger: pd.DataFrame) -> str:
    """The page: the number of claims with each verdict, then all claims."""
    counts = ledger["Verdict"].str.partition(";")[0].value_counts()
    summary = ", ".join(f"{count} {verdict}" for verdict, count in counts.items())
    articles = [_article(claim) for claim in ledger.to_dict("records")]
    return document("Ledger of claims", [f"<p>{len(ledger)} claims: {text_of(summary)}.</p>\n", *articles], STYLE)

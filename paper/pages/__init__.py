"""Tables and ledger as pages, which the report of the pipeline shows."""

from pathlib import Path

STYLE = Path(__file__).with_name("page.css").read_text(encoding="utf-8")

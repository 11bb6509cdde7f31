"""The long description of the wheel: README without its picture, and with names of files in place of links to them."""

import re
from pathlib import Path

from setuptools import setup

text = Path("README.md").read_text(encoding="utf-8")
text = re.sub(r"!\[[^]]*\]\([^)]*\)\s+\*[^*]*\*\s+", "", text)  # with its caption
text = re.sub(r"\s\(\[[^]]*\]\((?!https:)[^)]*\)\)", "", text)  # a link in brackets
text = re.sub(r"\[([^]]*)\]\(#[^)]*\)", r"\1", text)
text = re.sub(r"\[([^]]*)\]\((?!https:)([^)#]*)[^)]*\)", r"\1 (`\2`)", text)
setup(long_description=text, long_description_content_type="text/markdown")

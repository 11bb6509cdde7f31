"""Pages without their figures."""

import pytest

from study.assessment import drawing, scheme


@pytest.fixture
def undrawn(monkeypatch):
    """Figures of pages are empty, for tests of their text: drawing takes most of the time of a page."""
    for module in (drawing, scheme):
        monkeypatch.setattr(module, "svg_of", lambda figure: "<svg></svg>")

"""What a notebook shows of a mistake: the user's line and the message, nothing of the inside."""

from __future__ import annotations

import pytest

from acausal import compile_text
from acausal.diagnostics import AcausalError


def test_a_notebook_shows_the_users_line_and_the_message() -> None:
    with pytest.raises(AcausalError) as error:
        compile_text("model M Real x; end M;")  # this line
    shown = "\n".join(error.value._render_traceback_())
    assert "# this line" in shown
    assert error.value.diagnostics[0].code in shown
    assert "instantiate" not in shown

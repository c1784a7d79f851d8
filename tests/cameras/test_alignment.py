"""What makes a camera suspect is in its range, or refused."""

from dataclasses import fields

import numpy as np
import pytest

from filter import Alignment, InvalidInput


@pytest.mark.parametrize("name", [field.name for field in fields(Alignment)])
@pytest.mark.parametrize("wrong", [0.0, -1.0, np.nan, np.inf, "much", None])
def test_a_value_out_of_range_is_refused_by_its_name(name, wrong):
    with pytest.raises(InvalidInput, match=name):
        Alignment(**{name: wrong})


def test_a_share_is_at_most_all():
    assert Alignment(share=1).share == 1.0
    with pytest.raises(InvalidInput, match="share"):
        Alignment(share=1.01)

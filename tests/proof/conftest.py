"""Runs that several files of tests hold against the checker."""

import pytest
from helpers.proved.doubts import lied

from filter import Bearing


@pytest.fixture(scope="session")
def doubtful(tmp_path_factory):
    """Return the folder of a run in which a bearing is wrong, and three cases are left to the end."""
    path = tmp_path_factory.mktemp("doubtful")
    lied(path, Bearing)
    return path

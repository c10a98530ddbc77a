"""Fixtures for all Python tests."""

from pathlib import Path

import pytest
from scripted_studies import mixed  # noqa: F401, a fixture of the tests of tradeoff

SHARED = Path(__file__).resolve().parents[3] / "shared"


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of evaluation data beside the repository; skips the test where it is absent."""
    if not SHARED.is_dir():
        pytest.skip(f"no evaluation data at {SHARED}")
    return SHARED

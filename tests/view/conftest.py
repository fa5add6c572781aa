"""What tests of the page share."""

from pathlib import Path

import pytest

from sigmafmu.view import page as pages


@pytest.fixture(scope="session")
def viewer():
    """Nothing, where the package has the page's script."""
    if not Path(pages.__file__).with_name(pages.VIEWER).is_file():
        pytest.skip("the package was built without npm, so it has no viewer")

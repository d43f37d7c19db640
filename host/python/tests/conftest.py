"""Where data and the program are."""

import os
import shutil
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def sample_scan():
    """The virtual scan of sample 5."""
    folder = Path(os.environ.get("ASPERITY_DATA", ROOT.parent / "shared" / "data"))
    path = folder / "samples" / "scan5.csv"
    if not path.exists():
        pytest.skip(f"no data: {path} is missing (set ASPERITY_DATA)")
    return path


@pytest.fixture(scope="session")
def program():
    """The command line program: ASPERITY_PROGRAM, else one built in the workspace, else of the PATH."""
    given = os.environ.get("ASPERITY_PROGRAM")
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    if given and not Path(given).exists():
        pytest.fail(f"ASPERITY_PROGRAM: there is no {given}")
    places = [given] if given else [target / "release" / "asperity", target / "debug" / "asperity"]
    for place in places:
        if Path(place).exists():
            return str(place)
    found = shutil.which("asperity")
    if not found:
        pytest.skip("the program asperity is not built (set ASPERITY_PROGRAM)")
    return found

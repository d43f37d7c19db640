"""Where data and the program are."""

import os
import shutil
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def sample_scan():
    """The virtual scan of sample 5."""
    given = os.environ.get("ASPERITY_DATA")
    if given == "none":
        pytest.skip("not run: needs samples/scan5.csv (ASPERITY_DATA=none)")
    path = Path(given or ROOT.parent / "shared" / "data") / "samples" / "scan5.csv"
    if not path.exists():
        absent(f"{path} is absent; set ASPERITY_DATA to the folder of the measured data, or to none")
    return path


def absent(remedy):
    """Skips a test that lacks something; where CI is set it fails."""
    if os.environ.get("CI", "false") not in ("", "false"):
        pytest.fail(f"{remedy} (a failure, not a skip, because CI is set)")
    pytest.skip(remedy)


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
        absent("the program asperity is not built (set ASPERITY_PROGRAM)")
    return found

"""The page of mission keys is the one that scripts/mission_keys makes of the schema."""

import subprocess
import sys

from programs import REPOSITORY


def test_the_page_of_mission_keys_is_current():
    made = subprocess.run([sys.executable, REPOSITORY / "scripts" / "mission_keys"], capture_output=True, check=True)
    page = (REPOSITORY / "docs" / "mission_keys.md").read_bytes()
    assert made.stdout == page, "docs/mission_keys.md is stale: run scripts/regenerate"

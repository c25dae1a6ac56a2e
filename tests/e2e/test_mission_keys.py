"""What scripts make of the schemas is current: the page of mission keys, and the classes of documents in Python."""

import subprocess
import sys

import pytest
from programs import REPOSITORY


@pytest.mark.parametrize(
    ("script", "made"),
    [("mission_keys", "docs/mission_keys.md"), ("python_documents", "python/samara_tpf/_documents.py")],
)
def test_what_is_made_of_the_schemas_is_current(script, made):
    printed = subprocess.run([sys.executable, REPOSITORY / "scripts" / script], capture_output=True, check=True).stdout
    assert printed == (REPOSITORY / made).read_bytes(), f"{made} is stale: run scripts/regenerate"

"""Runs an example of MAVSDK's, unchanged, at another port than the 14540 that some of them have in their source.

python mavsdk_example.py PORT EXAMPLE.py [ARGUMENT ...]
"""

import runpy
import sys

from mavsdk import Mavsdk


def main():
    port, example, *arguments = sys.argv[1:]
    connect = Mavsdk.add_any_connection
    Mavsdk.add_any_connection = lambda self, url, *rest: connect(self, url.replace("14540", port), *rest)
    sys.argv = [example, *arguments]
    runpy.run_path(example, run_name="__main__")


if __name__ == "__main__":
    main()

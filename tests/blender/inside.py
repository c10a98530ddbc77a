"""Runs in Blender: tests of this folder by unittest, counts into a JSON file.

Arguments: [--installed ZIP --pattern FILES] [names ...] report. --installed tests the add-on of a
zip, which the tests install, in place of the repository's.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import unittest
from pathlib import Path

import bpy  # noqa: F401  # as a module, it puts Blender's others on the path

HERE = Path(__file__).resolve().parent
ZIP = "IFA_TEST_ZIP"


def select(suite, names):
    for test in suite:
        if isinstance(test, unittest.TestSuite):
            yield from select(test, names)
        elif not names or any(name in test.id() for name in names):
            yield test


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--installed", metavar="ZIP")
    parser.add_argument("--pattern", default="test_*.py")
    parser.add_argument("names", nargs="*")
    parser.add_argument("report")
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1 :])
    sys.path.insert(0, str(HERE))
    if options.installed:
        os.environ[ZIP] = options.installed
    else:
        sys.path.insert(1, str(HERE.parents[1] / "addon"))
    found = unittest.defaultTestLoader.discover(str(HERE), options.pattern)
    tests = list(select(found, options.names))
    result = unittest.TextTestRunner(stream=sys.stdout, verbosity=2).run(unittest.TestSuite(tests))
    failed = len(result.failures) + len(result.errors) + len(result.unexpectedSuccesses)
    skipped = len(result.skipped)
    counts = {"passed": result.testsRun - failed - skipped, "failed": failed, "skipped": skipped}
    if result.testsRun == 0:
        counts["failed"] = 1  # a driver that finds no test must not pass
    Path(options.report).write_text(json.dumps(counts))
    sys.exit(1 if counts["failed"] else 0)


main()
